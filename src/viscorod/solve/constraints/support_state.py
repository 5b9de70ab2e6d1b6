"""Supports in action: targets in time, imposed rows, consistent velocities, reactions."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.nodes import support_rows as supports
from viscorod.mechanics.nodes.nodes_held_in_part import correct_poses, project_twists
from viscorod.mechanics.nodes.prescribed_motion import prescribed_motion
from viscorod.solve.constraints.free_block import free_block, free_rows
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.once import once_of_layout
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

CONSTANT = frozenset(
    {"directions", "_impose", "_impose_tangent", "_project", "complete", "partial", "q0", "r0"}
)
STILL = frozenset({"acceleration", "rate", "target", "twist", "twist_rate"})
"""What never changes, and what else does not where no support moves: motions that go on need none of it."""


class SupportState:
    """Targets of all supports at one time, and the operations that impose them on a state."""

    def __init__(self, problem: Problem) -> None:
        s = problem.supports
        self.problem = problem
        self.set = s
        m = len(s.nodes)
        self.r0 = problem.positions[s.nodes]
        self.q0 = problem.quaternions[s.nodes]
        self.target: Floats = np.zeros((m, 6))
        self.rate: Floats = np.zeros((m, 6))
        self.acceleration: Floats = np.zeros((m, 6))
        self.reaction: Floats = np.zeros((m, 6))
        self.weights: Floats = np.ones((problem.size, 6))
        self.nodes = supports.SupportedNodes(s.nodes, s.fixed, s.axes, self.r0, self.q0)
        self.directions = supports.Directions.of(m)
        self._impose, self._impose_tangent = (
            KnownTypes(supports.impose),
            KnownTypes(supports.impose_tangent),
        )
        self._project, self._correct = KnownTypes(project_twists), KnownTypes(correct_poses)
        self.complete = s.complete
        self.partial = s.partial
        self.moving = bool(s.motions)
        self.stage: tuple[Floats, Floats] | None = (
            None  # motions at the start (m, 6), parts of them at the end
        )
        self.twist: Floats = np.zeros((len(self.complete), 6))
        self.twist_rate: Floats = np.zeros((len(self.complete), 6))

    @property
    def unsaved(self) -> frozenset[str]:
        """What ``saved_state`` leaves out."""
        return CONSTANT if self.moving else CONSTANT | STILL

    def update(self, t: float, before: bool = False, scale: float = 1.0) -> None:
        """Evaluate all prescribed motions; in a stage of statics between what they are at its start and at its end."""
        if self.stage is None:
            self._update(t, before, scale)
            return
        first, part = self.stage
        self.target.fill(0.0)
        self._update(t, before, 1.0)
        self.target[:] = first + scale * (part * self.target - first)

    def _update(self, t: float, before: bool, scale: float) -> None:
        """Evaluate all prescribed motions and their derivatives at time ``t`` [s]."""
        for k, component, motion in self.set.motions:
            self.target[k, component] = scale * motion.value(t, before)
            self.rate[k, component] = scale * motion.rate(t, before)
            self.acceleration[k, component] = scale * motion.acceleration(t, before)

    @property
    def largest_turn(self) -> float:
        """Largest prescribed rotation [rad] at the time of the last update."""
        turns = np.linalg.norm(self.target[:, 3:] * self.set.fixed[:, 3:], axis=1)
        return float(turns.max(initial=0.0))

    def prescribe(self, state: State) -> None:
        """Put fully supported nodes at their prescribed pose and twist."""
        c = self.complete
        if len(c) == 0:
            return
        if not self.moving:
            state.twist[self.set.nodes[c]] = 0.0
            return
        r, q, self.twist, self.twist_rate = self.complete_motion()
        nodes = self.set.nodes[c]
        state.r[nodes], state.q[nodes], state.twist[nodes] = r, q, self.twist

    def complete_motion(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return poses, body twists and their rates of all completely held supports, in their order."""
        return self._prescribed(self.complete)

    def _prescribed(self, c: Integers) -> tuple[Floats, Floats, Floats, Floats]:
        """Return poses, body twists and their rates of supports whose free components are zero."""
        held = self.set.fixed[c]
        r, q = np.empty((len(c), 3)), np.empty((len(c), 4))
        twist, rate = np.empty((len(c), 6)), np.empty((len(c), 6))
        prescribed_motion(
            self.set.axes[c],
            self.r0[c],
            self.q0[c],
            held * self.target[c],
            held * self.rate[c],
            held * self.acceleration[c],
            r,
            q,
            twist,
            rate,
        )
        return r, q, twist, rate

    def impose(self, state: State, residual: Floats, matrix: Matrix, *, tangent: bool) -> None:
        """Replace the rows of supported nodes; keeps the reactions (components along the support's axes).

        With the ``tangent`` held rows of both are multiplied by ``weights``.
        """
        impose = self._impose.suited(state.r, state.q, residual)
        impose(self.nodes, self.target, state.r, state.q, residual, self.reaction, self.directions)
        if tangent:
            self.weights = np.ones(residual.shape)
            self._impose_tangent.suited(matrix.blocks)(
                self.nodes,
                self.directions,
                self.reaction,
                self.weights,
                matrix.blocks,
                matrix.pattern.starts,
                matrix.pattern.across,
                matrix.pattern.diagonal,
            )
            residual *= self.weights

    def unbalanced(self, residual: Floats) -> Floats:
        """Return a copy of an imposed residual without the rows of held components."""
        free = residual.copy()
        free[self.set.nodes] *= 1.0 - self.set.fixed
        return free

    def power(self, state: State) -> float:
        """Return the power [W] that moving supports put into the model, after :meth:`impose` in the same state.

        How fast rotations change follows from the twists: the reaction's moment acts about the axes in space.
        """
        if not self.moving:
            return 0.0
        speeds = self.rate.copy()
        directions = self.directions.G[:, 3:, 3:]
        turning = np.einsum("mij,mj->mi", directions, state.twist[self.set.nodes, 3:])
        speeds[~self.set.in_body, 3:] = turning[~self.set.in_body]
        return float(np.sum(self.set.fixed * self.reaction * speeds))

    def global_reactions(self, state: State) -> Floats:
        """Return the reactions as force [N] and moment [N m] in global axes ``(m, 6)``.

        The components that :meth:`impose` keeps are conjugate to those that supports measure; ``G^T`` makes a wrench
        of them.
        """
        out = np.empty((1, len(self.set.nodes), 6))
        supports.reaction_wrenches(
            self.nodes,
            self.target[None],
            state.r[None],
            state.q[None],
            self.reaction[None],
            supports.Directions.of(1),
            out,
        )
        wrenches: Floats = out[0]
        return wrenches

    def _directions(self, k: int, state: State) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the components of a support's motion, their derivative G, dual directions Z, and psi."""
        found = supports.Directions.of(1)
        supports.support_directions(self.nodes, k, self.target, state.r, state.q, 0, found)
        return found.value[0], found.G[0], found.Z[0], found.psi[0]

    def measured(self, state: State) -> Floats:
        """Return the motions of all supports in a state ``(m, 6)``, rotations nearest to the present targets."""
        out = np.zeros_like(self.target)
        for k in np.flatnonzero(~self.set.in_body):
            out[k] = self.set.fixed[k] * self._directions(int(k), state)[0]
        return out

    def motion_gradients(self, k: int, state: State) -> Floats:
        """Return the derivatives of a support's motions by body increments of its node, one row each ``(6, 6)``."""
        return self._directions(k, state)[1]

    def free_directions(self, k: int, state: State) -> Floats:
        """Return the body increments of a support's node, one column for each motion along its axes ``(6, 6)``."""
        return self._directions(k, state)[2]

    def free_rows(self) -> np.ndarray:
        """Return the indices of the balance rows that remain after :meth:`impose`."""
        return free_rows(self.problem)

    def free_basis(self, state: State) -> sparse.csc_array:
        """Return columns that span the body increments that the supports allow, one per free row."""
        if len(self.partial) == 0:
            return _picked(self.problem).copy()
        free = self.free_rows()
        blocks = sparse.eye_array(6 * self.problem.size, format="lil")
        for k in self.partial:
            first = 6 * int(self.set.nodes[k])
            blocks[first : first + 6, first : first + 6] = self._directions(int(k), state)[2]
        return sparse.csc_array(blocks.tocsc()[:, free])

    def reduce_tangent(
        self, state: State, residual: Floats, matrix: Matrix
    ) -> tuple[sparse.csr_array, sparse.csc_array]:
        """Return the tangent stiffness of the motions that the supports allow, and the basis of these.

        Displacements are measured in lengths of the model: they are comparable with rotations, whatever the unit.

        Args:
            residual: unbalanced forces ``(N, 6)``, of which reactions are made; overwritten, like ``matrix``, by
                :meth:`impose`.

        Returns:
            ``(free, free)``; ``(6 n, free)``, from these motions to body increments of the nodes.
        """
        _, unit = self._reduce(state, residual, matrix)
        if len(self.partial):
            basis = self.free_basis(state)
            basis.data *= np.repeat(unit, np.diff(basis.indptr))
        else:
            basis = _picked_in_lengths(self.problem)
        return free_block(self.problem).matrix(matrix.blocks), basis

    def reduced_tangent(self, state: State, residual: Floats, matrix: Matrix) -> Floats:
        """Return the tangent stiffness of :meth:`reduce_tangent` as a full matrix ``(free, free)``."""
        return matrix.pattern.full_part(matrix.blocks, *self._reduce(state, residual, matrix))

    def _reduce(self, state: State, residual: Floats, matrix: Matrix) -> tuple[Integers, Floats]:
        """Put the motions that the supports allow into a matrix; returns their rows, and their units, ``(free,)``."""
        self.impose(state, residual, matrix, tangent=True)
        free = self.free_rows()
        starts = matrix.pattern.starts
        for k in self.partial:
            node, Z = self.set.nodes[k], self._directions(int(k), state)[2]
            column = slice(starts[node], starts[node + 1])
            matrix.blocks[column] = Z.T @ matrix.blocks[column]
        return free, np.where(free % 6 < 3, self.problem.length, 1.0)

    def project_twists(self, state: State) -> None:
        """Give partially supported nodes exactly the prescribed velocity components."""
        if len(self.partial) == 0:
            return
        _, _, turning, _ = self._prescribed(self.partial)
        project = self._project.suited(state.r, state.q, state.twist)
        given = self.nodes, self.partial, self.target, self.rate, turning
        project(*given, state.r, state.q, supports.Directions.of(1), state.twist)

    def correct(self, state: State, t: float) -> None:
        """Put the held components of moving, partially supported nodes exactly where they are at time ``t`` [s]."""
        if not self.moving or len(self.partial) == 0:
            return
        self.update(t)
        correct = self._correct.suited(state.r, state.q)
        given = self.nodes, self.partial, self.target
        correct(*given, state.r, state.q, supports.Directions.of(1), np.empty((1, 6)))
        self.project_twists(state)


@once_of_layout
def _picked(problem: Problem) -> sparse.csc_array:
    """Return columns that pick the body increments of nodes that no support holds ``(6 n, free)``."""
    free = free_rows(problem)
    columns = np.ones(len(free)), free, np.arange(len(free) + 1)
    return sparse.csc_array(columns, shape=(6 * problem.size, len(free)))


@once_of_layout
def _picked_in_lengths(problem: Problem) -> sparse.csc_array:
    """Return the same with displacements in lengths of the model; whoever reads it changes nothing in it."""
    basis = _picked(problem).copy()
    basis.data *= free_block(problem).unit
    return basis
