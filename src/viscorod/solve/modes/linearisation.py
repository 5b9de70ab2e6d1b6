"""Small motions about an equilibrium as matrices, with the motions of rigid parts apart from those of strains.

Elements do not resist rigid motions of the parts between joints, whatever their strains. That follows from geometry, so
it is not left to round-off: these motions are coordinates of their own, in which only loads, springs and dampers act,
and those that nothing resists are rigid motions exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.constraints.free_block import free_block
from viscorod.solve.constraints.null_space import null_space
from viscorod.solve.constraints.rigid_motions import RigidParts, motions_of_parts, surely_held
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear.sparse_lu import SparseLU, solver_within
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.second_variation import without_elements
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.work import Work
from viscorod.typing import Floats

DENSE = 500
"""Motions up to which full matrices are faster."""
FREE = 1e-8
"""Resistance to a motion, as a part of what adds up to it, that is round-off."""
FAINT = 1e-10
"""Reactions below this part of the largest force are round-off."""
EPS = float(np.finfo(float).eps)
STILL = 1e3 * EPS
"""Part of a rigid motion below which a place does not move in it."""


@dataclass(frozen=True)
class Linearisation:
    """Matrices of small motions about an equilibrium in the motions the supports allow: ``M x'' + D x' + K x = 0``.

    Displacements are measured in lengths of the model; ``basis`` maps them to nodal body increments ``(6 n, free)``.
    ``gradients`` ``(rows, free)`` are those of further conditions on the motions; None where the basis fulfils them.
    The first ``rigid`` motions are free of stiffness and described by ``texts``; the first ``parts``, these among
    them, are rigid motions of the parts between joints. ``work`` and ``loss`` are the forms of
    stiffness and damping without the round-off of entries; None where not known. ``levers`` ``(6 n,)`` are forces at
    nodes times the length of the model [N m] for their rotations: round-off of a lever of length 0 is a part of it.
    """

    stiffness: sparse.csr_array
    damping: sparse.csr_array
    mass: sparse.csr_array
    basis: sparse.csc_array
    gradients: sparse.csr_array | None
    rigid: int = 0
    parts: int = 0
    texts: tuple[str, ...] = field(default=(), compare=False)
    work: Work | None = field(default=None, compare=False)
    loss: Work | None = field(default=None, compare=False)
    levers: Floats | None = field(default=None, compare=False)

    @property
    def motions(self) -> int:
        """Number of independent motions that the conditions allow."""
        return int(self.mass.shape[0] - (0 if self.gradients is None else self.gradients.shape[0]))

    def unconditional(self) -> Linearisation:
        """Return the same in a full basis of the motions that fulfil the conditions."""
        if self.gradients is None:
            return self
        k = self.parts
        Z = sparse.block_diag([sparse.eye_array(k), null_space(self.gradients[:, k:])], format="csr")

        def within(matrix: sparse.csr_array) -> sparse.csr_array:
            return sparse.csr_array(Z.T @ (matrix @ Z))

        K, D, M = (within(matrix) for matrix in (self.stiffness, self.damping, self.mass))
        return replace(
            self,
            stiffness=K,
            damping=D,
            mass=M,
            basis=sparse.csc_array(self.basis @ Z),
            gradients=None,
            work=None if self.work is None else self.work.within(Z),
            loss=None if self.loss is None else self.loss.within(Z),
        )

    def solver(self, matrix: sparse.csr_array) -> Callable[[Floats], Floats]:
        """Return a solver of systems with a matrix like the stiffness, within the conditions; right sides are columns.

        Raises:
            SolveError: it is singular.
        """
        try:
            return solver_within(matrix, self.gradients)
        except RuntimeError:
            raise beyond_precision() from None

    def strained(self) -> tuple[sparse.csr_array, sparse.csr_array | None]:
        """Return stiffness and gradients of all motions but the rigid ones."""
        k = self.rigid
        return self.stiffness[k:, k:], None if self.gradients is None else self.gradients[:, k:]


def nodal_motions(problem: Problem) -> Linearisation:
    """Return the body increments of all nodes as motions, with their inertia alone."""
    size = 6 * problem.size
    none = sparse.csr_array((size, size))
    mass = block_diagonal(problem.mass)
    return Linearisation(none, none, mass, sparse.csc_array(sparse.eye_array(size)), None)


def rigid_parts(system: System, supports: SupportState, state: State) -> RigidParts | None:
    """Return the rigid motions of parts that supports and joints allow in a state; None if surely none."""
    problem = system.problem
    if surely_held(problem):
        return None
    held = [supports.motion_gradients(k, state) for k in range(len(supports.set.nodes))]
    return motions_of_parts(problem, state.r, state.q, held, system.constraints.measure(state)[2])


def linearise(
    solver: StaticSolver, state: State, t: float = 0.0, *, before: bool = True, scale: float = 1.0
) -> Linearisation:
    """Linearise about the equilibrium ``state`` (at rest) under ``scale`` times the loads at time ``t`` [s]."""
    system, problem = solver.system, solver.system.problem
    damping_matrix = Matrix(problem.pattern)
    resting = State(state.r, state.q, np.zeros((problem.size, 6)), state.multiplier)
    tangent = solver.tangent(resting, t, before=before, scale=scale, rate_matrix=damping_matrix)
    basis, size = tangent.basis, 6 * problem.size  # rows of multipliers come after those of the nodes
    supports = solver.supports
    loads = solver.loads.at(t, before, scale)
    noise = _force_noise(solver)
    balance = _without_noise(system.residual(), noise, problem.length)
    damping = _within(supports, basis, damping_matrix.blocks)
    inertia = np.zeros_like(damping_matrix.blocks)
    inertia[problem.pattern.diagonal[: problem.size]] = np.swapaxes(problem.mass, 1, 2)
    mass = _within(supports, basis, inertia)
    levers = _levers(system.internal, system.external, problem.length)
    whole = Linearisation(
        tangent.stiffness,
        damping,
        mass,
        basis,
        tangent.gradients,
        work=tangent.work,
        loss=tangent.loss,
        levers=levers,
    )
    found, parts = whole, rigid_parts(system, supports, resting)
    if parts is not None and parts.found:
        # what resists rigid motions of parts: loads, reactions, springs and dampers
        bare, resistance = without_elements(system), Matrix(problem.pattern)
        held_by = np.where(np.abs(state.multiplier) > noise, state.multiplier, 0.0)
        held_by[problem.held.place] = 0.0
        resting = State(state.r, state.q, resting.twist, held_by)
        bare.assemble(resting, loads, None, tangent=True, moving=False, rate_matrix=resistance)
        remainder, _ = supports.reduce_tangent(state, balance, bare.matrix)
        dampers = sparse.csr_array(basis.T @ resistance.sparse()[:size, :size] @ basis)
        found = _apart(whole, parts, remainder, dampers)
    full = basis.shape[1] <= DENSE
    return found.unconditional() if full else found


def _within(supports: SupportState, basis: sparse.csc_array, blocks: Floats) -> sparse.csr_array:
    """Return ``basis' A basis`` of the matrix with these values: where a basis only picks motions, without products."""
    problem = supports.problem
    if len(supports.partial):
        size = 6 * problem.size
        return sparse.csr_array(basis.T @ problem.pattern.sparse(blocks)[:size, :size] @ basis)
    return free_block(problem).matrix(blocks)


