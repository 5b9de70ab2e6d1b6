"""The tangent stiffness at an equilibrium, the conditions beside it, and how many of its eigenvalues are negative."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from viscorod.errors import SolveError
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.statics.work import Work
from viscorod.typing import Floats, Integers

__all__ = [
    "SMALL",
    "Tangent",
    "factor_without_exchanges",
    "negative_eigenvalues",
    "softest",
    "surely_positive",
    "surely_positive_factors",
    "with_one_sign",
]

ROUND_OFF = 32.0 * float(np.finfo(float).eps)
"""Rounding of the entries of a stiffness and of its pivots, as a part of the sum of a row's entries."""
NEAR, EXACT = 40, 16.0 * float(np.finfo(float).eps)
"""Motions at most whose stiffness is told apart from this round-off, and their own, as a part of what adds up to it."""
FULL = 10_000
"""Size up to which all eigenvalues are found where pivots vanish: a full matrix of it takes almost a gigabyte."""
SMALL = 200
"""Size up to which a full matrix is quicker than a sparse one."""
ITERATIONS = 8
"""Inverse iterations, next to where stiffness vanishes."""
ALIKE = 1e-6
"""Part by which components of a direction differ that are one by symmetry: what its iteration leaves."""
NEUTRAL = 1e-13
"""Stiffness, as a part of the mean, that a direction without any is given where it would make a pivot vanish."""
NOTHING = 1e-14
"""Entries of a condition, which has unit length, that are round-off."""
MANY = 3.0
"""Motions that are coupled with so many times more others than most are those of the whole structure."""


@dataclass(frozen=True)
class Tangent:
    """Stiffness against small motions that supports allow; displacements are measured in lengths of the model.

    Attributes:
        stiffness: ``(free, free)``; symmetric at an equilibrium of a conservative system.
        basis: from these motions to body increments of the nodes ``(6 n, free)``.
        gradients: of the conditions of joints and held strains ``(rows, free)``, each of unit length; None without.
        work, loss: the forms of stiffness and damping without the round-off of entries; None where not known.
    """

    stiffness: sparse.csr_array
    basis: sparse.csc_array
    gradients: sparse.csr_array | None
    work: Work | None = None
    loss: Work | None = None


def negative_eigenvalues(tangent: Tangent) -> int:
    """Return the number of negative eigenvalues of the stiffness (its symmetric part) in the motions allowed.

    It counts the directions in which an equilibrium of a conservative system is unstable, by the signs of pivots
    (Sylvester's law of inertia). Eigenvalues that may have got their sign from the rounding of the matrix, and there
    are some where the mesh of a slender rod is fine, are judged by the ``work`` of their motions (Rayleigh and Ritz).
    """
    symmetric = sparse.csc_array(0.5 * (tangent.stiffness + tangent.stiffness.T))
    if tangent.work is None or not symmetric.shape[0]:
        return _Pivots(symmetric, tangent.gradients).negative
    certain, possible, motions = _doubtful(symmetric, tangent.gradients)
    if certain == possible:
        return certain
    if motions is None:
        return _Pivots(symmetric, tangent.gradients).negative
    return certain + _negative_work(tangent.work, motions)


def _doubtful(
    symmetric: sparse.csc_array, gradients: sparse.csr_array | None
) -> tuple[int, int, Floats | None]:
    """Return how many eigenvalues are certainly and possibly negative, and the motions of those in between.

    None if there are none, too many, or they were not found.
    """
    if gradients is None and symmetric.shape[0] <= SMALL and surely_positive(symmetric.toarray()):
        return 0, 0, None
    scale = np.asarray(abs(symmetric).sum(axis=1)).ravel()
    size = sparse.diags_array(np.maximum(scale, NEUTRAL * float(scale.mean())))
    possible = _Pivots(sparse.csc_array(symmetric - ROUND_OFF * size), gradients).negative
    if possible == 0:
        return 0, 0, None
    shifted = _Pivots(sparse.csc_array(symmetric + ROUND_OFF * size), gradients)
    count = possible - shifted.negative
    motions = None
    if 0 < count <= NEAR and shifted.solve is not None:
        motions = _nearest(shifted.solve, size, count)
    return shifted.negative, possible, motions


