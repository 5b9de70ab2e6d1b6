"""Which unknowns of a matrix of blocks are solved for; all others are zero."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.solve.linear.pattern import Pattern
from viscorod.typing import Integers


class Unknowns(NamedTuple):
    """The unknowns of a matrix with ``6 N`` of them that are solved for: ``s`` in each of ``M`` of its block rows.

    Attributes:
        pattern: blocks between these block rows, in their own numbers.
        blocks: the number of each of these blocks in the matrix ``(b,)``.
        equations, numbers: of the matrix, by which and for which is solved ``(M, s)``.
        others: unknowns that are zero ``(6 N - M s,)``.
    """

    pattern: Pattern
    blocks: Integers
    equations: Integers
    numbers: Integers
    others: Integers

    @classmethod
    def every(cls, pattern: Pattern) -> Unknowns:
        """Return all unknowns of a matrix."""
        numbers = np.arange(6 * pattern.size).reshape(-1, 6)
        return cls(pattern, np.arange(len(pattern.rows)), numbers, numbers, np.zeros(0, int))

    @classmethod
    def some(cls, pattern: Pattern, rows: Integers, equations: Integers, components: Integers) -> Unknowns:
        """Return some unknowns of a matrix, which couple with no others.

        Args:
            pattern: of the matrix.
            rows: block rows, ascending ``(M,)``.
            equations, components: the places, 0 to 5, of equations and unknowns in each ``(M, s)``.
        """
        place = np.full(pattern.size, -1)
        place[rows] = np.arange(len(rows))
        blocks = np.flatnonzero((place[pattern.rows] >= 0) & (place[pattern.columns] >= 0))
        pairs = np.column_stack([place[pattern.rows[blocks]], place[pattern.columns[blocks]]])
        numbers = 6 * rows[:, None] + components
        return cls(
            Pattern.of(len(rows), [pairs]),
            blocks,
            6 * rows[:, None] + equations,
            numbers,
            np.setdiff1d(np.arange(6 * pattern.size), numbers),
        )

    @property
    def whole(self) -> bool:
        """Whether these are all unknowns of the matrix."""
        return len(self.others) == 0

    @property
    def size(self) -> int:
        """Number of unknowns in a block row."""
        return int(self.numbers.shape[1])

    def own(self, rows: Integers) -> Integers:
        """Return block rows of the matrix in the numbers of those solved for; -1 for others."""
        place = np.full((len(self.others) + self.numbers.size) // 6, -1)
        place[self.numbers[:, 0] // 6] = np.arange(len(self.numbers))
        return np.asarray(place[rows])
