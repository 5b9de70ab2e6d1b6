"""Motions that constraints allow, and constraints that depend on others."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.typing import Floats, Integers

ROUND_OFF = 1e-9
"""Part of a constraint, of unit length, that others must leave of it."""


def _unit_rows(gradients: sparse.csr_array) -> tuple[Floats, Floats]:
    rows = gradients.toarray()
    size = np.linalg.norm(rows, axis=1)
    return rows / np.where(size > 0.0, size, 1.0)[:, None], size


def unit_rows(gradients: sparse.csr_array) -> sparse.csr_array:
    """Return conditions of unit length without those that do not restrict the free motions."""
    size = np.sqrt(gradients.multiply(gradients).sum(axis=1))
    kept = np.flatnonzero(size > ROUND_OFF * size.max(initial=0.0))
    unit = sparse.csr_array(sparse.diags_array(1.0 / size[kept]) @ gradients[kept])
    unit.eliminate_zeros()
    return unit


def null_space(gradients: sparse.csr_array) -> Floats:
    """Return an orthonormal basis of the motions with ``gradients motion = 0`` ``(columns, free)``.

    Args:
        gradients: ``(rows, columns)``, displacements measured in lengths of the model.
    """
    rows, _ = _unit_rows(gradients)
    Q, R, _ = scipy.linalg.qr(rows.T, pivoting=True)
    diagonal = np.abs(np.diag(R))
    rank = int(np.count_nonzero(diagonal > ROUND_OFF))
    return np.asarray(Q[:, rank:])


def dependent_rows(gradients: sparse.csr_array) -> Integers:
    """Return the rows that depend on those before them (to round-off), rows of zeros among them."""
    rows, size = _unit_rows(gradients)
    if len(rows) == 0:
        return np.zeros(0, dtype=np.int64)
    R = scipy.linalg.qr(rows.T, mode="r")[0]
    found: list[int] = []
    # R has one column per row; a column is independent if it reaches below the rows that earlier ones reach
    reached = 0
    work = R.copy()
    for j in range(work.shape[1]):
        below = work[reached:, j]
        norm = np.linalg.norm(below)
        if size[j] == 0.0 or norm <= ROUND_OFF:
            found.append(j)
            continue
        if reached < work.shape[0] - 1 and np.abs(below[1:]).max(initial=0.0) > 0.0:
            reflector = below.copy()
            reflector[0] += np.copysign(norm, below[0])
            reflector /= np.linalg.norm(reflector)
            rest = work[reached:, j:]
            rest -= 2.0 * np.outer(reflector, reflector @ rest)
        reached += 1
        if reached == work.shape[0]:
            found.extend(range(j + 1, work.shape[1]))
            break
    return np.array(found, dtype=np.int64)
