"""Motions with steps and stored times that are known from another one, of one model or of several side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.history import History
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.company_steps import CompanySteps
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.company import Company, Member
from viscorod.solve.transient.integrators.contract import Integrator, StepReport
from viscorod.solve.transient.transient_result import TransientResult
from viscorod.solve.transient.transient_solver import Transient
from viscorod.typing import Floats

__all__ = ["GivenSteps", "Retraced", "side_by_side"]


class GivenSteps:
    """Steps that end where they are told to; one that fails ends the run.

    Args:
        ends: of all steps [s].
    """

    notes_failures = False

    def __init__(self, ends: Sequence[float] | Floats) -> None:
        self._ends = np.asarray(ends, dtype=float)
        self._failed = False

    def begin(self, t: float, corner: float, *, first: float | None) -> None:
        """See :class:`~viscorod.solve.transient.step_control.StepControl`."""

    def next_end(self, t: float) -> float:
        """See :class:`~viscorod.solve.transient.step_control.StepControl`."""
        return float(self._ends[np.searchsorted(self._ends, t, side="right")])

    def accepts(self, report: StepReport, h: float) -> bool:
        """See :class:`~viscorod.solve.transient.step_control.StepControl`."""
        del h
        self._failed = not report.converged
        return report.converged

    @property
    def exhausted(self) -> bool:
        """See :class:`~viscorod.solve.transient.step_control.StepControl`."""
        return self._failed

    @property
    def limit(self) -> str:
        """See :class:`~viscorod.solve.transient.step_control.StepControl`."""
        return "the given step"


class Retraced(Transient):
    """Goes through given steps and records given times.

    Args:
        problem, integrator: what moves; ends: of its steps [s]; times: to be recorded [s], the first one 0.

    Attributes:
        ends, times: the same.
    """

    def __init__(
        self, problem: Problem, integrator: Integrator, ends: Sequence[float] | Floats, times: Floats
    ) -> None:
        super().__init__(problem, integrator, GivenSteps(ends))
        self.ends, self.times = np.asarray(ends, dtype=float), times

    def goes_as(self, other: Retraced) -> bool:
        """Return whether steps end, and states are recorded, at the same times as those of another motion."""
        return np.array_equal(self.ends, other.ends) and np.array_equal(self.times, other.times)

    def open(self, state: State, duration: float) -> None:
        """Begin in ``state`` (overwritten) a motion that lasts for ``duration`` [s]."""
        self.duration, self._patient = duration, False
        self.result = TransientResult(History(), effort=self.effort)
        self.begin(state)

    def step(self, corner: float) -> bool:
        """Take the next step, before or to the time ``corner`` [s]; False if the run ends."""
        return self._take_one(corner)

    @property
    def complete(self) -> bool:
        """Whether it went through all steps and recorded all times."""
        return self.result.outcome is Outcome.COMPLETED and self.result.history.count == len(self.times)

    def _record_times(self, t: float, end: float, output_interval: float | None, final: bool) -> list[float]:
        del output_interval, final
        slack = 1e-9 * (end - t)
        first, last = np.searchsorted(self.times, [t + slack, end + slack], side="right")
        return [float(at) for at in self.times[first:last]]


def side_by_side(
    motions: Sequence[Retraced],
    states: Sequence[State],
    duration: float,
    members: Sequence[Member] = (),
) -> Retraced | None:
    """Let models that differ little move through the same steps; return the one that did not come to the end, if any.

    Args:
        motions: that have not begun; the first one leads, see ``integrators.company``.
        states: that they begin in (overwritten); duration: of all [s].
        members: which numbers they differ by; not needed of one.
    """
    first, *others = motions
    company: Company | None = None
    if isinstance(first.integrator, Collocation):
        company = Company(first.integrator, *(members[:1] or [Member(0, 0.0)]))
        for one, member in zip(others, members[1:], strict=True):
            if isinstance(one.integrator, Collocation):
                company.join(one.integrator, member)
    for one, state in zip(motions, states, strict=True):
        one.open(state, duration)
    corners, jumps = first.corners(0.0, duration)
    own = [one.corners(0.0, duration)[0] for one in motions]  # as many, at times that may differ a little
    steps = _compiled(company, motions, duration)
    for k, corner in enumerate(corners):
        stuck = _go_on(motions, [times[k] for times in own], steps)
        if stuck is not None:
            return stuck
        if corner in jumps:
            for one, times in zip(motions, own, strict=True):
                one.restart(times[k])
    return next((one for one in motions if not one.complete), None)


def _compiled(company: Company | None, motions: Sequence[Retraced], duration: float) -> CompanySteps | None:
    """Return what takes compiled steps of motions whose steps all end at the same times, if anything does."""
    first, *others = motions
    if company is None or not all(one.goes_as(first) for one in others):
        return None
    return CompanySteps.of(company, motions, duration, first.ends, first.times)


def _go_on(
    motions: Sequence[Retraced], corners: Sequence[float], steps: CompanySteps | None
) -> Retraced | None:
    """Go on to the next corner [s] of each; return the motion that did not get there, if any."""
    first = motions[0]
    while first.integrator.t < corners[0]:
        apart = motions
        if steps is not None and steps.ready:
            apart = steps.go(corners[0])
        for one in apart:
            corner = corners[motions.index(one)]
            if one.result.outcome is not Outcome.COMPLETED or not one.step(corner):
                return one
    return None
