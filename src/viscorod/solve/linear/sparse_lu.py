"""Sparse LU of a matrix that is symmetric, or nearly so, whose entries are of very different sizes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse

from viscorod.typing import Floats

THRESHOLD = 0.1
"""SuperLU keeps to the diagonal, and so to the ordered fill, where its entry has this share of the largest below."""

NOTHING = 1e-14
"""Part of the largest entry of a row below which its diagonal is round-off of 0; that of a definite matrix is above."""


class SparseLU:
    """LU of a sparse matrix, real or complex, whose fill is that of its pattern.

    Rows and columns are first scaled by the roots of the diagonal. Otherwise pivots of slender rods, whose stretch is a
    million times stiffer than their bending, leave the diagonal, and the fill grows with the square of the length.

    Args:
        matrix: ``(n, n)``; rows may have a zero diagonal, as those of conditions do.

    Raises:
        RuntimeError: a pivot is exactly zero.
    """

    def __init__(self, matrix: Any) -> None:
        from scipy.sparse.linalg import splu

        matrix = sparse.csc_array(matrix)
        if not matrix.has_canonical_format:
            matrix = matrix.copy()
            matrix.sum_duplicates()
        self.scales = _scales(matrix)
        across = np.repeat(self.scales, np.diff(matrix.indptr))
        values = self.scales[matrix.indices] * matrix.data * across
        scaled = sparse.csc_array((values, matrix.indices, matrix.indptr), shape=matrix.shape)
        self._factors: Any = splu(scaled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=THRESHOLD)

    @property
    def nonzeros(self) -> int:
        """Number of entries of both factors."""
        return int(self._factors.nnz)

    @property
    def phase(self) -> float:
        """Phase [rad] of the determinant."""
        factors = self._factors
        odd = _parity(factors.perm_r) * _parity(factors.perm_c) < 0
        return float(np.angle(factors.U.diagonal()).sum() + np.pi * odd)

    def solve(self, b: np.ndarray, *, transposed: bool = False) -> np.ndarray:
        """Return the solutions for right sides ``(n,)`` or ``(n, m)``, of the transposed system if that is wanted."""
        scales = self.scales if b.ndim == 1 else self.scales[:, None]
        found = self._factors.solve(scales * b, "T" if transposed else "N")
        return np.asarray(scales * found)


def _scales(matrix: sparse.csc_array) -> Floats:
    """Return factors ``(n,)`` of rows and columns that make the diagonal 1; where there is none, the largest entry.

    Of a diagonal that is round-off the root would be a scale without meaning, and pivots would follow it.
    """
    largest = np.zeros(matrix.shape[0])
    np.maximum.at(largest, matrix.indices, np.abs(matrix.data))
    diagonal = np.abs(matrix.diagonal())
    own = np.sqrt(np.where(diagonal > NOTHING * largest, diagonal, 0.0))
    scales = np.divide(1.0, own, out=np.zeros_like(own), where=own > 0.0)
    if not own.all():
        beside = np.asarray((abs(matrix) @ sparse.diags_array(scales)).max(axis=1).todense()).ravel()
        scales = np.where(own > 0.0, scales, 1.0 / np.where(beside > 0.0, beside, 1.0))
    return np.asarray(scales)


def _parity(order: np.ndarray) -> int:
    """Return the sign of a permutation."""
    seen, sign = np.zeros(len(order), dtype=bool), 1
    for first in range(len(order)):
        place, length = first, 0
        while not seen[place]:
            seen[place] = True
            place, length = int(order[place]), length + 1
        if length and length % 2 == 0:
            sign = -sign
    return sign


def solver_within(matrix: Any, gradients: Any) -> Callable[[Floats], Floats]:
    """Return what solves systems with a matrix in the motions that conditions allow; right sides are columns.

    Args:
        matrix: ``(n, n)``.
        gradients: of the conditions ``(rows, n)``, each of unit length; None without.

    Raises:
        RuntimeError: it is singular.
    """
    if gradients is None:
        factor = SparseLU(matrix)
        return lambda b: np.asarray(factor.solve(b))
    held = gradients * float(np.abs(matrix.diagonal()).mean())
    whole = SparseLU(sparse.block_array([[matrix, held.T], [held, None]]))
    rows, size = held.shape[0], matrix.shape[0]
    return lambda b: np.asarray(whole.solve(np.concatenate([b, np.zeros((rows, *b.shape[1:]))]))[:size])
