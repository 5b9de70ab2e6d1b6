"""The exact linearisation of one collocation step: how its end follows its start and the arrays of the problem.

The balances of all stages stay fulfilled: one linear system for the body increments ``p_i`` of all stages that supports
allow and for multipliers, ``K_i p_i + C_i dx_i + M da_i + f_i = 0`` with the Jacobians of these stages, the maps of
``stage_maps`` and ``da_i = sum_l d_il/h (dx_l - dx_0)``. It is solved by GMRES, preconditioned with what the iteration
of a step solves with: one real and some complex matrices of the size of the model, here of the mean Jacobian of the
stages (see ``stage_kernels``). That takes some five iterations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.support_rows import Directions
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.sensitivity import stage_maps
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.array_forces import ArrayForces
from viscorod.solve.sensitivity.end_corrections import EndCorrections
from viscorod.solve.sensitivity.equilibrium_sensitivity import actions_of
from viscorod.solve.sensitivity.known_models import require_linearisable
from viscorod.solve.sensitivity.stage_branches import StageBranches
from viscorod.solve.sensitivity.stage_records import LookedBack, StageRecord, Weights
from viscorod.solve.sensitivity.stage_solver import StageSolver
from viscorod.solve.sensitivity.stage_terms import begin_stages
from viscorod.solve.sensitivity.transposed_solution import StageSystem, through_twists
from viscorod.solve.transient.integrators import jacobian
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.stage_data import Matrices
from viscorod.typing import Floats

__all__ = ["StepLinearisation"]


class StepLinearisation:
    """Linearises one step after the other; arrays are allocated once.

    Columns of arrays are independent changes. Rows are those of all nodes, ``6 n``; changes are ones that supports
    allow. Multipliers of joints and held strains are unknowns of every stage, and no part of the state.

    Args:
        integrator: of the steps.

    Attributes:
        arrays: how the balances of the stages change with the arrays of the problem.
    """

    def __init__(self, integrator: Collocation) -> None:
        require_linearisable(integrator)
        self.tableau, self.body = integrator.tableau, integrator.body
        self.actions = actions_of(integrator.system)
        self.problem = problem = integrator.system.problem
        stages, n, N, b = (
            len(self.tableau.nodes),
            problem.size,
            problem.pattern.size,
            len(problem.pattern.rows),
        )
        self.K, self.C = np.zeros((2, stages, b, 6, 6))
        self.mass = np.zeros((stages, n, 6, 6))
        self._directions = [Directions.of(len(self.body.complete)) for _ in range(stages)]
        self.arrays = ArrayForces(self.actions, stages)
        dashpots = self._dashpots = integrator.dashpots
        self.branches = (
            None if dashpots is None else StageBranches(dashpots, self.arrays.B, self.arrays.weights)
        )
        self._maps = np.zeros((4, stages, n, 6, 6))
        self.solver = StageSolver(problem, self.tableau, self.body, integrator.system.matrix.scales)
        self._fixed = [(m, int(k)) for m, k in enumerate(self.body.supports.nodes)]
        self._end = EndCorrections(self.actions)
        self._still, self._scratch = np.zeros((n, 6, 6)), np.zeros((stages + 1, 6))
        self._step: StageRecord
        self._shapes = (stages, n, 6), (stages, N, 6)
        self._project, self._write_maps = KnownTypes(jacobian.project), KnownTypes(stage_maps.stage_maps)
        self._begin = KnownTypes(begin_stages)
        self._through = KnownTypes(through_twists)
        self._follow = KnownTypes(stage_maps.follow_twists)
        self._follow_back = KnownTypes(stage_maps.follow_twists_transposed)
        self._balances = KnownTypes(stage_maps.add_balances)
        self._balances_back = KnownTypes(stage_maps.add_balances_transposed)

    def linearise(self, step: StageRecord) -> None:
        """Linearise a step."""
        last = len(step.times) - 1
        self._rates = rates = self.tableau.derivative / step.h
        self._starts = rates.sum(axis=1)
        self.actions.system.constraints.near[:] = step.near
        self.actions.system.impose_rest(Imposed(1.0, step.t, False))
        self._begin.call(self.body.mass, step.twist, self.problem.pattern.diagonal, self.K, self.C, self.mass)
        for i, t in enumerate(step.times):
            self._linearise_stage(step, i, float(t), step.before and i == last)
        self.arrays.begin(step)
        speeds = _weighted(rates, step.X)
        self._write_maps.call(step.X, speeds, self.body.split, self.body.held, *self._maps)
        self._end.take(step)
        self._step, middle = step, len(step.times) // 2
        directions, stiffen = self._directions[middle], None
        if self.branches is not None and self._dashpots is not None:
            self.branches.take(step.h)
            parts = self.C[0], self.mass[0], self._still, directions, self.arrays.operators[middle]
            dashpots = self._dashpots

            def stiffen(K: Floats, mu: complex) -> Floats:
                return dashpots.add_stiffness(Matrices(K, *parts), mu)

        fields = self.K, self.C, self.mass
        self.solver.factorise(*fields, step.twist, directions, step.h, stiffen)

    def _linearise_stage(self, step: StageRecord, i: int, t: float, before: bool) -> None:
        """Write the derivatives of the balance at one stage, rows of supports projected."""
        actions, body, K, C = self.actions, self.body, self.K[i], self.C[i]
        system, pattern = actions.system, self.problem.pattern
        state = State(step.r[i], step.q[i], step.twist[i], step.multiplier[i])
        operators: Operators = self.arrays.operators[i]
        system.linearise(state, self._still, step.section_force[i], operators, K, C)
        constraints = system.constraints
        if self.problem.constrained:
            constraints.update(t, before)
            constraints.add_forces(state, np.zeros_like(state.twist))
            held = (body.elements.order, operators.strain) if len(self.problem.held.place) else None
            constraints.add_tangent(state, self._still, K, C, moving=True, held=held)
        actions.add_load_stiffness(t, state, self._still, K, C, before=before)
        actions.move_supports(t, before=before)
        directions = self._directions[i]
        self._project.call(
            body.supports,
            actions.supports.target,
            step.reaction[i],
            state.r,
            state.q,
            pattern,
            K,
            C,
            self.mass[i],
            directions,
            np.zeros(6),
        )
        for m, k in self._fixed:
            held_rows = body.supports.fixed[m] != 0.0
            K[pattern.diagonal[k]][:, held_rows] = directions.G[m][held_rows].T
        self.arrays.take(i, t, before, constraints.scale)

    # --- forward

    def forward(
        self, pose: Floats, twist: Floats, changes: Sequence[ArrayChanges | None] = ()
    ) -> tuple[Floats, Floats]:
        """Return the changes of poses and twists at the end ``(6 n, k)`` that those at the start lead to.

        Args:
            pose, twist: at the start ``(6 n, k)``.
            changes: of the arrays of the problem that belong to the columns; none by default.
        """
        found = np.zeros((2, *pose.shape))
        for k in range(pose.shape[1]):
            change = changes[k] if k < len(changes) else None
            forces = None if change is None else self.project(self.arrays.force(change))
            p, x = self.move(pose[:, k], twist[:, k], forces)
            found[0, :, k], found[1, :, k] = p[-1].ravel(), x[-1].ravel()
        return found[0], found[1]

    def project(self, forces: Floats) -> Floats:
        """Project forces of all stages ``(s, N, 6)`` on what supports leave free, in place; held rows become zero."""
        for directions, force in zip(self._directions, forces, strict=True):
            for m, k in self._fixed:
                free = self.body.supports.fixed[m] == 0.0
                force[k] = np.where(free, directions.Z[m].T @ force[k], 0.0)
        return forces

    def move(self, pose: Floats, twist: Floats, forces: Floats | None) -> tuple[Floats, Floats]:
        """Return the changes of poses and twists ``(s, n, 6)`` of all stages.

        Args:
            pose, twist: changes at the start ``(6 n,)``; forces: of the balances ``(s, N, 6)``, projected.
        """
        n = self.problem.size
        pose, twist = (self._free(values.reshape(n, 6)) for values in (pose, twist))
        carried = np.einsum("snij,nj->sni", self._maps[0], pose)
        offset = -self._twists(carried)
        x0 = _weighted(self._rates, offset) - self._starts[:, None, None] * twist
        right = np.zeros(self._shapes[1]) if forces is None else forces.copy()
        pattern, still = self.problem.pattern, np.zeros(self._shapes[1])
        fields = (self.K, self.C, self.mass)
        self._balances.call(pattern.rows, pattern.columns, *fields, still, offset, x0, right)
        p = self.solver.solve(self._apply, -right)[:, :n]
        x = offset + self._twists(p)
        x[-1] = self._end.forward(p[-1], x[-1])
        return p, x

    def _twists(self, p: Floats) -> Floats:
        found = np.empty(self._shapes[0])
        self._follow.call(self._rates, *self._maps[1:], np.ascontiguousarray(p), self._scratch, found)
        return found

    def _apply(self, p: Floats) -> Floats:
        """Return the change of the balances with the increments ``p (s, N, 6)``."""
        pattern, x, out = self.problem.pattern, self._twists(p), np.zeros(self._shapes[1])
        acceleration = _weighted(self._rates, x)
        fields = (self.K, self.C, self.mass)
        self._balances.call(pattern.rows, pattern.columns, *fields, p, x, acceleration, out)
        if self.branches is not None:
            n = self.problem.size
            memory = np.zeros_like(out)
            memory[:, :n] = self.branches.forces(p[:, :n])
            out += self.project(memory)
        return out

    # --- backward

    def backward(self, pose: Floats, twist: Floats) -> tuple[Floats, Floats, ArrayChanges]:
        """Return the derivatives by the start ``(6 n, 1)``, and by the arrays, of a function of the end.

        Args:
            pose, twist: derivatives of the function by the poses and twists at the end ``(6 n, 1)``.
        """
        by_pose, by_twist = self.look_at_end(pose.reshape(-1, 6), twist.reshape(-1, 6))
        weights = Weights(by_pose, np.zeros(self._shapes[0]))
        weights.twists[-1] = by_twist
        found = self.look_back(weights)
        gradient = self.arrays.gradient(self.lifted(found.forces))
        return found.pose.reshape(-1, 1), found.twist.reshape(-1, 1), gradient

    def look_at_end(self, pose: Floats, twist: Floats) -> tuple[Floats, Floats]:
        """Return derivatives by the end of the step ``(n, 6)`` as ones by its last stage, which is corrected."""
        return self._end.backward(pose, twist)

    def lifted(self, forces: Floats) -> Floats:
        """Return derivatives by projected forces ``(s, N, 6)`` as ones by the forces themselves."""
        found = forces.copy()
        for directions, force in zip(self._directions, found, strict=True):
            for m, k in self._fixed:
                free = self.body.supports.fixed[m] == 0.0
                force[k] = directions.Z[m] @ np.where(free, force[k], 0.0)
        return found

    def look_back(self, weights: Weights) -> LookedBack:
        """Return the derivatives of a function by the start and by what the step depends on.

        Args:
            weights: derivatives of the function by the end.
        """
        n, by_poses = self.problem.size, np.zeros(self._shapes[1])
        by_poses[-1, :n] = weights.pose
        self._add_twists_back(weights.twists, by_poses)
        dashpot = weights.dashpot
        if self.branches is not None and dashpot is not None:
            by_poses[:, :n] += self.branches.nodal(self.branches.by_end(dashpot), n)
        forces = -self._solved_back(by_poses)
        start_pose, start_twist = np.empty((2, n, 6))
        given = weights.twists, self._maps[0], self.body.held, forces, self.solver.work
        self._through.call(self._system(), *given, start_pose, start_twist)
        branches = None
        if self.branches is not None:
            dashpot = np.zeros_like(self._step.dashpot) if dashpot is None else dashpot
            pushed = self.lifted(forces)[:, :n]
            branches = self.branches.gradient(pushed, dashpot, self._step.strain, self._step.dashpot)
        return LookedBack(start_pose, start_twist, forces, branches)

    def _solved_back(self, by_poses: Floats) -> Floats:
        """Return the solution ``(s, N, 6)`` of the transposed system."""
        if self.branches is not None or not self.solver.compiled:
            return self.solver.solve_transposed(self._apply_transposed, by_poses)
        return self.solver.solve_compiled(self._system(), by_poses)

    def _system(self) -> StageSystem:
        """Return how the balances of the present step follow from increments of poses."""
        pattern = self.problem.pattern
        fields = self._rates, *self._maps[1:], pattern.rows, pattern.columns, self.K, self.C, self.mass
        return StageSystem(*fields)

    def _add_twists_back(self, x: Floats, out: Floats) -> None:
        self._follow_back.call(self._rates, *self._maps[1:], np.ascontiguousarray(x), self._scratch, out)

    def _apply_transposed(self, y: Floats) -> Floats:
        """Return the transpose of :meth:`_apply` times ``y (s, N, 6)``."""
        pattern, out = self.problem.pattern, np.zeros(self._shapes[1])
        by_twist, by_acceleration = np.zeros((2, *self._shapes[0]))
        fields = (self.K, self.C, self.mass)
        self._balances_back.call(pattern.rows, pattern.columns, *fields, y, out, by_twist, by_acceleration)
        by_twist += _weighted(self._rates.T, by_acceleration)
        self._add_twists_back(by_twist, out)
        if self.branches is not None:
            n = self.problem.size
            out[:, :n] += self.branches.forces_back(self.lifted(y)[:, :n])
        return out

    def _free(self, values: Floats) -> Floats:
        """Return values of all nodes ``(n, 6)``, with zeros for those that are held completely."""
        return np.asarray(np.where(self.body.held[:, None] != 0.0, 0.0, values))


def _weighted(weights: Floats, values: Floats) -> Floats:
    """Return sums ``sum_j weights_ij values_j`` over stages."""
    return np.asarray((weights @ values.reshape(len(values), -1)).reshape(values.shape))
