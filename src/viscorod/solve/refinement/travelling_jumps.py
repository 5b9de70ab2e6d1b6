"""Elements within which a travelling force makes section forces jump, which no polynomial follows."""

from __future__ import annotations

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.problem.division import divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Integers

__all__ = ["TravellingJumps"]

BESIDE = 1e-9
"""Part of the length of a rod nearer than which a force acts at the end of an element."""


class TravellingJumps:
    """Finds the elements under the travelling forces of a problem.

    Section forces jump there by the force. Elements spread the jump over their length, whatever that is: the forces
    beside it are as wrong on any mesh, while moments and shapes become better.

    Args:
        model: that was discretised; problem: what came of it.

    Attributes:
        loads: those that travel.
    """

    def __init__(self, model: ModelDescription, problem: Problem) -> None:
        self.problem = problem
        self.loads = [load for load in problem.station_loads if model.loads[load.load].travels]
        divisions = list(divisions_of(problem).values()) if self.loads else []
        self._ends = [division.ends for division in divisions]
        self._first = np.cumsum([0, *(division.count for division in divisions)])

    def at(self, t: float, *, before: bool) -> Integers:
        """Return the elements, counted rod by rod, within which such a force acts at the time ``t`` [s]."""
        found = []
        for load in self.loads:
            s, length = load.position(t, before), float(self.problem.rod_lengths[load.rod])
            if load.factor(t, before) == 0.0 or not 0.0 <= s <= length:
                continue
            ends = self._ends[load.rod]
            if np.abs(ends - s).min() > BESIDE * length:
                found.append(int(self._first[load.rod] + np.searchsorted(ends, s) - 1))
        return np.array(found, dtype=np.int64)