def _force_noise(solver: StaticSolver) -> float:
    """Return the force [N] that is round-off of the last assembly of a solver, or an error of its equilibrium."""
    system, problem = solver.system, solver.system.problem
    unit = np.repeat([1.0, 1.0 / problem.length], 3)
    largest = max(float(np.abs(f * unit).max(initial=0.0)) for f in (system.internal, system.external))
    stiff = max((float(e.stiffness[:, :3, :3].max(initial=0.0)) for e in problem.sets), default=0.0)
    return max(FAINT * largest, 1e3 * EPS * stiff)


def _without_noise(forces: Floats, noise: float, length: float) -> Floats:
    """Return forces and moments, or gaps, ``(N, 6)`` with zeros for those that are round-off."""
    size = np.abs(forces) * np.repeat([1.0, 1.0 / length], 3)
    return np.where(size > noise, forces, 0.0)


def _apart(
    whole: Linearisation, parts: RigidParts, remainder: sparse.csr_array, dampers: sparse.csr_array
) -> Linearisation:
    """Return the same in rigid motions of parts, free ones first, and what is left of the motions without them.

    Args:
        whole: in the motions that supports allow.
        parts: what is rigid; remainder, dampers: the stiffness and the damping that resist it.
    """
    basis, size = whole.basis, whole.mass.shape[0]
    C = _coordinates(basis, parts.increments)
    unit = np.abs(C).max(axis=0)
    # what a motion does not move would be taken for resisted by the loads there
    C = _moving(C / unit)
    weights = unresisted(remainder, C)
    rigid, k = weights.shape[1], C.shape[1]
    motions = parts.combined(weights / unit[:, None]) if rigid else []
    if motions:
        free = _coordinates(basis, np.array([m.increments.ravel() for m in motions]).T)
        around, _ = scipy.linalg.qr(weights)
        C = np.hstack([free / np.abs(free).max(axis=0), C @ around[:, rigid:]])
    # what is on the axis of a rotation does not move: a damper there would resist the rounding of zero
    C = _moving(C)
    _, _, places = scipy.linalg.qr(C.T, mode="economic", pivoting=True)
    others = np.setdiff1d(np.arange(size), places[:k])
    ones = np.ones(size - k), (others, np.arange(size - k))
    T = sparse.csr_array(sparse.hstack([sparse.csc_array(C), sparse.csc_array(ones, shape=(size, size - k))]))

    def split(matrix: sparse.csr_array, resisting: Floats) -> sparse.csr_array:
        """Return ``T' matrix T``, with ``resisting (size, k)``, what the matrix makes of the motions of parts."""
        right, corner = resisting[others], C.T @ resisting
        left = _like(right.T, (matrix.T @ C)[others].T, (abs(matrix).T @ np.abs(C))[others].T)
        corner = _like(corner.T, corner, np.abs(C).T @ (abs(matrix) @ np.abs(C)))
        rows = [[corner, left], [right, matrix[others][:, others]]]
        return sparse.csr_array(sparse.block_array([[sparse.csr_array(b) for b in row] for row in rows]))

    stiff = np.asarray(remainder @ C)
    stiff[:, :rigid] = 0.0
    gradients = whole.gradients
    if gradients is not None:
        none = sparse.csr_array((gradients.shape[0], k))
        gradients = sparse.csr_array(sparse.hstack([none, gradients[:, others]]))
    return Linearisation(
        split(whole.stiffness, stiff),
        split(whole.damping, np.asarray(dampers @ C)),
        sparse.csr_array(T.T @ whole.mass @ T),
        sparse.csc_array(basis @ T),
        gradients,
        rigid,
        k,
        tuple(m.text for m in motions),
        None if whole.work is None else whole.work.within(T),
        None if whole.loss is None else whole.loss.within(T),
        whole.levers,
    )


