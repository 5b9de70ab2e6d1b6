"""Systems with the dynamic stiffness ``sum_i c_i A_i`` of many frequencies, solved as bands where they are narrow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.linalg import get_lapack_funcs
from scipy.sparse.csgraph import reverse_cuthill_mckee

from viscorod.errors import SolveError
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.typing import Floats

__all__ = ["DynamicStiffness", "aligned"]

NARROW = 0.2
"""Part of the size up to which a bandwidth is narrow."""
THIN = 60.0
"""Bandwidth that is narrow at any size."""


class DynamicStiffness:
    """Solves ``sum_i c_i A_i x = b`` with conditions ``G x = g``, their multipliers among the unknowns.

    Args:
        parts: the matrices ``A_i (n, n)``; gradients: ``G (m, n)`` of unit length, None without.
        units: of the unknowns ``(n,)``, by which rows and columns are scaled: lengths of displacements.
    """

    def __init__(
        self, parts: Sequence[sparse.csr_array], gradients: sparse.csr_array | None, units: Floats
    ) -> None:
        scale = sparse.diags_array(units)
        scaled = [sparse.csr_array(scale @ part @ scale) for part in parts]
        self.size, self.conditions = len(units), 0 if gradients is None else int(gradients.shape[0])
        own = sum(np.abs(part.diagonal()) for part in (scaled[0], *scaled[3:]))
        self._weight = float(own.mean()) or 1.0
        self._scale = np.concatenate([units, np.full(self.conditions, self._weight)])
        if gradients is not None:
            held = sparse.csr_array(self._weight * (gradients @ scale))
            none = sparse.csr_array((self.conditions, self.conditions))
            blocks = [[[part, held.T], [held, none]] for part in scaled[:1]]
            blocks += [[[part, None], [None, none]] for part in scaled[1:]]
            scaled = [sparse.csr_array(sparse.block_array(block)) for block in blocks]
        pattern = sparse.csr_array(sum(abs(part) for part in scaled))
        pattern = sparse.csr_array(pattern + pattern.T)
        self._order = reverse_cuthill_mckee(sparse.csr_matrix(pattern), symmetric_mode=True)
        place = np.empty(len(self._order), dtype=np.int64)
        place[self._order] = np.arange(len(place))
        row, column = (place[x] for x in pattern.nonzero())
        self._width = int(np.abs(row - column).max(initial=0))
        self._narrow = self._width <= max(NARROW * len(place), THIN)
        if self._narrow:
            bands = np.array([self._band(part, place) for part in scaled])
            self._buffer = np.zeros(bands.shape[1:], dtype=complex, order="F")
            # complex and in the order of the buffer: they are summed at every frequency
            self._parts = bands.transpose(0, 2, 1).reshape(len(bands), -1).astype(complex)
            self._gbsv = get_lapack_funcs(("gbsv",), (self._buffer,))[0]
        else:
            self._sparse = aligned(scaled, pattern)
            self._pattern = pattern

    def _band(self, matrix: sparse.csr_array, place: np.ndarray) -> Floats:
        """Return a matrix as LAPACK stores bands for its LU."""
        coo = sparse.coo_array(matrix)
        row, column = place[coo.row], place[coo.col]
        out = np.zeros((3 * self._width + 1, len(place)))
        np.add.at(out, (2 * self._width + row - column, column), coo.data)
        return out

    def solve(self, coefficients: Sequence[complex], b: np.ndarray, g: np.ndarray) -> np.ndarray:
        """Return the unknowns and the multipliers ``(n + m, k)`` for right sides ``b (n, k)`` and ``g (m, k)``.

        Raises:
            SolveError: the dynamic stiffness is singular: an undamped resonance.
        """
        right = np.concatenate([b, g]) * self._scale[:, None]
        if self._narrow:
            np.dot(np.asarray(coefficients, dtype=complex), self._parts, out=self._buffer.T.reshape(-1))
            _, _, found, info = self._gbsv(
                self._width,
                self._width,
                self._buffer,
                right[self._order],
                overwrite_ab=True,
                overwrite_b=True,
            )
            if info > 0:
                raise _resonance()
            x = np.empty_like(found)
            x[self._order] = found
        else:
            data = np.tensordot(np.asarray(coefficients), self._sparse, 1)
            whole = sparse.csc_array(
                (data, self._pattern.indices, self._pattern.indptr), shape=self._pattern.shape
            ).T
            try:
                x = SparseLU(whole).solve(right)
            except RuntimeError:
                raise _resonance() from None
        return np.asarray(x * self._scale[:, None])


def aligned(parts: Sequence[sparse.csr_array], pattern: sparse.csr_array) -> Floats:
    """Return the values of matrices in the places of a pattern that holds them all ``(parts, entries)``."""
    pattern.sort_indices()
    size = pattern.shape[0]
    keys = np.repeat(np.arange(size), np.diff(pattern.indptr)) * size + pattern.indices
    out = np.zeros((len(parts), len(keys)))
    for k, part in enumerate(parts):
        coo = sparse.coo_array(part)
        coo.sum_duplicates()
        out[k, np.searchsorted(keys, coo.row * size + coo.col)] = coo.data
    return out


def _resonance() -> SolveError:
    return SolveError(
        "there is no harmonic response: at this frequency an undamped vibration is in resonance, or nothing holds the "
        "model; give damping, or leave out frequencies that are exactly natural ones (and 0 of a free model)"
    )
