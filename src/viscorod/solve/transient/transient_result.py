"""What a transient run comes to: its history, how it ended, and what it took."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from viscorod.shown import counted
from viscorod.solve.history import History
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators.contract import StepReport

__all__ = ["StepCounts", "TransientResult"]


@dataclass
class StepCounts:
    """Numbers of steps and iterations of a run, and where and why the smallest accepted step was taken.

    ``failed`` counts the steps of equal length that did not converge, the first at ``first_failed_at`` [s] and the
    shortest of ``shortest_failed`` [s].
    """

    steps: int = 0
    rejected: int = 0
    iterations: int = 0
    evaluations: int = 0
    factorisations: int = 0
    jacobians: int = 0
    failed: int = 0
    first_failed_at: float = 0.0
    shortest_failed: float = np.inf
    smallest_step: float = np.inf
    smallest_at: float = 0.0
    smallest_why: str = ""

    @property
    def notes(self) -> list[str]:
        """A sentence about the steps that failed, if there are any."""
        if not self.failed:
            return []
        were = f"{counted(self.failed, 'step')} failed and {'was' if self.failed == 1 else 'were'}"
        smallest = min(self.smallest_step, self.shortest_failed)
        return [
            f"{were} shortened, the first at t = {self.first_failed_at:.6g} s, down to {smallest:.3g} s: use a smaller "
            "time_step, or an integrator that chooses its steps"
        ]


@dataclass
class TransientResult:
    """History of a transient run and how it ended.

    Attributes:
        outcome: COMPLETED or the reason of the last failed step, which happened at ``failed_at`` [s].
        reason: why an INTERRUPTED run stopped.
        between_steps: it stopped after a step, from where it can go on bit for bit; others stop within one.
    """

    history: History = field(default_factory=History)
    outcome: Outcome = Outcome.COMPLETED
    failed_at: float = 0.0
    report: StepReport | None = None
    effort: StepCounts = field(default_factory=StepCounts)
    reason: str = ""
    between_steps: bool = False
