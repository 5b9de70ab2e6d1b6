"""Samples that stand several times in a row, because what sampled them was slower than what wrote them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.records.motion_record import Record

__all__ = ["HELD", "held_for", "without_held"]

HELD = "stands {} times in a row (it was held): the first of them is used, and the others are no samples"

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


def without_held(record: Record) -> tuple[Record, int]:
    """Return a record with the first sample of each value that was held, and for how many samples it was; 1 if none."""
    held, first = held_for(record.values)
    if held == 1:
        return record, 1
    noise = None if record.noise is None else record.noise[first::held]
    return record.with_samples(record.times[first::held], record.values[first::held], noise), held
