"""Nodes that are held completely: pose, twist and its rate from six functions of time (see ``support_rows``)."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.rotation import (
    inverse_rotation_tangent,
    relative_rotation,
    rotation_matrix,
    rotation_tangent,
    rotation_tangent_rate,
    turned,
)
from viscorod.typing import Floats


@part
def step_to_target(
    axes: Floats, r0: Floats, q0: Floats, target: Floats, r: Floats, q: Floats, out: Floats
) -> None:
    """Write the body increment ``(6,)`` that takes a pose to the fully prescribed one, for any number of turns."""
    R = np.empty((3, 3))
    rotation_matrix(q0, R)
    theta = np.zeros(3)
    for a in range(3):
        for i in range(3):
            for b in range(3):
                theta[a] += R[b, a] * axes[b, i] * target[3 + i]
    reached = np.empty(4)
    turned(q0, theta, reached)
    turn = np.empty(3)
    relative_rotation(q, reached, turn)
    gap = np.empty(3)
    rotation_matrix(q, R)
    for i in range(3):
        gap[i] = 0.0
        for a in range(3):
            distance = r0[a] - r[a]
            for b in range(3):
                distance += axes[a, b] * target[b]
            gap[i] += R[a, i] * distance
    # the translation of the logarithm on SE(3): the inverse of the left tangent, the transpose of that of the right
    Ti = np.empty((3, 3))
    inverse_rotation_tangent(turn, Ti)
    for i in range(3):
        out[i] = Ti[0, i] * gap[0] + Ti[1, i] * gap[1] + Ti[2, i] * gap[2]
        out[3 + i] = turn[i]


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
    psi = np.empty((3, 3))  # rotation vector in the reference frame and its two derivatives
    R0 = np.empty((3, 3))
    R = np.empty((3, 3))
    T = np.empty((3, 3))
    Tt = np.empty((3, 3))
    for s in range(axes.shape[0]):
        rotation_matrix(q0[s], R0)
        for a in range(3):
            r[s, a] = r0[s, a]
            psi[0, a] = psi[1, a] = psi[2, a] = 0.0
            for i in range(3):
                r[s, a] += axes[s, a, i] * target[s, i]
                e = 0.0
                for b in range(3):
                    e += R0[b, a] * axes[s, b, i]
                psi[0, a] += e * target[s, 3 + i]
                psi[1, a] += e * rate[s, 3 + i]
                psi[2, a] += e * acceleration[s, 3 + i]
        turned(q0[s], psi[0], q[s])
        rotation_matrix(q[s], R)
        rotation_tangent(psi[0], T)
        rotation_tangent_rate(psi[0], psi[1], Tt)
        for i in range(3):
            twist[s, i] = 0.0
            twist[s, 3 + i] = 0.0
            twist_rate[s, i] = 0.0
            twist_rate[s, 3 + i] = 0.0
            for j in range(3):
                for a in range(3):
                    twist[s, i] += R[a, i] * axes[s, a, j] * rate[s, j]
                    twist_rate[s, i] += R[a, i] * axes[s, a, j] * acceleration[s, j]
                twist[s, 3 + i] += T[i, j] * psi[1, j]
                twist_rate[s, 3 + i] += T[i, j] * psi[2, j] + Tt[i, j] * psi[1, j]
        v = twist[s, 0:3]
        w = twist[s, 3:6]
        twist_rate[s, 0] -= w[1] * v[2] - w[2] * v[1]
        twist_rate[s, 1] -= w[2] * v[0] - w[0] * v[2]
        twist_rate[s, 2] -= w[0] * v[1] - w[1] * v[0]
