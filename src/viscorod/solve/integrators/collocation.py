"""Collocation methods on the Lie group: what Radau IIA and the midpoint rule share.

The step's unknowns are nodal coordinates relative to the poses at its start, in which the equations of motion are
ordinary
differential equations; so the methods keep their order for large rotations. Stresses are carried as independent
iterates (mixed Newton), which lets a frozen Jacobian serve steps with large rotations: only strains, never stiffness
times strains, are linearised about old poses. The Jacobian and the factors stay in use over several steps (see
``stages`` and ``jacobian``).
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics import inertia, loading
from viscorod.mechanics import supports as support_kernels
from viscorod.mechanics.internal_force import Points, energies, internal_forces
from viscorod.mechanics.interpolation import interpolate
from viscorod.mechanics.motion import extrapolate
from viscorod.solve import lapack
from viscorod.solve.history import Snapshot
from viscorod.solve.integrators import iteration, jacobian, solved_step
from viscorod.solve.integrators.contract import StepReport
from viscorod.solve.integrators.solved_step import try_step
from viscorod.solve.integrators.stage_data import Body, Ends, Factors, Given, Matrices, Stages, Work
from viscorod.solve.integrators.tableau import Tableau
from viscorod.solve.loads import ExternalLoads, LoadState
from viscorod.solve.newton import Outcome
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System
from viscorod.solve.time_step import start_step
from viscorod.typing import Floats

_OUTCOME = {
    iteration.CONVERGED: Outcome.CONVERGED,
    iteration.SLOW: Outcome.SLOW,
    iteration.DIVERGED: Outcome.DIVERGED,
    iteration.NOT_FINITE: Outcome.NOT_FINITE,
}


class Collocation:
    """What all collocation methods share (see :class:`~viscorod.solve.integrators.contract.Integrator`).

    Args:
        system, supports: what is integrated.
        tableau: the method.
        newton_tolerance: error left by the iteration (displacement over model length, rotation in rad).
    """

    stale = 0.1
    """Convergence rate from which on the Jacobian is renewed."""

    iterations = 12
    """Allowed iterations per step."""

    def __init__(
        self, system: System, supports: SupportState, tableau: Tableau, newton_tolerance: float
    ) -> None:
        self.system, self.supports, self.tableau = system, supports, tableau
        self.newton_tolerance = newton_tolerance
        self.loads = ExternalLoads(system.problem)
        problem = system.problem
        self.t = 0.0
        self.state = State(problem.positions.copy(), problem.quaternions.copy(), np.zeros((problem.size, 6)))
        self.kinetic = self.elastic = self.work = self.loss = 0.0
        self.evaluations = self.factorisations = self.jacobians = 0
        stages = len(tableau.nodes)
        self._last = stages - 1
        self.body = body = Body.of(problem, system.elements(), supports)
        self.given = Given.of(stages, body, max(1, len(problem.station_loads)))
        self.stages = Stages.of(stages, body)
        self.ends = Ends.of(body, active=False)
        self.matrices = Matrices.of(body, system.band.width)
        self.factors = Factors.of(system.band, with_complex=stages > 1)
        self.scratch = Work.of(body, stages)
        self._places = system.gauss_places()
        self._points = Points.of(body.elements, 1)  # at t
        self._stress = np.zeros(body.elements.reference.shape)  # at t
        self._force = np.zeros((problem.size, 6))  # what accelerates the nodes at t
        self._end_rate = np.zeros((problem.size, 6))  # of the twists at t
        self._turning = np.zeros((problem.size, 6, 6))
        self._powers = np.zeros((2, stages))
        self._reaction = np.zeros((len(body.nodes), 6))  # of the supports at t, along their axes
        self._error = np.zeros((problem.size, 6))
        self._elastic = np.zeros(stages)
        self._snapshot: Snapshot
        self._earlier: tuple[State, Floats, Floats, float] | None = None  # the last step's polynomials
        self._have_jacobian = self._fresh_jacobian = False
        self._factor_step = self._end = self._step = 0.0
        self._rate = 1.0
        self._before: tuple[State, Snapshot] | None = None
        self._stage_reactions: Floats

    # --- the contract

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        supports = self.supports
        supports.update(t, False)
        supports.prescribe(state)
        supports.project_twists(state)
        self._settle(t, state, before=False)
        self._earlier = None
        self._rate = 1.0
        self._have_jacobian = False

    def first_step(self, duration: float) -> float:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        return start_step(
            self.body.mass, self._force, self.state.twist, self.body.held, self.body.length, duration
        )

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        h = end - self.t
        self._prepare_step(end, before)
        if not self._have_jacobian:
            self._renew_jacobian()
        if h != self._factor_step and not self._factorise(h):
            return StepReport(Outcome.SINGULAR, 0, 0.0, 0.0, 0)
        self._predict(h)
        state, stages = self.state, self.stages
        code, count, size, rate, unknown, error, worst = try_step(
            self.body,
            self.given,
            state.r,
            state.q,
            state.twist,
            self._force,
            h,
            self.tableau,
            self.factors,
            self.matrices,
            stages,
            self.ends,
            self.scratch,
            self.newton_tolerance,
            self.iterations,
            self._rate,
            self._powers,
            self._elastic,
            self._error,
        )
        self.evaluations += (count + (code == iteration.CONVERGED)) * len(self.tableau.nodes)
        self._end = end
        if code == iteration.CONVERGED:
            self._rate = rate
            return self._judge(StepReport(Outcome.CONVERGED, count, size, 0.0, 0, 0.0, rate), error, worst)
        node, component = divmod(unknown, 6)
        self._rate = 1.0
        if not self._fresh_jacobian:
            self._have_jacobian = False
            return self.attempt(end, before=before).after(count)
        imbalance = float(np.abs(stages.residual).max())
        return StepReport(_OUTCOME[code], count, size, imbalance, node, 0.0, rate, component)

    def accept(self) -> None:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        stages, weights = self.stages, self.tableau.weights
        h = self._end - self.t
        self.elastic = float(self._elastic[self._last])
        self.work, self.loss = h * float(weights @ self._powers[0]), h * float(weights @ self._powers[1])
        self._before = (self.state, self._snapshot)
        self._stage_reactions = self._reactions()
        self._earlier = (self.state, stages.X.copy(), np.concatenate([self._stress[None], stages.stress]), h)
        self._arrive()
        self.t, self._step = self._end, h
        self._fresh_jacobian = False
        if self._rate > self.stale:
            self._have_jacobian = False

    def snapshot(self) -> Snapshot:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        return self._snapshot

    def between(self, parts: Floats) -> list[tuple[Snapshot, float, float]]:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`.

        Poses and twists are polynomials of degree 5 through both ends of the step (with accelerations), Gauss points
        and reactions follow the stages.
        """
        assert self._before is not None
        (old, first), new, h = self._before, self.state, self._step
        count, stages = len(parts), self.stages
        change = (stages.twist - old.twist).reshape(self._last + 1, -1)
        start_rate = np.dot(self.tableau.start_derivative / h, change).reshape(old.twist.shape)
        r, q, twist = (np.empty((count, *shape.shape)) for shape in (new.r, new.q, new.twist))
        interpolate(
            parts,
            h,
            old.r,
            old.q,
            old.twist,
            start_rate,
            new.r,
            new.q,
            new.twist,
            self._end_rate,
            self.body.split,
            self._last > 0,
            r,
            q,
            twist,
        )
        weights = self.tableau.polynomials(parts)
        points = np.empty((3, count, len(self._places), 6))
        solved_step.follow(
            weights,
            first.strain,
            first.strain_rate,
            first.section_force,
            stages.strain,
            stages.strain_rate,
            stages.stress,
            self._places,
            points,
        )
        change = (self._stage_reactions - first.reaction).reshape(self._last + 1, -1)
        reaction = first.reaction + np.dot(weights, change).reshape(count, *first.reaction.shape)
        work, losses = h * self._powers @ self.tableau.partial_weights(parts).T
        found = []
        loss = 0.0
        for k, part in enumerate(parts):
            state = State(r[k], q[k], twist[k])
            self.supports.correct(state, self.t - (1.0 - part) * h)
            kinetic = inertia.kinetic_energy(self.body.mass, twist[k])
            strain, rate, force = points[0, k], points[1, k], points[2, k]
            snapshot = Snapshot(state, strain, rate, force, reaction[k], kinetic, 0.0)
            loss = max(loss, min(float(losses[k]), self.loss))  # interpolation must not give energy back
            found.append((snapshot, float(work[k]), loss))
        return found

    # --- what methods differ in

    def _judge(self, report: StepReport, error: float, unknown: int) -> StepReport:
        """Complete the report of a converged step by its error estimate, largest at ``unknown``."""
        del error, unknown
        return report

    def _prepare_step(self, end: float, before: bool) -> None:
        """Evaluate loads and prescribed motions at all stages of the step to ``end``."""
        for i, c in enumerate(self.tableau.nodes):
            last = i == self._last
            self._prepare(i, end if last else self.t + c * (end - self.t), before=before and last)

    def _arrive(self) -> None:
        """Make the last stage the new state."""
        stages, last = self.stages, self._last
        self.state = State(stages.r[last].copy(), stages.q[last].copy(), stages.twist[last].copy())
        self._force[:], self._stress[:] = stages.force[last], stages.stress[last]
        self._reaction[:] = stages.reaction[last]
        if len(self.supports.partial):
            self._move_supports(self._end)
            self.supports.project_twists(self.state)
        self._end_rate = stages.acceleration[last].copy()
        self.kinetic = inertia.kinetic_energy(self.body.mass, self.state.twist)
        self._snapshot = self._take()

    # --- parts

    def _settle(self, t: float, state: State, *, before: bool, acceleration: Floats | None = None) -> None:
        """Make ``state`` the one at ``t``: forces, energies and reactions there.

        Without accelerations those of free nodes are unknown, and reactions lack the inertia of partly held ones.
        """
        supports, body, points = self.supports, self.body, self._points
        self.t, self.state = t, state
        internal, external = self.scratch.vector, self.scratch.change
        internal_forces(
            body.elements,
            state.r[None],
            state.q[None],
            state.twist[None],
            points,
            self.scratch.element,
            internal[None],
        )
        external.fill(0.0)
        self._add_loads(self.loads.at(t, before), state, external, None)
        self.evaluations += 1
        residual = internal - external
        inertia.add_coriolis(body.mass, state.twist, residual)
        np.negative(residual, out=self._force)
        if acceleration is None:
            supports.add_acceleration(residual)
        else:
            residual += np.einsum("nij,nj->ni", body.mass, acceleration)
        supports.impose(state, residual, self.system.band, tangent=False)
        self.kinetic = inertia.kinetic_energy(body.mass, state.twist)
        elastic, dissipated = np.empty((2, 1))  # not the powers of the last step, which states between need
        energies(body.elements, points.strain, points.strain_rate, elastic, dissipated)
        self.elastic = float(elastic[0])
        self._reaction[:] = supports.reaction
        self._stress[:] = points.stress[0]
        self._snapshot = Snapshot(
            state,
            self._gather(points.strain[0]),
            self._gather(points.strain_rate[0]),
            self._gather(points.stress[0]),
            supports.global_reactions(state),
            self.kinetic,
            self.elastic,
        )

    def _gather(self, fields: Floats) -> Floats:
        """Bring Gauss-point fields ``(..., e, points, 6)`` into the order of results ``(..., m, 6)``."""
        return fields.reshape(*fields.shape[:-3], -1, 6)[..., self._places, :]

    def _take(self) -> Snapshot:
        stages, last = self.stages, self._last
        return Snapshot(
            self.state,
            self._gather(stages.strain[last]),
            self._gather(stages.strain_rate[last]),
            self._gather(stages.stress[last]),
            self._stage_reactions[last],
            self.kinetic,
            self.elastic,
        )

    def _reactions(self) -> Floats:
        """Global wrenches of the supports at all stages ``(s, supports, 6)``."""
        b, stages = self.body, self.stages
        out = np.empty(stages.reaction.shape)
        support_kernels.reaction_wrenches(
            b.nodes,
            b.fixed,
            b.axes,
            b.r0,
            b.q0,
            self.given.target,
            stages.r,
            stages.q,
            stages.reaction,
            out,
        )
        return out

    def _move_supports(self, t: float, *, before: bool = True) -> None:
        if self.supports.moving:
            self.supports.update(t, before)

    def _prepare(self, i: int, t: float, *, before: bool) -> None:
        """Evaluate loads and prescribed motions of stage ``i`` at time ``t``."""
        given, supports = self.given, self.supports
        if supports.moving:
            supports.update(t, before)
            given.target[i], given.rate[i] = supports.target, supports.rate
            c = supports.complete
            if len(c):
                r, q, twist, rate = supports.complete_motion()
                given.r[i, c], given.q[i, c], given.twist[i, c], given.twist_rate[i, c] = r, q, twist, rate
        loads = self.loads.at(t, before)
        given.acting[i] = 1.0 if len(loads.nodes) else 0.0
        if len(loads.nodes):
            given.dead[i], given.following[i], given.gravity[i] = loads.dead, loads.following, loads.gravity
        if self.system.problem.station_loads:
            given.element[i] = -1
            for k, load in enumerate(loads.stations):
                given.element[i, k] = self.system.element_number(load.part, load.element)
                given.shape[i, k, : len(load.shape)] = load.shape
                given.point_dead[i, k], given.point_following[i, k] = load.dead, load.following

    def _predict(self, h: float) -> None:
        """Start the iteration from the last step's polynomials, or from the present twists and stresses."""
        nodes, stages = self.tableau.nodes, self.stages
        if self._earlier is None or self._last == 0:
            np.multiply.outer(nodes * h, self.state.twist, out=stages.X)
            stages.X[:, self.body.held != 0.0] = 0.0
            stages.stress[:] = self._stress
            return
        old, coordinates_, stress, old_step = self._earlier
        weights = self.tableau.polynomials(1.0 + nodes * (h / old_step))
        all_weights = np.concatenate([1.0 - weights.sum(axis=1, keepdims=True), weights], axis=1)
        np.dot(all_weights, stress.reshape(len(stress), -1), out=stages.stress.reshape(len(nodes), -1))
        extrapolate(
            old.r,
            old.q,
            coordinates_,
            weights,
            self.state.r,
            self.state.q,
            self.body.split,
            self.body.held,
            stages.X,
        )

    def _renew_jacobian(self) -> None:
        """Linearise at the start of the step."""
        state, matrices, body = self.state, self.matrices, self.body
        jacobian.adjoint(state.twist, self._turning)
        matrices.K.fill(0.0)
        matrices.C.fill(0.0)
        self.system.linearise(state, self._turning, self._stress, matrices.operators, matrices.K, matrices.C)
        self._add_loads(self.loads.at(self.t), state, self.scratch.vector, matrices.K)
        matrices.mass[:] = body.mass
        jacobian.add_inertia(body.mass, state.twist, self._turning, matrices.K, matrices.C, matrices.adjoint)
        self._move_supports(self.t, before=False)
        jacobian.project(
            body.nodes,
            body.fixed,
            body.axes,
            body.r0,
            body.q0,
            self.supports.target,
            self._reaction,
            state.r,
            state.q,
            matrices.K,
            matrices.C,
            matrices.mass,
            matrices.G,
            matrices.Z,
        )
        self._have_jacobian = self._fresh_jacobian = True
        self._factor_step = 0.0
        self.jacobians += 1

    def _add_loads(self, loads: LoadState, state: State, external: Floats, K: Floats | None) -> None:
        """Add loads to ``external (n, 6)``; they turn with the body frames: subtract their derivative from ``K``."""
        body, tangent = self.body, K is not None
        band = self.scratch.band if K is None else K
        diagonal = (band.shape[1] - 1) // 2
        if len(loads.nodes):
            loading.add_nodal_loads(
                loads.nodes,
                state.q,
                loads.dead,
                loads.following,
                loads.gravity,
                body.mass,
                tangent,
                external,
                band,
                diagonal,
            )
        for load in loads.stations:
            elements, e = body.elements, self.system.element_number(load.part, load.element)
            m = int(elements.order[e]) + 1
            loading.add_station_load(
                elements.nodes[e, :m],
                elements.links[e, :m],
                elements.link_positions,
                elements.link_quaternions,
                load.shape,
                load.dead,
                load.following,
                state.r,
                state.q,
                tangent,
                external,
                band,
                diagonal,
            )

    def _factorise(self, h: float) -> bool:
        """Factorise the real and the complex matrix for the step ``h``; False if one is singular."""
        t, m, f, b = self.tableau, self.matrices, self.factors, self.body
        self._factor_step = h
        self.factorisations += 1
        jacobian.combine(m.K, m.C, m.mass, t.real / h, b.nodes, b.fixed, m.G, f.columns, f.real_rows, f.real)
        good = lapack.factorise(f.real, f.real_integers) == 0
        if self._last > 0:
            jacobian.combine(
                m.K, m.C, m.mass, t.pair / h, b.nodes, b.fixed, m.G, f.columns, f.complex_rows, f.complex
            )
            good = good and lapack.factorise_complex(f.complex, f.complex_integers) == 0
        return good
