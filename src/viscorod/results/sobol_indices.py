"""Sobol' indices: the parts of a variance that are due to each of several independent numbers, and their errors.

Sources: A. Saltelli et al., "Variance based sensitivity analysis of model output", Comput. Phys. Commun. 181 (2010)
259-270, table 2, (b) and (f); M. J. W. Jansen, "Analysis of variance designs for model output", Comput. Phys. Commun.
117 (1999) 35-43.
"""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["sobol_indices", "with_intervals"]

RESAMPLES = 400
"""Of the bootstrap."""


def with_intervals(found: Floats, seed: int, confidence: float) -> list[dict[str, float]]:
    """Return the indices of every number, ``first`` and ``total``, with intervals of a bootstrap over the points.

    Args:
        found: values at A, B and AB ``(points, keys + 2)``, which vary; seed: of the bootstrap.
        confidence: of the intervals, ``first_lower`` to ``first_upper`` and ``total_lower`` to ``total_upper``.
    """
    first, total = sobol_indices(found)
    drawn = np.random.default_rng(seed).integers(len(found), size=(RESAMPLES, len(found)))
    again = np.array([sobol_indices(found[rows]) for rows in drawn])
    tail = 50.0 * (1.0 - confidence)
    low, high = np.percentile(again, [tail, 100.0 - tail], axis=0)
    return [
        {
            "first": first[k],
            "first_lower": low[0, k],
            "first_upper": high[0, k],
            "total": total[k],
            "total_lower": low[1, k],
            "total_upper": high[1, k],
        }
        for k in range(len(first))
    ]


def sobol_indices(found: Floats) -> tuple[Floats, Floats]:
    """Return first and total indices ``(keys,)`` of the values at A, B and AB ``(points, keys + 2)``.

    As ``scipy.stats.sobol_indices`` computes them, but for any number of points.
    """
    f = found - found[:, :2].mean()
    a, b, ab = f[:, :1], f[:, 1:2], f[:, 2:]
    variance = np.var(f[:, :2])
    first: Floats = np.mean(b * (ab - a), axis=0) / variance
    total: Floats = 0.5 * np.mean((a - ab) ** 2, axis=0) / variance
    return first, total
