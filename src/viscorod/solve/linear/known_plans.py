"""Plans that are made once for all matrices alike: members of a sweep differ in numbers, not in what couples.

A plan depends on the numbers of blocks alone: on how a model is divided and joined, which is its topology. So it is
found again by these, and a model that is divided or joined otherwise has another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan
from viscorod.typing import Integers

__all__ = ["plan_of"]

MOST_BLOCKS = 5_000
"""Blocks of a matrix beyond which its plan is not kept: numbers are a small part of the work then."""
KEPT = 32
"""Plans that are kept, those that were used last."""


def plan_of(pattern: Pattern, interiors: Sequence[Integers], without: tuple[int, ...] = ()) -> Plan:
    """Return the plan of a matrix, see ``Plan.of``: that of an earlier one with the same blocks, if it is kept.

    Args:
        pattern: all blocks; interiors: groups of block rows that couple with no other group.
        without: block rows whose unknowns are zero.
    """
    if len(pattern.rows) > MOST_BLOCKS:
        return Plan.of(pattern, interiors, without)
    return _kept(_Alike(pattern, interiors, without))


class _Alike:
    """A pattern and its interiors, equal to all that have the same numbers."""

    def __init__(self, pattern: Pattern, interiors: Sequence[Integers], without: tuple[int, ...]) -> None:
        self.pattern, self.interiors, self.without = pattern, interiors, without
        arrays = pattern.rows, pattern.columns, pattern.diagonal, *interiors
        self._content = tuple((array.shape, array.dtype.str, array.tobytes()) for array in arrays)
        self._number = hash((self._content, without))

    def __hash__(self) -> int:
        return self._number

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Alike):
            return False
        return self._content == other._content and self.without == other.without


@lru_cache(maxsize=KEPT)
def _kept(alike: _Alike) -> Plan:
    return Plan.of(alike.pattern, alike.interiors, alike.without)
