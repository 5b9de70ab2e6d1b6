"""Motion of nodes within a step, in coordinates of the pose at its start.

A node's pose is ``H = H0 exp(X)`` with ``X = (a, theta)`` in the body frame of the start; its twist follows from the
rate of ``X`` by the right tangent of the exponential (SE(3) is the dual-number extension of SO(3), so the translation
is the derivative of the rotational formula along ``a``). Nodes that are ``split`` use ``r = r0 + R0 a`` and
``R = R0 exp(theta)`` instead, in which held displacements are linear.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.rotation import inverse_coefficients, versine_coefficients
from viscorod.typing import Floats

Motion: TypeAlias = tuple[
    float, float, float, float, float, float, float, float, float, float, float, float, float
]
"""Translation, quaternion and body twist, component by component."""

Rates: TypeAlias = tuple[float, float, float, float, float, float]


@part
def versine_slopes(phi2: float, a: float, b: float) -> tuple[float, float]:
    """Return the derivatives over ``phi`` of the two :func:`versine_coefficients` ``a, b``, divided by ``phi``."""
    if phi2 < 0.04:
        return (
            -1 / 12 + phi2 * (1 / 180 - phi2 * (1 / 6720 - phi2 / 453600)),
            -1 / 60 + phi2 * (1 / 1260 - phi2 * (1 / 60480 - phi2 / 4989600)),
        )
    return (1.0 - b * phi2 - 2.0 * a) / phi2, (a - 3.0 * b) / phi2


@part
def moved(
    a0: float,
    a1: float,
    a2: float,
    t0: float,
    t1: float,
    t2: float,
    da0: float,
    da1: float,
    da2: float,
    dt0: float,
    dt1: float,
    dt2: float,
    split: bool,
) -> Motion:
    """Return translation, rotation (quaternion) and body twist of coordinates ``(a, t)`` that change at ``(da, dt)``.

    Components are written out: this runs for every node at every stage, and views of arrays would cost more than it.
    """
    phi2 = t0 * t0 + t1 * t1 + t2 * t2
    a, b = versine_coefficients(phi2)
    # w = dt - a theta x dt + b theta x (theta x dt)
    c0, c1, c2 = t1 * dt2 - t2 * dt1, t2 * dt0 - t0 * dt2, t0 * dt1 - t1 * dt0
    e0, e1, e2 = t1 * c2 - t2 * c1, t2 * c0 - t0 * c2, t0 * c1 - t1 * c0
    w0, w1, w2 = dt0 - a * c0 + b * e0, dt1 - a * c1 + b * e1, dt2 - a * c2 + b * e2
    half = 0.5 * math.sqrt(phi2)
    s = 0.5 * (1.0 - phi2 / 24 * (1.0 - phi2 / 80)) if phi2 < 1e-4 else math.sin(half) / (2.0 * half)
    x0, x1, x2, x3 = math.cos(half), s * t0, s * t1, s * t2
    if split:
        # v = exp(-theta) da
        y0, y1, y2 = 2 * (x2 * da2 - x3 * da1), 2 * (x3 * da0 - x1 * da2), 2 * (x1 * da1 - x2 * da0)
        v0 = da0 - x0 * y0 + x2 * y2 - x3 * y1
        v1 = da1 - x0 * y1 + x3 * y0 - x1 * y2
        v2 = da2 - x0 * y2 + x1 * y1 - x2 * y0
        return a0, a1, a2, x0, x1, x2, x3, v0, v1, v2, w0, w1, w2
    g0, g1, g2 = t1 * a2 - t2 * a1, t2 * a0 - t0 * a2, t0 * a1 - t1 * a0
    u0 = a0 + a * g0 + b * (t1 * g2 - t2 * g1)
    u1 = a1 + a * g1 + b * (t2 * g0 - t0 * g2)
    u2 = a2 + a * g2 + b * (t0 * g1 - t1 * g0)
    # the formula of w, differentiated along (a, da)
    f0 = t1 * da2 - t2 * da1 + a1 * dt2 - a2 * dt1
    f1 = t2 * da0 - t0 * da2 + a2 * dt0 - a0 * dt2
    f2 = t0 * da1 - t1 * da0 + a0 * dt1 - a1 * dt0
    along = t0 * a0 + t1 * a1 + t2 * a2
    a_slope, b_slope = versine_slopes(phi2, a, b)
    p, k = -a_slope * along, b_slope * along
    v0 = da0 - a * f0 + b * (t1 * f2 - t2 * f1 + a1 * c2 - a2 * c1) + p * c0 + k * e0
    v1 = da1 - a * f1 + b * (t2 * f0 - t0 * f2 + a2 * c0 - a0 * c2) + p * c1 + k * e1
    v2 = da2 - a * f2 + b * (t0 * f1 - t1 * f0 + a0 * c1 - a1 * c0) + p * c2 + k * e2
    return u0, u1, u2, x0, x1, x2, x3, v0, v1, v2, w0, w1, w2


@kernel
def place(
    r0: Floats, q0: Floats, X: Floats, rate: Floats, split: bool, r: Floats, q: Floats, twist: Floats
) -> None:
    """Write pose and body twist of one node from its coordinates ``X (6,)`` and their ``rate (6,)`` [1/s].

    Args:
        r0, q0: pose at the start of the step; r, q, twist: outputs (3,), (4,), (6,).
        split: whether displacement and rotation are separate coordinates.
    """
    a0, a1, a2, t0, t1, t2 = X
    d0, d1, d2, d3, d4, d5 = rate
    u0, u1, u2, x0, x1, x2, x3, v0, v1, v2, w0, w1, w2 = moved(
        a0, a1, a2, t0, t1, t2, d0, d1, d2, d3, d4, d5, split
    )
    twist[0], twist[1], twist[2], twist[3], twist[4], twist[5] = v0, v1, v2, w0, w1, w2
    n0 = q0[0] * x0 - q0[1] * x1 - q0[2] * x2 - q0[3] * x3
    n1 = q0[0] * x1 + q0[1] * x0 + q0[2] * x3 - q0[3] * x2
    n2 = q0[0] * x2 + q0[2] * x0 + q0[3] * x1 - q0[1] * x3
    n3 = q0[0] * x3 + q0[3] * x0 + q0[1] * x2 - q0[2] * x1
    scale = 1.0 / math.sqrt(n0 * n0 + n1 * n1 + n2 * n2 + n3 * n3)
    q[0], q[1], q[2], q[3] = scale * n0, scale * n1, scale * n2, scale * n3
    z0, z1, z2 = 2 * (q0[2] * u2 - q0[3] * u1), 2 * (q0[3] * u0 - q0[1] * u2), 2 * (q0[1] * u1 - q0[2] * u0)
    r[0] = r0[0] + u0 + q0[0] * z0 + q0[2] * z2 - q0[3] * z1
    r[1] = r0[1] + u1 + q0[0] * z1 + q0[3] * z0 - q0[1] * z2
    r[2] = r0[2] + u2 + q0[0] * z2 + q0[1] * z1 - q0[2] * z0


@part
def place_stages(
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    X: Floats,
    D: Floats,
    h: float,
    split: Floats,
    held: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    acceleration: Floats,
) -> None:
    """Write poses, body twists and their rates of all nodes at all stages, from the coordinates there.

    Args:
        r0, q0, twist0: poses and twists at the start of the step.
        X: coordinates ``(s, n, 6)``; D: derivatives from stage values ``(s, s)``; h: step [s].
        split, held: per node, coordinates are separate / pose and twist are known (left alone).
        r, q, twist, acceleration: outputs ``(s, n, ...)``; the acceleration is that of the body twist.
    """
    stages = X.shape[0]
    for k in range(X.shape[1]):
        if held[k] != 0.0:
            continue
        s0, s1, s2, s3 = q0[k, 0], q0[k, 1], q0[k, 2], q0[k, 3]
        apart = split[k] != 0.0
        for i in range(stages):
            d0 = d1 = d2 = d3 = d4 = d5 = 0.0
            for j in range(stages):
                c = D[i, j] / h
                d0 += c * X[j, k, 0]
                d1 += c * X[j, k, 1]
                d2 += c * X[j, k, 2]
                d3 += c * X[j, k, 3]
                d4 += c * X[j, k, 4]
                d5 += c * X[j, k, 5]
            u0, u1, u2, x0, x1, x2, x3, v0, v1, v2, w0, w1, w2 = moved(
                X[i, k, 0],
                X[i, k, 1],
                X[i, k, 2],
                X[i, k, 3],
                X[i, k, 4],
                X[i, k, 5],
                d0,
                d1,
                d2,
                d3,
                d4,
                d5,
                apart,
            )
            twist[i, k, 0], twist[i, k, 1], twist[i, k, 2] = v0, v1, v2
            twist[i, k, 3], twist[i, k, 4], twist[i, k, 5] = w0, w1, w2
            n0 = s0 * x0 - s1 * x1 - s2 * x2 - s3 * x3
            n1 = s0 * x1 + s1 * x0 + s2 * x3 - s3 * x2
            n2 = s0 * x2 + s2 * x0 + s3 * x1 - s1 * x3
            n3 = s0 * x3 + s3 * x0 + s1 * x2 - s2 * x1
            scale = 1.0 / math.sqrt(n0 * n0 + n1 * n1 + n2 * n2 + n3 * n3)
            q[i, k, 0], q[i, k, 1], q[i, k, 2], q[i, k, 3] = scale * n0, scale * n1, scale * n2, scale * n3
            z0, z1, z2 = 2 * (s2 * u2 - s3 * u1), 2 * (s3 * u0 - s1 * u2), 2 * (s1 * u1 - s2 * u0)
            r[i, k, 0] = r0[k, 0] + u0 + s0 * z0 + s2 * z2 - s3 * z1
            r[i, k, 1] = r0[k, 1] + u1 + s0 * z1 + s3 * z0 - s1 * z2
            r[i, k, 2] = r0[k, 2] + u2 + s0 * z2 + s1 * z1 - s2 * z0
        for i in range(stages):
            for a in range(6):
                total = 0.0
                for j in range(stages):
                    total += D[i, j] * (twist[j, k, a] - twist0[k, a])
                acceleration[i, k, a] = total / h


@part
def rates_of(
    a0: float,
    a1: float,
    a2: float,
    t0: float,
    t1: float,
    t2: float,
    d0: float,
    d1: float,
    d2: float,
    w0: float,
    w1: float,
    w2: float,
    split: bool,
) -> Rates:
    """Return the rates of the coordinates ``(a, t)`` of a node that moves with the body twist ``(d, w)``.

    The inverse of the tangent is ``T^-1 = 1 + theta^/2 + c theta^2`` with ``c`` of :func:`inverse_coefficients`.
    """
    phi2 = t0 * t0 + t1 * t1 + t2 * t2
    c, slope = inverse_coefficients(phi2)
    c0, c1, c2 = t1 * w2 - t2 * w1, t2 * w0 - t0 * w2, t0 * w1 - t1 * w0
    e0, e1, e2 = t1 * c2 - t2 * c1, t2 * c0 - t0 * c2, t0 * c1 - t1 * c0
    x3, x4, x5 = w0 + 0.5 * c0 + c * e0, w1 + 0.5 * c1 + c * e1, w2 + 0.5 * c2 + c * e2
    f0, f1, f2 = t1 * d2 - t2 * d1, t2 * d0 - t0 * d2, t0 * d1 - t1 * d0
    if split:
        a, b = versine_coefficients(phi2)
        return (
            d0 + (1.0 - b * phi2) * f0 + a * (t1 * f2 - t2 * f1),
            d1 + (1.0 - b * phi2) * f1 + a * (t2 * f0 - t0 * f2),
            d2 + (1.0 - b * phi2) * f2 + a * (t0 * f1 - t1 * f0),
            x3,
            x4,
            x5,
        )
    h0, h1, h2 = f0 + a1 * w2 - a2 * w1, f1 + a2 * w0 - a0 * w2, f2 + a0 * w1 - a1 * w0
    p = slope * (t0 * a0 + t1 * a1 + t2 * a2)
    return (
        d0 + 0.5 * h0 + c * (t1 * h2 - t2 * h1 + a1 * c2 - a2 * c1) + p * e0,
        d1 + 0.5 * h1 + c * (t2 * h0 - t0 * h2 + a2 * c0 - a0 * c2) + p * e1,
        d2 + 0.5 * h2 + c * (t0 * h1 - t1 * h0 + a0 * c1 - a1 * c0) + p * e2,
        x3,
        x4,
        x5,
    )


@part
def coordinate_rates(X: Floats, twist: Floats, split: bool, out: Floats) -> None:
    """Write the rates of the coordinates ``X (6,)`` of a node that moves with the body ``twist (6,)``."""
    a0, a1, a2, t0, t1, t2 = X
    d0, d1, d2, w0, w1, w2 = twist
    out[0], out[1], out[2], out[3], out[4], out[5] = rates_of(
        a0, a1, a2, t0, t1, t2, d0, d1, d2, w0, w1, w2, split
    )


@part
def move_stages(X: Floats, change: Floats, split: Floats, held: Floats) -> None:
    """Change the coordinates ``X (s, n, 6)`` so that poses move by body increments ``change``, to first order."""
    for k in range(X.shape[1]):
        if held[k] != 0.0:
            continue
        for i in range(X.shape[0]):
            x0, x1, x2, x3, x4, x5 = rates_of(
                X[i, k, 0],
                X[i, k, 1],
                X[i, k, 2],
                X[i, k, 3],
                X[i, k, 4],
                X[i, k, 5],
                change[i, k, 0],
                change[i, k, 1],
                change[i, k, 2],
                change[i, k, 3],
                change[i, k, 4],
                change[i, k, 5],
                split[k] != 0.0,
            )
            X[i, k, 0] += x0
            X[i, k, 1] += x1
            X[i, k, 2] += x2
            X[i, k, 3] += x3
            X[i, k, 4] += x4
            X[i, k, 5] += x5


@kernel
def coordinates(r0: Floats, q0: Floats, r: Floats, q: Floats, split: bool, X: Floats) -> None:
    """Write the coordinates ``X (6,)`` of the pose ``(r, q)`` relative to ``(r0, q0)``, less than half a turn away."""
    n0 = q0[0] * q[0] + q0[1] * q[1] + q0[2] * q[2] + q0[3] * q[3]
    n1 = q0[0] * q[1] - q0[1] * q[0] - q0[2] * q[3] + q0[3] * q[2]
    n2 = q0[0] * q[2] - q0[2] * q[0] - q0[3] * q[1] + q0[1] * q[3]
    n3 = q0[0] * q[3] - q0[3] * q[0] - q0[1] * q[2] + q0[2] * q[1]
    sign = 1.0 if n0 >= 0.0 else -1.0
    sine = math.sqrt(n1 * n1 + n2 * n2 + n3 * n3)
    factor = 2.0 * sign if sine < 1e-8 else 2.0 * math.atan2(sine, sign * n0) * sign / sine
    t0, t1, t2 = factor * n1, factor * n2, factor * n3
    X[3], X[4], X[5] = t0, t1, t2
    g0, g1, g2 = r[0] - r0[0], r[1] - r0[1], r[2] - r0[2]
    y0, y1, y2 = (
        2 * (q0[2] * g2 - q0[3] * g1),
        2 * (q0[3] * g0 - q0[1] * g2),
        2 * (q0[1] * g1 - q0[2] * g0),
    )
    u0 = g0 - q0[0] * y0 + q0[2] * y2 - q0[3] * y1
    u1 = g1 - q0[0] * y1 + q0[3] * y0 - q0[1] * y2
    u2 = g2 - q0[0] * y2 + q0[1] * y1 - q0[2] * y0
    if not split:
        # the translation of the logarithm: inverse of the left tangent, which is that of -theta
        c, _ = inverse_coefficients(t0 * t0 + t1 * t1 + t2 * t2)
        c0, c1, c2 = t1 * u2 - t2 * u1, t2 * u0 - t0 * u2, t0 * u1 - t1 * u0
        u0, u1, u2 = (
            u0 - 0.5 * c0 + c * (t1 * c2 - t2 * c1),
            u1 - 0.5 * c1 + c * (t2 * c0 - t0 * c2),
            u2 - 0.5 * c2 + c * (t0 * c1 - t1 * c0),
        )
    X[0], X[1], X[2] = u0, u1, u2


@part
def extrapolate(
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    X: Floats,
    weights: Floats,
    r1: Floats,
    q1: Floats,
    split: Floats,
    held: Floats,
    out: Floats,
) -> None:
    """Continue the motion of a step as coordinates from another start.

    Args:
        r0, q0, twist0: poses and twists at the start of the old step; X: its stage coordinates ``(stages, n, 6)``.
        weights: ``(new stages, stages + 1)``, of the old stages at the new ones, and of ``twist0`` [s].
        r1, q1: poses at the start of the new step.
        split, held: per node, coordinates are separate / pose is prescribed (left zero).
        out: ``(new stages, n, 6)``.
    """
    x = np.empty(6)
    still = np.zeros(6)
    r = np.empty(3)
    q = np.empty(4)
    twist = np.empty(6)
    for k in range(r0.shape[0]):
        for i in range(out.shape[0]):
            for a in range(6):
                out[i, k, a] = 0.0
            if held[k] != 0.0:
                continue
            for a in range(6):
                x[a] = weights[i, X.shape[0]] * twist0[k, a]
                for j in range(X.shape[0]):
                    x[a] += weights[i, j] * X[j, k, a]
            place(r0[k], q0[k], x, still, split[k] != 0.0, r, q, twist)
            coordinates(r1[k], q1[k], r, q, split[k] != 0.0, out[i, k])
