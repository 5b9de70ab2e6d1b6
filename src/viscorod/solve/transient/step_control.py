"""Step size control: fixed steps that are halved where they fail, or steps that follow the error."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Protocol

from viscorod.solve.transient.integrators.contract import StepReport

HALVINGS = 12
RECOVERY = 8
SMALLEST = 1e-13
"""Smallest step as a part of the duration."""

PATIENCE, PROGRESS = 500, 1e-7
"""So many steps must take the run forward by such a part of its duration."""


class StepControl(Protocol):
    """Decides where steps end and whether an attempt is good enough."""

    @property
    def notes_failures(self) -> bool:
        """True if a failed step is worth a note; where steps adapt anyway it is not."""

    def begin(self, t: float, corner: float, *, first: float | None) -> None:
        """Set the next ``corner`` [s], which must be hit; ``first`` is a step [s] to begin with after a jump."""

    def next_end(self, t: float) -> float:
        """Return the end [s] of the next step."""

    def accepts(self, report: StepReport, h: float) -> bool:
        """Judge an attempt of length ``h`` [s] and choose the next step."""

    @property
    def exhausted(self) -> bool:
        """True if steps cannot become smaller."""

    @property
    def limit(self) -> str:
        """The limit of the last accepted step, in words."""


class FixedSteps:
    """Equal steps between corners; a step that fails is halved, and doubled again after some successes."""

    notes_failures = True

    def __init__(self, time_step: float) -> None:
        self.time_step = time_step
        self._begin = self._corner = self._full = 0.0
        self._count = self._done = self._whole = 0  # full steps, completed ones, parts of the present one
        self._level = self._easy = 0
        self._stuck = False

    def begin(self, t: float, corner: float, *, first: float | None) -> None:
        """See :class:`StepControl`."""
        del first
        self._begin, self._corner = t, corner
        self._count = max(1, math.ceil((corner - t) / self.time_step * (1.0 - 1e-9)))
        self._full = (corner - t) / self._count
        self._done = self._whole = self._level = self._easy = 0

    def next_end(self, t: float) -> float:
        """See :class:`StepControl`."""
        del t
        parts = 2**HALVINGS
        reached = self._whole + (parts >> self._level)
        if self._done + 1 == self._count and reached == parts:
            return self._corner
        return float(self._begin + self._full * (self._done + reached / parts))

    def accepts(self, report: StepReport, h: float) -> bool:
        """See :class:`StepControl`."""
        del h
        parts = 2**HALVINGS
        size = parts >> self._level
        if not report.converged:
            self._stuck = self._level == HALVINGS
            self._level, self._easy = self._level + 1, 0
            return False
        self._whole += size
        if self._whole == parts:
            self._done, self._whole = self._done + 1, 0
        self._easy += 1
        if self._level and self._easy >= RECOVERY and self._whole % (2 * size) == 0:
            self._level, self._easy = self._level - 1, 0
        return True

    @property
    def exhausted(self) -> bool:
        """See :class:`StepControl`."""
        return self._stuck

    @property
    def limit(self) -> str:
        """See :class:`StepControl`."""
        return "convergence of Newton's method" if self._level else "the given step"


@dataclass
class ErrorControl:
    """Steps of which each errs by about the tolerated amount: predictive control (Gustafsson 1994) with limits.

    Attributes:
        order: of the error estimate: it grows as the power ``order + 1`` of the step.
        largest: largest step [s]; duration: of the run [s].
        iterations: Newton iterations of a step that is neither easy nor hard.
    """

    order: int
    largest: float
    duration: float
    iterations: int = 10
    keep: float = 1.2
    growth: float = 5.0
    notes_failures = False

    def __post_init__(self) -> None:
        self._h = self.largest
        self._corner = 0.0
        self._last: tuple[float, float] | None = None
        self._limit = self._accepted_limit = ""
        self._failed = False
        self._recent: deque[float] = deque(maxlen=PATIENCE)

    def begin(self, t: float, corner: float, *, first: float | None) -> None:
        """See :class:`StepControl`."""
        self._corner = corner
        if first is not None:
            self._h, self._last = min(first, self.largest), None
            self._limit = "the jump at its start" if t > 0.0 else "the beginning of the run"

    def next_end(self, t: float) -> float:
        """See :class:`StepControl`."""
        left = self._corner - t
        if self._h >= left * (1.0 - 1e-9):
            return self._corner
        # no tiny last step: the one before it is shortened
        return t + (self._h if self._h <= 0.5 * left else 0.5 * left)

    def accepts(self, report: StepReport, h: float) -> bool:
        """See :class:`StepControl`."""
        if not report.converged:
            self._h = 0.3 * h
            self._limit, self._failed = "convergence of Newton's method", True
            return False
        power = 1.0 / (self.order + 1)
        error = max(report.error, 1e-10)
        limit = self.iterations
        safety = 0.9 * (2 * limit + 1) / (2 * limit + report.iterations)
        factor = safety * error**-power
        if error > 1.0:
            self._h = h * min(max(factor, 0.1), 0.9)
            self._limit, self._failed = "the error", True
            return False
        if self._last is not None:
            before, error_before = self._last
            factor = min(factor, safety * (h / before) * (error_before / error) ** power * error**-power)
        factor = min(max(factor, 0.2), 1.0 if self._failed else self.growth)
        self._last = (h, max(error, 1e-2))
        self._recent.append(h)
        self._accepted_limit = self._limit if h >= 0.99 * self._h else "the next corner of loads or motions"
        self._failed = False
        if h < 0.99 * self._h:
            # the step was cut to hit a corner: the one planned is still good unless this one says otherwise
            self._h = max(self._h, h * factor) if error < 0.1 else h * factor
        elif not 1.0 <= factor <= self.keep:
            self._h = h * factor
        self._limit = "the error"
        if self._h >= self.largest:
            self._h, self._limit = self.largest, "the largest allowed step"
        return True

    @property
    def exhausted(self) -> bool:
        """See :class:`StepControl`."""
        crawling = len(self._recent) == PATIENCE and sum(self._recent) < PROGRESS * self.duration
        return crawling or self._h < SMALLEST * self.duration

    @property
    def limit(self) -> str:
        """See :class:`StepControl`."""
        return self._accepted_limit
