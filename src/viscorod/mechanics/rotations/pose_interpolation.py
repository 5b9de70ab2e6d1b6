"""Poses and twists between two states in time, by Hermite polynomials of positions and rotation vectors."""

from __future__ import annotations

from typing import NamedTuple

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.nodal_motion import coordinate_rates, coordinates, place
from viscorod.typing import Floats


@part
def hermite(
    x: float, h: float, y0: float, v0: float, a0: float, y1: float, v1: float, a1: float, smooth: bool
) -> tuple[float, float]:
    """Return value and derivative at ``t0 + x h`` of the Hermite polynomial of two values and derivatives.

    With ``smooth`` it is of degree 5 and uses the second derivatives ``a0, a1`` as well, otherwise of degree 3.
    """
    d = y1 - y0
    if smooth:
        c0, c1, c2 = h * v0, 0.5 * h * h * a0, 0.5 * h * h * a1
        e1 = h * v1
        # y0 + c0 x + c1 x^2 + x^3 (p + q x + s x^2)
        A, B, C = d - c0 - c1, e1 - c0 - 2.0 * c1, c2 - c1
        p = 10.0 * A - 4.0 * B + C
        q = -15.0 * A + 7.0 * B - 2.0 * C
        s = 6.0 * A - 3.0 * B + C
        y = y0 + x * (c0 + x * (c1 + x * (p + x * (q + x * s))))
        v = (c0 + x * (2.0 * c1 + x * (3.0 * p + x * (4.0 * q + x * 5.0 * s)))) / h
        return y, v
    p, q = 3.0 * d - h * (2.0 * v0 + v1), h * (v0 + v1) - 2.0 * d
    return y0 + x * (h * v0 + x * (p + x * q)), v0 + x * (2.0 * p + 3.0 * x * q) / h


class MovingPoses(NamedTuple):
    """Poses ``(n, 3)`` [m], ``(n, 4)``, body twists and their rates ``(n, 6)`` of nodes at one time."""

    r: Floats
    q: Floats
    twist: Floats
    rate: Floats


@part
def interpolate_poses(
    parts: Floats,
    h: float,
    start: MovingPoses,
    end: MovingPoses,
    split: Floats,
    smooth: bool,
    r: Floats,
    q: Floats,
    twist: Floats,
    scratch: Floats,
) -> None:
    """Write poses and body twists of all nodes at ``parts (k,)`` (0 to 1) of an interval of ``h`` [s].

    The coordinates of ``nodal_motion`` are interpolated, so that a steady rotation is followed exactly; they rotate by
    less than pi in the interval.

    Args:
        start, end: poses, twists and their rates at both ends.
        split: per node, whether displacement and rotation are separate coordinates.
        smooth: use the rates (degree 5, error of order 6) or not (degree 3, error of order 4).
        r, q, twist: outputs ``(k, n, 3)``, ``(k, n, 4)``, ``(k, n, 6)``; scratch: ``(10, 6)``.
    """
    X, speed, acceleration = scratch[0:2], scratch[2:4], scratch[4:6]
    one, other, at, at_rate = scratch[6], scratch[7], scratch[8], scratch[9]
    for i in range(6):
        X[0, i] = 0.0
    for k in range(split.shape[0]):
        apart = split[k] != 0.0
        coordinates(start.r[k], start.q[k], end.r[k], end.q[k], apart, X[1])
        for side in range(2):
            xe, ae = (start.twist[k], start.rate[k]) if side == 0 else (end.twist[k], end.rate[k])
            coordinate_rates(X[side], xe, apart, speed[side])
            coordinate_rates(X[side], ae, apart, acceleration[side])
            # the map itself changes along the motion
            size = 1e-300
            for i in range(6):
                size = max(size, abs(speed[side, i]))
            small = 1e-4 / size
            for i in range(6):
                at[i] = X[side, i] + small * speed[side, i]
            coordinate_rates(at, xe, apart, one)
            for i in range(6):
                at[i] = X[side, i] - small * speed[side, i]
            coordinate_rates(at, xe, apart, other)
            for i in range(6):
                acceleration[side, i] += (one[i] - other[i]) / (2.0 * small)
        for j in range(parts.shape[0]):
            for i in range(6):
                at[i], at_rate[i] = hermite(
                    parts[j],
                    h,
                    0.0,
                    speed[0, i],
                    acceleration[0, i],
                    X[1, i],
                    speed[1, i],
                    acceleration[1, i],
                    smooth,
                )
            place(start.r[k], start.q[k], at, at_rate, apart, r[j, k], q[j, k], twist[j, k])


@kernel
def interpolate(
    parts: Floats,
    h: float,
    start: MovingPoses,
    end: MovingPoses,
    split: Floats,
    smooth: bool,
    r: Floats,
    q: Floats,
    twist: Floats,
    scratch: Floats,
) -> None:
    """Do what :func:`interpolate_poses` does."""
    interpolate_poses(parts, h, start, end, split, smooth, r, q, twist, scratch)
