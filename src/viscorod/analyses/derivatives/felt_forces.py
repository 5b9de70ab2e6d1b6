"""How far a number that changes nothing at rest moves a motion, before the motion is gone through with another number.

Times of damping, dampers and moments of inertia are felt in motion only. What they change of the forces in some states
of the motion, held by the stiffness at the start, is within some ten times of how far the motion moves: enough to tell
numbers that round-off would hide.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.derivatives.static_changes import StaticChange, near
from viscorod.analyses.discrete import DiscreteModel
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.steady.steady_poses import nodal_state
from viscorod.typing import Floats

__all__ = ["FeltForces"]

FIELDS = ("position", "rotation", "velocity", "angular_velocity")
INSTANTS = 3
"""States of a motion that are looked at."""


class _Moving(NamedTuple):
    """A state of a motion at a time [s], and the rates of its twists ``(n, 6)``."""

    time: float
    state: State
    acceleration: Floats


class FeltForces:
    """What numbers change of the forces in a motion.

    Args:
        discrete: the model; run: the motion; change: of the equilibrium that it starts from.
    """

    def __init__(self, discrete: DiscreteModel, run: Run, change: StaticChange) -> None:
        self._discrete, self._run, self._change = discrete, run, change

    def moved(self, neighbours: Neighbours) -> float:
        """Return how far what two neighbours differ by would move nodes, over the size of the model; 0 if unknown."""
        problem, matrix, largest = self._discrete.problem, self._change.system.matrix, 0.0
        if problem.relaxing:  # what dashpots remember is not stored
            return 0.0
        for at in self._states:
            first, *others = (self._forces(one, at) for one in neighbours.each)
            for other in others:
                forces = np.zeros((problem.pattern.size, 6))
                forces[: problem.size] = other - first
                forces[problem.supports.nodes] = 0.0
                largest = max(largest, float(np.abs(matrix.solve(forces)[: problem.size, :3]).max()))
        return largest / problem.length

    @cached_property
    def _states(self) -> list[_Moving]:
        """States that are stored, without what joints and held strains carry; none if some stations are not."""
        problem, times = self._discrete.problem, np.asarray(self._run.time, dtype=float)
        fields = [np.asarray(self._run.stored[name].values, dtype=float) for name in FIELDS]
        found: list[_Moving] = []
        if len(times) < 3 or fields[0].shape[1] != len(problem.stations.nodes) + len(problem.bodies.nodes):
            return found
        for k in np.unique(np.linspace(1, len(times) - 2, INSTANTS).astype(int)):
            before, state, after = (
                nodal_state(problem, *(field[m] for field in fields)) for m in (k - 1, k, k + 1)
            )
            acceleration = (after.twist - before.twist) / (times[k + 1] - times[k - 1])
            found.append(_Moving(float(times[k]), state, acceleration))
        return found

    def _forces(self, one: Neighbour, at: _Moving) -> Floats:
        """Return the forces of a neighbour in a state of the motion ``(n, 6)``, without those of conditions."""
        static, size = one.resting, one.problem.size
        near(static, self._change.angles)
        static.supports.update(at.time, True)
        static.system.constraints.update(at.time, True)
        loads = static.loads.at(at.time, True)
        static.system.assemble(at.state, loads, None, tangent=False, moving=True)
        inertia = np.einsum("nij,nj->ni", one.problem.mass, at.acceleration)
        found: Floats = inertia + (static.system.internal - static.system.external)[:size]
        return found
