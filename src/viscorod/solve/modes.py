"""Small vibrations about an equilibrium: natural frequencies, damping ratios and shapes.

The pencil ``s^2 M + s D + K`` is solved for ``1/(s - s0)``, so that the slow modes come out to full relative
accuracy however
stiff the fast ones are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.history import StationReader
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.relaxing_modes import Pencil, branch_stiffness, follow
from viscorod.solve.static import StaticSolver
from viscorod.solve.system import State
from viscorod.typing import Floats

DENSE = 500


@dataclass(frozen=True)
class Linearisation:
    """Matrices of small motions about an equilibrium in the motions the supports allow: ``M x'' + D x' + K x = 0``.

    Displacements are measured in lengths of the model; ``basis`` maps them to nodal body increments ``(6 n, free)``.
    """

    stiffness: sparse.csr_array
    damping: sparse.csr_array
    mass: sparse.csr_array
    basis: sparse.csc_array


@dataclass(frozen=True)
class Modes:
    """Modes in order of frequency.

    Attributes:
        eigenvalues: s in ``exp(s t)`` [1/s], one of each conjugate pair (Im >= 0); overdamped modes give two real ones.
        frequencies: ``|s|/2 pi`` [Hz] (for an underdamped mode the undamped natural frequency).
        damping_ratios: ``-Re s/|s|``.
        shapes: displacement of every station ``(modes, stations, 3)``, global axes, complex, largest component 1.
        rotations: rotation of every station (body axes), same scaling.
        positions: of the stations about which they swing ``(stations, 3)`` [m].
    """

    eigenvalues: np.ndarray
    frequencies: Floats
    damping_ratios: Floats
    shapes: np.ndarray
    rotations: np.ndarray
    positions: Floats


def linearise(
    solver: StaticSolver, state: State, t: float = 0.0, *, before: bool = True, scale: float = 1.0
) -> Linearisation:
    """Linearise about the equilibrium ``state`` (at rest) under ``scale`` times the loads at time ``t`` [s]."""
    system, problem = solver.system, solver.system.problem
    stiffness = solver.tangent(state, t, before=before, scale=scale)
    basis = solver.basis(state)
    n = problem.size
    resting = State(state.r, state.q, np.zeros((n, 6)), state.multiplier)
    loads = solver.loads.at(t, before, scale)
    damping_matrix = Matrix(problem.pattern)
    system.assemble(resting, loads, None, tangent=True, moving=False, rate_matrix=damping_matrix)
    size = 6 * n  # rows of multipliers come after those of the nodes
    damping = sparse.csr_array(basis.T @ damping_matrix.sparse()[:size, :size] @ basis)
    mass = sparse.csr_array(basis.T @ sparse.block_diag(list(problem.mass), format="csr") @ basis)
    # displacements over the length of the model are comparable with rotations, whatever the unit of length
    constrained = system.constraints.rows > 0  # the basis takes care of that then
    lengths = (
        np.ones(basis.shape[1])
        if constrained
        else np.where(solver.supports.free_rows() % 6 < 3, problem.length, 1.0)
    )
    unit = sparse.diags_array(lengths)
    return Linearisation(
        sparse.csr_array(unit @ stiffness @ unit),
        sparse.csr_array(unit @ damping @ unit),
        sparse.csr_array(unit @ mass @ unit),
        sparse.csc_array(basis @ unit),
    )


def natural_frequencies(linear: Linearisation, count: int) -> Floats:
    """Return the ``count`` lowest undamped angular frequencies [rad/s]; rigid and unstable motions count as 0."""
    import scipy.sparse.linalg as spla

    size = linear.mass.shape[0]
    count = min(count, size)
    K = 0.5 * (linear.stiffness + linear.stiffness.T)
    with np.errstate(all="ignore"):
        shift = 1e-10 * float(K.diagonal().sum() / linear.mass.diagonal().sum())
    if not np.isfinite(shift):
        raise _beyond_precision()
    shifted = sparse.csc_array(K + shift * linear.mass)
    if size <= DENSE or count >= size - 1:
        try:
            inverse = scipy.linalg.eigh(linear.mass.toarray(), shifted.toarray(), eigvals_only=True)[::-1]
        except np.linalg.LinAlgError:
            return np.zeros(count)
    else:
        solve = _factored(shifted).solve
        operator = spla.LinearOperator((size, size), matvec=lambda x: solve(linear.mass @ x))
        inverse = np.sort(np.real(spla.eigs(operator, count, return_eigenvectors=False)))[::-1]
    values = 1.0 / inverse[:count] - shift
    values[values < 1e-4 * shift] = 0.0
    return np.asarray(np.sqrt(np.maximum(values, 0.0)))


def _factored(matrix: sparse.csc_array) -> Any:
    """The factors of a matrix that is regular unless stiffnesses differ by more than numbers have digits."""
    import scipy.sparse.linalg as spla

    try:
        return spla.splu(matrix)
    except RuntimeError:
        raise _beyond_precision() from None


def _beyond_precision() -> SolveError:
    return SolveError(
        "Small vibrations cannot be told: stiffnesses differ by more than double precision holds; check that "
        "lengths, sections and moduli are in SI units"
    )


def negative_eigenvalues(tangent: sparse.csc_array) -> int:
    """Return the number of negative eigenvalues of the symmetric part of a tangent stiffness."""
    import scipy.sparse.linalg as spla

    symmetric = 0.5 * (tangent + sparse.csc_array(tangent.T))
    # Sylvester's law of inertia: without row exchanges the signs of the pivots are those of the eigenvalues, and unlike
    # the eigenvalues themselves they do not drown in the round-off of the stiffest directions
    try:
        factor = spla.splu(
            symmetric, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:  # exactly singular: a neutral direction, which is not a negative one
        return int(np.count_nonzero(scipy.linalg.eigvalsh(symmetric.toarray()) < 0.0))
    return int(np.count_nonzero(factor.U.diagonal() < 0.0))


def complex_modes(solver: StaticSolver, state: State, linear: Linearisation, count: int) -> Modes:
    """Return the ``count`` slowest damped modes about ``state``."""
    import scipy.sparse.linalg as spla

    size = linear.mass.shape[0]
    K, D, M = linear.stiffness, linear.damping, linear.mass
    shift = 0.0
    diagonal = np.abs(K.diagonal())
    try:
        factor = spla.splu(sparse.csc_array(K + sparse.eye_array(size) * 1e-300))
        pivots = np.abs(factor.U.diagonal())
    except RuntimeError:  # exactly singular
        pivots = np.array([0.0, 1.0])
    if pivots.min() < 1e-13 * pivots.max() * (diagonal.min() / diagonal.max()) or not pivots.min():
        shift = 1e-3 * float(np.sqrt(diagonal.sum() / M.diagonal().sum()))
    Ks = sparse.csc_array(K + shift * D + shift**2 * M)
    Ds = sparse.csr_array(D + 2.0 * shift * M)
    factor = _factored(Ks)
    if size <= DENSE:
        lower = np.hstack([-factor.solve(M.toarray()), -factor.solve(Ds.toarray())])
        companion = np.vstack([np.hstack([np.zeros((size, size)), np.eye(size)]), lower])
        if not np.isfinite(companion).all():
            raise _beyond_precision()
        values, vectors = np.linalg.eig(companion)
    else:

        def apply(x: Floats) -> Floats:
            return np.concatenate([x[size:], -factor.solve(M @ x[:size] + Ds @ x[size:])])

        operator = spla.LinearOperator((2 * size, 2 * size), matvec=apply)
        values, vectors = spla.eigs(operator, min(2 * count + 6, 2 * size - 2))
    kept = np.flatnonzero(np.abs(values) > 1e-14 * np.abs(values).max())
    s = shift + 1.0 / values[kept]
    kept, s = kept[s.imag >= -1e-12 * np.abs(s)], s[s.imag >= -1e-12 * np.abs(s)]
    order = np.argsort(np.abs(s), kind="stable")[:count]
    s, vectors = s[order], vectors[:size, kept[order]]
    if solver.system.relaxation is not None:
        s, vectors = _with_branches(solver, state, linear, s, vectors)
    shapes, rotations = _shapes(solver, state, linear, vectors)
    size_s = np.abs(s)
    ratio = np.divide(-s.real, size_s, out=np.zeros(len(s)), where=size_s > 0.0)
    positions = StationReader(solver.system.problem).read(state.r, state.q, np.zeros_like(state.twist))[0]
    return Modes(s, size_s / (2.0 * np.pi), ratio, shapes, rotations, positions)


def _with_branches(
    solver: StaticSolver, state: State, linear: Linearisation, s: np.ndarray, vectors: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return what the modes of the relaxed rods become with their Maxwell branches; lost ones are left out."""
    system = solver.system
    assert system.relaxation is not None
    branches = tuple(
        sparse.csr_array(linear.basis.T @ branch @ linear.basis)
        for branch in branch_stiffness(system, system.relaxation, state)
    )
    pencil = Pencil(linear.stiffness, linear.damping, linear.mass, branches, system.relaxation.times)
    highest = float(np.abs(s).max(initial=0.0))
    found = [
        follow(pencil, complex(root), vector) if abs(root) > 1e-6 * highest else (complex(root), vector)
        for root, vector in zip(s, vectors.T, strict=True)
    ]
    values = np.array([root for root, _ in found])
    kept = np.flatnonzero(np.isfinite(values))
    order = kept[np.argsort(np.abs(values[kept]), kind="stable")]
    return values[order], np.array([found[k][1] for k in order]).T.reshape(len(vectors), -1)


def _shapes(
    solver: StaticSolver, state: State, linear: Linearisation, vectors: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and rotations of the stations for eigenvectors in the free motions."""
    reader = StationReader(solver.system.problem)
    shapes, rotations = [], []
    for vector in (linear.basis @ vectors).T:
        parts = []
        for part in (vector.real, vector.imag):
            parts.append(reader.read(state.r, state.q, np.ascontiguousarray(part).reshape(-1, 6))[2:])
        shape = parts[0][0] + 1j * parts[1][0]
        turn = parts[0][1] + 1j * parts[1][1]
        peak = shape.ravel()[np.argmax(np.abs(shape))]
        if np.abs(peak) < 1e-12 * np.abs(turn).max():  # pure twisting
            peak = turn.ravel()[np.argmax(np.abs(turn))]
        if peak == 0.0:  # only what is no rod moves
            peak = 1.0
        shapes.append(shape / peak)
        rotations.append(turn / peak)
    return np.array(shapes), np.array(rotations)
