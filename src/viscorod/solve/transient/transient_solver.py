"""Transient analysis: drives an integrator through time, hits all corners of the loads, keeps the energy account."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from viscorod.errors import InputError
from viscorod.solve.energy_account import EnergiesWithin, EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Records, Snapshot
from viscorod.solve.problem.node_names import describe_node
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.newton import Outcome, interruption
from viscorod.solve.transient.corners import corners_of
from viscorod.solve.transient.events import EventWatch
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.integrators.contract import Integrator, StepReport
from viscorod.solve.transient.loop_arrays import LARGEST_STRAIN, MOST_CORNERS, MOST_STEPS
from viscorod.solve.transient.many_steps import ManySteps
from viscorod.solve.transient.saved_state import SavedTree, restore, saved
from viscorod.solve.transient.step_control import KnownSteps, StepControl
from viscorod.solve.transient.transient_result import StepCounts, TransientResult

AT_ONCE = 32
"""States within one step that are in memory at once."""

LONG = 300
"""Steps after which a run counts as a long one."""


class Notes(Protocol):
    """Keeps some of the states of a motion, at the ends of steps."""

    def coming(self, steps: int) -> list[int]:
        """Return after which of the next ``steps``, counted from 1, it wants to see the state."""

    def passed(self, steps: int, t: float, state: Callable[[], Snapshot]) -> None:
        """Take note of so many steps since the last call, the last of which ends at ``t`` [s] in ``state``."""


class Transient:
    """Runs an integrator over a time span.

    The instants at which loads or prescribed motions are not smooth are always hit, and after a jump the integrator
    starts anew, so that no load is ever averaged over a jump.

    Args:
        problem: for the corners of its loads; integrator, control: what steps, and how far.
        halved: tells what steps err by.
    """

    def __init__(
        self,
        problem: Problem,
        integrator: Integrator,
        control: StepControl,
        halved: HalvedSteps | None = None,
    ) -> None:
        self.problem = problem
        self.halved = halved
        self.integrator = integrator
        self.control = control
        self.account = EnergyAccount()
        self.effort = StepCounts()
        self.watch = EventWatch([])
        self.result = TransientResult()
        self.duration = math.inf
        self.output_interval: float | None = None
        self._progress: Callable[[float, float], None] | None = None
        self._after_step: Callable[[], str] | None = None
        self._notes: Notes | None = None
        self._patient = True
        self.many: ManySteps | None = None

    def run(
        self,
        state: State,
        duration: float,
        *,
        output_interval: float | None = None,
        progress: Callable[[float, float], None] | None = None,
        history: History | None = None,
        checkpoint: SavedTree = None,
        after_step: Callable[[], str] | None = None,
        patient: bool = True,
        notes: Notes | None = None,
        watch: EventWatch | None = None,
    ) -> TransientResult:
        """Integrate from ``state`` at t = 0 to ``duration`` [s].

        Args:
            state: initial poses and twists (overwritten).
            output_interval: time between records [s]; None records every step and what lies between.
            progress: called with (time, step) after every step; with an attribute ``patient`` that is true, only after
                the last one of some short steps that are taken at once.
            history: that records; None keeps everything in memory.
            checkpoint: from :meth:`saved` of a run that was stopped; this one goes on from there.
            after_step: called after every step; returns why the run is to stop, or nothing.
            patient: that may be called after some short steps that are taken at once, too.
            notes: keeps some states.
            watch: checks every step for events, which may end the run.
        """
        self.watch = watch or EventWatch([])
        self.output_interval, self.duration = output_interval, duration
        self._progress, self._after_step, self._notes = progress, after_step, notes
        self._patient = patient
        self.result = result = TransientResult(history or History(), effort=self.effort)
        try:
            self._integrate(state, checkpoint)
        except KeyboardInterrupt as asked:
            result.outcome, result.reason = Outcome.INTERRUPTED, interruption(asked)
        except InputError as error:
            if not result.history.count:
                raise
            result.outcome, result.reason = Outcome.INTERRUPTED, str(error)
        finally:  # what they belong to refers to this object
            self._progress = self._after_step = self._notes = None
        self.update_counts()
        return result

    def update_counts(self) -> None:
        """Take over the counts of the integrator."""
        effort, integrator = self.effort, self.integrator
        effort.evaluations, effort.factorisations = integrator.evaluations, integrator.factorisations
        effort.jacobians = integrator.jacobians

    def _integrate(self, state: State, checkpoint: SavedTree) -> None:
        integrator, control = self.integrator, self.control
        self.begin(state, record=checkpoint is None)
        if checkpoint is not None:
            self.resume(checkpoint)
        corners, jumps = self.corners(0.0, self.duration)
        t, restart, resumed = integrator.t, True, checkpoint is not None
        for k, corner in enumerate(corners):
            if resumed and corner < t:
                continue
            if not resumed and integrator.t < corner:  # steps taken at once may have passed it
                control.begin(t, corner, first=integrator.first_step(self.duration) if restart else None)
            resumed = False
            if self.many is not None:
                self.many.look_ahead(_up_to_jump(corners[k : k + MOST_CORNERS + 1], jumps))
            if not self.integrate_to(corner):
                return
            t, restart = corner, corner in jumps
            if restart:
                self.restart(corner)

    def begin(self, state: State, *, record: bool = True) -> None:
        """Start from ``state`` at t = 0, and record it."""
        integrator, account = self.integrator, self.account
        integrator.start(0.0, state)
        integrator.watch(self.duration)
        if self.halved is not None:
            self.halved.begin(integrator, self.duration)
        account.elastic = integrator.elastic
        account.kinetic = integrator.kinetic
        account.start = account.kinetic + account.elastic
        account.branches = np.zeros(len(self.problem.relaxation_times))
        self._look_for_many(long=False)
        if record:
            self.result.history.record(0.0, integrator.snapshot(), account, 0.0, 0)
            self.watch.begin(0.0, integrator.snapshot())

    def integrate_to(self, corner: float) -> bool:
        """Integrate to the time ``corner`` [s], for which the step control is set; False if the run ends before."""
        integrator = self.integrator
        while integrator.t < corner:
            steps = self.effort.steps
            if self.many is not None and not self._take_many(self.many):
                return False
            if self.effort.steps > steps:
                continue
            if not self._take_one(corner):
                return False
            if self.many is None and self.effort.steps == LONG:
                self._look_for_many(long=True)
        return True

    def _look_for_many(self, *, long: bool) -> None:
        """See whether many steps can be taken at once."""
        if self._patient and not self.watch.monitors and math.isfinite(self.duration):
            given = self.duration, self.output_interval
            self.many = ManySteps.of(self.integrator, self.control, *given, long=long)

    def _take_one(self, corner: float) -> bool:
        """Try one step; False if the run ends."""
        integrator, control, effort, result = self.integrator, self.control, self.effort, self.result
        t = integrator.t
        end = control.next_end(t)
        if self.halved is not None:
            self.halved.prepare(effort.steps, integrator, end - t)
        report = integrator.attempt(end, before=end == corner)
        effort.iterations += report.iterations
        result.report = report
        if not control.accepts(report, end - t):
            effort.rejected += 1
            if not report.converged and control.notes_failures:
                effort.first_failed_at = effort.first_failed_at if effort.failed else t
                effort.failed += 1
                effort.shortest_failed = min(effort.shortest_failed, end - t)
            if control.exhausted:
                result.outcome, result.failed_at = report.outcome, end
                if report.converged:
                    result.outcome = Outcome.TOO_SMALL
            return not control.exhausted
        before, began = self.account.copy(), integrator.state
        integrator.accept()
        if self.halved is not None:
            self.halved.compare(effort.steps, integrator, began, end - t, left=end == corner)
        if not integrator.strain < LARGEST_STRAIN:
            result.outcome, result.failed_at = Outcome.BROKEN, end
            return False
        self.account.add(integrator)
        effort.steps += 1
        if end - t < effort.smallest_step:
            effort.smallest_step, effort.smallest_at = end - t, t
            effort.smallest_why = self._limit_in_words(control.limit, report)
        if self._progress is not None:
            self._progress(end, end - t)
        stop = self.watch.check_step(integrator, t) if self.watch.monitors else None
        self._record(before, t, end, stop, report.iterations)
        if control.exhausted:
            result.outcome, result.failed_at = Outcome.TOO_SMALL, end
            return False
        if stop is not None:
            return False
        if self._notes is not None:
            self._notes.passed(1, end, integrator.snapshot)
        return self._goes_on(end)

    def _goes_on(self, end: float) -> bool:
        """Return whether the run goes on after a step to ``end`` [s]."""
        reason = self._after_step() if self._after_step is not None else ""
        if not reason or end >= self.duration:
            return True
        self.result.outcome, self.result.reason = Outcome.INTERRUPTED, reason
        self.result.between_steps = True
        return False

    def _take_many(self, many: ManySteps) -> bool:
        """Take compiled steps until one is to be taken by itself; False if the run ends."""
        effort, halved, notes = self.effort, self.halved, self._notes
        if not many.ready or (halved is not None and halved.waiting):
            return True
        before, after = self.account, self.account.copy()
        marks = [] if notes is None else notes.coming(MOST_STEPS)
        taken = many.take(effort.steps, marks, halved, before)
        effort.iterations += taken.iterated
        effort.rejected += taken.rejected
        if halved is not None:
            tried = many.tried()
            for k, h in enumerate(taken.lengths):
                halved.passed(effort.steps + k, h)
                if k in tried:
                    halved.take(effort.steps + k, tried[k])
        effort.steps += len(taken.lengths)
        least = min(taken.lengths, default=math.inf)
        if least < effort.smallest_step:
            k = taken.lengths.index(least)
            effort.smallest_step, effort.smallest_at = least, taken.starts[k]
            effort.smallest_why = self._limit_in_words(many.limit(taken, k), many.report(taken, k))
        if taken.ends:
            self.result.report = many.report(taken, len(taken.ends) - 1)
            records = many.records(before)
            many.bring(after)
            self.account = after
            if records is not None:
                self.result.history.extend(*records)
            if notes is not None:
                seen = 0
                for count, state in many.marked(taken, marks):
                    notes.passed(count - seen, taken.ends[count - 1], state)
                    seen = count
                if seen < len(taken.ends):
                    notes.passed(len(taken.ends) - seen, self.integrator.t, self.integrator.snapshot)
        if self._progress is not None:  # which may end the run: states are recorded by now
            told = slice(-1, None) if getattr(self._progress, "patient", False) else slice(None)
            for end, h in zip(taken.ends[told], taken.lengths[told], strict=True):
                self._progress(end, h)
        many.check()
        if taken.broken:
            self.result.outcome, self.result.failed_at = Outcome.BROKEN, self.integrator.t
            return False
        return not taken.ends or self._goes_on(taken.ends[-1])

    def _record(
        self, before: EnergyAccount, t: float, end: float, stop: float | None, iterations: int
    ) -> None:
        """Record what is due of the step from ``t`` to ``end`` [s], or to where the run stops in it."""
        integrator, history = self.integrator, self.result.history
        times = self._record_times(t, end, self.output_interval, end == self.duration)
        if stop is not None:
            times = [*(at for at in times if at < stop), stop]
        if not times:
            return
        parts = [(at - t) / (end - t) for at in times]
        while parts and parts[-1] > 1.0 - 1e-9:
            parts.pop()
        least, driven, after = -np.inf, False, self.account.copy()
        for begin in range(0, len(parts), AT_ONCE):
            some = np.array(parts[begin : begin + AT_ONCE])
            states, share = integrator.between(some)
            loss = share.loss
            driven = driven or bool((np.diff(loss, prepend=0.0 if begin == 0 else loss[0]) < 0.0).any())
            if not driven:  # interpolation must not give energy back
                np.maximum(loss, least, out=loss)
            least = loss[-1]
            energy = EnergiesWithin(before, after, some, states.kinetic, share)
            instants = times[begin : begin + len(some)]
            history.extend(instants, Records(states, energy), end - t, iterations)
        if len(times) > len(parts):
            history.record(times[-1], integrator.snapshot(), after, end - t, iterations)

    def saved(self) -> SavedTree:
        """Return the state from which another run of the same model can go on."""
        parts = (self.integrator, self.control, self.account, self.effort, self.watch)
        trials = None if self.halved is None else saved(self.halved.trials)
        return {"parts": [saved(part) for part in parts], "trials": trials}

    def resume(self, checkpoint: SavedTree) -> None:
        """Put back what :meth:`saved` returned."""
        parts = (self.integrator, self.control, self.account, self.effort, self.watch)
        for part, tree in zip(parts, checkpoint["parts"], strict=True):
            restore(part, tree)
        if self.halved is not None:
            restore(self.halved.trials, checkpoint.get("trials"))
        self.integrator.resume()

    def _record_times(self, t: float, end: float, output_interval: float | None, final: bool) -> list[float]:
        """Return the times in the step from ``t`` to ``end`` at which states are recorded."""
        if output_interval is None:
            count = self.integrator.records
            return [*(t + k / count * (end - t) for k in range(1, count)), end]
        first = math.floor(t / output_interval * (1.0 + 1e-12) + 1e-9) + 1
        last = math.floor(end / output_interval * (1.0 + 1e-12) + 1e-9)
        times = [k * output_interval for k in range(first, last + 1)]
        return [*times, end] if final and (not times or times[-1] < end * (1.0 - 1e-9)) else times

    def _limit_in_words(self, limit: str, report: StepReport) -> str:
        """Say what limited an accepted step."""
        if limit in ("the error", "convergence of Newton's method"):
            joined = "of" if limit == "the error" else "for"
            return f"{limit} {joined} {report.motion} at {describe_node(self.problem, report.node)}"
        return limit

    def corners(self, start: float, end: float) -> tuple[list[float], set[float]]:
        """Return the times from ``start`` to ``end`` [s] that steps must hit, and those after which to restart."""
        corners, jumps = corners_of(self.problem, start, end, within=self.integrator.looks_within)
        return self.control.among(corners) if isinstance(self.control, KnownSteps) else corners, jumps

    def restart(self, t: float) -> None:
        """Start the integrator anew at ``t`` [s], after a jump of loads or prescribed motions.

        The impulse of a support whose velocity jumps counts as external work, and what a jump of rest strains changes
        of the elastic energy as work of the actuator.
        """
        kinetic, elastic = self.integrator.kinetic, self.integrator.elastic
        unbalanced, state = self.integrator.unbalanced().copy(), self.integrator.state.copy()
        self.integrator.start(t, state.copy())  # records keep that before the jump
        if self.halved is not None:
            self.halved.release(self.integrator, unbalanced, state.twist)
        self.account.external += self.integrator.kinetic - kinetic
        self.account.kinetic = self.integrator.kinetic
        if self.problem.rest_strains:
            self.account.actuator += self.integrator.elastic - elastic
            self.account.elastic = self.integrator.elastic


def _up_to_jump(corners: list[float], jumps: set[float]) -> list[float]:
    """Return the corners after the first, no further than to the first jump among all."""
    first = next((k for k, corner in enumerate(corners) if corner in jumps), len(corners))
    return corners[1 : first + 1]
