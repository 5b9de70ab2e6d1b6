"""The smallest solution of large sparse equations that are short of rank by a few: a border finds the null space.

``[[A, B], [C', 0]]`` with a few random columns B and rows C' is regular if A lacks no more ranks than there are of
them; what solves it with right sides in the last rows tells the null space of A (Govaerts, Numerical Methods for
Bifurcations of Dynamical Equilibria, SIAM 2000, chapter 3).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.solve.modes.linearisation import factored
from viscorod.typing import Floats

__all__ = ["smallest_solution"]

BORDER = 8
"""Columns of the border, which is the largest loss of rank."""
RANK = 1e-11
"""Part of the length of a vector that it may leave in equations of unit size, if it is one of the null space."""


def smallest_solution(matrix: sparse.csr_array, right: Floats) -> Floats:
    """Return the smallest x that fulfils ``matrix x = right`` best, all equations and unknowns being of unit size.

    Raises:
        SolveError: the matrix lacks more ranks than expected.
    """
    size = int(matrix.shape[0])
    random = np.random.default_rng(1)
    columns, rows = (random.standard_normal((size, BORDER)) / np.sqrt(size) for _ in range(2))
    whole = sparse.block_array([[matrix, sparse.csr_array(columns)], [sparse.csr_array(rows.T), None]])
    factor = factored(whole)
    sides = np.zeros((size + BORDER, 1 + BORDER))
    sides[:size, 0] = right
    sides[size:, 1:] = np.eye(BORDER)
    found = factor.solve(sides)
    found += factor.solve(sides - whole @ found)
    x, others = found[:size, 0], found[:size, 1:]
    left, values, weights = np.linalg.svd(found[size:, 1:])
    motions = others @ weights.T
    lengths = np.linalg.norm(motions, axis=0)
    null = np.linalg.norm(matrix @ motions, axis=0) <= RANK * lengths
    # without the forces in the border that regular motions can balance
    against = left.T @ found[size:, 0]
    share = np.where(null, 0.0, -against / np.where(null, 1.0, values))
    x = x + motions @ share
    if null.any():
        space, _ = np.linalg.qr(motions[:, null])
        x = x - space @ (space.T @ x)
    return np.asarray(x)
