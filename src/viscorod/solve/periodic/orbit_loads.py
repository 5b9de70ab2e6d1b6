"""The loads at all phases of an orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from viscorod.solve.periodic.orbit_kernels import add_orbit_loads
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["OrbitLoads"]


class _Stacked(NamedTuple):
    """Loads of nodes at all phases: the nodes, and of each phase what ``add_nodal_loads`` needs (first index)."""

    nodes: Integers
    dead: Floats
    following: Floats
    gravity: Floats
    levers: Floats


@dataclass
class OrbitLoads:
    """Loads at all phases.

    Attributes:
        states: of them; factors: of the inputs ``(phases, k)``; stacked: all of them, if they act on nodes alone.
    """

    states: list[LoadState]
    factors: Floats
    stacked: _Stacked | None

    @classmethod
    def of(cls, states: list[LoadState], factors: Floats | None = None) -> OrbitLoads:
        """Return them from the loads at each phase."""
        stacked = None
        if not any(one.stations or one.sees_motion for one in states):
            parts = [np.array([getattr(s, name) for s in states]) for name in _Stacked._fields[1:]]
            nodes = np.unique(np.concatenate([one.nodes for one in states]))
            stacked = _Stacked(nodes, *(np.ascontiguousarray(part) for part in parts))
        return cls(states, np.zeros(0) if factors is None else factors, stacked)

    def add(self, problem: Problem, r: Floats, q: Floats, twist: Floats) -> tuple[Floats, Floats]:
        """Return the wrenches of all nodes ``(N, n, 6)``, body axes, and the powers that they dissipate ``(N,)`` [W].

        Args:
            problem: whose loads these are; r, q, twist: of all nodes at all phases ``(N, n, 3)``, ...
        """
        external, powers = np.zeros_like(twist), np.zeros(len(twist))
        if self.stacked is not None:
            add_orbit_loads(*self.stacked, q, problem.mass, external)
            return external, powers
        for i, load in enumerate(self.states):
            powers[i] = load.add(problem, (r[i], q[i]), twist[i], external[i])
        return external, powers
