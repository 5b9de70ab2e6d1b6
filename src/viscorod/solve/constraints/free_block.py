"""What supports leave of a matrix: its rows and columns of the motions that are free, as a sparse matrix.

Where these are among the blocks depends on the layout of a model alone, and is found once for all its matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.once import once_of_layout
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["FreeBlock", "free_block", "free_rows"]


@dataclass(frozen=True)
class FreeBlock:
    """Some rows and columns of the matrices of one pattern, each times a unit, without entries that are zero.

    Attributes:
        places: of the entries among the values of all blocks ``(e,)``, row by row, columns ascending.
        columns: of the entries among the chosen ones ``(e,)``; ends: of the rows among the entries ``(k + 1,)``.
        unit: of the chosen rows and columns ``(k,)``.
    """

    places: Integers
    columns: np.ndarray
    ends: Integers
    unit: Floats

    @classmethod
    def of(cls, pattern: Pattern, chosen: Integers, unit: Floats) -> FreeBlock:
        """Find chosen rows and columns ``(k,)``, ascending, in a pattern; ``unit (k,)`` is that of each."""
        number, within = np.full(6 * pattern.size, -1), np.arange(6)
        number[chosen] = np.arange(len(chosen))
        shape = (len(pattern.rows), 6, 6)
        rows = np.broadcast_to(6 * pattern.rows[:, None, None] + within, shape).ravel()
        columns = np.broadcast_to(6 * pattern.columns[:, None, None] + within[:, None], shape).ravel()
        rows, columns = number[rows], number[columns]
        inside = np.flatnonzero((rows >= 0) & (columns >= 0))
        places = inside[np.lexsort((columns[inside], rows[inside]))]
        ends = np.searchsorted(rows[places], np.arange(len(chosen) + 1))
        # SciPy's own kind of index for sizes like these
        return cls(places, columns[places].astype(np.int32), ends, unit)

    def matrix(self, blocks: Floats) -> csr_array:
        """Return the part of a matrix with the values ``blocks (b, 6, 6)``: ``(k, k)``."""
        across = np.repeat(self.unit, np.diff(self.ends))
        values = blocks.ravel()[self.places] * across * self.unit[self.columns]
        stored = values != 0.0
        before = np.append(0, np.cumsum(stored))
        size = len(self.ends) - 1
        ends = before[self.ends].astype(np.int32)
        found = csr_array((values[stored], self.columns[stored], ends), shape=(size, size))
        found.has_canonical_format = True
        return found


@once_of_layout
def free_rows(problem: Problem) -> Integers:
    """Return the rows of the balance ``(6 n,)`` that supports leave: those of motions that they do not hold."""
    free = np.ones((problem.size, 6), dtype=bool)
    free[problem.supports.nodes] = problem.supports.fixed == 0.0
    return np.flatnonzero(free.ravel())


@once_of_layout
def free_block(problem: Problem) -> FreeBlock:
    """Return what is left of the matrices of a problem; displacements are measured in lengths of the model."""
    free = free_rows(problem)
    return FreeBlock.of(problem.pattern, free, np.where(free % 6 < 3, problem.length, 1.0))
