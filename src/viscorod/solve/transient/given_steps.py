"""A motion with steps and stored times that are known from another one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.solve.problem.problem import Problem
from viscorod.solve.transient.integrators.contract import Integrator, StepReport
from viscorod.solve.transient.transient_solver import Transient
from viscorod.typing import Floats

__all__ = ["GivenSteps", "Retraced"]


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
        problem, integrator: what moves; steps: its steps; times: to be recorded [s], the first one 0.
    """

    def __init__(self, problem: Problem, integrator: Integrator, steps: GivenSteps, times: Floats) -> None:
        super().__init__(problem, integrator, steps, str)
        self._times = times

    def _record_times(self, t: float, end: float, output_interval: float | None, final: bool) -> list[float]:
        del output_interval, final
        slack = 1e-9 * (end - t)
        first, last = np.searchsorted(self._times, [t + slack, end + slack], side="right")
        return [float(at) for at in self._times[first:last]]
