"""Samples that stand several times in a row, because what sampled them was slower than what wrote them."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["held_for"]

RUNS = 16
"""Runs of equal values that must be there to tell."""
MOST = 0.98
"""Part of the runs that are as long, or twice, thrice as long where neighbours happen to be equal."""


def held_for(values: Floats) -> tuple[int, int]:
    """Return how many samples of values (n,) each value is held for, and where the first whole run begins; 1 and 0.

    Levels of a coarse converter are held for as long as the motion stays within one, which is another number of samples
    each time.
    """
    changes = np.flatnonzero(np.diff(values)) + 1
    runs = np.diff(changes)
    if len(runs) < RUNS:
        return 1, 0
    usual = int(np.median(runs))
    if usual < 2 or np.count_nonzero(runs % usual == 0) < MOST * len(runs):
        return 1, 0
    return usual, int(changes[0]) % usual
