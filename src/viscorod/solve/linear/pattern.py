"""Pattern of the 6x6 blocks of a matrix: one block row per node, and one per group of six multipliers.

All matrices of a model share one pattern, symmetric and sorted by columns. Their values are arrays ``(b, 6, 6)`` whose
entry ``[s, j, i]`` is in row i and column j of block ``s`` (column by column, as LAPACK has it).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from viscorod.typing import Floats, Integers


class Pattern(NamedTuple):
    """The blocks of a matrix with ``N`` block rows, for Python and for compiled code.

    Attributes:
        rows, columns: block row and block column of every block ``(b,)``, in order of columns, then rows.
        starts: blocks ``starts[k]`` to ``starts[k + 1]`` are in block column k ``(N + 1,)``.
        across: number of the block (j, i) for the block (i, j) ``(b,)``.
        diagonal: numbers of the diagonal blocks ``(N,)``.
    """

    rows: Integers
    columns: Integers
    starts: Integers
    across: Integers
    diagonal: Integers

    @classmethod
    def of(cls, size: int, cliques: Iterable[Integers]) -> Pattern:
        """Return the pattern with all couplings within cliques.

        Args:
            size: number of block rows.
            cliques: arrays ``(count, members)`` of block rows that couple with each other, such as the nodes of
                elements.
        """
        pairs = [np.arange(size, dtype=np.int64) * (size + 1)]
        for members in cliques:
            pairs.append((members[:, None, :] * size + members[:, :, None]).ravel())
        keys = np.unique(np.concatenate(pairs))
        columns, rows = np.divmod(keys, size)
        starts = np.searchsorted(columns, np.arange(size + 1))
        across = np.searchsorted(keys, rows * size + columns)
        diagonal = np.searchsorted(keys, np.arange(size, dtype=np.int64) * (size + 1))
        return cls(
            *(np.ascontiguousarray(a, dtype=np.int64) for a in (rows, columns, starts, across, diagonal))
        )

    @property
    def size(self) -> int:
        """Number of block rows."""
        return len(self.diagonal)

    def slots(self, members: Integers) -> Integers:
        """Return the numbers of the blocks between the members of cliques.

        Args:
            members: block rows ``(count, m)``.

        Returns:
            ``(count, m, m)``: ``[e, k, j]`` is the block in the row of member k and the column of member j.
        """
        keys = self.columns * self.size + self.rows
        wanted = members[:, None, :] * self.size + members[:, :, None]
        return np.ascontiguousarray(
            np.searchsorted(keys, wanted.ravel()).reshape(wanted.shape), dtype=np.int64
        )

    def slot(self, row: int, column: int) -> int:
        """Return the number of a block."""
        first = int(self.starts[column])
        return first + int(np.searchsorted(self.rows[first : self.starts[column + 1]], row))

    def sparse(self, blocks: Floats) -> csc_array:
        """Return a matrix with the values ``blocks (b, 6, 6)`` as a sparse array, without those that are zero."""
        rows, columns = self._places()
        stored = blocks != 0.0
        size = 6 * self.size
        return csc_array((blocks[stored], (rows[stored], columns[stored])), shape=(size, size))

    def full_part(self, blocks: Floats, chosen: Integers, unit: Floats) -> Floats:
        """Return chosen rows and columns ``(k,)`` as a full matrix, each times its ``unit (k,)``."""
        whole = np.zeros((self.size, 6, self.size, 6))
        whole[self.rows, :, self.columns] = blocks.transpose(0, 2, 1)
        size = 6 * self.size
        part: Floats = whole.reshape(size, size)[np.ix_(chosen, chosen)]
        return part * unit[:, None] * unit

    def _places(self) -> tuple[Integers, Integers]:
        """Return row and column of every value of the blocks ``(b, 6, 6)``."""
        shape, within = (len(self.rows), 6, 6), np.arange(6)
        rows = np.broadcast_to(6 * self.rows[:, None, None] + within, shape)
        return rows, np.broadcast_to(6 * self.columns[:, None, None] + within[:, None], shape)