def surely_positive(matrix: Floats) -> bool:
    """Return whether a symmetric matrix stays positive definite when its rounding is taken off: it has a root then."""
    scale = np.abs(matrix).sum(axis=1)
    lowered = matrix - np.diag(ROUND_OFF * np.maximum(scale, NEUTRAL * float(scale.mean())))
    try:
        np.linalg.cholesky(lowered)
    except np.linalg.LinAlgError:
        return False
    return bool(np.isfinite(scale).all())


def surely_positive_factors(matrix: sparse.csc_array) -> Any | None:
    """Return the factors of a sparse symmetric matrix that stays positive definite like that, else None."""
    scale = np.asarray(abs(matrix).sum(axis=1)).ravel()
    size = np.maximum(scale, NEUTRAL * float(scale.mean()))
    lowered = factor_without_exchanges(sparse.csc_array(matrix - sparse.diags_array(ROUND_OFF * size)))
    if lowered is None or not (lowered.U.diagonal() > 0.0).all():
        return None
    return factor_without_exchanges(matrix)


def _negative_work(work: Work, motions: Floats) -> int:
    """Return how many combinations of motions do negative work."""
    form, _ = work.form(motions)
    _, turned = np.linalg.eigh(form)
    form, size = work.form(motions @ turned)
    return int(np.count_nonzero(form.diagonal() < -EXACT * size))


def _nearest(solve: Callable[[Floats], Floats], size: sparse.dia_array, count: int) -> Floats | None:
    """Return the motions ``(free, count)`` whose stiffness is round-off; None if they were not found."""
    import scipy.sparse.linalg as spla

    free = size.shape[0]
    if free <= count + 1:
        return None
    inverse = spla.LinearOperator((free, free), matvec=solve, dtype=float)
    start = solve(size @ np.random.default_rng(1).standard_normal(free))
    try:
        return np.asarray(
            spla.eigsh(size, count, size, sigma=-ROUND_OFF, OPinv=inverse, which="LA", v0=start, tol=1e-6)[1]
        )
    except spla.ArpackError:
        return None


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


def softest(tangent: Tangent, count: int = 1) -> Floats:
    """Return the nodal body increments ``(6 n, count)`` of the directions with the least stiffness.

    They are found by inverse iteration. Next to a bifurcation they are those of the branches.
    """
    inverse = Inverse(tangent)
    x = np.random.default_rng(1).standard_normal((inverse.size, count))
    for _ in range(ITERATIONS):
        x = inverse.apply(np.linalg.qr(x)[0])
    return with_one_sign(np.asarray(tangent.basis @ x))


def with_one_sign(directions: Floats) -> Floats:
    """Return directions ``(n, count)`` whose largest component is positive, the first one of those that are alike.

    In a symmetric shape two are, of opposite signs, and round-off says which is larger.
    """
    size = np.abs(directions)
    first = np.argmax(size >= (1.0 - ALIKE) * size.max(axis=0), axis=0)
    found: Floats = directions * np.sign(directions[first, np.arange(directions.shape[1])])
    return found


