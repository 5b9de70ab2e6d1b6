"""Where a node that moves carries all others, and how they move beside that."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.rotations.vectors import (
    conjugate,
    cross,
    difference,
    dot,
    entries,
    plus,
    product,
    put,
    put4,
    quaternion,
    rotated,
    rotated_back,
    vector,
)
from viscorod.typing import Floats

__all__ = ["Carrier", "carry_along"]


class Carrier(NamedTuple):
    """A node that carries all others along.

    Attributes:
        node: which one it is; turns: whether they turn with it (0 or 1).
        directions: projects on the global directions in which they move with it ``(3, 3)``; all if they turn with it.
    """

    node: int
    turns: int
    directions: Floats

    @classmethod
    def none(cls) -> Carrier:
        """Return what stands where nothing is carried along."""
        return cls(0, 0, np.zeros((3, 3)))


@kernel
def carry_along(
    carrier: Carrier,
    r0: Floats,
    q0: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    carried_r: Floats,
    carried_q: Floats,
    relative_twist: Floats,
) -> None:
    """Write where all nodes are carried, and their body twists less those of being carried along.

    Args:
        r0, q0: where the motion begins, ``(n, 3)`` [m], ``(n, 4)``; r, q, twist: where the nodes are, ``(n, 6)``.
        carried_r, carried_q, relative_twist: outputs, like ``r``, ``q`` and ``twist``.
    """
    node, along = carrier.node, carrier.directions
    begun, here, now = vector(r0, node, 0), vector(r, node, 0), quaternion(q, node)
    away, velocity = difference(here, begun), rotated(now, vector(twist, node, 0))
    x, y, z = entries(along[0], 0), entries(along[1], 0), entries(along[2], 0)
    moved = dot(x, away), dot(y, away), dot(z, away)
    speed = dot(x, velocity), dot(y, velocity), dot(z, velocity)
    turn, spin = (1.0, (0.0, 0.0, 0.0)), (0.0, 0.0, 0.0)
    if carrier.turns != 0:
        turn = product(now, conjugate(quaternion(q0, node)))
        spin = rotated(now, vector(twist, node, 3))
    for k in range(r.shape[0]):
        start, orientation = vector(r0, k, 0), quaternion(q, k)
        arm = difference(start, begun)
        swung = difference(rotated(turn, arm), arm)  # nothing, without rounding, where nothing turns
        put(carried_r, k, 0, plus(plus(start, 1.0, moved), 1.0, swung))
        put4(carried_q, k, product(turn, quaternion(q0, k)))
        carrying = plus(speed, 1.0, cross(spin, difference(vector(r, k, 0), here)))
        v, w = rotated_back(orientation, carrying), rotated_back(orientation, spin)
        put(relative_twist, k, 0, difference(vector(twist, k, 0), v))
        put(relative_twist, k, 3, difference(vector(twist, k, 3), w))
