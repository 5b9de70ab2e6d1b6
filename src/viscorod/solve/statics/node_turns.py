"""How far neighbouring nodes of rods turn against each other: beyond half a turn an element cannot tell which way."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product, rotation_vectors
from viscorod.solve.formulations.system import State
from viscorod.solve.once import once_of_layout
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

LARGEST = 0.9 * np.pi
"""Largest rotation [rad] between neighbouring nodes of an equilibrium: quaternions beyond half a turn wrap."""

SURELY_SMALL = np.cos(np.pi / 9.0)
"""Scalar part of the quaternions of rotations by 40 degrees: four of them are less than half a turn in any order."""


_SIDES = slice(None, -1), slice(1, None)


class NodeTurns:
    """Rotations between the neighbouring nodes of all elements of a problem."""

    def __init__(self, problem: Problem) -> None:
        self._turned = problem.link_quaternions
        self._nodes, self._links, self._linked = _ends_of_pairs(problem)

    def of(self, state: State) -> Floats:
        """Return the rotation vectors ``(pairs, 3)``, the shorter way round."""
        a, b = self._ends(state)
        return rotation_vectors(product(conjugate(a), b))

    def _ends(self, state: State) -> tuple[Floats, Floats]:
        q: Floats = state.q[self._nodes]
        if len(self._links):
            q[self._linked] = product(q[self._linked], self._turned[self._links])
        return q[0], q[1]

    def jumped(self, old: State, new: State) -> bool:
        """Return whether a load step took a rotation to half a turn, or past it.

        The scalar parts of the four rotations between ends, and between times, tell most that did not.

        Past it, the rotation between two nodes has not changed by as much as they have turned, but by whole turns less.
        """
        (a, b), (a1, b1) = self._ends(old), self._ends(new)
        scalars = np.einsum("ipk,ipk->ip", np.stack([a, a1, a, b]), np.stack([b, b1, a1, b1]))
        if float(np.abs(scalars).min(initial=1.0)) > SURELY_SMALL:
            return False
        # from end to end before and then, and of the second and the first end from before to then, all in one call
        turns = product(conjugate(np.concatenate([a, a1, b, a])), np.concatenate([b, b1, b1, a1]))
        first, then, own, other = np.split(rotation_vectors(turns), 4)
        beyond = np.linalg.norm(then, axis=1) > np.maximum(LARGEST, np.linalg.norm(first, axis=1) + 1e-9)
        other = np.einsum("nji,nj->ni", matrices(turns[: len(a)]), other)
        missing = np.linalg.norm(then - first - own + other, axis=1)
        return bool(beyond.any() or (missing > np.pi).any())

    def worst(self, state: State) -> int:
        """Return a node at the largest rotation."""
        return int(self._nodes[0][np.argmax(np.linalg.norm(self.of(state), axis=1))])


@once_of_layout
def _ends_of_pairs(problem: Problem) -> tuple[Integers, Integers, tuple[Integers, Integers]]:
    """Return the first and the second of all neighbouring nodes of elements ``(2, pairs)``, links, and whose they are.

    The links stand in the order of the pairs that have one, which are the last, an index into ``(2, pairs)``.
    """
    nodes, links = (
        np.stack([np.concatenate([part[:, side].ravel() for part in parts]) for side in _SIDES])
        for parts in ([e.nodes for e in problem.sets], [e.links for e in problem.sets])
    )
    sides, pairs = np.nonzero(links >= 0)
    return nodes, links[sides, pairs], (sides, pairs)
