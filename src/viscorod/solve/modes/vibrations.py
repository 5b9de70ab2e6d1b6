"""Small vibrations about an equilibrium: natural frequencies, damping ratios and shapes.

The pencil ``s^2 M + s D + K`` is solved for ``1/(s - s0)``, so that the slow modes come out to full relative accuracy
however stiff the fast ones are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.constraints.null_space import null_space
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.modes.maxwell_modes import Pencil, branch_stiffness, follow_mode
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

DENSE, DENSE_DAMPED = 500, 200
"""Motions up to which full matrices are faster, without and with damping."""
TOLERANCES, RESTARTS = (1e-12, 1e-8, 1e-4), 30
"""Relative errors of eigenvalues found by iteration, and how often it starts anew for each."""
RIGID = 6
"""Free motions of a body."""


@dataclass(frozen=True)
class Linearisation:
    """Matrices of small motions about an equilibrium in the motions the supports allow: ``M x'' + D x' + K x = 0``.

    Displacements are measured in lengths of the model; ``basis`` maps them to nodal body increments ``(6 n, free)``.
    ``gradients`` ``(rows, free)`` are those of further conditions on the motions; None where the basis fulfils them.
    """

    stiffness: sparse.csr_array
    damping: sparse.csr_array
    mass: sparse.csr_array
    basis: sparse.csc_array
    gradients: sparse.csr_array | None

    @property
    def motions(self) -> int:
        """Number of independent motions that the conditions allow."""
        return int(self.mass.shape[0] - (0 if self.gradients is None else self.gradients.shape[0]))

    def unconditional(self) -> Linearisation:
        """Return the same in a full orthonormal basis of the motions that fulfil the conditions."""
        if self.gradients is None:
            return self
        Z = null_space(self.gradients)

        def within(matrix: sparse.csr_array) -> sparse.csr_array:
            return sparse.csr_array(Z.T @ (matrix @ Z))

        K, D, M = (within(matrix) for matrix in (self.stiffness, self.damping, self.mass))
        return Linearisation(K, D, M, sparse.csc_array(self.basis @ Z), None)

    def solver(self, matrix: sparse.csr_array) -> Callable[[Floats], Floats]:
        """Return a solver of systems with a matrix like the stiffness, within the conditions.

        Raises:
            SolveError: it is singular.
        """
        if self.gradients is None:
            factor = _factored(sparse.csc_array(matrix))
            return lambda b: np.asarray(factor.solve(b))
        held = self.gradients * float(np.abs(matrix.diagonal()).mean())
        whole = _factored(sparse.csc_array(sparse.block_array([[matrix, held.T], [held, None]])))
        none, size = np.zeros(held.shape[0]), matrix.shape[0]
        return lambda b: np.asarray(whole.solve(np.concatenate([b, none]))[:size])


@dataclass(frozen=True)
class Modes:
    """Modes in order of frequency.

    Motions that the material overdamps creep back at rates that crowd near one over its retardation time. In models of
    more than some hundred motions they cannot be separated, and are left out.

    Attributes:
        eigenvalues: s in ``exp(s t)`` [1/s], one of each conjugate pair (Im >= 0); overdamped modes give two real ones.
        frequencies: ``|s|/2 pi`` [Hz] (for an underdamped mode the undamped natural frequency).
        damping_ratios: ``-Re s/|s|``.
        shapes: displacement of every station ``(modes, stations, 3)``, global axes, complex, largest component 1.
        rotations: rotation of every station (body axes), same scaling.
        positions: of the stations about which they swing ``(stations, 3)`` [m].
        frequency_errors: estimated errors of the frequencies by the mesh, in parts of them; none where not estimated.
    """

    eigenvalues: np.ndarray
    frequencies: Floats
    damping_ratios: Floats
    shapes: np.ndarray
    rotations: np.ndarray
    positions: Floats
    frequency_errors: Floats = field(default_factory=lambda: np.zeros(0))


def linearise(
    solver: StaticSolver, state: State, t: float = 0.0, *, before: bool = True, scale: float = 1.0
) -> Linearisation:
    """Linearise about the equilibrium ``state`` (at rest) under ``scale`` times the loads at time ``t`` [s]."""
    system, problem = solver.system, solver.system.problem
    tangent = solver.tangent(state, t, before=before, scale=scale)
    basis = tangent.basis
    n = problem.size
    resting = State(state.r, state.q, np.zeros((n, 6)), state.multiplier)
    loads = solver.loads.at(t, before, scale)
    damping_matrix = Matrix(problem.pattern)
    system.assemble(resting, loads, None, tangent=True, moving=False, rate_matrix=damping_matrix)
    size = 6 * n  # rows of multipliers come after those of the nodes
    damping = sparse.csr_array(basis.T @ damping_matrix.sparse()[:size, :size] @ basis)
    mass = sparse.csr_array(basis.T @ sparse.block_diag(list(problem.mass), format="csr") @ basis)
    found = Linearisation(tangent.stiffness, damping, mass, basis, tangent.gradients)
    full = basis.shape[1] <= DENSE or system.relaxation is not None
    return found.unconditional() if full else found


def natural_frequencies(linear: Linearisation, count: int) -> Floats:
    """Return the ``count`` lowest undamped angular frequencies [rad/s]; rigid and unstable motions count as 0."""
    size = linear.mass.shape[0]
    count = min(count, size)
    K = 0.5 * (linear.stiffness + linear.stiffness.T)
    with np.errstate(all="ignore"):
        shift = 1e-10 * float(K.diagonal().sum() / linear.mass.diagonal().sum())
    if not np.isfinite(shift):
        raise _beyond_precision()
    shifted = sparse.csr_array(K + shift * linear.mass)
    if linear.gradients is None and (size <= DENSE or count >= size - 1):
        try:
            inverse = scipy.linalg.eigh(linear.mass.toarray(), shifted.toarray(), eigvals_only=True)[::-1]
        except np.linalg.LinAlgError:
            return np.zeros(count)
    else:
        solve, count = linear.solver(shifted), min(count, linear.motions)
        inverse = np.sort(np.real(_largest(lambda x: solve(linear.mass @ x), size, count)[0]))[::-1]
    values = 1.0 / inverse[:count] - shift
    values[values < 1e-4 * shift] = 0.0
    return np.asarray(np.sqrt(np.maximum(values, 0.0)))


def _largest(
    apply: Callable[[Floats], Floats], size: int, count: int, least: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ``count`` largest eigenvalues of an operator in size, and their vectors.

    Round-off of a long, slender rod may leave fewer digits than are wanted first; the tolerance is then relaxed. Before
    many digits are given up, fewer eigenvalues are: those that crowd cannot be separated (see :class:`Modes`). The
    start is the same each time, so that digits do not depend on chance.

    Args:
        apply: the operator; size: of its vectors; count: of eigenvalues; least: how many of them will do.

    Raises:
        SolveError: it leaves fewer than four digits.
    """
    import scipy.sparse.linalg as spla

    operator = spla.LinearOperator((size, size), matvec=apply)
    start = np.random.default_rng(1).standard_normal(size)
    space = min(size, max(2 * count + 1, 20))

    def search(wanted: int, tolerance: float) -> tuple[tuple[np.ndarray, np.ndarray] | None, int]:
        """Return eigenvalues and vectors if all were found, and how many were."""
        try:
            found = spla.eigs(operator, wanted, ncv=space, v0=start, tol=tolerance, maxiter=RESTARTS)
        except spla.ArpackNoConvergence as error:
            return None, len(error.eigenvalues)
        except spla.ArpackError:
            return None, 0
        return found, wanted

    fine, usual, coarse = TOLERANCES
    fewer = 0
    for tolerance in (fine, usual):
        found, fewer = search(count, tolerance)
        if found is not None:
            return found
    fewer = min(fewer, count - 1)
    attempts = [(count, coarse)]
    if least is not None and fewer > 0:
        attempts.insert(0 if fewer >= least else 1, (fewer, usual))
    for wanted, tolerance in attempts:
        found, _ = search(wanted, tolerance)
        if found is not None:
            return found
    raise _beyond_precision()


