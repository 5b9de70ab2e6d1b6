"""The states of a result that are shown, and the values of everything in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.array_pieces import in_states
from viscorod.results.extremes import hermite
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["Frames"]

_BETWEEN = 8  # parts into which the way from one stored state to the next is divided at most


@dataclass(frozen=True, eq=False)
class Frames:
    """States of a result at chosen instants.

    Attributes:
        result: whose states they are.
        before: the stored state at or before each frame ``(n,)``.
        part: part of the way to the next stored state ``(n,)``, from 0 to 1.
        stored: number of stored states.
    """

    result: Result
    before: Integers
    part: Floats
    stored: int

    @classmethod
    def of(cls, result: Result, limit: int) -> Frames:
        """Choose at most `limit` frames.

        A motion with more stored states is shown at even times; one with fewer at every stored state and up to eight
        times as often, since positions between them are known from velocities. Of an equilibrium stored states are
        shown as they are, evenly left out.
        """
        known = np.asarray(result.data[result.dimension].values, dtype=float)
        count = known.size
        if result.dimension != "time":
            chosen = np.unique(np.rint(np.linspace(0, count - 1, min(limit, count))).astype(np.int64))
            return cls(result, chosen, np.zeros(chosen.size), count)
        if count > limit:
            instants = np.linspace(known[0], known[-1], limit)
            before = np.clip(np.searchsorted(known, instants, side="right") - 1, 0, count - 2)
            part = np.clip((instants - known[before]) / (known[before + 1] - known[before]), 0.0, 1.0)
            return cls(result, before.astype(np.int64), part, count)
        parts = max(1, min(_BETWEEN, (limit - 1) // max(count - 1, 1)))
        number = np.arange(parts * (count - 1) + 1)
        return cls(result, (number // parts).astype(np.int64), (number % parts) / parts, count)

    @property
    def count(self) -> int:
        """Number of frames."""
        return int(self.before.size)

    @cached_property
    def instants(self) -> Floats:
        """Times [s] or load factors of the frames ``(n,)``."""
        return self.linear(self.result.dimension)

    def linear(self, name: str) -> Floats:
        """Return a variable of the result in the frames ``(n, ...)``, straight from one stored state to the next."""
        before, after = self._around(name)
        if not self.part.any():
            return before
        part = self.part.reshape(-1, *(1,) * (before.ndim - 1))
        between: Floats = (1.0 - part) * before + part * after
        return between

    def _around(self, name: str) -> tuple[Floats, Floats]:
        """Return a variable in the stored states at or before the frames, and in those after them."""
        around = np.stack([self.before, np.minimum(self.before + 1, self.stored - 1)])
        states = np.unique(around)
        before, after = in_states(self.result.data[name], self.result.dimension, states)[
            np.searchsorted(states, around)
        ]
        return before, after

    def positions(self) -> Floats:
        """Return positions of all stations ``(n, stations, 3)`` [m]; cubic between states, by velocities."""
        if not self.part.any():
            return self.linear("position")
        start, end = self._around("time")
        step = (end - start)[:, None, None]
        v0, v1 = self._around("velocity")
        return hermite(self.part[:, None, None], *self._around("position"), step * v0, step * v1)

    def rotations(self) -> Floats:
        """Return orientations of all stations ``(n, stations, 4)``, unit quaternions, linear between stored states."""
        between = self.linear("rotation")
        unit: Floats = between / np.linalg.norm(between, axis=-1, keepdims=True)
        return unit
