"""Groups of block rows that are eliminated first, each on its own: the interiors of elements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from viscorod.solve.linear.pattern import Pattern
from viscorod.typing import Integers


class Fronts(NamedTuple):
    """Groups of one size ``interior (count, k)``, and all that they couple with ``boundary (count, m)``."""

    interior: Integers
    boundary: Integers


class Elimination(NamedTuple):
    """Eliminated groups and the remaining matrix.

    Attributes:
        fronts: the groups, by size.
        rows: the remaining block rows ``(M,)``.
        remaining: the pattern between them, in their own numbering; it contains what the elimination adds.
    """

    fronts: Sequence[Fronts]
    rows: Integers
    remaining: Pattern

    @classmethod
    def of(cls, pattern: Pattern, interiors: Iterable[Integers], without: Sequence[int] = ()) -> Elimination:
        """Eliminate what is possible: groups that touch another one remain.

        Args:
            pattern: all blocks.
            interiors: groups of block rows, one array ``(count, k)`` per size.
            without: block rows that are left out, with their columns, and their groups are not eliminated.
        """
        there = np.ones(pattern.size, dtype=bool)
        there[list(without)] = False
        given = (np.asarray(members, dtype=np.int64) for members in interiors)
        groups = [members[there[members].all(axis=1)] for members in given]
        sizes = np.concatenate([np.zeros(0, int), *(np.full(len(g), g.shape[1]) for g in groups)]).astype(int)
        members = np.concatenate([np.zeros(0, np.int64), *(g.ravel() for g in groups)])
        numbers = np.repeat(np.arange(len(sizes)), sizes)
        owner = _owners(pattern, members, numbers)
        if owner is None:
            if there.all():
                return cls((), np.arange(pattern.size), pattern)
            owner = np.full(pattern.size, -1)

        rows = np.flatnonzero((owner < 0) & there)
        of_column = owner[pattern.columns]
        leaving = (of_column >= 0) & (owner[pattern.rows] < 0) & there[pattern.rows]
        keys = np.unique(of_column[leaving] * pattern.size + pattern.rows[leaving])
        touching, boundary = np.divmod(keys, pattern.size)
        inner = np.concatenate([[0], np.cumsum(sizes)])
        outer = np.searchsorted(touching, np.arange(len(sizes) + 1))
        kept = np.zeros(len(sizes), dtype=bool)
        kept[owner[owner >= 0]] = True
        shapes = np.column_stack([sizes, np.diff(outer)])
        fronts = []
        for k, m in np.unique(shapes[kept], axis=0):
            same = np.flatnonzero(kept & (shapes == (k, m)).all(axis=1))
            fronts.append(
                Fronts(
                    members[inner[same][:, None] + np.arange(k)],
                    boundary[outer[same][:, None] + np.arange(m)],
                )
            )

        place = np.full(pattern.size, -1)
        place[rows] = np.arange(len(rows))
        both = (place[pattern.rows] >= 0) & (place[pattern.columns] >= 0)
        pairs = np.column_stack([place[pattern.rows[both]], place[pattern.columns[both]]])
        return cls(fronts, rows, Pattern.of(len(rows), [pairs, *(place[f.boundary] for f in fronts)]))

    @property
    def cost(self) -> float:
        """Time [ns] of the elimination as measured: some per group, and more speed for larger ones."""
        total = 0.0
        for interior, boundary in self.fronts:
            n, m = 6.0 * interior.shape[1], 6.0 * boundary.shape[1]
            flops = n**3 * 2.0 / 3.0 + 2.0 * n**2 * m + 2.0 * n * m**2
            total += len(interior) * (900.0 + flops / min(18.0, 3.0 + n / 11.0))
        return total


def _owners(pattern: Pattern, members: Integers, numbers: Integers) -> Integers | None:
    """Return the group of every block row ``(N,)``, -1 if it has none or touches another; None if no group is left."""
    owner = np.full(pattern.size, -1)
    owner[members] = numbers
    bad = numbers[owner[members] != numbers]  # a row of two groups: the last one has it, and is bad as well
    bad = np.union1d(bad, owner[members[owner[members] != numbers]])
    first, second = owner[pattern.rows], owner[pattern.columns]
    bad = np.union1d(bad, first[(first >= 0) & (second >= 0) & (first != second)])
    owner[np.isin(owner, bad)] = -1
    return owner if (owner >= 0).any() else None
