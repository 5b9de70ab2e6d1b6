"""Square band matrices in LAPACK storage, factorised and solved in place."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dgbtrf, dgbtrs

from viscorod.mechanics.compiled import kernel
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.typing import Floats


@kernel
def scale_translations(data: Floats, diagonal: int, width: int, unit: float) -> None:
    """Multiply the rows and columns of displacements (three of every six) of a band by ``unit``."""
    size = data.shape[0]
    for j in range(size):
        column = unit if j % 6 < 3 else 1.0
        for i in range(max(0, j - width), min(size, j + width + 1)):
            data[j, diagonal + i - j] *= column * (unit if i % 6 < 3 else 1.0)


class BandMatrix:
    """A matrix of 6x6 node blocks whose nodes couple at most ``reach`` places apart.

    ``data`` has one row per matrix column, so that kernels add down a column contiguously; entry (i, j) stands at
    ``data[j, diagonal + i - j]``. Its transpose is LAPACK's general band storage, handed over without a copy.
    """

    def __init__(self, nodes: int, reach: int, length: float = 1.0) -> None:
        self.nodes = nodes
        # rows and columns of displacements are measured in a length near that of the model, so that pivoting compares
        # like with like; near one metre this changes nothing
        self.unit = 1.0 if 0.1 < length < 10.0 else 2.0 ** round(np.log2(length))
        self.reach = min(reach, max(nodes - 1, 0))
        self.size = 6 * nodes
        self.width = 6 * self.reach + 5
        self.diagonal = 2 * self.width
        self.data: Floats = np.zeros((self.size, 3 * self.width + 1))
        self._pivots = np.empty(0, dtype=np.int32)

    def clear(self) -> None:
        """Set all entries to zero."""
        self.data.fill(0.0)

    def factorise(self) -> None:
        """Replace the matrix by its LU factors.

        Raises:
            SingularMatrixError: a pivot is exactly zero.
        """
        if self.unit != 1.0:
            scale_translations(self.data, self.diagonal, self.width, self.unit)
        _, self._pivots, info = dgbtrf(self.data.T, self.width, self.width, overwrite_ab=1)
        if info > 0:
            raise SingularMatrixError(info - 1)

    def solve(self, right_side: Floats) -> Floats:
        """Solve with the factors; ``right_side`` (size,) or (nodes, 6) is overwritten and returned."""
        b = right_side.reshape(-1, 6)
        if self.unit != 1.0:
            b[:, :3] *= self.unit
        x, _ = dgbtrs(self.data.T, self.width, self.width, b.reshape(-1), self._pivots, overwrite_b=1)
        solution: Floats = np.asarray(x).reshape(-1, 6)
        if self.unit != 1.0:
            solution[:, :3] *= self.unit
        return solution.reshape(right_side.shape)

    def sparse(self) -> sparse.csc_array:
        """Return the (not yet factorised) matrix as a sparse array."""
        columns = self.data[:, self.width :]
        rows = np.arange(self.size)[:, None] + np.arange(-self.width, self.width + 1)
        stored = (columns != 0.0) & (rows >= 0) & (rows < self.size)
        ends = np.concatenate([[0], np.cumsum(np.count_nonzero(stored, axis=1))])
        return sparse.csc_array((columns[stored], rows[stored], ends), shape=(self.size, self.size))
