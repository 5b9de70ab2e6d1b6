"""Loading and unloading that differ: what a static law cannot have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from viscorod.analyses.identification.members import Member
from viscorod.records.static_record import StaticRecord
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.solve.estimation.noise import MEDIAN_TO_DEVIATION
from viscorod.typing import Floats

__all__ = ["static_loops"]

FEWEST = 5
"""Loads between the ends at which two records are compared, at least: all differ to one side by chance once in 16."""
MATTERS, CLEAR = 0.01, 4.0
"""Part of the way, and times the scatter of the differences, by which records must differ to be called a loop."""


def static_loops(members: Sequence[Member], best: Estimate) -> Iterator[str]:
    """Tell of two records of one place under the same loads of which one lies beyond the other all along.

    Args:
        members: with records; best: their fit.
    """
    begin = 0
    for member in members:
        found: list[tuple[StaticRecord, Floats]] = []
        for record in member.records:
            if isinstance(record, StaticRecord):
                found.append((record, best.residuals[begin : begin + len(record.observed)]))
            begin += len(record.observed)
        for (one, left), (other, right) in combinations(found, 2):
            if one.axes == other.axes:  # place, quantity and direction
                yield from _loop(one, left, other, right)


def _loop(one: StaticRecord, left: Floats, other: StaticRecord, right: Floats) -> Iterator[str]:
    low, high = max(one.loads[0], other.loads[0]), min(one.loads[-1], other.loads[-1])
    inside = (one.loads > low) & (one.loads < high)
    if np.count_nonzero(inside) < FEWEST:
        return
    apart = left[inside] - np.interp(one.loads[inside], other.loads, right)
    scatter = MEDIAN_TO_DEVIATION * float(np.median(np.abs(np.diff(apart, 2)))) / np.sqrt(6.0)
    mean, way = float(np.abs(apart).mean()), float(np.ptp(one.values))
    if abs(np.sign(apart).sum()) == len(apart) and mean > max(MATTERS * way, CLEAR * scatter):
        part = f"{100.0 * mean / way:.2g} % of the way in the mean"
        yield (
            f"{one.name} and {other.name} differ at the same loads, always to one side and by {part}: a loop of "
            "loading and unloading (damping, friction of the grip, creep), which no static law has. Moduli lie between "
            "those of the two, and intervals do not hold for that: fit each by itself."
        )
