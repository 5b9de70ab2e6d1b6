"""How states within a step change with both of its ends, and what a scalar sees of that, node by node."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, interpolate_poses
from viscorod.mechanics.rotations.rotation import retract
from viscorod.typing import Floats

__all__ = ["OneNode", "look_within"]


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
            last, field, component = c >= 18, (c % 18) // 6, c % 6
            for side in range(2):
                change = sizes[c] if side == 0 else -sizes[c]
                for i in range(3):
                    one.start.r[0, i], one.end.r[0, i] = start.r[m, i], end.r[m, i]
                for i in range(4):
                    one.start.q[0, i], one.end.q[0, i] = start.q[m, i], end.q[m, i]
                for i in range(6):
                    one.increment[0, i] = 0.0
                    one.start.twist[0, i], one.end.twist[0, i] = start.twist[m, i], end.twist[m, i]
                    one.start.rate[0, i], one.end.rate[0, i] = start.rate[m, i], end.rate[m, i]
                if field == 0:
                    one.increment[0, component] = change
                    if last:
                        retract(one.end.r, one.end.q, one.increment, one.end.r, one.end.q)
                    else:
                        retract(one.start.r, one.start.q, one.increment, one.start.r, one.start.q)
                elif field == 1:
                    if last:
                        one.end.twist[0, component] += change
                    else:
                        one.start.twist[0, component] += change
                elif last:
                    one.end.rate[0, component] += change
                else:
                    one.start.rate[0, component] += change
                interpolate_poses(
                    parts,
                    h,
                    one.start,
                    one.end,
                    one.split,
                    True,
                    one.r[side],
                    one.q[side],
                    one.twist[side],
                    one.scratch,
                )
            total = 0.0
            for k in range(parts.shape[0]):
                w, x, y, z = turns[k, m, 0], turns[k, m, 1], turns[k, m, 2], turns[k, m, 3]
                a, b, d = (
                    one.r[0, k, 0, 0] - one.r[1, k, 0, 0],
                    one.r[0, k, 0, 1] - one.r[1, k, 0, 1],
                    one.r[0, k, 0, 2] - one.r[1, k, 0, 2],
                )
                # back into the axes of the node: a + 2 v x (v x a - w a) for the vector v of its rotation
                e, f, g = y * d - z * b - w * a, z * a - x * d - w * b, x * b - y * a - w * d
                total += by_pose[k, m, 0] * (a + 2.0 * (y * g - z * f))
                total += by_pose[k, m, 1] * (b + 2.0 * (z * e - x * g))
                total += by_pose[k, m, 2] * (d + 2.0 * (x * f - y * e))
                p, q, r, s = (
                    one.q[0, k, 0, 0] - one.q[1, k, 0, 0],
                    one.q[0, k, 0, 1] - one.q[1, k, 0, 1],
                    one.q[0, k, 0, 2] - one.q[1, k, 0, 2],
                    one.q[0, k, 0, 3] - one.q[1, k, 0, 3],
                )
                total += 2.0 * by_pose[k, m, 3] * (w * q - p * x - (y * s - z * r))
                total += 2.0 * by_pose[k, m, 4] * (w * r - p * y - (z * q - x * s))
                total += 2.0 * by_pose[k, m, 5] * (w * s - p * z - (x * r - y * q))
                for i in range(6):
                    total += by_twist[k, m, i] * (one.twist[0, k, 0, i] - one.twist[1, k, 0, i])
            out[c, m] = total / (2.0 * sizes[c])
