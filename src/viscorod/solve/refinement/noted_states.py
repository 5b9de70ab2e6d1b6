"""The states of a motion that its mesh is judged by."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from viscorod.solve.history import Snapshot

__all__ = ["NotedStates"]

MOST = 6
"""States that are kept, the last one included."""
GROWTH, NEAR = 1.5, 0.85
"""Recorded states from one of these to the next, in parts; nearer than this part to the next the last one is that."""


class NotedStates:
    """Keeps the ends of some steps of a motion: the first, the last, and early ones more closely.

    Errors of a motion that fades are largest early, those of one that lasts in the end. States between the ends of
    steps would not do: polynomials in time do not balance.

    Attributes:
        states: with their times [s]; start: the one at t = 0, None before the first note.
    """

    def __init__(self) -> None:
        self.states: list[tuple[float, Snapshot]] = []
        self.start: Snapshot | None = None
        self._count, self._next = 0, 1

    def coming(self, steps: int) -> list[int]:
        """Return after which of the next ``steps``, counted from 1, :meth:`note` keeps the state."""
        found, at = [], self._next
        while at <= self._count + steps:
            found.append(at - self._count)
            at = int(GROWTH * at) + 1
        return found

    def note(self, start: Snapshot | None, t: float, state: Callable[[], Snapshot], steps: int = 1) -> None:
        """Keep the end of a step where it is due.

        Args:
            start: the state at t = 0, None if it is known; t: end of a step [s]; state: returns the one there.
            steps: since the last call, the last of which ends here.
        """
        if start is not None:
            self.start = start
        self._count += steps
        if self._count >= self._next:
            self.states = [*self.states[1 - MOST :], (t, state())]
            self._next = int(GROWTH * self._count) + 1

    def with_last(self, last: tuple[float, Snapshot]) -> list[tuple[float, Snapshot]]:
        """Return the states that are looked at at the end, of which the ``last`` one [s] is one."""
        if self.states and last[0] <= self.states[-1][0]:
            return self.states
        return [*self.states[: None if self._count > NEAR * self._next else -1], last]

    def saved(self) -> dict[str, Any]:
        """Return all of it, for another run of the same problem that goes on from there."""
        return {"noted": self.states, "start": self.start, "count": self._count, "next": self._next}

    def take_over(self, saved: dict[str, Any]) -> None:
        """Go on with what another run noted."""
        self.states, self.start = saved["noted"], saved["start"]
        self._count, self._next = saved["count"], saved["next"]
