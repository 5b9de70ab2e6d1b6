"""Multipliers of joints that balance what an iteration with a frozen Jacobian leaves at their nodes.

A frozen Jacobian knows the gradients of joints as they were turned at another time, and no change of a node tells that
a multiplier is not yet what it ought to be: the nodes of a joint do not move by it. Gauss's principle says what it
ought to be: the forces along the present gradients that leave the least imbalance, measured by the masses. These normal
equations are solved by conjugate gradients (Hestenes and Stiefel 1952), which take redundant joints as well.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.joints.joint_coordinates import DISTANCE, TRANSLATION
from viscorod.mechanics.joints.joint_forces import Joints, JointStates, gradient_of, scatter_force
from viscorod.typing import Floats

LEFT = 1e-4
"""Part of the largest multiplier below which what iterations leave is not corrected: it is as small in the poses."""
MINOR = 1e-3
"""Part of the forces, times the length, that counts as moments where there are none, and the other way round."""
SOLVED = 1e-12
"""Part of the squared imbalance at which conjugate gradients stop."""


class Settling(NamedTuple):
    """What settling multipliers needs.

    Attributes:
        inverse: of masses and moments of inertia ``(n, 6)``, 0 where a node balances without (it is supported).
        gradients: of all coordinates ``(c, 12)``; scale, right, way: vectors of conjugate gradients ``(c,)``.
        push: forces along these ``(n, 6)``, 0 between the calls.
    """

    inverse: Floats
    gradients: Floats
    scale: Floats
    right: Floats
    way: Floats
    push: Floats

    @classmethod
    def of(cls, inverse: Floats, count: int) -> Settling:
        """Allocate for a number of coordinates."""
        scale, right, way = np.zeros((3, count))
        return cls(inverse, np.zeros((count, 12)), scale, right, way, np.zeros_like(inverse))


@part
def settle_multipliers(
    joints: Joints, states: JointStates, work: Settling, length: float, r: Floats, q: Floats, residual: Floats
) -> None:
    """Correct the multipliers of held coordinates by what is left at their nodes.

    Args:
        length: of the model [m]; r, q: poses ``(s, n, ...)``; residual: unbalanced internal forces ``(s, n, 6)``,
            which the corrections are added to.
    """
    nodes, place, near = joints.nodes, joints.place, states.near
    inverse, gradients, scale, right, way, push = work
    for i in range(states.multiplier.shape[0]):
        left, most = residual[i], states.multiplier.shape[1]
        for c in range(place.shape[0]):
            if place[c] >= 0:
                gradient_of(c, joints, r[i], q[i], near[c], gradients[c])
                scale[c] = square_of(c, joints, gradients[c], inverse)
        square = turned_back(joints, work, left)
        if settled(joints, states.multiplier[i], work, length):
            continue
        first = square
        for c in range(place.shape[0]):
            way[c] = right[c] * scale[c]
        for _ in range(2 * most):
            if not square > SOLVED * first:
                break
            for c in range(place.shape[0]):
                if place[c] >= 0:
                    scatter_force(c, nodes, gradients[c], way[c], push)
            resisted = 0.0
            for c in range(place.shape[0]):
                if place[c] >= 0:
                    resisted += way[c] * weighed(c, joints, gradients[c], inverse, push)
            part_of_way = square / resisted if resisted > 0.0 else 0.0
            for c in range(place.shape[0]):
                if place[c] >= 0:
                    states.multiplier[i, place[c]] += part_of_way * way[c]
                    scatter_force(c, nodes, gradients[c], part_of_way * way[c], left)
                    for side in range(2):
                        n = nodes[c, side]
                        if n >= 0:
                            for k in range(6):
                                push[n, k] = 0.0
            before, square = square, turned_back(joints, work, left)
            for c in range(place.shape[0]):
                way[c] = right[c] * scale[c] + square / before * way[c]
        for c in range(place.shape[0]):
            if place[c] >= 0:
                states.force[i, c] = states.multiplier[i, place[c]]


@part
def square_of(c: int, joints: Joints, gradient: Floats, inverse: Floats) -> float:
    """Return the inverse of the gradient's square, measured by inverse masses; 0 where both nodes are supported."""
    total = 0.0
    for side in range(2):
        n = joints.nodes[c, side]
        if n >= 0:
            for k in range(6):
                total += inverse[n, k] * gradient[6 * side + k] * gradient[6 * side + k]
    return 1.0 / total if total > 0.0 else 0.0


@part
def weighed(c: int, joints: Joints, gradient: Floats, inverse: Floats, x: Floats) -> float:
    """Return the product of a gradient with forces ``x (n, 6)`` over the masses."""
    total = 0.0
    for side in range(2):
        n = joints.nodes[c, side]
        if n >= 0:
            for k in range(6):
                total += inverse[n, k] * gradient[6 * side + k] * x[n, k]
    return total


@part
def turned_back(joints: Joints, work: Settling, left: Floats) -> float:
    """Write the right side of the normal equations for an imbalance ``(n, 6)``; return its square, scaled."""
    square = 0.0
    for c in range(joints.place.shape[0]):
        work.right[c] = 0.0
        if joints.place[c] >= 0:
            work.right[c] = -weighed(c, joints, work.gradients[c], work.inverse, left)
            square += work.right[c] * work.right[c] * work.scale[c]
    return square


@part
def settled(joints: Joints, multiplier: Floats, work: Settling, length: float) -> bool:
    """Return whether the multipliers ``(places,)`` are right, but for :data:`LEFT`."""
    force = moment = forces = moments = 0.0  # largest changes, and largest ones
    for c in range(joints.place.shape[0]):
        if joints.place[c] >= 0:
            change, whole = abs(work.right[c] * work.scale[c]), abs(multiplier[joints.place[c]])
            if joints.kind[c] == TRANSLATION or joints.kind[c] == DISTANCE:
                force, forces = max(force, change), max(forces, whole)
            else:
                moment, moments = max(moment, change), max(moments, whole)
    small = force <= LEFT * max(forces, MINOR * moments / length)
    return small and moment <= LEFT * max(moments, MINOR * forces * length)
