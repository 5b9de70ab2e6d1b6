"""Loads on a reduced motion: wrenches of all nodes in their poses, and generalised forces."""

from __future__ import annotations

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["ReducedLoads"]


class ReducedLoads:
    """The loads of a problem.

    Attributes:
        see_twists: whether any depends on how the nodes move.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.external = ExternalLoads(problem)
        self.see_twists = bool(problem.motion_loads)

    def see_poses(self, t: float, *, before: bool) -> bool:
        """Return whether what acts at ``t`` [s] depends on where the nodes are and how they are turned."""
        now = self.external.at(t, before)
        return bool(
            now.dead.any() or now.gravity.any() or now.sees_motion or any(s.dead.any() for s in now.stations)
        )

    def wrenches(self, t: float, state: State, *, before: bool) -> tuple[Floats, float]:
        """Return the wrenches ``(n, 6)`` in the axes of the nodes, and the power that loads dissipate outside [W]."""
        out = np.zeros((self.problem.size, 6))
        now = self.external.at(t, before)
        return out, now.add(self.problem, (state.r, state.q), state.twist, out)

    def patterns(self) -> Floats:
        """Return what loads do at a factor of one ``(6 n, k)``: following ones, and dead ones along each axis of nodes.

        Dead loads turn in the axes of the sections as these turn in space.
        """
        problem, found = self.problem, []
        for load in problem.nodal_loads:
            following, dead = np.zeros((2, problem.size, 6))
            np.add.at(following, load.nodes, load.following)
            np.add.at(dead, load.nodes, load.dead)
            dead[:, :3] += np.einsum("n,i->ni", problem.mass[:, 0, 0], load.gravity)
            found.append(following)
            for half in (slice(0, 3), slice(3, 6)):
                size = np.linalg.norm(dead[:, half], axis=1)
                for axis in range(3):
                    shape = np.zeros((problem.size, 6))
                    shape[:, half.start + axis] = size
                    found.append(shape)
        kept = [shape.ravel() for shape in found if shape.any()]
        return np.column_stack(kept) if kept else np.zeros((6 * problem.size, 0))
