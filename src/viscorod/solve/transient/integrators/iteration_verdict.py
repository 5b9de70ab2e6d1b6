"""Verdict on the simplified Newton iteration of a collocation step: go on, converged, or given up."""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import part

ROUNDING = 1e-10
"""Changes below this that do not shrink any more are made of rounding errors."""

CONVERGED, SLOW, DIVERGED, NOT_FINITE, GOING = 0, 1, 2, 3, 4


@part
def judge(
    count: int, limit: int, size: float, last: float, rate: float, tolerance: float
) -> tuple[int, float]:
    """Return the verdict on an iteration and the convergence rate.

    Args:
        count: of this iteration, from 1; limit: allowed iterations.
        size, last: sizes of this and the last change (displacement over length, or rotation [rad]).
        rate: convergence rate so far; tolerance: allowed error of what is iterated.
    """
    if not size <= 1e3:
        return DIVERGED if size <= 1e300 else NOT_FINITE, rate
    if count > 1:
        rate = max(size / last, 1e-3) if count == 2 else math.sqrt(rate * max(size / last, 1e-6))
        if size <= ROUNDING and size > 0.3 * last:
            return CONVERGED, min(rate, 0.9)
        if rate >= 0.99 and size > tolerance:
            return DIVERGED, rate
        left = limit - count
        if rate < 1.0 and size * rate**left / (1.0 - rate) > tolerance and left < limit - 2:
            return SLOW, rate
    if size == 0.0 or (rate < 1.0 and size * rate / (1.0 - rate) <= tolerance):
        return CONVERGED, rate
    return GOING, rate
