"""Collocation methods on the Lie group: the common part of Radau IIA and the midpoint rule.

The step's unknowns are nodal coordinates relative to the poses at its start, in which the equations of motion are
ordinary differential equations; so the methods keep their order for large rotations. Stresses are carried as
independent iterates (mixed Newton), which lets a frozen Jacobian serve steps with large rotations: only strains, never
stiffness times strains, are linearised about old poses. The Jacobian and the factors stay in use over several steps
(see ``stage_kernels`` and ``jacobian``).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.mechanics.nodes import inertia
from viscorod.solve.constraints.projection import start_consistently
from viscorod.solve.constraints.start_balance import StartBalance
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.energy_account import NO_LOSS, StepShare
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import Snapshot
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators import iteration_verdict
from viscorod.solve.transient.integrators.company import Company
from viscorod.solve.transient.integrators.contract import OUTCOME, Inside, Integrator, StepReport
from viscorod.solve.transient.integrators.lent_steps import Course, Lent, StepTaken
from viscorod.solve.transient.integrators.loop_data import OF_START, OLD
from viscorod.solve.transient.integrators.record_kernels import StepEnd
from viscorod.solve.transient.integrators.stability import seen_by_halving, stability
from viscorod.solve.transient.integrators.stage_model import StageModel
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.solve.transient.load_content import StepContent
from viscorod.solve.transient.time_step import first_time_step
from viscorod.typing import Floats


class Collocation(StageModel):
    """Common part of all collocation methods (see :class:`~viscorod.solve.transient.integrators.contract.Integrator`).

    Args:
        system, supports: the model.
        tableau: the method.
        newton_tolerance: error left by the iteration (displacement over model length, rotation in rad).
    """

    looks_within = True

    stale = 0.1
    """Convergence rate from which on the Jacobian is renewed."""

    aged = 0.03
    """The same where a step of another length asks for new factors in any case."""

    company: Company | None = None
    """Others that take the same steps."""

    def __init__(
        self, system: System, supports: SupportState, tableau: Tableau, newton_tolerance: float
    ) -> None:
        if tableau.nodes[-1] != 1.0 and type(self)._end_step is Collocation._end_step:
            raise ValueError(
                f"the last node is {tableau.nodes[-1]:.6g}, and its stage is taken as the end of the step; "
                "take a method whose last node is 1, or override _end_step"
            )
        super().__init__(system, supports, tableau, newton_tolerance)

    # --- the contract

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        supports, rows = self.supports, np.ascontiguousarray
        state.r, state.q, state.twist = rows(state.r), rows(state.q), rows(state.twist)
        supports.update(t, False)
        supports.prescribe(state)
        supports.project_twists(state)
        if self.stage_constraints is not None:
            self.system.constraints.update(t)
            self.system.impose_rest(Imposed(t=t))
            start_consistently(self.system, supports, state)
            self.stage_constraints.reset()
        self._evaluate_start(t, state)
        self.predictor.reset()
        self._rate = 1.0
        self._have_jacobian, self._fresh_jacobian = False, OLD

    def _evaluate_start(self, t: float, state: State) -> None:
        """Evaluate the state in which a motion starts, with multipliers and reactions that its accelerations have."""

        def unbalanced(acceleration: Floats) -> Floats:
            self._evaluate_state(t, state, before=False, acceleration=acceleration)
            return self._force

        strain = None if self.forces.motion is None else self.forces.motion.start
        StartBalance(self.system, self.supports, t, state, strain).solve(unbalanced)

    def unbalanced(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._force

    def first_step(self, duration: float) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return first_time_step(
            self.body.mass, self._force, self.state.twist, self.body.held, self.body.length, duration
        )

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        h, self._end = end - self.t, end
        links = self.stage_constraints
        if self.company is not None and (together := self.company.begin(self)) is not None:
            self._have_jacobian = together
        elif self._rate > self.aged and not self.factors_of(h):
            self._have_jacobian = False
        if links is not None and links.turn_axes(self.t, self.state):
            self._have_jacobian = False
        self.prepare_step(end, before)
        self.predictor.predict(self.state, self._stress, h)
        if not self._have_jacobian:
            known = self.predictor.last is not None
            self.renew_jacobian(h, at_start=not known or self._fresh_jacobian != OLD)
        # equal steps differ by the rounding of their ends
        if not self.factors_of(h) and not self._factorise(h):
            return StepReport(Outcome.SINGULAR, 0, 0.0, 0.0, 0)
        self.systems.provide()
        if links is not None:
            links.predict(h)
        if self.dashpots is not None:
            self.dashpots.prepare(h)
        if self.company is not None:
            self.company.correct(self)
        code, count, size, rate, unknown, error, worst = self.trying.call(*self.step_arguments(h))
        self.systems.check()
        self.evaluations += (count + (code == iteration_verdict.CONVERGED)) * len(self.tableau.nodes)
        if code == iteration_verdict.CONVERGED:
            self._rate, self._fresh_jacobian = rate, OLD
            error, worst = self._judge(error, worst)
            node, component = divmod(worst, 6)
            return StepReport(Outcome.CONVERGED, count, size, 0.0, node, error, rate, component)
        node, component = divmod(unknown, 6)
        self._rate = 1.0
        if self._fresh_jacobian != OF_START or (self.company is not None and self.company.helped(self)):
            self._have_jacobian = False
            return self.attempt(end, before=before).after(count)
        if links is not None:
            self.system.constraints.laws.callback.check()
        self.actions.loads.laws.callback.check()
        imbalance = float(np.abs(self.stages.residual[:, : len(self.body.mass)]).max())
        return StepReport(OUTCOME[code], count, size, imbalance, node, 0.0, rate, component)

    @property
    def lent(self) -> Lent:
        """What the compiled loop of steps works on."""
        return Lent(self.share(), self._kept, self.recorder.reading, self.recorder.start_rate, self._ad)

    def lend(self, state: State) -> Course:
        """Let the compiled loop go on, which changes the arrays of ``state``, the present one; return how it stands."""
        self.systems.provide()
        self.state = state
        have, fresh = self._have_jacobian, self._fresh_jacobian
        return Course(self.t, self._factor_step, self._rate, have, fresh, 0, 0, 0)

    def take_back(self, state: State, course: Course) -> None:
        """Go on from where the compiled loop has come to, with arrays of its own."""
        self.state, self.t = state, course.t
        self._factor_step, self._rate = course.factor_step, course.rate
        self._have_jacobian, self._fresh_jacobian = course.have_jacobian, course.fresh_jacobian
        self.evaluations += course.evaluations
        self.factorisations += course.factorisations
        self.jacobians += course.jacobians

    def take_step(self, step: StepTaken) -> None:
        """Take the last step of the compiled loop, which ends at the present state, as the last one."""
        self._end, self._step = self.t, step.h
        self.kinetic, self.elastic, self.work, self.loss, self.outside = step.energies
        self._end_rate = step.end.rate
        self.predictor.keep(step.start[0], step.h)
        self.recorder.take_over(step.start, step.end, step.strain)
        self.recorder.record_end(self.state, self.kinetic, self.elastic)

    def accept(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        h = self._end - self.t
        self.elastic = float(self.account.elastic[self._last])
        self.predictor.keep(self.state, h)
        end, kinetic, shares = self.recorder.take_step(self.state, h, self.account, self._kept)
        self.work, self.loss, self.outside = shares
        if len(self.stages.rest):
            self.actuator = h * float(self.account.powers[3] @ self.tableau.weights)
        if self.dashpots is not None:
            self.dashpots.end_step(self.stages.strain)
        self._end_step(end, kinetic)
        self.t, self._step = self._end, h
        if self._rate > self.stale:
            self._have_jacobian = False

    @property
    def drift(self) -> tuple[float, float]:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return (0.0, 0.0) if self.stage_constraints is None else self.stage_constraints.drift

    @property
    def strain(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self.recorder.strain

    @property
    def section_force(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self.recorder.snapshot.section_force

    def snapshot(self) -> Snapshot:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        snapshot = self.recorder.snapshot
        if self.dashpots is not None:
            present = self.dashpots.present()
            snapshot = snapshot._replace(branch_power=present.power[0], branch_strain=present.strain[0])
        if self.stage_constraints is None or self._factor_step == 0.0:
            return snapshot
        self.system.constraints.update(self.t, True)  # states between may have been computed
        return self.stage_constraints.with_allowed_velocities(snapshot, self.systems)

    def between(self, parts: Floats) -> Inside:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        states, work, loss, outside, actuator = self.recorder.between(
            parts, self.t, self._step, self.state, self._end_rate, self.account.powers, self.loss
        )
        if len(self.stages.rest):
            actuator = self._step * (self.tableau.partial_weights(parts) @ self.account.powers[3])
        if self.dashpots is None:
            return Inside(states, StepShare(work, loss, outside, actuator, np.zeros((len(parts), 0))))
        found = self.dashpots.between(parts)
        states = states._replace(branch_power=found.power, branch_strain=found.strain)
        return Inside(states, StepShare(work, loss, outside, actuator, found.loss))

    @property
    def branch_loss(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return NO_LOSS if self.dashpots is None else self.dashpots.loss

    def resume(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: factors follow from the Jacobian."""
        self.actions.reset()
        if self._factor_step > 0.0:
            self.systems.want(self.matrices, self._factor_step)

    def stability(self, z: np.ndarray) -> np.ndarray:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return stability(self.tableau, z)

    @property
    def seen_by_halving(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return seen_by_halving(self.tableau)

    def begin_half(self, whole: Integrator, place: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: ``whole`` predicts its halves."""
        given: Any = whole
        self.predictor.follow(given.predictor, place)
        if self.stage_constraints is not None:
            self.stage_constraints.follow(given.stage_constraints, place)

    # --- what methods differ in

    def watch(self, duration: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        self.actions.content = StepContent.of(self.system.problem, self.tableau.nodes, duration)

    def unseen(self) -> tuple[float, int]:
        """Return the displacement, over the length, or rotation that is missed between the stages, and the unknown."""
        force = self.actions.unseen(self.t, self.state)
        gap = 0.0 if self.actions.content is None else self.actions.content.gap
        if force is None:
            return gap, 0
        force[self.supports.set.nodes] *= 1.0 - self.supports.set.fixed
        none = np.zeros((self.system.problem.multipliers, 6))
        moved = np.abs(self.systems.solve_real(np.concatenate([force, none]))[: len(force)])
        moved[:, :3] /= self.body.length
        return max(float(moved.max()), gap), int(moved.argmax())

    def _judge(self, error: float, unknown: int) -> tuple[float, int]:
        """Return the error of a converged step over the tolerated one, and the unknown where it is largest."""
        del error, unknown
        return 0.0, 0

    def _end_step(self, end: StepEnd, kinetic: float) -> None:
        """Make the last stage, ``end`` with its kinetic energy [J], the new state."""
        self.state = State(end.r, end.q, end.twist, self.state.multiplier)
        if self.forces.motion is not None:
            self.forces.set_strains(self._whole_strain(self._last))
        partial = len(self.supports.partial) > 0
        if partial:
            self.actions.move_supports(self._end, before=True)
            self.supports.project_twists(self.state)
        if self.stage_constraints is not None:
            self.system.constraints.update(self._end, True)
            self.elastic += self.stage_constraints.end_step(self.state, self._end - self.t, stage=True)
        if partial:  # twists have been projected
            kinetic = inertia.kinetic_energy(self.body.mass, self.state.twist)
        self._end_rate, self.kinetic = end.rate, kinetic
        self.recorder.record_end(self.state, kinetic, self.elastic)

    def _factorise(self, h: float) -> bool:
        """Factorise the real and the complex matrix for the step ``h``; False if one is singular."""
        self._factor_step = h
        if self.company is not None and self.company.lends_factors(self, h):
            return True
        self.factorisations += 1
        return self.systems.factorise(self.matrices, h)
