"""Transient analysis: drives an integrator through time, hits all corners of the loads, keeps the energy account."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from viscorod.errors import InputError
from viscorod.solve.events import Watch
from viscorod.solve.history import EnergyAccount, History
from viscorod.solve.integrators.contract import Integrator, StepReport
from viscorod.solve.newton import Outcome
from viscorod.solve.problem import Problem
from viscorod.solve.saved_state import Tree, restore, saved
from viscorod.solve.step_control import StepControl
from viscorod.solve.system import State

MOST_NOTES = 20

LARGEST_STRAIN = 100.0
"""Shear or stretch beyond which a run is stopped: nothing that means anything comes after it."""


@dataclass
class Effort:
    """What a run took: steps, iterations, and where the smallest accepted step was and why."""

    steps: int = 0
    rejected: int = 0
    iterations: int = 0
    evaluations: int = 0
    factorisations: int = 0
    jacobians: int = 0
    smallest_step: float = np.inf
    smallest_at: float = 0.0
    smallest_why: str = ""


@dataclass
class TransientResult:
    """History of a transient run and how it ended.

    Attributes:
        outcome: COMPLETED or the reason of the last failed step, which happened at ``failed_at`` [s].
        notes: one line per instant at which a step failed.
        reason: why an INTERRUPTED run stopped.
    """

    history: History = field(default_factory=History)
    outcome: Outcome = Outcome.COMPLETED
    failed_at: float = 0.0
    report: StepReport | None = None
    effort: Effort = field(default_factory=Effort)
    notes: list[str] = field(default_factory=list)
    reason: str = ""


class Transient:
    """Runs an integrator over a time span.

    The instants at which loads or prescribed motions are not smooth are always hit, and after a jump the integrator
    starts anew, so that no load is ever averaged over a jump.

    Args:
        problem: for the corners of its loads; integrator, control: what steps, and how far.
        place: describes a node in words.
    """

    def __init__(
        self,
        problem: Problem,
        integrator: Integrator,
        control: StepControl,
        place: Callable[[int], str],
    ) -> None:
        self.problem = problem
        self.place = place
        self.integrator = integrator
        self.control = control
        self.account = EnergyAccount()
        self.effort = Effort()
        self.notes: list[str] = []
        self.watch = Watch([])

    def run(
        self,
        state: State,
        duration: float,
        *,
        output_interval: float | None = None,
        progress: Callable[[float, float], None] | None = None,
        history: History | None = None,
        checkpoint: Tree = None,
        after_step: Callable[[], str] | None = None,
        watch: Watch | None = None,
    ) -> TransientResult:
        """Integrate from ``state`` at t = 0 to ``duration`` [s].

        Args:
            state: initial poses and twists (overwritten).
            output_interval: time between records [s]; None records every step and what lies between.
            progress: called with (time, step) after every step.
            history: what records; None keeps everything in memory.
            checkpoint: what :meth:`saved` returned in a run that was stopped: this one goes on from there.
            after_step: called after every step; returns why the run is to stop, or nothing.
            watch: asked after every step what has happened, and whether the run ends with it.
        """
        self.watch = watch or Watch([])
        result = TransientResult(history or History(), effort=self.effort, notes=self.notes)
        try:
            self._march(result, state, duration, output_interval, progress, checkpoint, after_step)
        except KeyboardInterrupt:
            result.outcome, result.reason = Outcome.INTERRUPTED, "interrupted from the keyboard"
        except InputError as error:
            if not result.history.count:
                raise
            result.outcome, result.reason = Outcome.INTERRUPTED, str(error)
        effort, integrator = result.effort, self.integrator
        effort.evaluations, effort.factorisations = integrator.evaluations, integrator.factorisations
        effort.jacobians = integrator.jacobians
        return result

    def _march(
        self,
        result: TransientResult,
        state: State,
        duration: float,
        output_interval: float | None,
        progress: Callable[[float, float], None] | None,
        checkpoint: Tree,
        after_step: Callable[[], str] | None,
    ) -> None:
        integrator, account, control, effort = self.integrator, self.account, self.control, result.effort
        history = result.history
        self._begin(0.0, state)
        account.elastic = integrator.elastic
        account.kinetic = integrator.kinetic
        account.start = account.kinetic + account.elastic
        account.branches = np.zeros(len(self.problem.relaxation_times))
        if checkpoint is None:
            history.record(0.0, integrator.snapshot(), account, 0.0, 0)
            self.watch.begin(0.0, integrator.snapshot())
        else:
            self._resume(checkpoint)
        corners, jumps = self._corners(duration)
        t, restart, resumed = integrator.t, True, checkpoint is not None
        for corner in corners:
            if resumed and corner < t:
                continue
            if not resumed:
                control.begin(t, corner, first=integrator.first_step(duration) if restart else None)
            resumed = False
            while integrator.t < corner:
                t = integrator.t
                end = control.aim(t)
                report = integrator.attempt(end, before=end == corner)
                effort.iterations += report.iterations
                result.report = report
                if not control.accepts(report, end - t):
                    effort.rejected += 1
                    if not report.converged and control.notes_failures and len(result.notes) < MOST_NOTES:
                        result.notes.append(
                            f"t = {t:.6g} s: a step of {end - t:.3g} s failed and was shortened"
                        )
                    if control.exhausted:
                        result.outcome, result.failed_at = report.outcome, end
                        if report.converged:
                            result.outcome = Outcome.TOO_SMALL
                        return
                    continue
                before = account.copy()
                integrator.accept()
                if not integrator.strain < LARGEST_STRAIN:
                    result.outcome, result.failed_at = Outcome.BROKEN, end
                    return
                account.add(integrator)
                effort.steps += 1
                if end - t < effort.smallest_step:
                    effort.smallest_step, effort.smallest_at = end - t, t
                    effort.smallest_why = self._why(report)
                if progress is not None:
                    progress(end, end - t)
                stop = self.watch.after(integrator, t) if self.watch.monitors else None
                times = self._records(t, end, output_interval, end == duration)
                if stop is not None:
                    times = [*(at for at in times if at < stop), stop]
                parts = [part for part in ((at - t) / (end - t) for at in times) if part <= 1.0 - 1e-9]
                states = integrator.between(np.array(parts)) if parts else []
                lost = integrator.branch_losses(np.array(parts))
                for (between, work, loss), at, part, branches in zip(
                    states, times, parts, lost, strict=False
                ):
                    energy = before.between(account, part, between.kinetic, work, loss, branches)
                    history.record(at, between, energy, end - t, report.iterations)
                if len(times) > len(states):
                    history.record(times[-1], integrator.snapshot(), account, end - t, report.iterations)
                if control.exhausted:
                    result.outcome, result.failed_at = Outcome.TOO_SMALL, end
                    return
                if stop is not None:
                    return
                reason = after_step() if after_step is not None else ""
                if reason and end < duration:
                    result.outcome, result.reason = Outcome.INTERRUPTED, reason
                    return
            t, restart = corner, corner in jumps
            if restart:
                self._begin(corner, integrator.state)

    def saved(self) -> Tree:
        """Return from what another run of the same model can go on."""
        parts = (self.integrator, self.control, self.account, self.effort, self.watch)
        return {"parts": [saved(part) for part in parts], "notes": list(self.notes)}

    def _resume(self, checkpoint: Tree) -> None:
        parts = (self.integrator, self.control, self.account, self.effort, self.watch)
        for part, tree in zip(parts, checkpoint["parts"], strict=True):
            restore(part, tree)
        self.notes[:] = checkpoint["notes"]
        self.integrator.resume()

    def _records(self, t: float, end: float, output_interval: float | None, final: bool) -> list[float]:
        """Return the times in the step from ``t`` to ``end`` at which states are recorded."""
        if output_interval is None:
            count = self.integrator.records
            return [*(t + k / count * (end - t) for k in range(1, count)), end]
        first = math.floor(t / output_interval * (1.0 + 1e-12) + 1e-9) + 1
        last = math.floor(end / output_interval * (1.0 + 1e-12) + 1e-9)
        times = [k * output_interval for k in range(first, last + 1)]
        return [*times, end] if final and (not times or times[-1] < end * (1.0 - 1e-9)) else times

    def _why(self, report: StepReport) -> str:
        """What limited an accepted step, in words."""
        limit = self.control.limit
        if limit in ("the error", "convergence of Newton's method"):
            return f"{limit}{' of' if limit == 'the error' else ' for'} {report.motion} at {self.place(report.node)}"
        return limit

    def _corners(self, duration: float) -> tuple[list[float], set[float]]:
        """Instants that steps must hit, and those among them after which the integrator starts anew.

        Instants that only rounding keeps apart are one; the later stands for both.
        """
        corners: list[float] = []
        jumps: set[float] = set()
        instants = {t for t in self.problem.breakpoints if 0.0 < t < duration}
        for t in [*sorted(t for t in instants if t < duration), duration]:
            jumped = t in self.problem.jumps and t < duration
            if corners and t - corners[-1] < 1e-12 * duration:
                jumped = jumped or corners[-1] in jumps
                corners.pop()
            corners.append(t)
            if jumped:
                jumps.add(t)
        return corners, jumps

    def _begin(self, t: float, state: State) -> None:
        """Start or restart the integrator; the impulse of a support whose velocity jumps counts as external work."""
        before = self.integrator.kinetic
        self.integrator.start(t, state)
        if t > 0.0:
            self.account.external += self.integrator.kinetic - before
            self.account.kinetic = self.integrator.kinetic
