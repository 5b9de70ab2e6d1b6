"""What a scalar sees of states: by poses and twists of nodes, and by both ends of the step that they are within."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, interpolate_poses
from viscorod.mechanics.rotations.rotation import retract
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    conjugate,
    cross,
    difference,
    dot,
    plus,
    plus4,
    product,
    put,
    put4,
    quaternion,
    rotated,
    rotated_back,
    scaled4,
    stage_quaternion,
    stage_vector,
    vector,
)
from viscorod.typing import Floats, Integers

__all__ = ["OneNode", "Seen", "look_at_states", "look_within"]


class Seen(NamedTuple):
    """Derivatives of a scalar by what is stored ``(k, stations, 3)``, of rotations 4; empty where it does not look."""

    position: Floats
    rotation: Floats
    velocity: Floats
    spin: Floats


@part
def _add(out: Floats, k: int, m: int, at: int, a: Vector) -> None:
    for i in range(3):
        out[k, m, at + i] += a[i]


@kernel
def look_at_states(
    instants: Integers,
    stations: Integers,
    of: Integers,
    offset: Floats,
    turn: Floats,
    stored: Floats,
    seen: Seen,
    q: Floats,
    twist: Floats,
    by_pose: Floats,
    by_twist: Floats,
) -> None:
    """Write the derivatives of a scalar by body increments of poses and by twists of ``m`` nodes ``(k, m, 6)``.

    Args:
        instants: numbers of the stored times ``(k,)``; stations: numbers of those that it looks at; of: their nodes.
        offset, turn: places of all stations in the axes of their nodes; stored: rotations, whose signs count.
        q, twist: of the nodes ``(k, m, ...)``.
    """
    for k in range(by_pose.shape[0]):
        at = instants[k]
        for m in range(by_pose.shape[1]):
            for i in range(6):
                by_pose[k, m, i] = by_twist[k, m, i] = 0.0
        for number in range(stations.shape[0]):
            station, m = stations[number], of[number]
            here, arm, own = stage_quaternion(q, k, m), vector(offset, station, 0), quaternion(turn, station)
            if seen.position.shape[0] > 0:
                pushed = rotated_back(here, stage_vector(seen.position, at, station, 0))
                _add(by_pose, k, m, 0, pushed)
                _add(by_pose, k, m, 3, cross(arm, pushed))
            if seen.rotation.shape[0] > 0:
                whole, kept = product(here, own), stage_quaternion(stored, at, station)
                same = whole[0] * kept[0] + dot(whole[1], kept[1])
                sign = 1.0 if same > 0.0 else -1.0
                # sign q (0, theta)/2 turn
                back = scaled4(0.5 * sign, stage_quaternion(seen.rotation, at, station))
                _add(by_pose, k, m, 3, product(product(conjugate(here), back), conjugate(own))[1])
            if seen.velocity.shape[0] > 0:
                # of a place that turns with its node, in the axes of the node
                pushed = rotated_back(here, stage_vector(seen.velocity, at, station, 0))
                spin = stage_vector(twist, k, m, 3)
                speed = plus(stage_vector(twist, k, m, 0), 1.0, cross(spin, arm))
                _add(by_pose, k, m, 3, cross(speed, pushed))
                _add(by_twist, k, m, 0, pushed)
                _add(by_twist, k, m, 3, cross(arm, pushed))
            if seen.spin.shape[0] > 0:  # in the axes of the place
                _add(by_twist, k, m, 3, rotated(own, stage_vector(seen.spin, at, station, 0)))


class OneNode(NamedTuple):
    """Scratch for one node: both ends of the step, an increment ``(1, 6)``, two states at all places.

    Attributes:
        split: ``(1,)``; r, q, twist: ``(2, k, 1, ...)``; scratch: ``(10, 6)``.
    """

    start: MovingPoses
    end: MovingPoses
    increment: Floats
    split: Floats
    r: Floats
    q: Floats
    twist: Floats
    scratch: Floats

    @classmethod
    def of(cls, places: int) -> OneNode:
        """Allocate for so many places within a step."""
        start, end = (MovingPoses(*(np.zeros((1, size)) for size in (3, 4, 6, 6))) for _ in range(2))
        r, q, twist = (np.zeros((2, places, 1, size)) for size in (3, 4, 6))
        return cls(start, end, np.zeros((1, 6)), np.zeros(1), r, q, twist, np.zeros((10, 6)))


@part
def _copy_node(ends: MovingPoses, m: int, out: MovingPoses) -> None:
    """Copy how node ``m`` moves."""
    put(out.r, 0, 0, vector(ends.r, m, 0))
    put4(out.q, 0, quaternion(ends.q, m))
    for at in (0, 3):
        put(out.twist, 0, at, vector(ends.twist, m, at))
        put(out.rate, 0, at, vector(ends.rate, m, at))


@part
def _change(end: MovingPoses, increment: Floats, field: int, component: int, size: float) -> None:
    """Change a component of the pose (0), the twist (1) or its rate (2) of the one node."""
    if field == 0:
        for i in range(6):
            increment[0, i] = size if i == component else 0.0
        retract(end.r, end.q, increment, end.r, end.q)
    elif field == 1:
        end.twist[0, component] += size
    else:
        end.rate[0, component] += size


@part
def _seen(one: OneNode, k: int, q: Quaternion, by_pose: Floats, by_twist: Floats, m: int) -> float:
    """Return what a scalar sees of the difference of both states of node ``m`` at place ``k``."""
    moved = difference(stage_vector(one.r[0], k, 0, 0), stage_vector(one.r[1], k, 0, 0))
    turned = product(
        conjugate(q), plus4(stage_quaternion(one.q[0], k, 0), -1.0, stage_quaternion(one.q[1], k, 0))
    )
    total = dot(stage_vector(by_pose, k, m, 0), rotated_back(q, moved))
    total += 2.0 * dot(stage_vector(by_pose, k, m, 3), turned[1])
    for at in (0, 3):
        moves = difference(stage_vector(one.twist[0], k, 0, at), stage_vector(one.twist[1], k, 0, at))
        total += dot(stage_vector(by_twist, k, m, at), moves)
    return total


@kernel
def look_within(
    parts: Floats,
    h: float,
    start: MovingPoses,
    end: MovingPoses,
    split: Floats,
    turns: Floats,
    by_pose: Floats,
    by_twist: Floats,
    sizes: Floats,
    one: OneNode,
    out: Floats,
) -> None:
    """Write the derivatives of a scalar by poses, twists and rates at the start, then at the end ``(36, m)``.

    They are central differences of interpolated states.

    Args:
        parts: places in the step of ``h`` [s] ``(k,)``; start, end: of the ``m`` nodes; split: see ``nodal_motion``.
        turns: rotations at the places ``(k, m, 4)``; by_pose, by_twist: derivatives of the scalar by the states there,
            by body increments and twists ``(k, m, 6)``.
        sizes: of the differences ``(36,)``; one: scratch.
    """
    for m in range(split.shape[0]):
        one.split[0] = split[m]
        for c in range(36):
            field, component = (c % 18) // 6, c % 6
            for side in range(2):
                _copy_node(start, m, one.start)
                _copy_node(end, m, one.end)
                changed, size = one.end if c >= 18 else one.start, sizes[c] if side == 0 else -sizes[c]
                _change(changed, one.increment, field, component, size)
                fields = (one.r[side], one.q[side], one.twist[side])
                interpolate_poses(parts, h, one.start, one.end, one.split, True, *fields, one.scratch)
            total = 0.0
            for k in range(parts.shape[0]):
                total += _seen(one, k, stage_quaternion(turns, k, m), by_pose, by_twist, m)
            out[c, m] = total / (2.0 * sizes[c])
