"""Nodes that are held completely: pose, twist and its rate from six functions of time (see ``support_rows``)."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel, lane_kernel, part
from viscorod.mechanics.rotations.exponential_map import (
    exponential,
    logarithm,
    pulled,
    tangent_change,
    tangent_of,
)
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    conjugate,
    cross,
    difference,
    normalised,
    plus,
    product,
    put,
    put4,
    quaternion,
    rotated_back,
    vector,
)
from viscorod.typing import Floats


@lane_kernel
def axis(axes: Floats, s: int, i: int) -> Vector:
    """Return axis ``i`` of support ``s``, a column of ``axes (m, 3, 3)``."""
    return axes[s, 0, i], axes[s, 1, i], axes[s, 2, i]


@lane_kernel
def along_axes(axes: Floats, s: int, values: Floats, at: int) -> Vector:
    """Return three components along the axes of support ``s`` as one vector, from column ``at`` of its values on."""
    total = plus((0.0, 0.0, 0.0), values[s, at], axis(axes, s, 0))
    return plus(plus(total, values[s, at + 1], axis(axes, s, 1)), values[s, at + 2], axis(axes, s, 2))


@lane_kernel
def turned_by(q0: Quaternion, turn: Vector) -> Quaternion:
    """Return the orientation ``q0`` turned by a global rotation vector."""
    return normalised(product(q0, exponential(rotated_back(q0, turn))))


@part
def step_to_target(
    s: int,
    axes: Floats,
    r0: Floats,
    q0: Floats,
    target: Floats,
    r: Floats,
    q: Floats,
    k: int,
    out: Floats,
) -> None:
    """Write the body increment of node ``k``, a row of ``out (n, 6)``, that takes it to where support ``s`` has it.

    It may be any number of turns away. Arrays are those of all supports and of all nodes.
    """
    here = quaternion(q, k)
    reached = turned_by(quaternion(q0, s), along_axes(axes, s, target, 3))
    turn = logarithm(product(conjugate(here), reached))
    distance = plus(difference(vector(r0, s, 0), vector(r, k, 0)), 1.0, along_axes(axes, s, target, 0))
    # the translation of the logarithm on SE(3): the inverse of the left tangent, the transpose of that of the right
    put(out, k, 0, pulled(turn, rotated_back(here, distance), 1.0))
    put(out, k, 3, turn)


@kernel
def prescribed_motion(
    axes: Floats,
    r0: Floats,
    q0: Floats,
    target: Floats,
    rate: Floats,
    acceleration: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    twist_rate: Floats,
) -> None:
    """Write pose, body twist and its rate of fully prescribed nodes from their six components and two time derivatives.

    Args:
        axes, r0, q0: as in :func:`impose`, one row per node; target, rate, acceleration: ``(m, 6)``.
        r, q, twist, twist_rate: outputs ``(m, 3), (m, 4), (m, 6), (m, 6)``.
    """
    for s in range(axes.shape[0]):
        own = quaternion(q0, s)
        turn = rotated_back(own, along_axes(axes, s, target, 3))  # in the reference frame, as its derivatives
        turn_rate = rotated_back(own, along_axes(axes, s, rate, 3))
        second = rotated_back(own, along_axes(axes, s, acceleration, 3))
        here = normalised(product(own, exponential(turn)))
        v, w = rotated_back(here, along_axes(axes, s, rate, 0)), tangent_of(turn, turn_rate)
        put(r, s, 0, plus(vector(r0, s, 0), 1.0, along_axes(axes, s, target, 0)))
        put4(q, s, here)
        put(twist, s, 0, v)
        put(twist, s, 3, w)
        push = rotated_back(here, along_axes(axes, s, acceleration, 0))
        put(twist_rate, s, 0, difference(push, cross(w, v)))
        put(twist_rate, s, 3, plus(tangent_of(turn, second), 1.0, tangent_change(turn, turn_rate, turn_rate)))