class _Pivots:
    """Pivots of a stiffness, symmetric, in the motions allowed.

    Attributes:
        negative: how many are negative.
        solve: the motions under forces; None if a pivot vanishes.
    """

    def __init__(self, stiffness: sparse.csc_array, gradients: sparse.csr_array | None) -> None:
        self.solve: Callable[[Floats], Floats] | None = None
        if gradients is None:
            self.negative = self._free(stiffness)
        else:
            self.negative = self._beside_conditions(stiffness, gradients)

    def _free(self, stiffness: sparse.csc_array) -> int:
        size = stiffness.shape[0]
        factor = factor_without_exchanges(stiffness)
        if factor is None and size > FULL:
            scale = float(np.abs(stiffness.diagonal()).mean())
            factor = factor_without_exchanges(
                sparse.csc_array(stiffness + NEUTRAL * scale * sparse.eye_array(size))
            )
        if factor is None:  # exactly singular: a neutral direction, which is not a negative one
            return int(np.count_nonzero(_all_eigenvalues(stiffness) < 0.0))
        self.solve = factor.solve
        return int(np.count_nonzero(factor.U.diagonal() < 0.0))

    def _beside_conditions(self, stiffness: sparse.csc_array, gradients: sparse.csr_array) -> int:
        """Return the number of negative eigenvalues of ``stiffness`` in the motions with ``gradients motion = 0``.

        The matrix ``[[K, G'], [G, 0]]`` has as many, and one for each independent row of ``G``. ``K + a G'G`` in place
        of ``K`` changes nothing of that, and has no direction without stiffness among the held ones. Its rows are
        numbered along the structure and each condition follows the last motion that it holds: then no pivot vanishes,
        and the effort is that of a band.
        """
        scale = float(np.abs(stiffness.diagonal()).mean()) or 1.0
        held = sparse.csr_array(gradients, copy=True)
        held.data[np.abs(held.data) < NOTHING] = (
            0.0  # else conditions would follow motions that they do not hold
        )
        held.eliminate_zeros()
        stiffness = sparse.csc_array(stiffness / scale + held.T @ held)
        order = _along(sparse.csr_array(abs(stiffness)))
        size, conditions = len(order), int(held.shape[0])
        place = np.empty(size)
        place[order] = np.arange(size)
        last = np.maximum.reduceat(place[held.indices], held.indptr[:-1])
        rows = np.argsort(np.concatenate([place, last + 0.5]), kind="stable")
        for neutral in (0.0, NEUTRAL, 1e2 * NEUTRAL):
            stiffness = stiffness + neutral * sparse.eye_array(size)
            whole = sparse.csc_array(sparse.block_array([[stiffness, held.T], [held, None]]))
            factor = factor_without_exchanges(sparse.csc_array(whole[rows][:, rows]), "NATURAL")
            if factor is not None:
                break
        else:
            return int(np.count_nonzero(_all_eigenvalues(whole) < 0.0)) - conditions

        def solve(forces: Floats) -> Floats:
            right = np.concatenate([forces / scale, np.zeros(conditions)])
            found = np.empty_like(right)
            found[rows] = factor.solve(right[rows])
            return found[:size]

        self.solve = solve
        return int(np.count_nonzero(factor.U.diagonal() < 0.0)) - conditions


def _along(pattern: sparse.csr_array) -> Integers:
    """Return an order along the structure; motions of very many nodes, as rigid ones, come last."""
    coupled = np.diff(pattern.indptr)
    many = coupled > MANY * np.median(coupled)
    few = np.flatnonzero(~many)
    local = sparse.csr_matrix(pattern[few][:, few])
    order = few[reverse_cuthill_mckee(local, symmetric_mode=True)]
    return np.concatenate([order, np.flatnonzero(many)])


def _all_eigenvalues(matrix: sparse.csc_array) -> np.ndarray:
    """Return all eigenvalues of a symmetric matrix, by a full one.

    Raises:
        SolveError: it is too large for that.
    """
    if matrix.shape[0] > FULL:
        raise SolveError(
            "Stability cannot be told: some motions of this large model have no stiffness at all; hold them, or look "
            "for parts that nothing holds (viscorod check)"
        )
    return np.asarray(scipy.linalg.eigvalsh(matrix.toarray()))


def factor_without_exchanges(matrix: sparse.csc_array, order: str = "MMD_AT_PLUS_A") -> Any | None:
    """Return the factors of a symmetric or Hermitian matrix without row exchanges; None if a pivot vanishes.

    By Sylvester's law of inertia the signs of the pivots are those of the eigenvalues, and unlike the eigenvalues
    themselves they do not drown in the round-off of the stiffest directions.
    """
    import scipy.sparse.linalg as spla

    try:
        return spla.splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