def _levers(internal: Floats, external: Floats, length: float) -> Floats:
    """Return the forces at all nodes ``(N, 6)`` times a length for their rotations, 0 for displacements ``(6 N,)``."""
    found = np.zeros((len(internal), 6))
    size = np.maximum(np.linalg.norm(internal[:, :3], axis=1), np.linalg.norm(external[:, :3], axis=1))
    found[:, 3:] = length * size[:, None]
    return found.ravel()


def _moving(motions: Floats) -> Floats:
    """Return motions (columns) without the round-off of what does not move in them."""
    return np.where(np.abs(motions) > STILL * np.abs(motions).max(axis=0), motions, 0.0)


def _like(wanted: Floats, found: Floats, size: Floats) -> Floats:
    """Return ``found``, and what is ``wanted`` where only round-off of entries of that ``size`` differs."""
    return np.where(np.abs(found - wanted) <= 1e3 * EPS * size, wanted, found)


def unresisted(matrix: sparse.csr_array, motions: Floats) -> Floats:
    """Return orthonormal weights ``(k, m)`` of the ``motions (size, k)`` that a matrix does not resist.

    Each row counts as a part of what adds up to it: a soft spring beside a hard one is not taken for round-off.
    """
    forces = np.asarray(matrix @ motions)
    size = np.asarray(abs(matrix) @ np.abs(motions)).max(axis=1)
    rows = forces[size > 0.0] / size[size > 0.0, None]
    triangle = np.linalg.qr(rows, mode="r") if len(rows) > len(rows.T) else rows
    _, values, directions = np.linalg.svd(triangle)
    return directions[np.count_nonzero(values > FREE) :].T


def _coordinates(basis: sparse.csc_array, increments: Floats) -> Floats:
    """Return the motions (columns of ``basis``) that make up nodal body increments ``(6 n, k)``."""
    gram = sparse.csc_array(basis.T @ basis)
    found = factored(gram).solve(np.asarray(basis.T @ increments))
    return np.asarray(found).reshape(basis.shape[1], -1)


def factored(matrix: Any) -> SparseLU:
    """Factorise a matrix that is regular unless stiffnesses differ by more than double precision resolves.

    Raises:
        SolveError: it is singular.
    """
    try:
        return SparseLU(matrix)
    except RuntimeError:
        raise beyond_precision() from None


def beyond_precision() -> SolveError:
    """Return the error of matrices whose entries cannot be told from round-off."""
    return SolveError(
        "Small vibrations cannot be computed: stiffnesses differ by more than double precision holds; check that "
        "lengths, sections and moduli are in SI units"
    )
