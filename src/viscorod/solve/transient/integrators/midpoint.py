"""The implicit midpoint rule with an exact energy balance."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.rotations.nodal_motion import coordinates, place
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.record_kernels import StepEnd
from viscorod.solve.transient.integrators.step_task import Ends
from viscorod.solve.transient.integrators.tableau import MIDPOINT
from viscorod.typing import Floats


class Midpoint(Collocation):
    """The implicit midpoint rule: order 2, and energy changes by exactly what loads do and viscosity takes.

    Section forces are corrected point by point so that their work is the change of the elastic energy (see
    ``internal_force.conserve_energy``); body velocities make the kinetic energy quadratic, which the rule keeps exact.

    Args:
        system, supports: the model.
        newton_tolerance: error left by the iteration (displacement over model length, rotation in rad).
    """

    estimate_order = 2
    records = 1
    oldest = 8
    """Steps with one Jacobian, where there are constraints.

    The error of velocities at the end of a step is of second order itself, and is projected away along the constraints'
    gradients in the Jacobian: with a Jacobian of a fixed age the method would have order 1.
    """

    def __init__(self, system: System, supports: SupportState, *, newton_tolerance: float = 1e-13) -> None:
        super().__init__(system, supports, MIDPOINT, newton_tolerance)
        self.ends = Ends.of(self.body, driven=system.imposed.changes)
        self._end_twist, self._end_acceleration = np.zeros((2, len(supports.complete), 6))
        self._age = 0
        self._middle: Floats | None = None  # wrenches of the supports in the middle of the last step
        self._since = 0.0  # time from there to its end [s]

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        super().start(t, state)
        self._middle, self._since = None, 0.0

    def accept(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        super().accept()
        self._age += 1
        if self.stage_constraints is not None and self._age >= self.oldest:
            self._have_jacobian = False

    def renew_jacobian(self, h: float, *, at_start: bool) -> None:
        """See :class:`~viscorod.solve.transient.integrators.collocation.Collocation`."""
        super().renew_jacobian(h, at_start=at_start)
        self._age = 0

    def prepare_step(self, end: float, before: bool) -> None:
        """See :class:`~viscorod.solve.transient.integrators.collocation.Collocation`."""
        h = end - self.t
        motion, supports = self.actions.motion, self.supports
        self.actions.look_within(self.t, end)
        self.actions.prepare(0, self.t + 0.5 * h, before=False)
        if self.stage_constraints is not None:
            self.stage_constraints.prepare_end(self.t, end, before=before)
        if self.system.imposed.changes:
            self._prepare_rest(end, before=before)
        if not supports.moving:
            return
        supports.update(self.t, False)
        start, start_rate = supports.target.copy(), supports.rate.copy()
        supports.update(end, before)
        motion.target[0], motion.rate[0] = supports.target, (supports.target - start) / h
        moving_axes = supports.set.in_body
        motion.rate[0, moving_axes] = 0.5 * (start_rate + supports.rate)[moving_axes]
        c = supports.complete
        if len(c) == 0:
            return
        nodes = supports.set.nodes[c]
        r, q, twist, acceleration = supports.complete_motion()
        motion.end_r[c], motion.end_q[c] = r, q
        old = self.state
        X, still, unused = np.empty(6), np.zeros(6), np.empty(6)
        for k, support, node in zip(range(len(c)), c, nodes, strict=True):
            coordinates(old.r[node], old.q[node], r[k], q[k], False, X)
            place(
                old.r[node],
                old.q[node],
                0.5 * X,
                still,
                False,
                motion.r[0, support],
                motion.q[0, support],
                unused,
            )
            motion.twist[0, support] = 0.5 * (old.twist[node] + twist[k])
            motion.twist_rate[0, support] = (twist[k] - old.twist[node]) / h
        self._end_twist, self._end_acceleration = twist, acceleration

    def _prepare_rest(self, end: float, *, before: bool) -> None:
        """Let the middle have the mean of both ends, with which the energy balance is exact."""
        stages, imposed = self.stages, self.system.imposed
        first, last = imposed.driven(self.t), imposed.driven(end, before)
        stages.rest[0], stages.rest_rate[0] = 0.5 * (first + last), (last - first) / (end - self.t)
        self.ends.rest[0] = last

    def _end_step(self, end: StepEnd, kinetic: float) -> None:
        """Extrapolate from the middle to the end of the step, and evaluate the forces there."""
        del kinetic
        reaction = self._extrapolated(end.reactions[-1].copy())
        ends, stages = self.ends, self.stages
        twist = 2.0 * stages.twist[0] - self.state.twist
        self.forces.extrapolate_strains(self._whole_strain(0))
        state = State(ends.r[0].copy(), ends.q[0].copy(), twist, self.state.multiplier)
        supports, acceleration = self.supports, stages.acceleration[0].copy()
        if supports.moving:
            held = supports.set.nodes[supports.complete]
            state.twist[held], acceleration[held] = self._end_twist, self._end_acceleration
            supports.update(self._end, True)
        if self.stage_constraints is not None:
            self.system.constraints.update(self._end, True)
            self.stage_constraints.end_step(state, self._end - self.t, stage=False)
        self._evaluate_state(self._end, state, before=True, acceleration=acceleration)
        self.recorder.snapshot = self.recorder.snapshot._replace(reaction=reaction)

    def _extrapolated(self, middle: Floats) -> Floats:
        """Return wrenches of supports at the end of a step, on the line through two middles, or start and middle.

        Those evaluated at the end have accelerations of the middle, and rates of strains that alternate from one end
        to the next where viscosity is stiff.
        """
        earlier = self.recorder.snapshot.reaction if self._middle is None else self._middle
        half = 0.5 * (self._end - self.t)
        found: Floats = middle + half * (middle - earlier) / (self._since + half)
        self._middle, self._since = middle, half
        return found

    def _evaluate_state(self, t: float, state: State, *, before: bool, acceleration: Floats) -> None:
        super()._evaluate_state(t, state, before=before, acceleration=acceleration)
        self.ends.start_strain[:] = self._points.strain