def _factored(matrix: sparse.csc_array) -> Any:
    """Factorise a matrix that is regular unless stiffnesses differ by more than double precision resolves."""
    import scipy.sparse.linalg as spla

    try:
        return spla.splu(matrix)
    except RuntimeError:
        raise _beyond_precision() from None


def _beyond_precision() -> SolveError:
    return SolveError(
        "Small vibrations cannot be computed: stiffnesses differ by more than double precision holds; check that "
        "lengths, sections and moduli are in SI units"
    )


def complex_modes(solver: StaticSolver, state: State, linear: Linearisation, count: int) -> Modes:
    """Return the ``count`` slowest damped modes about ``state``."""
    size = linear.mass.shape[0]
    K, D, M = linear.stiffness, linear.damping, linear.mass
    shift = _shift(linear)
    Ds = sparse.csr_array(D + 2.0 * shift * M)
    solve = linear.solver(sparse.csr_array(K + shift * D + shift**2 * M))
    if size <= DENSE_DAMPED and linear.gradients is None:
        lower = np.hstack([-solve(M.toarray()), -solve(Ds.toarray())])
        companion = np.vstack([np.hstack([np.zeros((size, size)), np.eye(size)]), lower])
        if not np.isfinite(companion).all():
            raise _beyond_precision()
        values, vectors = np.linalg.eig(companion)
    else:

        def apply(x: Floats) -> Floats:
            return np.concatenate([x[size:], -solve(M @ x[:size] + Ds @ x[size:])])

        wanted = min(2 * count + 6, 2 * linear.motions, 2 * size - 2)
        values, vectors = _largest(apply, 2 * size, wanted, least=min(count, wanted))
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


