"""Supports: prescribed or fixed displacements and rotations of a node, imposed exactly on the rows of the node.

A support measures, along constant axes ``A = [e1 e2 e3]`` (global), the displacement ``u = A^T (r - r0)`` and the
rotation
vector ``eta = A^T R0 psi`` with ``R = R0 exp(psi)``. With ``T`` the tangent of the exponential, body increments change
them by ``G = [A^T R, A^T R0 T^-1]``; the dual directions are ``Z = [R^T A, T R0^T A]``. Free components keep the
balance
projected on their dual direction, the others are replaced by ``G dx = target - value``; reactions are what the
projected balance leaves. This is Newton's method for the saddle-point system with the reactions eliminated.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.rotation import (
    add_skew,
    inverse_coefficients,
    inverse_rotation_tangent,
    retract,
    rotation_matrix,
    rotation_tangent,
    rotation_tangent_rate,
    rotation_vector,
)
from viscorod.typing import Floats, Integers


@kernel
def relative_rotation(q0: Floats, q: Floats, out: Floats) -> None:
    """Write the rotation vector of ``conj(q0) q`` into ``out``."""
    d = np.empty(4)
    d[0] = q0[0] * q[0] + q0[1] * q[1] + q0[2] * q[2] + q0[3] * q[3]
    d[1] = q0[0] * q[1] - q0[1] * q[0] - q0[2] * q[3] + q0[3] * q[2]
    d[2] = q0[0] * q[2] - q0[2] * q[0] - q0[3] * q[1] + q0[1] * q[3]
    d[3] = q0[0] * q[3] - q0[3] * q[0] - q0[1] * q[2] + q0[2] * q[1]
    rotation_vector(d, out)


@kernel
def support_directions(
    axes: Floats,
    r0: Floats,
    q0: Floats,
    r: Floats,
    q: Floats,
    value: Floats,
    G: Floats,
    Z: Floats,
    psi: Floats,
) -> None:
    """Write the measured components ``value``, their derivative ``G`` (rows) and dual directions ``Z`` (columns)."""
    R = np.empty((3, 3))
    R0 = np.empty((3, 3))
    T = np.empty((3, 3))
    Ti = np.empty((3, 3))
    rotation_matrix(q, R)
    rotation_matrix(q0, R0)
    relative_rotation(q0, q, psi)
    rotation_tangent(psi, T)
    inverse_rotation_tangent(psi, Ti)
    G[:, :] = 0.0
    Z[:, :] = 0.0
    for i in range(3):
        value[i] = 0.0
        value[3 + i] = 0.0
        for a in range(3):
            value[i] += axes[a, i] * (r[a] - r0[a])
            e = 0.0  # component a of axis i in the reference frame of the node
            for b in range(3):
                e += R0[b, a] * axes[b, i]
            value[3 + i] += e * psi[a]
            for j in range(3):
                G[i, j] += axes[a, i] * R[a, j]
                Z[j, i] += axes[a, i] * R[a, j]
                G[3 + i, 3 + j] += e * Ti[a, j]
                Z[3 + j, 3 + i] += e * T[j, a]


@kernel
def impose(
    nodes: Integers,
    fixed: Floats,
    axes: Floats,
    r0: Floats,
    q0: Floats,
    target: Floats,
    r: Floats,
    q: Floats,
    with_tangent: bool,
    residual: Floats,
    reaction: Floats,
    band: Floats,
    diagonal: int,
    reach: int,
) -> None:
    """Replace the rows of supported nodes in residual and band.

    Args:
        nodes: supported nodes ``(m,)``; fixed: 1.0 where a component is fixed or prescribed ``(m, 6)``.
        axes: ``(m, 3, 3)`` columns; r0, q0: reference poses; target: prescribed values ``(m, 6)`` [m, rad].
        residual: ``(n, 6)``; on return free rows hold the projected balance, fixed rows ``value - target``.
        reaction: output ``(m, 6)``, force and moment components along the axes that the support exerts.
        band: transposed band; reach: number of neighbouring nodes within the band on either side.
    """
    value = np.empty(6)
    G = np.empty((6, 6))
    Z = np.empty((6, 6))
    psi = np.empty(3)
    old = np.empty((6, 6))
    balance = np.empty(6)
    block = np.empty((6, 6))
    f = np.empty(3)
    d = np.empty(3)
    t = np.empty(3)
    M = np.empty((3, 3))
    Ti = np.empty((3, 3))
    n = r.shape[0]
    for s in range(nodes.shape[0]):
        k = nodes[s]
        support_directions(axes[s], r0[s], q0[s], r[k], q[k], value, G, Z, psi)
        everything = True
        for i in range(6):
            balance[i] = residual[k, i]
            if fixed[s, i] == 0.0:
                everything = False
        for i in range(6):
            reaction[s, i] = 0.0
            for j in range(6):
                reaction[s, i] += Z[j, i] * balance[j]
            if everything:
                continue
            if fixed[s, i] == 0.0:
                residual[k, i] = reaction[s, i]
                reaction[s, i] = 0.0
            else:
                residual[k, i] = value[i] - target[s, i]
        if everything:
            # the whole pose is known: the increment that reaches it, valid for any number of turns
            step = np.zeros((1, 6))
            for i in range(3):
                d[i] = 0.0
                f[i] = r0[s, i] - r[k, i]
                for j in range(3):
                    f[i] += axes[s, i, j] * target[s, j]
            rotation_matrix(q0[s], Ti)
            for a in range(3):
                for i in range(3):
                    for b in range(3):
                        step[0, 3 + a] += Ti[b, a] * axes[s, b, i] * target[s, 3 + i]
            qt = np.empty((1, 4))
            rt = np.zeros((1, 3))
            retract(rt, q0[s : s + 1], step, rt, qt)
            relative_rotation(q[k], qt[0], t)
            for i in range(3):
                psi[i] = -t[i]
            inverse_rotation_tangent(psi, M)
            rotation_matrix(q[k], Ti)
            for i in range(3):
                for j in range(3):
                    d[i] += Ti[j, i] * f[j]
            for i in range(3):
                residual[k, i] = 0.0
                for j in range(3):
                    residual[k, i] -= M[i, j] * d[j]
                residual[k, 3 + i] = -t[i]
        if not with_tangent:
            continue
        if not everything:
            # the directions in which the reactions act turn with the node: - d(G^T reaction)
            block[:, :] = 0.0
            for i in range(3):
                f[i] = 0.0
                d[i] = 0.0
                for j in range(3):
                    f[i] += G[j, i] * reaction[s, j]
            add_skew(f, -1.0, block[0:3, 3:6])
            inverse_rotation_tangent(psi, Ti)
            # moment m in the reference frame with T^-T m = G^T reaction
            rotation_tangent(psi, M)
            for i in range(3):
                for j in range(3):
                    for a in range(3):
                        d[i] += M[j, i] * G[3 + a, 3 + j] * reaction[s, 3 + a]
            c, c1 = inverse_coefficients(psi[0] ** 2 + psi[1] ** 2 + psi[2] ** 2)
            t[0] = psi[1] * d[2] - psi[2] * d[1]
            t[1] = psi[2] * d[0] - psi[0] * d[2]
            t[2] = psi[0] * d[1] - psi[1] * d[0]
            f[0] = psi[1] * t[2] - psi[2] * t[1]
            f[1] = psi[2] * t[0] - psi[0] * t[2]
            f[2] = psi[0] * t[1] - psi[1] * t[0]
            dot = psi[0] * d[0] + psi[1] * d[1] + psi[2] * d[2]
            M[:, :] = 0.0
            add_skew(d, 0.5, M)
            add_skew(t, -c, M)
            for i in range(3):
                for j in range(3):
                    M[i, j] += c1 * f[i] * psi[j] - c * d[i] * psi[j]
                M[i, i] += c * dot
            for i in range(3):
                for j in range(3):
                    for a in range(3):
                        block[3 + i, 3 + j] -= M[i, a] * Ti[a, j]
            for j in range(6):
                for i in range(6):
                    band[6 * k + j, diagonal + i - j] += block[i, j]
        for other in range(max(0, k - reach), min(n, k + reach + 1)):
            offset = diagonal + 6 * (k - other)
            for j in range(6):
                column = band[6 * other + j]
                for i in range(6):
                    old[i, j] = column[offset + i - j]
                for i in range(6):
                    new = 0.0
                    if everything:
                        if other == k and i == j:
                            new = 1.0
                    elif fixed[s, i] == 0.0:
                        for a in range(6):
                            new += Z[a, i] * old[a, j]
                    elif other == k:
                        new = G[i, j]
                    column[offset + i - j] = new


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
    """Pose, body twist and its rate of fully prescribed nodes from their six components and two time derivatives.

    Args:
        axes, r0, q0: as in :func:`impose`, one row per node; target, rate, acceleration: ``(m, 6)``.
        r, q, twist, twist_rate: outputs ``(m, 3), (m, 4), (m, 6), (m, 6)``.
    """
    psi = np.empty((3, 3))  # rotation vector in the reference frame and its two derivatives
    step = np.zeros((1, 6))
    R0 = np.empty((3, 3))
    R = np.empty((3, 3))
    T = np.empty((3, 3))
    Tt = np.empty((3, 3))
    for s in range(axes.shape[0]):
        rotation_matrix(q0[s], R0)
        for a in range(3):
            r[s, a] = r0[s, a]
            psi[:, a] = 0.0
            for i in range(3):
                r[s, a] += axes[s, a, i] * target[s, i]
                e = 0.0
                for b in range(3):
                    e += R0[b, a] * axes[s, b, i]
                psi[0, a] += e * target[s, 3 + i]
                psi[1, a] += e * rate[s, 3 + i]
                psi[2, a] += e * acceleration[s, 3 + i]
        step[0, 3:6] = psi[0]
        origin = np.zeros((1, 3))
        retract(origin, q0[s : s + 1], step, origin, q[s : s + 1])
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
