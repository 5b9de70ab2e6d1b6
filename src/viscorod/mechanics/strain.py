"""Geometric element: positions and rotations at Gauss-Lobatto nodes, strains at Gauss points.

With ``r = sum N_k r_k`` and ``q~ = sum N_k q_k`` the strains are ``V = R(q~)^T r'`` and ``U = 2 vec(conj(q~)
q~')/|q~|^2``
(Lang, Linn and Arnold 2011 for order 1; the element is objective for every order). All derivatives are taken in
coordinates carried by the Gauss point: with ``p_k = conj(q~) q_k/|q~|^2`` and the flat increments

    c = R^T dr' = sum N'_k R^T R_k a_k     y = conj(q~) dq~/|q~|^2 = sum N_k L_k th_k     b = sum N'_k L_k th_k

where ``L_k th = p_k (0, th)/2``, the strains vary by (``z = conj(q~) q~'/|q~|^2 = (z0, U/2)``)

    dV = c + 2 V x yv          dU = 2 bv - y0 U - 2 z0 yv + U x yv

and to second order by quadratic forms in (c, y, b) that are written out below. Nodal increments ``(a_k, th_k)``
and twists
``(v_k, w_k)`` are in the node's body frame.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from viscorod.mechanics.compiled import part
from viscorod.mechanics.rotation import add_skew, quaternion_product, rotate, rotation_matrix
from viscorod.typing import Floats, Integers

RateWork: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats]
"""Scratch arrays of :func:`strain_rate_operator`, allocated once per assembly."""


@part
def element_poses(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    r: Floats,
    q: Floats,
    re: Floats,
    qe: Floats,
) -> None:
    """Gather the poses of one element's nodes, with constant relative poses applied and one hemisphere throughout.

    ``links[k] >= 0`` names the constant pose of the element's node in the frame of the shared node (a rigid
    attachment).
    """
    offset = np.empty(3)
    for k in range(nodes.shape[0]):
        n = nodes[k]
        if links[k] < 0:
            for i in range(3):
                re[k, i] = r[n, i]
            for i in range(4):
                qe[k, i] = q[n, i]
        else:
            rotate(q[n], link_positions[links[k]], offset)
            for i in range(3):
                re[k, i] = r[n, i] + offset[i]
            quaternion_product(q[n], link_quaternions[links[k]], qe[k])
        if k > 0:
            dot = 0.0
            for i in range(4):
                dot += qe[k, i] * qe[k - 1, i]
            if dot < 0.0:
                for i in range(4):
                    qe[k, i] = -qe[k, i]


@part
def gauss_point(
    shape: Floats, slope: Floats, re: Floats, qe: Floats, V: Floats, U: Floats, p: Floats, frame: Floats
) -> float:
    """Strain measures at one Gauss point; ``slope`` is the derivative with respect to arc length.

    Writes ``V, U`` (3), ``p`` (nodes, 4) and the unit quaternion ``frame``; returns ``z0``.
    """
    m = re.shape[0]
    t0 = t1 = t2 = 0.0
    f0 = f1 = f2 = f3 = 0.0
    g0 = g1 = g2 = g3 = 0.0
    for k in range(m):
        s = slope[k]
        n = shape[k]
        # slopes sum to zero: differences to the first node lose no digits far from the origin
        t0 += s * (re[k, 0] - re[0, 0])
        t1 += s * (re[k, 1] - re[0, 1])
        t2 += s * (re[k, 2] - re[0, 2])
        f0 += n * qe[k, 0]
        f1 += n * qe[k, 1]
        f2 += n * qe[k, 2]
        f3 += n * qe[k, 3]
        g0 += s * (qe[k, 0] - qe[0, 0])
        g1 += s * (qe[k, 1] - qe[0, 1])
        g2 += s * (qe[k, 2] - qe[0, 2])
        g3 += s * (qe[k, 3] - qe[0, 3])
    norm2 = f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3
    i0, i1, i2, i3 = f0 / norm2, -f1 / norm2, -f2 / norm2, -f3 / norm2
    for k in range(m):
        a0, a1, a2, a3 = qe[k]
        p[k, 0] = i0 * a0 - i1 * a1 - i2 * a2 - i3 * a3
        p[k, 1] = i0 * a1 + i1 * a0 + i2 * a3 - i3 * a2
        p[k, 2] = i0 * a2 + i2 * a0 + i3 * a1 - i1 * a3
        p[k, 3] = i0 * a3 + i3 * a0 + i1 * a2 - i2 * a1
    z0 = i0 * g0 - i1 * g1 - i2 * g2 - i3 * g3
    U[0] = 2.0 * (i0 * g1 + i1 * g0 + i2 * g3 - i3 * g2)
    U[1] = 2.0 * (i0 * g2 + i2 * g0 + i3 * g1 - i1 * g3)
    U[2] = 2.0 * (i0 * g3 + i3 * g0 + i1 * g2 - i2 * g1)
    scale = 1.0 / np.sqrt(norm2)
    frame[0], frame[1], frame[2], frame[3] = f0 * scale, f1 * scale, f2 * scale, f3 * scale
    x, y, z, w = -frame[1], -frame[2], -frame[3], frame[0]
    c0, c1, c2 = 2 * (y * t2 - z * t1), 2 * (z * t0 - x * t2), 2 * (x * t1 - y * t0)
    V[0] = t0 + w * c0 + y * c2 - z * c1
    V[1] = t1 + w * c1 + z * c0 - x * c2
    V[2] = t2 + w * c2 + x * c1 - y * c0
    return z0


@part
def half_products(p: Floats, L: Floats) -> None:
    """Write ``L`` (4, 3) with ``L theta = p (0, theta)/2``."""
    h0, h1, h2, h3 = 0.5 * p[0], 0.5 * p[1], 0.5 * p[2], 0.5 * p[3]
    L[0, 0], L[0, 1], L[0, 2] = -h1, -h2, -h3
    L[1, 0], L[1, 1], L[1, 2] = h0, -h3, h2
    L[2, 0], L[2, 1], L[2, 2] = h3, h0, -h1
    L[3, 0], L[3, 1], L[3, 2] = -h2, h1, h0


@part
def strain_operator(
    shape: Floats, slope: Floats, V: Floats, U: Floats, z0: float, p: Floats, Q: Floats, L: Floats, B: Floats
) -> None:
    """Write ``B`` (6, 6 m), the strain per nodal increment, with ``Q = R^T R_k`` and ``L`` of every node."""
    for k in range(p.shape[0]):
        rotation_matrix(p[k], Q[k])
        half_products(p[k], L[k])
        Lk = L[k]
        s, n = slope[k], shape[k]
        col = 6 * k
        for j in range(3):
            for i in range(3):
                B[i, col + j] = s * Q[k, i, j]
                B[3 + i, col + j] = 0.0
            y0, y1, y2, y3 = n * Lk[0, j], n * Lk[1, j], n * Lk[2, j], n * Lk[3, j]
            c = col + 3 + j
            B[0, c] = 2.0 * (V[1] * y3 - V[2] * y2)
            B[1, c] = 2.0 * (V[2] * y1 - V[0] * y3)
            B[2, c] = 2.0 * (V[0] * y2 - V[1] * y1)
            B[3, c] = 2.0 * s * Lk[1, j] - y0 * U[0] - 2.0 * z0 * y1 + U[1] * y3 - U[2] * y2
            B[4, c] = 2.0 * s * Lk[2, j] - y0 * U[1] - 2.0 * z0 * y2 + U[2] * y1 - U[0] * y3
            B[5, c] = 2.0 * s * Lk[3, j] - y0 * U[2] - 2.0 * z0 * y3 + U[0] * y2 - U[1] * y1


@part
def strain_rate_operator(
    shape: Floats,
    slope: Floats,
    V: Floats,
    U: Floats,
    z0: float,
    p: Floats,
    Q: Floats,
    L: Floats,
    twist: Floats,
    work: RateWork,
    E: Floats,
) -> None:
    """Write ``E`` (6, 6 m), the change of the strain rate ``B x1`` per nodal increment at constant ``twist (m, 6)``."""
    m = p.shape[0]
    c, y, b, Vy, Uy, Ub, W = work
    c[:] = 0.0
    y[:] = 0.0
    b[:] = 0.0
    for k in range(m):
        for i in range(3):
            for j in range(3):
                c[i] += slope[k] * Q[k, i, j] * twist[k, j]
        for i in range(4):
            lw = L[k, i, 0] * twist[k, 3] + L[k, i, 1] * twist[k, 4] + L[k, i, 2] * twist[k, 5]
            y[i] += shape[k] * lw
            b[i] += slope[k] * lw
    yv = y[1:4]
    bv = b[1:4]
    dot = yv[0] * V[0] + yv[1] * V[1] + yv[2] * V[2]
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        Vy[i, 0] = 2.0 * (yv[i1] * V[i2] - yv[i2] * V[i1])
        Uy[i, 0] = (
            -2.0 * bv[i] + 2.0 * y[0] * U[i] + 4.0 * z0 * yv[i] + 2.0 * (yv[i1] * U[i2] - yv[i2] * U[i1])
        )
        Ub[i, 0] = -2.0 * yv[i]
        for j in range(3):
            Vy[i, 1 + j] = -4.0 * V[i] * yv[j] + 2.0 * yv[i] * V[j]
            Uy[i, 1 + j] = -2.0 * U[i] * yv[j]
            Ub[i, 1 + j] = 0.0
        Vy[i, 1 + i] += 2.0 * dot
        Uy[i, 1 + i] += 4.0 * z0 * y[0] - 2.0 * b[0]
        Ub[i, 1 + i] = -2.0 * y[0]
    add_skew(V, -2.0 * y[0], Vy[:, 1:4])
    add_skew(c, 2.0, Vy[:, 1:4])
    add_skew(U, -2.0 * y[0], Uy[:, 1:4])
    add_skew(bv, 2.0, Uy[:, 1:4])
    add_skew(yv, -2.0, Ub[:, 1:4])
    for k in range(m):
        s, n = slope[k], shape[k]
        col = 6 * k
        v = twist[k, 0:3]
        w = twist[k, 3:6]
        p0 = p[k, 0]
        pv = p[k, 1:4]
        pw = pv[0] * w[0] + pv[1] * w[1] + pv[2] * w[2]
        # W theta = p (0, theta)(0, w)/4: the nodal velocity q w/2 turns with the node
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            W[0, i] = 0.25 * (-p0 * w[i] + pv[i1] * w[i2] - pv[i2] * w[i1])
            for j in range(3):
                W[1 + i, j] = -0.25 * (pv[i] * w[j] + w[i] * pv[j])
            W[1 + i, i] += 0.25 * pw
        add_skew(w, -0.25 * p0, W[1:4, :])
        for j in range(3):
            # translation columns: -2 yv x c
            q0, q1, q2 = s * Q[k, 0, j], s * Q[k, 1, j], s * Q[k, 2, j]
            E[0, col + j] = -2.0 * (yv[1] * q2 - yv[2] * q1)
            E[1, col + j] = -2.0 * (yv[2] * q0 - yv[0] * q2)
            E[2, col + j] = -2.0 * (yv[0] * q1 - yv[1] * q0)
            E[3, col + j] = E[4, col + j] = E[5, col + j] = 0.0
            # rotation columns: second derivatives, then the turning nodal velocities through the first ones
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            x0, x1, x2, x3 = n * W[0, j], n * W[1, j], n * W[2, j], n * W[3, j]
            for i in range(3):
                i1, i2 = (i + 1) % 3, (i + 2) % 3
                shear = 0.0
                bend = 0.0
                for a in range(4):
                    shear += Vy[i, a] * n * L[k, a, j]
                    bend += (Uy[i, a] * n + Ub[i, a] * s) * L[k, a, j]
                shear += s * (Q[k, i, j1] * -v[j2] + Q[k, i, j2] * v[j1])
                xa = x2 if i == 0 else (x3 if i == 1 else x1)
                xb = x3 if i == 0 else (x1 if i == 1 else x2)
                xi = x1 if i == 0 else (x2 if i == 1 else x3)
                shear += 2.0 * (V[i1] * xb - V[i2] * xa)
                bend += 2.0 * s * W[1 + i, j] - x0 * U[i] - 2.0 * z0 * xi + U[i1] * xb - U[i2] * xa
                E[i, col + 3 + j] = shear
                E[3 + i, col + 3 + j] = bend
