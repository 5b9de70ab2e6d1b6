"""Slopes of smooth curves through points: the cubic spline, without the package that brings splines of all kinds.

Loading that package takes longer than all reports of a short run (``bench/startup.py``).
"""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["slopes_between", "spline_slopes"]


def spline_slopes(x: Floats, y: Floats) -> Floats:
    """Return the slopes ``(n,)`` at points of the cubic spline through them, not-a-knot at both ends.

    Args:
        x: where, increasing, shape (n,), n >= 2; y: values (n,). Two points give a line, three a parabola.

    Source: C. de Boor, A Practical Guide to Splines (1978), chapter IV.
    """
    from scipy.linalg import solve_banded

    h = np.diff(x)
    rise = np.diff(y) / h
    if x.size == 2:
        return np.array([rise[0], rise[0]])
    if x.size == 3:
        middle = (h[1] * rise[0] + h[0] * rise[1]) / (h[0] + h[1])
        return np.array([2.0 * rise[0] - middle, middle, 2.0 * rise[1] - middle])
    bands, right = np.zeros((3, x.size)), np.empty(x.size)
    bands[1, 1:-1] = 2.0 * (h[:-1] + h[1:])
    bands[0, 2:], bands[2, :-2] = h[:-1], h[1:]
    right[1:-1] = 3.0 * (h[1:] * rise[:-1] + h[:-1] * rise[1:])
    for end, near, far, beside in ((0, 0, 1, (0, 1)), (-1, -1, -2, (2, -2))):
        both = h[near] + h[far]
        bands[1, end] = h[far]
        bands[beside] = both
        right[end] = ((h[near] + 2.0 * both) * h[far] * rise[near] + h[near] ** 2 * rise[far]) / both
    found: Floats = solve_banded((1, 1), bands, right)
    return found


def slopes_between(x: Floats, y: Floats, slopes: Floats, at: Floats) -> Floats:
    """Return the slopes ``(m,)`` of the cubic Hermite curve through points and slopes, anywhere between its ends."""
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    h = x[k + 1] - x[k]
    u = (at - x[k]) / h
    rise = (y[k + 1] - y[k]) / h
    found: Floats = (
        6.0 * u * (1.0 - u) * rise
        + (1.0 - u) * (1.0 - 3.0 * u) * slopes[k]
        + u * (3.0 * u - 2.0) * slopes[k + 1]
    )
    return found
