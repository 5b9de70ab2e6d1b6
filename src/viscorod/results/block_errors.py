"""Errors of what Sobol' points tell, from how much blocks of consecutive points differ.

Each block of 2^m consecutive points of a scrambled sequence is spread as evenly as a sequence of that length by itself,
so that blocks serve as replicates, and the gain of even points over independent ones is in the error. Blocks fill each
other's gaps: all points together are better than replicates that know nothing of each other, and the error is rather
too large than too small. Numbers that are independent have the error of independent numbers.

Sources: A. B. Owen, "Monte Carlo variance of scrambled net quadrature", SIAM J. Numer. Anal. 34 (1997) 1884-1910;
R. S. Woodruff, "Confidence intervals for medians and other position measures", J. Amer. Statist. Assoc. 47 (1952)
635-646 (a quantile between two others, whose levels differ from its own by the error of the distribution function).
"""

from __future__ import annotations

import math

import numpy as np

from viscorod.typing import Floats

__all__ = ["mean_error", "quantile_interval"]

BLOCKS = 16
"""Replicates; the factor of Student's distribution is 2.13 for 95 %."""
LEAST = 4 * BLOCKS
"""Numbers from which on there are blocks of four at least; fewer count as independent."""
SLACK = 2.0
"""Members by which a quantile is uncertain in any case: of one number that varies, blocks may all be wrong alike."""


def mean_error(values: Floats) -> float:
    """Return the standard error of the mean of numbers ``(points, rows)``, NaN where a member has none."""
    known = values[np.isfinite(values)]
    if not _in_blocks(values, len(known)):
        return float(known.std(ddof=1)) / math.sqrt(len(known))
    return _error(np.where(np.isfinite(values), values - known.mean(), 0.0), len(known))


def quantile_interval(values: Floats, level: float, confidence: float) -> tuple[float, float]:
    """Return the interval of a quantile, infinite on a side where members are too few for a bound.

    Args:
        values: a number of the members at every point ``(points, rows)``, NaN where a member has none.
        level: of the quantile, between 0 and 1; confidence: of the interval.
    """
    from scipy.stats import quantile_test, t

    have = np.isfinite(values)
    known = np.sort(values[have])
    count = len(known)
    if not _in_blocks(values, count):
        low, high = quantile_test(known, p=level).confidence_interval(confidence)
        return (-math.inf if math.isnan(low) else float(low), math.inf if math.isnan(high) else float(high))
    middle = np.quantile(known, level)
    error = 0.0
    for below in (values < middle, values <= middle):  # they differ where many members have the same number
        error = max(error, _error(np.where(have, below - below[have].mean(), 0.0), count))
    reach = max(float(t.ppf(0.5 + 0.5 * confidence, BLOCKS - 1)) * error, SLACK / count)
    first, last = math.floor(count * (level - reach)), math.ceil(count * (level + reach)) + 1
    return (
        float(known[first - 1]) if first >= 1 else -math.inf,
        float(known[last - 1]) if last <= count else math.inf,
    )


def _in_blocks(values: Floats, known: int) -> bool:
    return known >= LEAST and len(values) % BLOCKS == 0


def _error(deviations: Floats, count: int) -> float:
    """Return the standard error of the mean of ``count`` numbers, from their deviations from it ``(points, rows)``."""
    blocks = BLOCKS * deviations.reshape(BLOCKS, -1).sum(axis=1) / count
    return float(blocks.std(ddof=1)) / math.sqrt(BLOCKS)
