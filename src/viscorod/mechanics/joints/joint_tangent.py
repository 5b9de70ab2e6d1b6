"""Derivatives of the forces of joints and springs, and the rows and columns of multipliers, as blocks of a matrix."""

from __future__ import annotations

from typing import NamedTuple

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.joints.joint_coordinates import add_gradient_change, place_of
from viscorod.mechanics.joints.joint_forces import Joints, SpringOperators, gradient_of
from viscorod.typing import Floats, Integers


class JointSlopes(NamedTuple):
    """Forces of all coordinates and their derivatives, ``(c,)``.

    Attributes:
        near: values that angles are to be near; force: of all coordinates.
        stiffness, damping: derivatives of the force of free ones by value and rate.
    """

    near: Floats
    force: Floats
    stiffness: Floats
    damping: Floats


@kernel
def add_joint_tangent(
    joints: Joints,
    r: Floats,
    q: Floats,
    twist: Floats,
    slopes: JointSlopes,
    rate_map: Floats,
    stiff: float,
    length: float,
    scale: Floats,
    K: Floats,
    C: Floats,
    operators: SpringOperators,
) -> None:
    """Add the derivative of the forces of joints, and the rows and columns of multipliers, to a matrix.

    Args:
        rate_map: d(twist)/d(increment) of every node ``(n, 6, 6)``; no nodes: dampers do not act.
        stiff, length: see :func:`scale_of`; scale: output, of all multipliers.
        K: blocks of the matrix ``(b, 6, 6)``; C: of its derivative by twists alone, no blocks if it is not wanted.
        operators: output.
    """
    near, force, stiffness, damping = slopes
    gradients, A, P, scratch, turning = operators
    moving = rate_map.shape[0] > 0
    nodes, kind, geometry, place, _, _, _, _, slots, up, down = joints
    for c in range(kind.shape[0]):
        gradient = gradients[c]
        gradient_of(c, joints, r, q, near[c], gradient)
        for i in range(12):
            A[c, i] = P[c, i] = 0.0
            for j in range(12):
                turning[i, j] = 0.0
        ra, qa = place_of(r, q, nodes[c, 0])
        rb, qb = place_of(r, q, nodes[c, 1])
        add_gradient_change(c, kind, geometry, ra, qa, rb, qb, 1.0, scratch, turning)
        k = d = 0.0
        if place[c] < 0:
            k, d = stiffness[c], damping[c] if moving else 0.0
            for side in range(2):
                n = nodes[c, side]
                if n >= 0:
                    for j in range(6):
                        A[c, 6 * side + j] = k * gradient[6 * side + j]
                        P[c, 6 * side + j] = d * gradient[6 * side + j]
            if d != 0.0:
                add_rate_change(c, nodes, twist, rate_map, gradient, turning, d, A)
        for i in range(2):
            for j in range(2):
                slot = slots[c, i, j]
                if slot < 0:
                    continue
                for b in range(6):
                    for a in range(6):
                        row, column = 6 * i + a, 6 * j + b
                        K[slot, b, a] += force[c] * turning[row, column] + gradient[row] * A[c, column]
                        if C.shape[0] > 0:
                            C[slot, b, a] += gradient[row] * P[c, column]
        if place[c] >= 0:
            number = place[c]
            size = scale_of(number, gradient, stiff, length)
            scale[number] = size
            for i in range(2):
                if nodes[c, i] < 0:
                    continue
                for a in range(6):
                    K[up[c, i], number % 6, a] += size * gradient[6 * i + a]
                    K[down[c, i], a, number % 6] += size * gradient[6 * i + a]


@part
def add_rate_change(
    c: int,
    nodes: Integers,
    twist: Floats,
    rate_map: Floats,
    gradient: Floats,
    turning: Floats,
    damping: float,
    A: Floats,
) -> None:
    """Add ``damping`` times the change of a coordinate's rate per increment to ``A (c, 12)``."""
    for side in range(2):
        n = nodes[c, side]
        if n < 0:
            continue
        for j in range(6):
            total = 0.0
            for i in range(6):
                total += gradient[6 * side + i] * rate_map[n, i, j]
            for other in range(2):
                o = nodes[c, other]
                if o >= 0:
                    for i in range(6):
                        total += twist[o, i] * turning[6 * other + i, 6 * side + j]
            A[c, 6 * side + j] += damping * total


@part
def scale_of(number: int, gradient: Floats, stiff: float, length: float) -> float:
    """Return the factor that makes the row of a multiplier as large as those of the stiffest node, for pivoting.

    Args:
        number: of the multiplier; gradient: of its coordinate, of six motions of every node.
        stiff: largest diagonal entry of all nodes, displacements measured in ``length``.
    """
    largest = 0.0
    for i in range(gradient.shape[0]):
        largest = max(largest, abs(gradient[i]) * (length if i % 6 < 3 else 1.0))
    # the solver scales every unknown like those of a node
    own = length if number % 6 < 3 else 1.0
    return stiff / (largest * own) if largest > 0.0 else 1.0
