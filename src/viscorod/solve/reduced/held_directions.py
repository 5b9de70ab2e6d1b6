"""The body directions in which supports hold nodes, and velocities that move one of them alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.undamped import Undamped
from viscorod.solve.reduced.motion_basis import static_shape
from viscorod.solve.reduced.point_operators import PointOperators
from viscorod.typing import Floats

__all__ = ["HeldDirections"]


class HeldDirections(NamedTuple):
    """What supports hold, in the axes of their nodes, which reduced motions keep.

    Attributes:
        support: number of the support of each direction ``(c,)``; direction: unit vectors ``(c, 6)``.
        velocity: quasi-static velocities of all nodes when it moves at unit speed, the others at rest ``(6 n, c)``.
    """

    support: np.ndarray
    direction: Floats
    velocity: Floats

    @classmethod
    def of(cls, supports: SupportState, operators: PointOperators, undamped: Undamped) -> HeldDirections:
        """Find the directions in the reference shape."""
        problem, state = supports.problem, State.reference(supports.problem)
        found: list[Floats] = []
        number: list[int] = []
        for k in range(len(supports.set.nodes)):
            free = supports.free_directions(k, state)[:, supports.set.fixed[k] == 0.0]
            held = scipy.linalg.null_space(free.T) if free.shape[1] else np.eye(6)
            found.extend(held.T)
            number.extend([k] * held.shape[1])
        directions = np.array(found).reshape(-1, 6)
        moved = np.zeros((6 * problem.size, len(found)))
        for c, k in enumerate(number):
            first = 6 * int(supports.set.nodes[k])
            moved[first : first + 6, c] = directions[c]
        stressed = operators.forces(operators.stresses(operators.rates(moved)))
        return cls(np.array(number, dtype=int), directions, moved - static_shape(undamped, stressed))

    def allowed(self, supports: SupportState, twist: Floats) -> Floats:
        """Return body twists ``(n, 6)`` without what the supports hold of them."""
        found = twist.copy()
        for k, direction in zip(supports.set.nodes[self.support], self.direction, strict=True):
            found[k] -= (direction @ twist[k]) * direction
        return found

    def reactions(self, supports: SupportState, forces: Floats, q: Floats) -> Floats:
        """Return the reactions of the supports as wrenches in global axes ``(supports, 6)``.

        Args:
            forces: along the directions ``(c,)``; q: quaternions of the nodes ``(n, 4)``.
        """
        nodes = supports.set.nodes
        body = np.zeros((len(nodes), 6))
        np.add.at(body, self.support, forces[:, None] * self.direction)
        R = matrices(q[nodes])
        return np.concatenate([np.einsum("mij,mj->mi", R, body[:, k : k + 3]) for k in (0, 3)], axis=1)
