"""Step size control: fixed steps that are halved where they fail, or steps that follow the error."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from viscorod.solve.transient import step_choice
from viscorod.solve.transient.integrators.contract import StepReport

HALVINGS = 12
RECOVERY = 8
SMALLEST = 1e-13
"""Smallest step as a part of the duration."""

BEYOND = 2.0
"""Length of a step over the duration that goes as far as it may."""
NEXT = 1e-9
"""Part of the duration within which a step ends at a corner."""

PATIENCE, PROGRESS = 500, 1e-7
"""So many steps must take the run forward by such a part of its duration."""


LIMITS = (
    "",
    "the jump at its start",
    "the beginning of the run",
    "convergence of Newton's method",
    "the error",
    "the next corner of loads or motions",
    "the largest allowed step",
)
"""What limits a step, in words, by the numbers of ``step_choice``."""


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
        self.numbers = np.zeros(step_choice.COUNT)
        self.numbers[step_choice.H] = self.largest
        self.numbers[step_choice.LAST_ERROR] = -1.0
        self.numbers[step_choice.LARGEST :] = (
            self.largest,
            self.order,
            self.iterations,
            self.keep,
            self.growth,
        )
        self._recent: deque[float] = deque(maxlen=PATIENCE)

    def begin(self, t: float, corner: float, *, first: float | None) -> None:
        """See :class:`StepControl`."""
        numbers = self.numbers
        numbers[step_choice.CORNER] = corner
        if first is not None:
            numbers[step_choice.H], numbers[step_choice.LAST_ERROR] = min(first, self.largest), -1.0
            numbers[step_choice.LIMIT] = step_choice.JUMP if t > 0.0 else step_choice.BEGINNING

    def next_end(self, t: float) -> float:
        """See :class:`StepControl`."""
        return float(step_choice.next_end(self.numbers, float(t)))

    def accepts(self, report: StepReport, h: float) -> bool:
        """See :class:`StepControl`."""
        error, count = float(report.error), int(report.iterations)
        accepted = bool(step_choice.choose_step(self.numbers, report.converged, error, count, float(h)))
        if accepted:
            self._recent.append(h)
        return accepted

    def took(self, steps: list[float]) -> None:
        """Take note of ``steps`` [s] that were chosen by ``numbers`` elsewhere, and accepted."""
        self._recent.extend(steps)

    @property
    def exhausted(self) -> bool:
        """See :class:`StepControl`."""
        crawling = len(self._recent) == PATIENCE and sum(self._recent) < PROGRESS * self.duration
        return bool(crawling or self.numbers[step_choice.H] < SMALLEST * self.duration)

    @property
    def limit(self) -> str:
        """See :class:`StepControl`."""
        return self.in_words(int(self.numbers[step_choice.ACCEPTED]))

    @staticmethod
    def in_words(limit: int) -> str:
        """Return what limited a step in words."""
        return LIMITS[limit]


class KnownSteps(ErrorControl):
    """Steps that end at given times, which count as corners; one that fails is divided.

    The integrator must call no error too large.

    Args:
        ends: of the steps [s]; duration: of the run [s].
    """

    def __init__(self, ends: Sequence[float], duration: float) -> None:
        super().__init__(1, BEYOND * duration, duration)
        self._ends = tuple(ends)

    def begin(self, t: float, corner: float, *, first: float | None) -> None:
        """See :class:`StepControl`: steps begin as they are known after a jump, too."""
        del first
        super().begin(t, corner, first=BEYOND * self.duration)

    def among(self, corners: Sequence[float]) -> list[float]:
        """Return corners [s], in order, with the ends of steps between them that are not next to one."""
        near = NEXT * corners[-1]
        places = np.searchsorted(corners, self._ends)
        known = np.concatenate([[-np.inf], corners, [np.inf]])
        apart = [
            end
            for end, k in zip(self._ends, places, strict=True)
            if min(end - known[k], known[k + 1] - end) > near and end < corners[-1]
        ]
        return sorted([*corners, *apart])
