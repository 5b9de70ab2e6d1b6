"""Small motions of all nodes about an equilibrium or a steady rotation, those of supports beside the free ones.

The forces of small motions ``d exp(s t)`` are ``sum_i c_i(s) A_i d`` with a few sparse matrices and scalar
coefficients: 1 (stiffness), ``s`` (damping), ``s^2`` (inertia), ``s tau/(1 + s tau)`` of every Maxwell branch, and
complex moduli of materials that were measured over frequency, over their moduli at rest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear_systems.measured_moduli import MeasuredPart, without_measured
from viscorod.solve.modes.maxwell_modes import strain_operators
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady.geometric_steady import GeometricSteady
from viscorod.solve.steady.steady_equations import Tangent
from viscorod.typing import Floats, Integers

Complexes = np.ndarray
Coefficient = Callable[[complex], complex]
"""A scalar function of ``s`` [1/s]."""

WORDS = ("d1", "d2", "d3", "about d1", "about d2", "about d3")
"""Body increments of a node."""


@dataclass(frozen=True)
class SmallMotions:
    """Small motions about a state as matrices over the body increments of all nodes ``d (6 n,)``, SI units.

    ``d = free x + held p`` with the free motions ``x`` and those of supports ``p`` (displacements [m] and rotations
    [rad] along their axes).

    Attributes:
        problem, state: whose motions they are, and about what.
        coefficients: ``c_i(s)``: 1, s, s^2, those of Maxwell branches, those of measured moduli.
        balance: ``A_i`` in the rows of the free motions ``(free, 6 n)``.
        nodal: ``A_i`` in the rows of all nodes ``(6 n, 6 n)``, with what turns the forces into global axes.
        free, held: bases ``(6 n, free)``, ``(6 n, held)``; held_motions: support and motion of each ``(held, 2)``.
        gradients: of the conditions of joints and held strains ``(rows, 6 n)``, unit length each; None without.
        condition_scale: by which each of these rows was divided ``(rows,)``.
        section: matrices of the sections at all Gauss points, one set per coefficient ``(points, 6, 6)``, order of
            results.
        strains: of all Gauss points per nodal increment ``(6 points, 6 n)``, order of results.
        times: relaxation times of the branches [s].
        band: frequencies [Hz] between which all measured moduli are known; None without any.
    """

    problem: Problem
    state: State
    coefficients: tuple[Coefficient, ...]
    balance: tuple[sparse.csr_array, ...]
    nodal: tuple[sparse.csr_array, ...]
    free: sparse.csr_array
    held: sparse.csr_array
    held_motions: Integers
    gradients: sparse.csr_array | None
    condition_scale: Floats
    section: tuple[Floats, ...]
    strains: sparse.csr_array
    times: Floats
    band: tuple[float, float] | None = None

    def at(self, s: complex) -> list[complex]:
        """Return all coefficients at ``s`` [1/s]."""
        return [c(s) for c in self.coefficients]

    @property
    def measured(self) -> bool:
        """True if moduli of a table take part, which are known at harmonic motions only."""
        return len(self.coefficients) > 3 + len(self.times)

    @cached_property
    def free_places(self) -> Integers:
        """Row of the largest entry of every free motion ``(free,)``: six for every node."""
        columns = sparse.csc_array(abs(self.free))
        if not columns.shape[1]:
            return np.empty(0, dtype=np.int64)
        counts = np.diff(columns.indptr)
        largest = np.flatnonzero(
            columns.data == np.repeat(np.maximum.reduceat(columns.data, columns.indptr[:-1]), counts)
        )
        of = np.repeat(np.arange(len(counts)), counts)[largest]
        first = largest[np.unique(of, return_index=True)[1]]
        return np.asarray(columns.indices[first], dtype=np.int64)

    def dof_names(self, names: Sequence[str]) -> list[str]:
        """Return the names of the free motions, node and direction; ``names`` are those of the nodes ``(n,)``."""
        return [f"{names[place // 6]} {WORDS[place % 6]}" for place in self.free_places]


def small_motions(
    solver: StaticSolver,
    state: State,
    measured: Sequence[MeasuredPart] = (),
    *,
    before: bool = True,
    scale: float = 1.0,
) -> SmallMotions:
    """Return the small motions about the equilibrium ``state`` under ``scale`` times the loads at t = 0.

    Args:
        solver: of the model; measured: parts of the sections whose moduli are taken from tables.
        before: just before t = 0.
    """
    system, supports = solver.system, solver.supports
    assert isinstance(system, GeometricSystem)
    problem, n = system.problem, system.problem.size
    solver.restore(state, 0.0, before=before, scale=scale)
    resting = _resting(state)
    loads = solver.loads.at(0.0, before, scale)
    damping_matrix = Matrix(problem.pattern)
    system.assemble(resting, loads, None, tangent=True, moving=False, rate_matrix=damping_matrix)
    size = 6 * n
    stiffness = sparse.csr_array(system.matrix.sparse()[:size, :size])
    damping = sparse.csr_array(damping_matrix.sparse()[:size, :size])
    unbalanced = system.residual()
    supports.impose(resting, unbalanced.copy(), system.matrix, tangent=True)
    rows = sparse.csr_array(system.matrix.sparse().tocsr()[supports.free_rows()][:, :size])
    gradients = sparse.csr_array(system.constraint_gradients(resting)) if system.constraints.rows else None
    tangent = Tangent(stiffness, damping, rows, unbalanced[:n], gradients)
    return _gathered(solver, state, tangent, measured)


def motions_about_rotation(
    solver: StaticSolver, equations: GeometricSteady, measured: Sequence[MeasuredPart] = ()
) -> SmallMotions:
    """Return the small motions about a steady rotation, seen in axes that turn with it.

    These are the global axes at the instant of its state. Gyroscopic forces are in the matrix of ``s``, centrifugal
    ones in that of 1.

    Args:
        solver: of the model; equations: that have converged; measured: see :func:`small_motions`.
    """
    system, state = solver.system, equations.state()
    tangent = equations.tangent()
    # strains, and what laws of sections make of them
    system.assemble(_resting(state), equations.loads, None, tangent=True, moving=False)
    return _gathered(solver, state.copy(), tangent, measured)


def _resting(state: State) -> State:
    return State(state.r, state.q, np.zeros_like(state.twist), state.multiplier)


def _gathered(
    solver: StaticSolver, state: State, tangent: Tangent, measured: Sequence[MeasuredPart]
) -> SmallMotions:
    """Return small motions from the matrices of all nodes, with what is measured apart."""
    system, resting = solver.system, _resting(state)
    assert isinstance(system, GeometricSystem)
    problem = system.problem
    stiffness, damping, rows = tangent.stiffness, tangent.damping, tangent.rows
    free, held, motions = _bases(solver, resting)
    gradients, norms = None, np.zeros(0)
    if tangent.gradients is not None:
        found = tangent.gradients
        norms = np.sqrt(np.asarray(found.multiply(found).sum(axis=1)).ravel())
        gradients = sparse.csr_array(sparse.diags_array(1.0 / norms) @ found)
    strains = _strain_rows(strain_operators(system, resting), system)
    C, D = (matrix.reshape(-1, 6, 6)[system.gauss_indices()] for matrix in system.section_tangents())
    none = np.zeros_like(C)
    section: list[Floats] = [C, D, none]
    coefficients: list[Coefficient] = [_power(0), _power(1), _power(2)]
    memory, at = system.relaxation, system.gauss_positions()
    if memory is not None:
        for j, tau in enumerate(memory.times):
            coefficients.append(_branch(float(tau)))
            section.append(memory.branches[:, j][at.section])
    weights = np.repeat(at.length, 6)
    if measured:
        changes = without_measured(measured, section)
        less = _from_sections(changes[0], strains, weights)
        stiffness, rows = stiffness + less, rows + sparse.csr_array(free.T @ less)
        damping = damping + _from_sections(changes[1], strains, weights)
        section = [matrix + change for matrix, change in zip(section, changes, strict=True)]
        for part in measured:
            coefficients.append(part.factor)
            section.append(part.section)
    nodal = [stiffness, damping, sparse.csr_array(block_diagonal(problem.mass))]
    nodal += [_from_sections(matrices_, strains, weights) for matrices_ in section[3:]]
    balance = [rows, *(sparse.csr_array(free.T @ matrix) for matrix in nodal[1:])]
    nodal[0] = sparse.csr_array(nodal[0] + _turning_forces(tangent.unbalanced))
    bands = [part.band for part in measured if part.band is not None]
    return SmallMotions(
        problem,
        state,
        tuple(coefficients),
        tuple(balance),
        tuple(nodal),
        free,
        held,
        motions,
        gradients,
        norms,
        tuple(section),
        strains,
        np.zeros(0) if memory is None else memory.times,
        (max(b[0] for b in bands), min(b[1] for b in bands)) if bands else None,
    )


def _power(k: int) -> Coefficient:
    return lambda s: s**k


def _branch(tau: float) -> Coefficient:
    return lambda s: s * tau / (1.0 + s * tau)


def _bases(solver: StaticSolver, state: State) -> tuple[sparse.csr_array, sparse.csr_array, Integers]:
    """Return the bases of free motions and of those of supports, and support and motion of each of the latter."""
    supports = solver.supports
    free = sparse.csr_array(supports.free_basis(state))
    fixed, nodes = supports.set.fixed, supports.set.nodes
    motions = np.argwhere(fixed != 0.0).astype(np.int64).reshape(-1, 2)
    columns = [supports.free_directions(int(k), state)[:, i] for k, i in motions]
    rows = (6 * nodes[motions[:, 0]][:, None] + np.arange(6)).ravel()
    places = np.repeat(np.arange(len(motions)), 6)
    values = np.array(columns).reshape(-1)
    held = sparse.coo_array((values, (rows, places)), shape=(free.shape[0], len(motions)))
    return free, sparse.csr_array(held), motions


def _strain_rows(operators: Operators, system: GeometricSystem) -> sparse.csr_array:
    """Return the change of the strains of all Gauss points, order of results, per nodal increment."""
    elements = system.elements()
    B, points = operators.strain, elements.reference.shape[1]
    found = B.reshape(len(B), points, 6, B.shape[-1])
    indices = system.gauss_indices()
    e, g = np.divmod(indices, points)
    width = elements.nodes.shape[1]
    columns = (6 * elements.nodes[:, :, None] + np.arange(6)).reshape(len(B), 6 * width)
    own = np.repeat(np.arange(width) <= elements.order[:, None], 6, axis=1)
    values = np.where(own[e][:, None, :], found[e, g], 0.0)
    rows = np.broadcast_to(np.arange(6 * len(indices)).reshape(-1, 6, 1), values.shape)
    across = np.broadcast_to(columns[e][:, None, :], values.shape)
    kept = values != 0.0
    shape = (6 * len(indices), 6 * system.problem.size)
    return sparse.csr_array(sparse.coo_array((values[kept], (rows[kept], across[kept])), shape=shape))


def _from_sections(section: Floats, strains: sparse.csr_array, weights: Floats) -> sparse.csr_array:
    """Return ``sum_g w_g B^T C_g B`` of section matrices at the Gauss points ``(points, 6, 6)``."""
    middle = block_diagonal(np.ascontiguousarray(section))
    return sparse.csr_array(strains.T @ (sparse.diags_array(weights) @ middle @ strains))


def _turning_forces(unbalanced: Floats) -> sparse.csr_array:
    """Return what the turn of a node adds to the change of the wrench that holds it, seen in global axes.

    ``d(R f) = R (df + theta x f)`` for force and moment ``f`` in body axes.
    """
    n = len(unbalanced)
    blocks = np.zeros((n, 6, 6))
    for i, turn in enumerate(np.eye(3)):
        blocks[:, :3, 3 + i] = np.cross(turn, unbalanced[:, :3])
        blocks[:, 3:, 3 + i] = np.cross(turn, unbalanced[:, 3:])
    return block_diagonal(blocks)


def global_axes(state: State) -> Floats:
    """Return the rotation matrices of all nodes ``(n, 3, 3)``, body to global."""
    return np.asarray(matrices(state.q))
