"""Generalised-alpha on the Lie group, in poses and spatial momenta.

The equations of motion are first order in the poses ``H`` (with ``H_t = H x1``) and the spatial momenta ``pi`` (with
``pi_t`` = resultant wrench about the origin). Both are advanced by the generalised-alpha method for first-order systems
(Jansen, Whiting and Hulbert 2000), the poses on SE(3) by the exponential (as Bruels and Cardona 2010 do for the
second-order method):

    D/h  = (1-g) xi_n + g xi_n+1      (1-am) xi_n+1 + am xi_n = (1-af) x1_n+1 + af x1_n       H_n+1 = H_n exp(D)

and the same for ``pi`` with the wrenches in place of the twists. It is of second order, dissipates only high
frequencies, ``rho`` being the spectral radius at infinity, and keeps linear and angular momentum of a free body to
round-off, because internal forces have no spatial resultant and the scheme is linear in the momenta.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.nodes import inertia
from viscorod.solve.constraints.projection import close_gaps, start_consistently, with_allowed_velocities
from viscorod.solve.constraints.start_balance import StartBalance
from viscorod.solve.energy_account import StepShare
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot, Snapshots
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.transient.integrators.contract import Inside, Integrator, StepReport
from viscorod.solve.transient.integrators.momentum_model import MomentumModel, Relation, Solution
from viscorod.solve.transient.integrators.step_recorder import interpolate_states
from viscorod.solve.transient.time_step import first_time_step
from viscorod.typing import Floats

START = 2
"""Steps of TR-BDF2 at the start: what a sudden load jumps is behind the first, so that the second shows the rate."""

ERROR_CONSTANT = 1.0 / 6.0
"""Estimated error of a step over ``h (x1' - x1 - h rate)``, the third derivative of the pose times h^3."""


class GeneralizedAlpha(MomentumModel):
    """Implicit one-step integrator of second order (see the module's text).

    Args:
        system, supports: the model.
        spectral_radius: 1 damps nothing numerically, 0 annihilates the highest frequencies in one step.
        tolerance: wanted accuracy of the motion (displacement over model length, rotation in rad); None makes no
            error estimate.
        newton_tolerance: size of the last Newton increment, likewise.
        iterations: allowed Newton iterations per step.
    """

    estimate_order = 2
    looks_within = False
    records = 1
    _starting = START
    seen_by_halving = 1.0
    """Halves are computed by the method of the first step, whose error in them is a tenth of that of a whole step."""

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        system, supports, rows = self.system, self.supports, np.ascontiguousarray
        mass = system.problem.mass
        state.r, state.q, state.twist = rows(state.r), rows(state.q), rows(state.twist)
        supports.update(t, False)
        system.constraints.update(t)
        supports.prescribe(state)
        supports.project_twists(state)
        system.impose_rest(Imposed(t=t))
        start_consistently(system, supports, state)
        if system.relaxation is not None and system.relaxation.known:
            system.relaxation.set_step(0.0)
        self._assemble_start(t, state)
        system.advance_branches()
        system.reset_stress()
        system.constraints.track_angles()
        self.kinetic = inertia.momenta(mass, state.r, state.q, state.twist, self._momentum)
        system.viscous_loss(0.0)
        self._starting = START
        self._rate = np.zeros_like(state.twist)
        self.t = t
        self.state = state
        self._power, self._lost_power = self._work_rate(), system.dissipated
        self._snapshot = Snapshot.of(state, system, supports, self.kinetic)
        self.elastic = self._snapshot.elastic

    def _assemble_start(self, t: float, state: State) -> None:
        """Assemble the state in which a motion starts, with multipliers and reactions that its accelerations have."""
        system, supports, loads = self.system, self.supports, self.loads.at(t)

        def unbalanced(acceleration: Floats) -> Floats:
            system.assemble(state, loads, None, tangent=False, moving=True)
            force = self._unbalanced(state)
            residual = np.einsum("nij,nj->ni", system.problem.mass, acceleration) - force
            supports.impose(state, residual, system.matrix, tangent=False)
            return force

        start = StartBalance(system, supports, t, state)
        start.solve(unbalanced)
        # the rate of the momenta: of nodes that supports hold by their accelerations, of others by their forces
        body, held = system.external - system.internal, supports.set.nodes
        moved = np.einsum("nij,nj->ni", system.problem.mass, start.acceleration)
        inertia.add_coriolis(system.problem.mass, state.twist, moved)
        body[held] = moved[held]
        self._wrench = np.empty_like(body)
        inertia.momenta(np.tile(np.eye(6), (len(body), 1, 1)), state.r, state.q, body, self._wrench)

    def first_step(self, duration: float) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        problem, held = self.system.problem, np.zeros(self.system.problem.size)
        held[self._held] = 1.0
        force = self.system.external - self.system.internal
        return first_time_step(problem.mass, force, self.state.twist, held, problem.length, duration)

    def unbalanced(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._unbalanced(self.state)

    def _unbalanced(self, state: State) -> Floats:
        """Return what accelerates the nodes in a ``state`` that is assembled ``(n, 6)``."""
        turning = np.zeros_like(state.twist)
        inertia.add_coriolis(self.system.problem.mass, state.twist, turning)
        return np.asarray(self.system.external - self.system.internal - turning)

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        self._end = end
        if self._starting:
            return self._starting_step(end, before=before)
        h = end - self.t
        c, old = self.coefficients, self.state
        slope = (1.0 - c.mass) / ((1.0 - c.force) * c.gamma * h)
        lag = c.mass / (1.0 - c.force) - (1.0 - c.gamma) * slope * h
        keep = c.force / (1.0 - c.force)
        relation = Relation(
            slope,
            lag * self._twist_mean - keep * old.twist,
            lag * self._wrench_mean - keep * self._wrench - slope * self._momentum,
        )
        predicted = h * old.twist + 0.5 * h * h * self._rate
        self._trial = relation, self._solve(end, before, relation, predicted.copy())
        return self._with_error(self._trial[1], 0)

    def _starting_step(self, end: float, *, before: bool) -> StepReport:
        """Take a step of the start by TR-BDF2 (Bank et al. 1985), of two stages, of second order and L-stable.

        What a sudden load does to the fastest modes at the start is gone at its end. Methods that do not know the
        accelerations at the start give those that supports, motors and joints prescribe several times over, and the
        forces of these would ring on.
        """
        g = 1.0 - np.sqrt(0.5)
        h = end - self.t
        old, began = self.state, self._wrench
        slope = 1.0 / (g * h)
        first = Relation(slope, -old.twist, -slope * self._momentum - began)
        stage = self._solve(self.t + 2.0 * g * h, False, first, 2.0 * g * h * old.twist)
        if not stage.report.converged:
            return stage.report
        momentum = np.empty_like(self._momentum)
        new = stage.state
        inertia.momenta(self.system.problem.mass, new.r, new.q, new.twist, momentum)
        wrench = slope * momentum + first.history
        ratio = 0.25 * np.sqrt(2.0) / g
        second = Relation(
            slope, -ratio * (old.twist + new.twist), -slope * self._momentum - ratio * (began + wrench)
        )
        self._trial = second, self._solve(end, before, second, h * new.twist)
        return self._with_error(self._trial[1], stage.report.iterations)

    def _with_error(self, solution: Solution, iterations: int) -> StepReport:
        """Complete the report of an attempt by the estimated error."""
        report = solution.report.after(iterations)
        if self.step_tolerance is None or not report.converged:
            return report
        h = self._end - self.t
        error = ERROR_CONSTANT * h * (solution.state.twist - self.state.twist - h * self._rate)
        error[self._held] = 0.0
        # (M/h^2 + C/h + K)^-1 M/h^2, factors of the last iteration: what rings faster than the step does not count
        slope = self._trial[0].slope
        error = slope**2 * np.einsum("nij,nj->ni", self.system.problem.mass, error)
        error[self.supports.set.nodes] *= 1.0 - self.supports.set.fixed
        gaps = np.zeros((self.system.problem.multipliers, 6))
        error = self.system.matrix.solve(np.concatenate([error, gaps]))[: len(error)]
        size = np.abs(error) / ([self.system.problem.length] * 3 + [1.0] * 3)
        node, component = divmod(int(np.argmax(size)), 6)
        return report._replace(error=float(size.max()) / self.step_tolerance, node=node, component=component)

    def watch(self, duration: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: rows of records are corners."""

    def accept(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        relation, solution = self._trial
        began = self.t
        h = self._end - began
        self._start = self.state, self._snapshot
        self._take_solution(solution, relation, self._end)
        if self._starting:
            self._starting -= 1
            # means of twists are those at t + (am - af) h (Arnold, Bruels and Cardona 2015): taken at t, they make
            # forces of what is prescribed ring. Those of wrenches stay, which a sudden load changes within the step
            apart = self.coefficients.mass - self.coefficients.force
            self._wrench_mean = self._wrench.copy()
            self._twist_mean = self.state.twist + apart * h * self._rate
            self._project_velocities()
            if self._starting and self.step_tolerance is None:
                self._rate[:] = 0.0  # the first difference still holds the jump
        else:
            mean, c1 = self._wrench_mean, 1.0 - self.coefficients.gamma
            self._wrench_mean = (
                (self._momentum - solution.momentum_before) / h - c1 * mean
            ) / self.coefficients.gamma
            self._twist_mean = (solution.increment / h - c1 * self._twist_mean) / self.coefficients.gamma
            self._project_velocities()
        power = self._work_rate()
        self.actuator = self._actuator_work(began)
        self.work = 0.5 * h * (self._power + power)
        self.outside = 0.5 * h * (self._lost_power + self.system.dissipated)
        self.branch_loss = self.system.advance_branches()
        self.loss = self.system.viscous_loss(h) + float(self.branch_loss.sum())
        self._power, self._lost_power = power, self.system.dissipated
        self._step = h
        self._snapshot = Snapshot.of(self.state, self.system, self.supports, self.kinetic)
        self.elastic = self._snapshot.elastic
        constraints = self.system.constraints
        gap = float((np.abs(constraints.gap) / constraints.unit).max(initial=0.0))
        self.drift = max(self.drift[0], gap), self.drift[1]

    @property
    def strain(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return float(np.abs(self._snapshot.strain[:, :3]).max(initial=0.0))  # none where bodies are alone

    @property
    def section_force(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._snapshot.section_force

    def snapshot(self) -> Snapshot:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        if self._starting == START or self.system.constraints.rows == 0:
            return self._snapshot
        found, left = with_allowed_velocities(
            self.system.constraints, self._snapshot, self.system.matrix.solve
        )
        self.drift = self.drift[0], max(self.drift[1], left)
        return found

    def between(self, parts: Floats) -> Inside:
        """Interpolate within the last step, cubic in the poses, linear in the rest (see ``contract.Integrator``)."""
        (old, before), after, rate = self._start, self._snapshot, self._rate
        split = np.zeros(len(rate))
        states, _ = interpolate_states(
            parts, self._step, (old, rate), (self.state, rate), split, with_rates=False
        )
        constraints, begin = self.system.constraints, self.t - self._step
        if constraints.rows:
            for state, part in zip(states, parts, strict=True):
                constraints.update(begin + part * self._step)
                gap = close_gaps(constraints, state, self.system.matrix.solve)
                self.drift = max(self.drift[0], gap), self.drift[1]
            constraints.update(self.t, True)
        blended = [
            Snapshots.of(before.blend(after, part, state, self.system))
            for state, part in zip(states, parts, strict=True)
        ]
        work, loss, outside, actuator = (
            parts * one for one in (self.work, self.loss, self.outside, self.actuator)
        )
        lost = np.multiply.outer(parts, self.branch_loss)
        return Inside(Snapshots.joined(blended), StepShare(work, loss, outside, actuator, lost))

    def resume(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: every iteration factorises."""

    def stability(self, z: np.ndarray) -> np.ndarray:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: the root next to the exact one."""
        c = self.coefficients
        new, old = np.zeros((2, len(z), 2, 2), dtype=complex)
        new[:, 0, 0], new[:, 0, 1] = 1.0, -c.gamma
        new[:, 1, 0], new[:, 1, 1] = -z * (1.0 - c.force), 1.0 - c.mass
        old[:, 0, 0], old[:, 0, 1] = 1.0, 1.0 - c.gamma
        old[:, 1, 0], old[:, 1, 1] = z * c.force, -c.mass
        roots = np.linalg.eigvals(np.linalg.solve(new, old))
        nearest = np.abs(roots - np.exp(z)[:, None]).argmin(axis=1)
        return np.asarray(roots[np.arange(len(z)), nearest])

    def begin_half(self, whole: Integrator, place: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: means of other steps do not serve."""
        del whole, place
        self._starting = START
