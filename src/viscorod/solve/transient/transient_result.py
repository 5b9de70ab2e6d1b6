"""What a transient run comes to: its history, how it ended, and what it took."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from viscorod.solve.history import History
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators.contract import StepReport

__all__ = ["StepCounts", "TransientResult"]


@dataclass
class StepCounts:
    """Numbers of steps and iterations of a run, and where and why the smallest accepted step was taken."""

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
        between_steps: it stopped after a step, from where it can go on bit for bit; others stop within one.
    """

    history: History = field(default_factory=History)
    outcome: Outcome = Outcome.COMPLETED
    failed_at: float = 0.0
    report: StepReport | None = None
    effort: StepCounts = field(default_factory=StepCounts)
    notes: list[str] = field(default_factory=list)
    reason: str = ""
    between_steps: bool = False
