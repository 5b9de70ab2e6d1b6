"""Arc length and rotation-minimising frames of smooth parametric curves, to round-off.

A curve r(u) is cut into panels on which a Gauss rule integrates speed and turning to round-off. In a panel
the first frame is rotated by the smallest rotation that takes the panel's first tangent t0 to the tangent t; it
turns about t at the rate -t0.(t x t')/(1 + t0.t), so that the opposite angle, a quadrature, makes it
rotation-minimising (compare Bergou et al., Discrete elastic rods, 2008, and the writhe formula of Fuller
1978).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from viscorod.model.fields.definition import RefusedError
from viscorod.typing import Floats, Integers

__all__ = ["SmoothCurve", "chebyshev_curve"]

Evaluate: TypeAlias = Callable[[Floats], tuple[Floats, Floats, Floats]]
"""u (n,) -> r, dr/du, d2r/du2, (n, 3) each."""

GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(20)
HALF_X, HALF_W = (GAUSS_X + 1.0) / 2.0, GAUSS_W / 2.0
MOST_PANELS = 4096


class SmoothCurve:
    """A parametric curve with its arc length s and a rotation-minimising frame.

    Args:
        evaluate: gives r, r', r'' for parameters u.
        breaks: increasing parameters; between two of them the curve is smooth.
    """

    def __init__(self, evaluate: Evaluate, breaks: Floats) -> None:
        self._evaluate = evaluate
        self._starts, lengths, turns = self._panels(breaks)
        self._s = np.concatenate([[0.0], np.cumsum(lengths)])
        self.length = float(self._s[-1])
        self._frames = self._panel_frames(turns)

    def parameter(self, s: Floats) -> tuple[Floats, Integers]:
        """Return parameters u (n,) and panel numbers (n,) of the arc lengths s (n,)."""
        panel: Integers = np.clip(np.searchsorted(self._s, s, side="right") - 1, 0, len(self._starts) - 2)
        first, last = self._starts[panel], self._starts[panel + 1]
        wanted, whole = s - self._s[panel], self._s[panel + 1] - self._s[panel]
        u = first + (last - first) * wanted / whole
        for _ in range(30):
            step = (self._integrate(first, u)[0] - wanted) / self._speed(u)
            u = np.clip(u - step, first, last)
            if np.all(np.abs(step) <= 4e-16 * np.abs(last - first)):
                break
        return u, panel

    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, 3) and rotation-minimising frames (n, 3, 3; tangent last) at s (n,)."""
        u, panel = self.parameter(s)
        position, first, _ = self._evaluate(u)
        tangent = _unit(first)
        turn = self._integrate(self._starts[panel], u)[1]
        return position, _transport(self._frames[panel], tangent, turn)

    def curvature(self, s: Floats) -> Floats:
        """Return the second derivative of the position by arc length (n, 3), 1/m."""
        _, first, second = self._evaluate(self.parameter(s)[0])
        speed = np.linalg.norm(first, axis=1, keepdims=True)
        tangent = first / speed
        normal: Floats = (second - (second * tangent).sum(axis=1, keepdims=True) * tangent) / speed**2
        return normal

    def _speed(self, u: Floats) -> Floats:
        speed: Floats = np.linalg.norm(self._evaluate(u)[1], axis=1)
        return speed

    def _integrate(self, first: Floats, last: Floats, pieces: int = 1) -> tuple[Floats, Floats]:
        """Return the arc length and turning angle (n,) from `first` to `last` (n,), each pair within one panel.

        The rule is applied to each of `pieces` equal parts; the angle is NaN where the tangent turns too far.
        """
        part = np.arange(pieces)[:, None] / pieces
        x, weight = (part + HALF_X / pieces).ravel(), np.tile(HALF_W / pieces, pieces)
        size = (last - first)[:, None]
        u = first[:, None] + size * x
        _, velocity, second = (array.reshape(*u.shape, 3) for array in self._evaluate(u.ravel()))
        start = self._evaluate(first)[1][:, None, :]
        with np.errstate(divide="ignore", invalid="ignore"):
            start = start / np.linalg.norm(start, axis=2, keepdims=True)
            speed = np.linalg.norm(velocity, axis=2)
            tangent = velocity / speed[:, :, None]
            cosine = (tangent * start).sum(axis=2)
            turning = (np.cross(tangent, second) * start).sum(axis=2) / speed / (1.0 + cosine)
        turning = np.where(cosine > 0.7, turning, np.nan)
        return (weight * size * speed).sum(axis=1), (weight * size * turning).sum(axis=1)

    def _panels(self, breaks: Floats) -> tuple[Floats, Floats, Floats]:
        """Return starts (n+1,), lengths (n,) and turning angles (n,) of panels fine enough for the quadrature."""
        done: list[tuple[Floats, Floats, Floats]] = []
        first, last = breaks[:-1], breaks[1:]
        total = 0.0
        for _ in range(50):
            length, turn = self._integrate(first, last)
            finer_length, finer_turn = self._integrate(first, last, pieces=2)
            total = total or float(finer_length.sum())
            # A NaN angle compares as False: the panel is halved.
            good = (np.abs(finer_length - length) <= 1e-14 * total) & (np.abs(finer_turn - turn) <= 1e-14)
            done.append((first[good], finer_length[good], finer_turn[good]))
            first, last = first[~good], last[~good]
            if not len(first) or len(first) > MOST_PANELS:
                break
            middle = (first + last) / 2.0
            first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
        if not len(first):  # a stop exactly between two panels is inside neither
            ends = np.unique(np.concatenate([breaks, *(part[0] for part in done)]))
            speed = self._speed(ends)
            first = ends[speed <= 1e-9 * speed.max()]
        if len(first):
            raise RefusedError(
                "the centre line stops, turns back or has a corner there",
                "give a smooth curve; for a corner make two rods and attach them",
                found=f"near the parameter {float(first.min()):.6g}",
            )
        starts, lengths, turns = (np.concatenate(parts) for parts in zip(*done, strict=True))
        order = np.argsort(starts)
        return np.append(starts[order], breaks[-1]), lengths[order], turns[order]

    def _panel_frames(self, turns: Floats) -> Floats:
        """Return the rotation-minimising frame at the start of every panel (n, 3, 3)."""
        tangents = _unit(self._evaluate(self._starts)[1])
        seed = np.eye(3)[np.argmin(np.abs(tangents[0]))]
        normal = _unit(seed - (seed @ tangents[0]) * tangents[0])
        frame = np.column_stack([normal, np.cross(tangents[0], normal), tangents[0]])
        frames = [frame]
        for tangent, turn in zip(tangents[1:], turns, strict=True):
            frame = _transport(frame[None], tangent[None], np.array([turn]))[0]
            frames.append(frame)
        return np.array(frames)


