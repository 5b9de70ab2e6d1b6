"""Where a function of the arc length bends or jumps: elements that end there see it as it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.typing import Floats

__all__ = ["kinks"]

SAMPLES, FINER, PASSES = 256, 8, 3
"""Intervals in which a function is sampled, how many more there are where kinks crowd, and how often."""
SHARP = 4.0
"""Second difference beside those of its neighbours that makes a kink: a smooth function has ratios near 1."""
NOTICED = 1e-5
"""Least second difference over the range of the values that counts."""
ROUGH = 0.5
"""Relative change of second differences from one sample to the next that no smooth function has."""
CLOSE = 2e-4
"""Kinks nearer to each other or to an end of the rod than this part of its length are one."""
STEEP = 4.0
"""Slope over those beside it that makes a jump."""
STRAIGHT = 0.02
"""How far from straight lines the function may be beside a kink, as a part of the kink."""
BISECTIONS = 40


def kinks(function: Callable[[float], Floats], length: float, samples: int = SAMPLES) -> list[float]:
    """Find the arc lengths between 0 and ``length`` [m] at which a function has a kink or a jump.

    In a piecewise linear function second differences of samples vanish but for those beside a kink, and in a smooth
    one neighbours are alike. Values left and right of a kink lie on two lines, whose intersection it is; a jump is
    found by bisection. Where kinks crowd, samples are taken closer to each other.

    Args:
        function: of the arc length, returns an array (n,).
        length: of the rod, m.
        samples: intervals to begin with; fewer where a value is costly.

    Returns:
        The arc lengths in ascending order, m.
    """
    found: list[float] = []
    _search(function, 0.0, length, samples, PASSES if samples == SAMPLES else 1, found)
    kept: list[float] = []
    for s in sorted(found):
        if s - (kept[-1] if kept else 0.0) > CLOSE * length and length - s > CLOSE * length:
            kept.append(s)
    return kept


def _search(
    function: Callable[[float], Floats], start: float, end: float, count: int, passes: int, found: list[float]
) -> None:
    """Add the kinks between two arc lengths to ``found``."""
    h = (end - start) / count
    s = start + h * np.arange(count + 1)
    values = np.array([function(float(x)) for x in s])
    span = np.ptp(values, axis=0)
    varying = np.flatnonzero(span > 1e-9 * np.abs(values).max(axis=0))
    if not len(varying):
        return
    scaled = values[:, varying] / span[varying]
    second = np.abs(scaled[2:] - 2.0 * scaled[1:-1] + scaled[:-2])  # at the samples 1, 2, ...
    # a kink between two samples shows at both of them
    pair = second[1:-2] + second[2:-1]
    sharp = np.where(pair > NOTICED, pair - SHARP * (second[:-3] + second[3:]), 0.0)
    component = np.argmax(sharp, axis=1)
    excess = sharp[np.arange(len(pair)), component]
    rough = (np.abs(np.diff(second, axis=0)) > ROUGH * np.maximum(second[1:], second[:-1])) & (
        np.maximum(second[1:], second[:-1]) > NOTICED
    )
    unclear = np.concatenate([[False], rough.any(axis=1), [False]])  # of the intervals
    for k in np.flatnonzero(excess > 0.0):
        if excess[k] < max(excess[max(k - 1, 0)], excess[min(k + 1, len(excess) - 1)]):
            continue
        at = _located(function, float(s[k + 2]), h, int(varying[component[k]]))
        if at is not None:
            found.append(at)
            unclear[k + 1 : k + 4] = False
    if passes > 1:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], unclear, [False]]).astype(int)))
        for first, last in edges.reshape(-1, 2):
            low, high = max(first - 2, 0), min(last + 2, count)
            _search(function, float(s[low]), float(s[high]), FINER * int(high - low), passes - 1, found)


def _located(function: Callable[[float], Floats], s: float, h: float, component: int) -> float | None:
    """Return the kink or jump of one component between ``s`` and ``s + h``, None if it is not smooth beside them."""

    def value(x: float) -> float:
        return float(function(x)[component])

    a, b, c, d = (value(x) for x in (s - h, s, s + h, s + 2.0 * h))
    left, right = (b - a) / h, (d - c) / h
    if left != right:
        # b + left x = c + right (x - h)
        x = (c - right * h - b) / (left - right)
        if -1e-6 * h <= x <= h * (1.0 + 1e-6):
            bent = max(abs(value(s - 0.5 * h) - 0.5 * (a + b)), abs(value(s + 1.5 * h) - 0.5 * (c + d)))
            return s + min(max(x, 0.0), h) if bent < STRAIGHT * abs(left - right) * h else None
    if abs(c - b) < STEEP * h * max(abs(left), abs(right)):
        return None
    low, high = s, s + h
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        y = value(middle)
        if abs(y - b) < abs(y - c):
            low, b = middle, y
        else:
            high, c = middle, y
    return 0.5 * (low + high)
