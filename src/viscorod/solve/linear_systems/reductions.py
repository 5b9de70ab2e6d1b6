"""Smaller linear systems: modes with static correction, Craig-Bampton, balanced truncation."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.linear_systems.second_order import FirstOrderMatrices, SecondOrder
from viscorod.solve.modes.linearisation import factored
from viscorod.typing import Floats, Integers

__all__ = ["balanced", "craig_bampton_basis", "modal_basis"]

FULL = 600
"""Coordinates up to which all modes are found by full matrices."""
SLOWLY = 1e-3
"""Rate at which what is taken for at rest grows where nothing holds the system, over its slowest frequency."""
INDEPENDENT = 1e-8
"""Part of a vector that must be left beside the others for it to count."""


def _symmetric(matrix: sparse.csr_array) -> sparse.csc_array:
    return sparse.csc_array(0.5 * (matrix + matrix.T))


def _modes(K: sparse.csc_array, M: sparse.csc_array, count: int, rigid: int = 0) -> tuple[Floats, Floats]:
    """Return the slowest undamped modes ``(n, count)``, ``rigid`` ones first, and their angular frequencies [rad/s]."""
    n = K.shape[0]
    if n <= max(FULL, 2 * count + 2):
        # all of them: LAPACK's methods for some eigenvalues may fail where many are nearly equal
        squares, vectors = scipy.linalg.eigh(K.toarray(), M.toarray())
        return vectors[:, :count], np.sqrt(np.maximum(squares[:count], 0.0))
    from scipy.sparse.linalg import LinearOperator, eigsh

    # beside 0, which rigid motions have: a square that is slow beside stiffness over mass
    shift = -1e-9 * float(K.diagonal().sum() / M.diagonal().sum()) if rigid else 0.0
    factor = factored(sparse.csc_array(K - shift * M))
    inverse = LinearOperator(K.shape, matvec=factor.solve, dtype=float)
    start = np.random.default_rng(1).standard_normal(n)
    squares, vectors = eigsh(K, count, M, sigma=shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return vectors[:, order], np.sqrt(np.maximum(squares[order], 0.0))


def modal_basis(system: SecondOrder, modes: int, rigid: int = 0) -> tuple[Floats, Floats]:
    """Return the slowest undamped modes and the static shapes under all inputs that they lack (static correction).

    Those of prescribed motions are under the inertial forces of their quasi-static shapes. Where nothing resists some
    ``rigid`` motions, the inertia of these balances the inputs (inertia relief). The second array are the angular
    frequencies of the modes [rad/s].
    """
    K, M = _symmetric(system.at_rest), _symmetric(system.terms[2])
    vectors, omega = _modes(K, M, max(modes, rigid + 1), rigid)
    slowest = float(omega[min(rigid, len(omega) - 1)])
    vectors, omega = vectors[:, :modes], omega[:modes]
    resting = system.at_rest
    # motions that grow slowly; their rigid part is then taken out with the modes
    factor = factored(resting + (SLOWLY * slowest) ** 2 * M if rigid else resting)
    moving = system.derivative >= 0
    right = [
        system.force[:, ~moving],
        *(part[:, moving] for part in (system.pushed_at_rest, system.pushed[2])),
    ]
    static = np.asarray(factor.solve(np.hstack(right))).reshape(K.shape[0], -1)
    return _joined(M, vectors, static), omega


def _joined(M: sparse.csc_array, vectors: Floats, others: Floats) -> Floats:
    """Return vectors and what others have beside them, orthonormal in the mass."""
    found: Floats = vectors / np.sqrt(np.einsum("ik,ik->k", vectors, M @ vectors))
    for other in others.T:
        size = np.sqrt(other @ (M @ other))
        if size == 0.0:
            continue
        x = other / size
        for _ in range(2):
            x = x - found @ (found.T @ (M @ x))
        left = np.sqrt(max(float(x @ (M @ x)), 0.0))
        if left > INDEPENDENT:
            found = np.column_stack([found, x / left])
    return found


def craig_bampton_basis(system: SecondOrder, kept: Integers, modes: int) -> Floats:
    """Return the static shapes of some kept coordinates, each 1 in turn, and modes with all of them held.

    R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6 (1968) 1313-1319.
    The kept coordinates are the first of the reduced system.
    """
    K, M = sparse.csr_array(system.terms[0]), _symmetric(system.terms[2])
    n = K.shape[0]
    inner = np.setdiff1d(np.arange(n), kept)
    basis = np.zeros((n, len(kept) + min(modes, len(inner))))
    basis[kept, np.arange(len(kept))] = 1.0
    if len(inner):
        within = sparse.csc_array(K[inner][:, inner])
        basis[inner, : len(kept)] = -np.asarray(factored(within).solve(K[inner][:, kept].toarray()))
        if modes:
            basis[inner, len(kept) :] = _modes(
                _symmetric(sparse.csr_array(within)), sparse.csc_array(M[inner][:, inner]), modes
            )[0]
    return basis


def balanced(system: SecondOrder, order: int) -> tuple[FirstOrderMatrices, Floats]:
    """Return the balanced truncation to an order, and all Hankel singular values.

    B. C. Moore, Principal component analysis in linear systems, IEEE Trans. Automatic Control 26 (1981) 17-32, by
    square roots of the Gramians (Laub, Heath, Paige and Ward 1987), in states whose squares are energies. The
    largest error of a response is at most twice the sum of the values left out.

    Raises:
        SolveError: a motion of the system does not decay.
    """
    A, B, C, D = _in_energies(system)
    if np.linalg.eigvals(A).real.max() >= 0.0:
        raise SolveError(
            "balanced truncation needs a system in which every motion decays: prescribed motions and what nothing "
            "holds or damps do not; take method = 'modal' or 'craig_bampton'"
        )
    left = _root(scipy.linalg.solve_continuous_lyapunov(A, -B @ B.T))
    right = _root(scipy.linalg.solve_continuous_lyapunov(A.T, -C.T @ C))
    U, values, V = np.linalg.svd(right.T @ left)
    order = min(order, int(np.count_nonzero(values > 1e-14 * values[0])))
    scale = 1.0 / np.sqrt(values[:order])
    T, L = left @ V[:order].T * scale, (right @ U[:, :order] * scale).T
    return FirstOrderMatrices(L @ A @ T, L @ B, C @ T, D), values


def _in_energies(system: SecondOrder) -> FirstOrderMatrices:
    """Return the equations of first order in modes, each state times the root of the energy that its unit has."""
    K, M = (_symmetric(system.terms[k]).toarray() for k in (0, 2))
    _, vectors = scipy.linalg.eigh(K, M)
    inner = system.within(vectors)
    sizes = [np.sqrt(np.abs(inner.terms[0].diagonal())), np.ones(inner.size)]
    sizes += [np.sqrt(np.abs(term.diagonal())) for term in inner.terms[3:]]
    A, B, C, D = inner.first_order()
    scale = np.ones(len(A))
    scale[: inner.size * len(sizes)] = np.concatenate(sizes)
    scale[scale == 0.0] = 1.0
    return FirstOrderMatrices(scale[:, None] * A / scale, scale[:, None] * B, C / scale, D)


def _root(gramian: Floats) -> Floats:
    """Return a square root of a Gramian whose eigenvalues may be round-off below zero."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
