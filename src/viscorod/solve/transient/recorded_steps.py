"""The steps of a run, recorded so that they can be gone through again, bit for bit, from checkpoints.

What an integrator was told is kept, step by step, also attempts that failed: its Jacobian, factors and predictions
depend on them. What it is, is kept every so many steps only (see ``saved_state``), so that memory does not grow by the
states of all stages. A stretch between two checkpoints is computed again when its stages are wanted.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from viscorod.solve.formulations.system import State
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.contract import Integrator, StepReport
from viscorod.solve.transient.saved_state import SavedTree, restore, saved

__all__ = ["RecordedSteps", "Step"]


class Step(NamedTuple):
    """A step that is about to be accepted again: number, end [s], and whether loads there are limits from the left."""

    number: int
    end: float
    before: bool


class RecordedSteps:
    """An integrator that remembers its steps; it takes the place of the integrator in a transient analysis.

    Args:
        integrator: that computes; every: accepted steps between two checkpoints.

    Attributes:
        times: of the start and of the ends of all accepted steps [s].
    """

    def __init__(self, integrator: Collocation, every: int = 32) -> None:
        self.integrator, self.every = integrator, every
        self.times: list[float] = []
        self._calls: list[tuple[Any, ...]] = []
        self._checkpoints: list[tuple[int, int, SavedTree]] = []  # calls and steps before it

    def __getattr__(self, name: str) -> Any:
        return getattr(self.integrator, name)

    def start(self, t: float, state: State) -> None:
        """Begin, or begin anew after a jump; see ``Integrator``."""
        self._calls.append(("start", t))
        self.integrator.start(t, state)
        if not self.times:
            self.times.append(t)
            self._keep()

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """Try a step; see ``Integrator``."""
        self._calls.append(("attempt", end, before))
        return self.integrator.attempt(end, before=before)

    def accept(self) -> None:
        """Take it; see ``Integrator``."""
        self._calls.append(("accept",))
        self.integrator.accept()
        self.times.append(self.integrator.t)
        if (len(self.times) - 1) % self.every == 0:
            self._keep()

    def begin_half(self, whole: Integrator, place: float) -> None:
        """Prepare for a half of a step, which is none of the run; see ``Integrator``."""
        self.integrator.begin_half(whole, place)

    @property
    def restarts(self) -> list[float]:
        """Times [s] at which it began anew, after jumps of loads or motions."""
        return [call[1] for call in self._calls if call[0] == "start"][1:]

    @property
    def stretches(self) -> int:
        """Number of stretches between checkpoints; the last one may be empty."""
        return len(self._checkpoints)

    def again(self, stretch: int) -> Iterator[Step]:
        """Go through a stretch again; at every step that is yielded the integrator has its stages, and its start.

        After the last one the integrator is where the stretch ended.
        """
        integrator = self.integrator
        first, number, tree = self._checkpoints[stretch]
        last = self._checkpoints[stretch + 1][0] if stretch + 1 < self.stretches else len(self._calls)
        restore(integrator, tree)
        integrator.resume()
        end, before = integrator.t, False
        for name, *arguments in self._calls[first:last]:
            if name == "start":
                integrator.start(arguments[0], integrator.state)
            elif name == "attempt":
                end, before = arguments
                integrator.attempt(end, before=before)
            else:
                yield Step(number, end, before)
                integrator.accept()
                number += 1

    def _keep(self) -> None:
        self._checkpoints.append((len(self._calls), len(self.times) - 1, saved(self.integrator)))
