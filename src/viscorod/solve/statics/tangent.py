"""The tangent stiffness at an equilibrium, the conditions beside it, and how many of its eigenvalues are negative."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.typing import Floats

__all__ = ["Tangent", "negative_eigenvalues", "null_vector"]

NEUTRAL = 1e-13
"""Stiffness, as a part of the mean, that a direction without any is given where it would make a pivot vanish."""


@dataclass(frozen=True)
class Tangent:
    """Stiffness against small motions that supports allow; displacements are measured in lengths of the model.

    Attributes:
        stiffness: ``(free, free)``; symmetric at an equilibrium of a conservative system.
        basis: from these motions to body increments of the nodes ``(6 n, free)``.
        gradients: of the conditions of joints and held strains ``(rows, free)``, each of unit length; None without.
    """

    stiffness: sparse.csr_array
    basis: sparse.csc_array
    gradients: sparse.csr_array | None


def negative_eigenvalues(tangent: Tangent) -> int:
    """Return the number of negative eigenvalues of the stiffness (its symmetric part) in the motions allowed.

    It counts the directions in which an equilibrium of a conservative system is unstable.
    """
    symmetric = sparse.csc_array(0.5 * (tangent.stiffness + tangent.stiffness.T))
    if tangent.gradients is not None:
        return _beside_conditions(symmetric, tangent.gradients)
    pivots = _pivots(symmetric, "MMD_AT_PLUS_A")
    if pivots is None:  # exactly singular: a neutral direction, which is not a negative one
        return int(np.count_nonzero(scipy.linalg.eigvalsh(symmetric.toarray()) < 0.0))
    return int(np.count_nonzero(pivots < 0.0))


class Inverse:
    """The motions under forces, of unit size, within the conditions."""

    def __init__(self, tangent: Tangent) -> None:
        import scipy.sparse.linalg as spla

        stiffness, self._rows = sparse.csc_array(tangent.stiffness), 0
        self.size = int(stiffness.shape[0])
        scale = float(np.abs(stiffness.diagonal()).mean()) or 1.0
        whole = stiffness + NEUTRAL * scale * sparse.eye_array(self.size)
        if tangent.gradients is not None:
            self._rows = int(tangent.gradients.shape[0])
            held = scale * tangent.gradients
            whole = sparse.block_array([[whole, held.T], [held, None]])
        try:
            self._factor = spla.splu(sparse.csc_array(whole))
        except RuntimeError as error:
            raise SingularMatrixError(0) from error

    def apply(self, forces: Floats) -> Floats:
        """Return the motions under forces ``(size, ...)``."""
        right = np.concatenate([forces, np.zeros((self._rows, *forces.shape[1:]))])
        return np.asarray(self._factor.solve(right)[: self.size])


def null_vector(tangent: Tangent) -> Floats:
    """Return the nodal body increments ``(6 n,)`` of the direction with the least stiffness, by inverse iteration.

    Next to a bifurcation it is that of the branch.
    """
    inverse = Inverse(tangent)
    x = np.random.default_rng(1).standard_normal(inverse.size)
    for _ in range(8):
        x = inverse.apply(x / np.linalg.norm(x))
    increments: Floats = np.asarray(tangent.basis @ x)
    increments *= np.sign(increments[np.argmax(np.abs(increments))])
    return increments


def _beside_conditions(stiffness: sparse.csc_array, gradients: sparse.csr_array) -> int:
    """Return the number of negative eigenvalues of ``stiffness`` in the motions with ``gradients motion = 0``.

    The matrix ``[[K, G'], [G, 0]]`` has as many, and one for each independent row of ``G``. ``K + a G'G`` in place of
    ``K`` changes nothing of that, and has no direction without stiffness among the held ones. Its rows are numbered
    along the structure and each condition follows the last motion that it holds: then no pivot vanishes, and the
    effort is that of a band.
    """
    scale = float(np.abs(stiffness.diagonal()).mean()) or 1.0
    held = sparse.csr_array(gradients)
    stiffness = sparse.csc_array(stiffness / scale + held.T @ held)
    pattern = sparse.csr_array(abs(stiffness))
    order = reverse_cuthill_mckee(sparse.csr_matrix(pattern), symmetric_mode=True)
    place = np.empty(len(order))
    place[order] = np.arange(len(order))
    last = np.maximum.reduceat(place[held.indices], held.indptr[:-1])
    rows = np.argsort(np.concatenate([place, last + 0.5]), kind="stable")
    for neutral in (0.0, NEUTRAL):
        stiffness = stiffness + neutral * sparse.eye_array(len(order))
        whole = sparse.csc_array(sparse.block_array([[stiffness, held.T], [held, None]]))
        pivots = _pivots(sparse.csc_array(whole[rows][:, rows]), "NATURAL")
        if pivots is not None:
            break
    else:
        pivots = scipy.linalg.eigvalsh(whole.toarray())
    return int(np.count_nonzero(pivots < 0.0)) - int(held.shape[0])


def _pivots(matrix: sparse.csc_array, order: str) -> np.ndarray | None:
    """Return the pivots of a symmetric matrix without row exchanges; None if one vanishes.

    By Sylvester's law of inertia their signs are those of the eigenvalues, and unlike the eigenvalues themselves they
    do not drown in the round-off of the stiffest directions.
    """
    import scipy.sparse.linalg as spla

    try:
        factor = spla.splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    return np.asarray(factor.U.diagonal())
