"""Many steps of a motion in one compiled call, where they need little of Python."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.mechanics.compilation.callback import Callback
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
from viscorod.model.actions.load_effects import CompiledLaw
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.load_courses import course_loads
from viscorod.solve.problem.motion_courses import course_motions
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.integrators import loop_data, step_loop
from viscorod.solve.transient.integrators.contract import Integrator, StepReport
from viscorod.solve.transient.integrators.lent_steps import Course, StepTaken
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.integrators.record_kernels import (
    StepEnd,
)
from viscorod.solve.transient.loop_addresses import find_addresses
from viscorod.solve.transient.loop_arrays import MOST_CORNERS, MOST_STEPS, loop_arrays
from viscorod.solve.transient.loop_link_arrays import serves_links
from viscorod.solve.transient.loop_own_kernels import own_kernels
from viscorod.solve.transient.motion_scale import GivenTolerance, PartOfMotion, Tolerance
from viscorod.solve.transient.step_control import ErrorControl, StepControl
from viscorod.solve.transient.taken_records import Taken, TakenRecords
from viscorod.solve.transient.trial_choice import SETTLED
from viscorod.typing import Floats

__all__ = ["ManySteps", "Taken"]

MOST_NODES = 300
"""Nodes of a model up to which Python between the steps is worth saving."""


class ManySteps(TakenRecords):
    """The compiled loop of steps of one motion.

    Args:
        integrator, control: that take the steps.
        duration: of the motion [s]; output_interval: time between records [s], None for all that a step has.
    """

    def __init__(
        self,
        integrator: Radau,
        control: ErrorControl,
        duration: float,
        output_interval: float | None,
    ) -> None:
        self.control = control
        content = integrator.actions.content
        motions = course_motions(integrator.supports.set)
        courses = course_loads(integrator.actions.loads)
        arrays = loop_arrays(integrator, control, duration, output_interval, courses, motions)
        super().__init__(integrator, arrays)
        self._factors = integrator.systems.factors
        self._shared: Shared[loop_data.StepLoop] | None = None
        self._callbacks: list[Callback] = []
        self._loads_known = courses is not None
        # of records, which are known, steps see the moments
        seen = content is None or content.alone
        self._known = courses is not None and motions is not None and seen
        self._steps = KnownTypes(step_loop.take_steps)
        self._began = 0.0  # of the steps that are taken at once [s]

    @classmethod
    def of(
        cls,
        integrator: Integrator,
        control: StepControl,
        duration: float,
        output_interval: float | None,
        *,
        long: bool,
    ) -> ManySteps | None:
        """Return what takes many steps of an integrator under a control at once; None if nothing can.

        Nothing is compiled for that. Machine code on disk is loaded for a ``long`` run, or if there was one before.
        """
        if PURE_PYTHON or type(integrator) is not Radau or not isinstance(control, ErrorControl):
            return None
        worth = cls.serves(integrator) and _worth_loading(integrator, long=long)
        return cls(integrator, control, duration, output_interval) if worth else None

    @staticmethod
    def serves(integrator: Radau) -> bool:
        """Return whether compiled code can take steps of an integrator."""
        problem, systems, content = integrator.system.problem, integrator.systems, integrator.actions.content
        return (
            problem.size <= MOST_NODES
            and (not problem.constrained or serves_links(integrator.system.constraints))
            and all(isinstance(load.law, CompiledLaw) for load in problem.motion_loads)
            and not (content is not None and content.asks)
            and not (integrator.system.imposed.changes or integrator.forces.motion is not None)
            and _knows_motions(integrator.supports)
            and systems.real.plan.banded
            and _serves(integrator.tolerance)
        )

    @property
    def ready(self) -> bool:
        """Whether the next step can be taken: not with factors of another plan."""
        return self.integrator.systems.factors is self._factors

    def look_ahead(self, corners: list[float]) -> None:
        """Take note of corners [s] after the next one, up to which steps go on."""
        ahead = self.loop.ahead
        ahead[:] = np.inf
        known = corners[:MOST_CORNERS]
        ahead[: len(known)] = known

    def take(
        self, number: int, marks: list[int], halved: HalvedSteps | None, account: EnergyAccount
    ) -> Taken:
        """Take steps up to the corners that are known.

        Args:
            number: of the first one; marks: steps at whose ends the state is kept, see :meth:`marked`.
            halved: that tries some again; account: before them.
        """
        batch, numbers = self.loop.batch, self.loop.numbers
        self.hand_over(account)
        trials = self.loop.trials
        trials[:] = -1.0, SETTLED, np.inf, number
        if halved is not None:
            trials[0], trials[2] = halved.coming
            assert halved.tolerance is not None  # steps of Radau follow one
            self.loop.limits[loop_data.HALF] = self.integrator.half_tolerance(halved.tolerance)
        numbers[loop_data.MOST] = MOST_STEPS if len(marks) <= loop_data.MARKS else marks[loop_data.MARKS] - 1
        batch.marks[:] = 0
        batch.marks[: len(marks)] = marks[: loop_data.MARKS]
        why = self._steps.call(self.addressed().argument)
        self.hand_back()
        steps = int(numbers[loop_data.STEPS])
        ends, lengths = batch.ends[:steps].tolist(), batch.lengths[:steps].tolist()
        self.control.took(lengths)
        counts, limits, unknowns = batch.notes[:, :steps].tolist()
        iterated, rejected = int(numbers[loop_data.ITERATED]), int(numbers[loop_data.REJECTED])
        starts = [self._began, *ends[:-1]]
        return Taken(
            why == loop_data.BROKEN, starts, ends, lengths, counts, limits, unknowns, iterated, rejected
        )

    def check(self) -> None:
        """Raise what went wrong in Python within the steps taken."""
        for callback in self._callbacks:
            callback.check()

    def limit(self, taken: Taken, k: int) -> str:
        """Return what limited the ``k``-th step, in words."""
        return self.control.in_words(taken.limits[k])

    def report(self, taken: Taken, k: int) -> StepReport:
        """Return the report of the ``k``-th step, as far as it is known."""
        node, component = divmod(taken.unknowns[k], 6)
        return StepReport(Outcome.CONVERGED, taken.iterations[k], 0.0, 0.0, node, component=component)

    def compile(self) -> None:
        """Compile the loop, but none of the kernels that it calls, except for those of its own that the model needs."""
        loop = Shared(self.loop).argument
        self._steps.compiled((loop,))
        for kernel, arguments in own_kernels(self.integrator).values():
            KnownTypes(kernel).compiled((loop, *arguments))

    def hand_over(self, account: EnergyAccount) -> None:
        """Hand the present state over."""
        integrator, clock, numbers, batch = (
            self.integrator,
            self.loop.clock,
            self.loop.numbers,
            self.loop.batch,
        )
        state, links = integrator.state, integrator.stage_constraints
        if links is not None and links.still:
            constraints, arrays = links.constraints, links.arrays
            arrays.states.target[:], arrays.target_rate[:] = constraints.target, constraints.target_rate
        old, length = integrator.predictor.last or (state, 0.0)
        for to, given in ((self.loop.state.now, state), (self.loop.state.last, old)):
            to.r[:], to.q[:], to.twist[:] = given.r, given.q, given.twist
        self.loop.state.points[1], self.loop.state.reactions[1] = integrator.recorder.present
        now = self.loop.state.now
        multiplier = state.multiplier if links is None else links.memory.multiplier
        course = integrator.lend(State(now.r, now.q, now.twist, multiplier))
        clock[:], numbers[:] = 0.0, 0
        self._began = integrator.t
        clock[loop_data.T], clock[loop_data.FACTOR_STEP], clock[loop_data.RATE] = course[:3]
        clock[loop_data.LAST_STEP] = length
        numbers[loop_data.HAVE], numbers[loop_data.FRESH] = course.have_jacobian, course.fresh_jacobian
        limits = self.loop.limits
        limits[loop_data.TOLERANCE] = integrator.step_factor * integrator.tolerance.value
        limits[loop_data.NEWTON] = integrator.newton_tolerance
        if isinstance(integrator.tolerance, PartOfMotion) and integrator.tolerance.start is not None:
            follows, begun = self.loop.state.follows, integrator.tolerance.start
            follows.r[:], follows.q[:] = begun.r, begun.q
        self.loop.loads.stages.factors[:] = np.nan  # what steps read may be Python's
        batch.notes[0], batch.states.energies[4] = 0, 0.0
        batch.accounts[0] = (
            *(account.kinetic, account.elastic, account.viscous, account.external),
            account.outside,
        )
        batch.lost[0] = account.branches

    def hand_back(self) -> None:
        """Bring the integrator to where the loop ended."""
        clock, numbers, given = self.loop.clock, self.loop.numbers, self.loop.state
        multiplier, links = self.integrator.state.multiplier.copy(), self.integrator.stage_constraints
        now, old = (
            State(one.r.copy(), one.q.copy(), one.twist.copy(), multiplier) for one in (given.now, given.last)
        )
        t, factor_step, rate = clock[: loop_data.LAST_STEP].tolist()
        have, fresh = bool(numbers[loop_data.HAVE]), int(numbers[loop_data.FRESH])
        counts = numbers[loop_data.EVALUATED : loop_data.PASSED].tolist()
        moved = t > self._began
        course = Course(t, factor_step, rate, have, fresh, *counts)
        self.integrator.take_back(now, course)
        if self._known:
            self.integrator.actions.reset()
        if numbers[loop_data.LOST] and factor_step > 0.0:
            self.integrator.systems.want(self.integrator.matrices, factor_step)
        self.integrator.newton_tolerance = float(self.loop.limits[loop_data.NEWTON])
        if moved:
            if links is not None:
                links.take_back(now, float(clock[loop_data.LAST_STEP]))
            end = StepEnd(*(field.copy() for field in given.end))
            start = old, self.loop.state.points[0].copy(), self.loop.state.reactions[0].copy()
            h, _, *energies, strain = clock[loop_data.LAST_STEP : loop_data.GAP].tolist()
            kinetic, elastic, work, loss, outside = energies
            shares = work, loss, outside
            self.integrator.take_step(StepTaken(h, start, end, (kinetic, elastic, *shares), strain))

    def addressed(self) -> Shared[loop_data.StepLoop]:
        """Return what the loop works on, in memory, with all addresses in it."""
        if self._shared is None:
            loop = self.loop
            self._shared = Shared(loop)
            arrays = (
                loop.model,
                loop.state,
                loop.systems,
                loop.batch.states,
                loop.renewal,
                loop.loads,
                loop.links,
            )
            calls = find_addresses(self.integrator, *arrays, self._shared)
            asked = {} if self._known else {"prepare": self._called(self._call_prepare)}
            if not (self._loads_known and calls.assemble):
                asked["renew"] = self._called(self._call_renew)
            if not self._known and self.integrator.actions.content is not None:
                asked["unseen"] = self._called(self._call_unseen)
            self._shared.put("calls", calls._replace(**asked))
        return self._shared

    def _called(self, function: Callable[[Floats], None]) -> int:
        """Return the address of a Python function."""
        self._callbacks.append(Callback(function))
        return self._callbacks[-1].address

    def _call_renew(self, message: Floats) -> None:
        self.integrator.t = float(message[0])
        self.integrator.renew_jacobian(float(message[1]) - self.integrator.t, at_start=bool(message[2]))
        self.integrator.jacobians -= int(message[3])  # those of halves do not count

    def _call_prepare(self, message: Floats) -> None:
        self.integrator.t = float(message[0])
        self.integrator.prepare_step(float(message[1]), bool(message[2]))

    def _call_unseen(self, message: Floats) -> None:
        self.integrator.t = float(message[0])
        message[1], message[2] = self.integrator.unseen()


def _knows_motions(supports: SupportState) -> bool:
    """Return whether the loop knows how moving supports hold nodes in part, if any do."""
    if not (supports.moving and len(supports.partial)):
        return True
    return supports.stage is None and course_motions(supports.set) is not None


def _serves(tolerance: Tolerance) -> bool:
    follows = isinstance(tolerance, PartOfMotion) and tolerance.start is not None
    return follows or type(tolerance) is GivenTolerance


def _worth_loading(integrator: Radau, *, long: bool) -> bool:
    """Return whether the loop is there; from disk it takes as long as it saves in some hundred steps."""
    known = [KnownTypes(step_loop.take_steps)]
    known += [KnownTypes(kernel) for kernel, _ in own_kernels(integrator).values()]
    if all(kernel.loaded for kernel in known):
        return True
    return (long or integrator.trying.loaded) and all(kernel.kept for kernel in known)