def _shift(linear: Linearisation) -> float:
    """Return the shift of the pencil [1/s]: 0, or near it where free motions make the stiffness singular."""
    import scipy.sparse.linalg as spla

    K, M = linear.stiffness, linear.mass
    if linear.gradients is not None:
        slowest = natural_frequencies(linear, 2 * RIGID)
        vibrating = slowest[slowest > 0.0]
        # beside the multiple root 0 of free motions, and far enough for it not to drown the vibrations
        return 3.0 * float(vibrating.min()) if 0 < len(vibrating) < len(slowest) else 0.0
    diagonal = np.abs(K.diagonal())
    try:
        factor = spla.splu(sparse.csc_array(K + sparse.eye_array(K.shape[0]) * 1e-300))
        pivots = np.abs(factor.U.diagonal())
    except RuntimeError:  # exactly singular
        pivots = np.array([0.0, 1.0])
    if pivots.min() < 1e-13 * pivots.max() * (diagonal.min() / diagonal.max()) or not pivots.min():
        return 1e-3 * float(np.sqrt(diagonal.sum() / M.diagonal().sum()))
    return 0.0


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
        follow_mode(pencil, complex(root), vector) if abs(root) > 1e-6 * highest else (complex(root), vector)
        for root, vector in zip(s, vectors.T, strict=True)
    ]
    values = np.array([root for root, _ in found])
    kept = np.flatnonzero(np.isfinite(values))
    order = kept[np.argsort(np.abs(values[kept]), kind="stable")]
    return values[order], np.array([found[k][1] for k in order]).T.reshape(len(vectors), -1)


def _shapes(
    solver: StaticSolver, state: State, linear: Linearisation, vectors: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return displacements and rotations of the stations for eigenvectors in the free motions."""
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
        if peak == 0.0:  # only bodies move
            peak = 1.0
        shapes.append(shape / peak)
        rotations.append(turn / peak)
    return np.array(shapes), np.array(rotations)