def _unit(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def _transport(frames: Floats, tangents: Floats, turns: Floats) -> Floats:
    """Take `frames` (n, 3, 3) to `tangents` (n, 3) by the smallest rotations, then turn them by `turns`."""
    normal, start = frames[:, :, 0], frames[:, :, 2]
    cosine = (start * tangents).sum(axis=1, keepdims=True)
    normal = normal - (normal * tangents).sum(axis=1, keepdims=True) / (1.0 + cosine) * (start + tangents)
    normal = _unit(normal - (normal * tangents).sum(axis=1, keepdims=True) * tangents)
    binormal = np.cross(tangents, normal)
    c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
    return np.stack([c * normal + s * binormal, c * binormal - s * normal, tangents], axis=2)


def chebyshev_curve(function: Callable[[float], Floats], degree: int = 32) -> tuple[Evaluate, Floats]:
    """Expand a Python function on [0, 1] in piecewise Chebyshev series, to round-off, with two derivatives.

    Args:
        function: u -> r (3,).
        degree: of the series in a panel; a panel is halved until its last coefficients vanish.

    Returns:
        the evaluation for `SmoothCurve` and the ends of the panels.

    Raises:
        RefusedError: the function has a corner or a jump.
    """
    nodes = np.polynomial.chebyshev.chebpts1(degree + 1)
    to_series = np.linalg.inv(np.polynomial.chebyshev.chebvander(nodes, degree))
    waiting, done = [(0.0, 1.0)], []
    scale = 0.0
    while waiting:
        a, b = waiting.pop()
        values = np.array([function(float(u)) for u in a + (b - a) * (nodes + 1.0) / 2.0])
        scale = max(scale, float(np.ptp(values, axis=0).max()), 0.01 * float(np.abs(values).max()))
        series = to_series @ values
        if np.abs(series[-4:]).max() <= 1e-13 * scale:
            done.append((a, b, series))
        elif b - a < 2.0**-26 or len(waiting) + len(done) > MOST_PANELS:
            raise RefusedError(
                "the centre line has a corner or a jump there, or cannot be resolved to 12 digits",
                "give a smooth curve; for a corner make two rods and attach them",
                found=f"near the parameter {a:.6g}",
            )
        else:
            waiting += [((a + b) / 2.0, b), (a, (a + b) / 2.0)]
    points = np.concatenate([panel[2][:1] for panel in done])
    if max(np.abs(panel[2][1:]).max() for panel in done) + np.ptp(points, axis=0).max() <= 1e-9 * scale:
        raise RefusedError("the centre line stops: all its points are the same", "give a curve", found="")
    done.sort(key=lambda panel: panel[0])
    starts = np.array([panel[0] for panel in done])
    sizes = np.array([panel[1] - panel[0] for panel in done])
    coefficients = np.array([panel[2] for panel in done])
    derivative = np.polynomial.chebyshev.chebder(coefficients, axis=1)
    _require_smooth_joints(starts, sizes, coefficients, derivative, scale)
    second = np.polynomial.chebyshev.chebder(derivative, axis=1)

    def evaluate(u: Floats) -> tuple[Floats, Floats, Floats]:
        panel = np.clip(np.searchsorted(starts, u, side="right") - 1, 0, len(starts) - 1)
        x = np.clip(2.0 * (u - starts[panel]) / sizes[panel] - 1.0, -1.0, 1.0)
        stretch = 2.0 / sizes[panel][:, None]
        basis = np.polynomial.chebyshev.chebvander(x, degree)
        return (
            np.einsum("nk,nki->ni", basis, coefficients[panel]),
            np.einsum("nk,nki->ni", basis[:, :-1], derivative[panel]) * stretch,
            np.einsum("nk,nki->ni", basis[:, :-2], second[panel]) * stretch**2,
        )

    return evaluate, np.append(starts, 1.0)


def _require_smooth_joints(
    starts: Floats, sizes: Floats, coefficients: Floats, derivative: Floats, scale: float
) -> None:
    """Refuse a jump, a corner or a stop exactly between two panels, which neither panel shows."""
    first, last = (-1.0) ** np.arange(coefficients.shape[1]), np.ones(coefficients.shape[1])
    gap = np.einsum("k,nki->ni", first, coefficients)[1:] - np.einsum("k,nki->ni", last, coefficients)[:-1]
    right = (np.einsum("k,nki->ni", first[:-1], derivative) * (2.0 / sizes)[:, None])[1:]
    left = (np.einsum("k,nki->ni", last[:-1], derivative) * (2.0 / sizes)[:, None])[:-1]
    noise = 1e-9 * scale / np.minimum(sizes[1:], sizes[:-1])  # of the slopes
    slow = np.minimum(np.linalg.norm(left, axis=1), np.linalg.norm(right, axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.linalg.norm(
            left / np.linalg.norm(left, axis=1)[:, None] - right / np.linalg.norm(right, axis=1)[:, None],
            axis=1,
        )
    bad = (
        (np.linalg.norm(gap, axis=1) > 1e-10 * scale)
        | (slow <= noise)
        | ~(turn * slow <= 1e-6 * slow + noise)
    )
    if bad.any():
        raise RefusedError(
            "the centre line jumps, stops or has a corner there",
            "give a smooth curve; for a corner make two rods and attach them",
            found=f"near the parameter {float(starts[1:][bad][0]):.6g}",
        )
