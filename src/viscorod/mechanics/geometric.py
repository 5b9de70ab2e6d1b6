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

from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.rotation import add_skew, quaternion_product, rotate, rotation_matrix
from viscorod.typing import Floats, Integers

RateWork: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats]
StiffnessWork: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats]
"""Scratch arrays, allocated once per assembly."""


@kernel
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
            re[k] = r[n]
            qe[k] = q[n]
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


@kernel
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


@kernel
def half_products(p: Floats, L: Floats) -> None:
    """Write ``L`` (4, 3) with ``L theta = p (0, theta)/2``."""
    h0, h1, h2, h3 = 0.5 * p[0], 0.5 * p[1], 0.5 * p[2], 0.5 * p[3]
    L[0, 0], L[0, 1], L[0, 2] = -h1, -h2, -h3
    L[1, 0], L[1, 1], L[1, 2] = h0, -h3, h2
    L[2, 0], L[2, 1], L[2, 2] = h3, h0, -h1
    L[3, 0], L[3, 1], L[3, 2] = -h2, h1, h0


@kernel
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


@kernel
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


@kernel
def add_geometric_stiffness(
    weight: float,
    shape: Floats,
    slope: Floats,
    V: Floats,
    U: Floats,
    z0: float,
    p: Floats,
    Q: Floats,
    L: Floats,
    S: Floats,
    work: StiffnessWork,
    KT: Floats,
) -> None:
    """Add ``weight`` times the derivative of ``B^T S`` at constant ``S`` to ``KT`` (transposed, 6 m x 6 m)."""
    m = p.shape[0]
    N = S[0:3]
    M = S[3:6]
    MU = M[0] * U[0] + M[1] * U[1] + M[2] * U[2]
    NV = N[0] * V[0] + N[1] * V[1] + N[2] * V[2]
    Hyy, Hby, F, Gy, Gb, Gc, f, g = work
    Hby[:, :] = 0.0
    Hyy[0, 0] = 2.0 * MU
    F[0] = -MU
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        Hyy[0, 1 + i] = (
            2.0 * (V[i1] * N[i2] - V[i2] * N[i1]) + 4.0 * z0 * M[i] + 2.0 * (U[i1] * M[i2] - U[i2] * M[i1])
        )
        Hyy[1 + i, 0] = Hyy[0, 1 + i]
        for j in range(3):
            Hyy[1 + i, 1 + j] = 2.0 * (N[i] * V[j] + V[i] * N[j])
        Hyy[1 + i, 1 + i] -= 4.0 * NV + 2.0 * MU
        Hby[1 + i, 0] = -2.0 * M[i]
        Hby[0, 1 + i] = -2.0 * M[i]
        F[1 + i] = 2.0 * (N[i1] * V[i2] - N[i2] * V[i1]) - 2.0 * z0 * M[i] + M[i1] * U[i2] - M[i2] * U[i1]
    add_skew(M, -2.0, Hby[1:4, 1:4])
    for j in range(m):
        sj, nj = slope[j] * weight, shape[j] * weight
        for a in range(4):
            for i in range(3):
                by = yy = yb = 0.0
                for c in range(4):
                    yy += Hyy[a, c] * L[j, c, i]
                    by += Hby[a, c] * L[j, c, i]
                    yb += Hby[c, a] * L[j, c, i]
                Gy[a, i] = nj * yy + sj * yb
                Gb[a, i] = nj * by
        for i in range(3):
            l1, l2, l3 = -2.0 * nj * L[j, 1, i], -2.0 * nj * L[j, 2, i], -2.0 * nj * L[j, 3, i]
            Gc[0, i] = N[1] * l3 - N[2] * l2
            Gc[1, i] = N[2] * l1 - N[0] * l3
            Gc[2, i] = N[0] * l2 - N[1] * l1
        for k in range(m):
            sk, nk = slope[k], shape[k]
            for i in range(3):
                for c in range(3):
                    turn = 0.0
                    for a in range(4):
                        turn += L[k, a, c] * (nk * Gy[a, i] + sk * Gb[a, i])
                    KT[6 * j + 3 + i, 6 * k + 3 + c] += turn
                    push = sk * (Q[k, 0, c] * Gc[0, i] + Q[k, 1, c] * Gc[1, i] + Q[k, 2, c] * Gc[2, i])
                    KT[6 * j + 3 + i, 6 * k + c] += push
                    KT[6 * k + c, 6 * j + 3 + i] += push
    for k in range(m):
        # the nodal frame in which the force is measured turns with the node
        s, n = slope[k] * weight, shape[k] * weight
        for i in range(3):
            f[i] = s * (Q[k, 0, i] * N[0] + Q[k, 1, i] * N[1] + Q[k, 2, i] * N[2])
        add_skew(f, -1.0, KT[6 * k + 3 : 6 * k + 6, 6 * k : 6 * k + 3])
        g[0] = n * F[0]
        for i in range(3):
            g[1 + i] = n * F[1 + i] + 2.0 * s * M[i]
        trace = 0.25 * (g[0] * p[k, 0] + g[1] * p[k, 1] + g[2] * p[k, 2] + g[3] * p[k, 3])
        for i in range(3):
            f[i] = g[0] * L[k, 0, i] + g[1] * L[k, 1, i] + g[2] * L[k, 2, i] + g[3] * L[k, 3, i]
            KT[6 * k + 3 + i, 6 * k + 3 + i] -= trace
        add_skew(f, -0.5, KT[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6])


@kernel
def link_map(position: Floats, quaternion: Floats, X: Floats) -> None:
    """Write ``X`` (6, 6): the body increment at a rigidly attached pose from that of the shared node."""
    R = np.empty((3, 3))
    rotation_matrix(quaternion, R)
    X[:, :] = 0.0
    for i in range(3):
        for j in range(3):
            X[i, j] = R[j, i]
            X[3 + i, 3 + j] = R[j, i]
        # R^T (theta x d)
        X[i, 3] = R[2, i] * position[1] - R[1, i] * position[2]
        X[i, 4] = R[0, i] * position[2] - R[2, i] * position[0]
        X[i, 5] = R[1, i] * position[0] - R[0, i] * position[1]


@kernel
def map_columns(A: Floats, col: int, X: Floats) -> None:
    """Multiply six columns of ``A`` from ``col`` on by ``X`` (6, 6)."""
    row = np.empty(6)
    for i in range(A.shape[0]):
        for j in range(6):
            row[j] = 0.0
            for a in range(6):
                row[j] += A[i, col + a] * X[a, j]
        for j in range(6):
            A[i, col + j] = row[j]


@kernel
def map_rows(A: Floats, first: int, X: Floats) -> None:
    """Multiply six rows of ``A`` from ``first`` on by the transpose of ``X`` (6, 6)."""
    column = np.empty(6)
    for j in range(A.shape[1]):
        for i in range(6):
            column[i] = 0.0
            for a in range(6):
                column[i] += X[a, i] * A[first + a, j]
        for i in range(6):
            A[first + i, j] = column[i]


@kernel
def strains(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    shapes: Floats,
    slopes: Floats,
    half_lengths: Floats,
    r: Floats,
    q: Floats,
    out: Floats,
    frames: Floats,
) -> None:
    """Evaluate ``(V, U)`` at every Gauss point of equal-order elements into ``out`` (elements, points, 6).

    ``frames`` (elements, points, 4) receives the unit quaternions of the sections.
    """
    m = nodes.shape[1]
    re = np.empty((m, 3))
    qe = np.empty((m, 4))
    p = np.empty((m, 4))
    slope = np.empty(m)
    for e in range(nodes.shape[0]):
        element_poses(nodes[e], links[e], link_positions, link_quaternions, r, q, re, qe)
        for g in range(shapes.shape[0]):
            for k in range(m):
                slope[k] = slopes[g, k] / half_lengths[e]
            gauss_point(shapes[g], slope, re, qe, out[e, g, 0:3], out[e, g, 3:6], p, frames[e, g])


@kernel
def assemble(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    shapes: Floats,
    slopes: Floats,
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    stiffness: Floats,
    damping: Floats,
    damped: bool,
    reference: Floats,
    stress: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    moving: bool,
    rate_map: Floats,
    with_tangent: bool,
    force: Floats,
    band: Floats,
    diagonal: int,
    strain: Floats,
    strain_rate: Floats,
    section_force: Floats,
    operator: Floats,
) -> None:
    """Add the internal forces of equal-order elements, and their tangent, in one pass over the Gauss points.

    Args:
        nodes, links: ``(elements, m)``, shared node and attachment (or -1) of every element node.
        link_positions, link_quaternions: constant relative poses of the attachments.
        shapes, slopes: basis and its derivative in xi at the Gauss points ``(points, m)``; ``weights`` ``(points,)``.
        half_lengths: half the reference arc length of each element [m].
        section: index of the section at every Gauss point ``(elements, points)``.
        stiffness, damping: section matrices C and D ``(sections, 6, 6)``; ``damped`` False skips D.
        reference: strains of the unstressed shape ``(elements, points, 6)``.
        stress: section force used in the geometric stiffness (the mixed iterate) ``(elements, points, 6)``.
        r, q, twist: nodal positions, unit quaternions and body twists; ``moving`` False means that all twists vanish.
        rate_map: d(twist)/d(increment) of every node ``(n, 6, 6)``; read only if ``damped and moving``.
        force: ``(n, 6)``, internal force in body frames is added.
        band: ``(6 n, columns)``, row j holds column j of the matrix, entry (i, j) at ``band[j, diagonal + i - j]``.
        strain, strain_rate, section_force: outputs ``(elements, points, 6)``: (V, U) - reference, its rate, C eps
            + D eps_t.
        operator: output ``(elements, points, 6, 6 m)``, change of the section force per nodal increment (with the
            tangent).

    model.md section 4: ``f = sum_g w_g B^T (C eps + D eps_t)``.
    """
    m = nodes.shape[1]
    size = 6 * m
    points = shapes.shape[0]
    re = np.empty((m, 3))
    qe = np.empty((m, 4))
    te = np.zeros((m, 6))
    p = np.empty((m, 4))
    slope = np.empty(m)
    frame = np.empty(4)
    V = np.empty(3)
    U = np.empty(3)
    Q = np.empty((m, 3, 3))
    L = np.empty((m, 4, 3))
    B = np.empty((6, size))
    E = np.empty((6, size))
    fe = np.empty(size)
    KT = np.empty((size, size))  # transposed element matrix: material part, then geometric part
    GT = np.empty((size, size))
    X = np.empty((m, 6, 6))
    rate_work = (
        np.empty(3),
        np.empty(4),
        np.empty(4),
        np.empty((3, 4)),
        np.empty((3, 4)),
        np.empty((3, 4)),
        np.empty((4, 3)),
    )
    stiffness_work = (
        np.empty((4, 4)),
        np.empty((4, 4)),
        np.empty(4),
        np.empty((4, 3)),
        np.empty((4, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(4),
    )
    viscous = damped and moving
    for e in range(nodes.shape[0]):
        element_poses(nodes[e], links[e], link_positions, link_quaternions, r, q, re, qe)
        linked = False
        for k in range(m):
            if links[e, k] >= 0:
                linked = True
                link_map(link_positions[links[e, k]], link_quaternions[links[e, k]], X[k])
        if viscous:
            for k in range(m):
                n = nodes[e, k]
                if links[e, k] < 0:
                    te[k] = twist[n]
                else:
                    for i in range(6):
                        te[k, i] = 0.0
                        for j in range(6):
                            te[k, i] += X[k, i, j] * twist[n, j]
        fe[:] = 0.0
        KT[:, :] = 0.0
        GT[:, :] = 0.0
        jacobian = half_lengths[e]
        for g in range(points):
            weight = weights[g] * jacobian
            shape = shapes[g]
            for k in range(m):
                slope[k] = slopes[g, k] / jacobian
            z0 = gauss_point(shape, slope, re, qe, V, U, p, frame)
            strain_operator(shape, slope, V, U, z0, p, Q, L, B)
            if linked:
                for k in range(m):
                    if links[e, k] >= 0:
                        map_columns(B, 6 * k, X[k])
            C = stiffness[section[e, g]]
            D = damping[section[e, g]]
            eps = strain[e, g]
            rate = strain_rate[e, g]
            S = section_force[e, g]
            for i in range(3):
                eps[i] = V[i] - reference[e, g, i]
                eps[3 + i] = U[i] - reference[e, g, 3 + i]
            for i in range(6):
                S[i] = 0.0
                rate[i] = 0.0
                for j in range(6):
                    S[i] += C[i, j] * eps[j]
            if viscous:
                for k in range(m):
                    for j in range(6):
                        t = twist[nodes[e, k], j]
                        for i in range(6):
                            rate[i] += B[i, 6 * k + j] * t
                for i in range(6):
                    for j in range(6):
                        S[i] += D[i, j] * rate[j]
            for i in range(6):
                s = weight * S[i]
                for j in range(size):
                    fe[j] += s * B[i, j]
            if not with_tangent:
                continue
            A = operator[e, g]
            for i in range(6):
                for j in range(size):
                    A[i, j] = 0.0
                for a in range(6):
                    c = C[i, a]
                    if c != 0.0:
                        for j in range(size):
                            A[i, j] += c * B[a, j]
            if viscous:
                strain_rate_operator(shape, slope, V, U, z0, p, Q, L, te, rate_work, E)
                for k in range(m):
                    col = 6 * k
                    if links[e, k] >= 0:
                        map_columns(E, col, X[k])
                    T = rate_map[nodes[e, k]]
                    for i in range(6):
                        for a in range(6):
                            t = B[i, col + a]
                            for j in range(6):
                                E[i, col + j] += t * T[a, j]
                for i in range(6):
                    for a in range(6):
                        d = D[i, a]
                        if d != 0.0:
                            for j in range(size):
                                A[i, j] += d * E[a, j]
            for j in range(size):
                for a in range(6):
                    t = weight * A[a, j]
                    for i in range(size):
                        KT[j, i] += t * B[a, i]
            add_geometric_stiffness(weight, shape, slope, V, U, z0, p, Q, L, stress[e, g], stiffness_work, GT)
        if linked and with_tangent:
            for k in range(m):
                if links[e, k] >= 0:
                    map_columns(GT, 6 * k, X[k])
                    map_rows(GT, 6 * k, X[k])
        for k in range(m):
            n = nodes[e, k]
            for i in range(6):
                force[n, i] += fe[6 * k + i]
            if with_tangent:
                for other in range(m):
                    first = diagonal + 6 * (nodes[e, other] - n)
                    for j in range(6):
                        target = band[6 * n + j]
                        material = KT[6 * k + j]
                        turned = GT[6 * k + j]
                        for i in range(6):
                            target[first - j + i] += material[6 * other + i] + turned[6 * other + i]


@kernel
def update_stress(
    nodes: Integers, section_force: Floats, operator: Floats, increment: Floats, stress: Floats
) -> None:
    """Carry the section force of the last iterate along the Newton increment: ``stress = S + A dx``.

    This is the mixed (stress as an independent iterate) Newton step with the stress eliminated point by point.
    """
    m = nodes.shape[1]
    x = np.empty(6 * m)
    for e in range(nodes.shape[0]):
        for k in range(m):
            for i in range(6):
                x[6 * k + i] = increment[nodes[e, k], i]
        for g in range(operator.shape[1]):
            for i in range(6):
                total = section_force[e, g, i]
                for j in range(6 * m):
                    total += operator[e, g, i, j] * x[j]
                stress[e, g, i] = total


@kernel
def elastic_energy(
    weights: Floats, half_lengths: Floats, section: Integers, stiffness: Floats, strain: Floats
) -> float:
    """Return the elastic energy [J], ``1/2 int eps.C eps``, from the strains at the Gauss points."""
    total = 0.0
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            C = stiffness[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                for j in range(6):
                    total += 0.5 * weight * strain[e, g, i] * C[i, j] * strain[e, g, j]
    return total


@kernel
def viscous_loss(
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    damping: Floats,
    strain: Floats,
    earlier: Floats,
    duration: float,
) -> float:
    """Return the energy [J] lost between two strain states, ``int d_eps.D d_eps / duration`` (never negative).

    The mean rate of the step stands for the rate: of second order, and blind to ringing of the rates about their mean.
    """
    total = 0.0
    d = np.empty(6)
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            D = damping[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                d[i] = strain[e, g, i] - earlier[e, g, i]
            for i in range(6):
                for j in range(6):
                    total += weight * d[i] * D[i, j] * d[j] / duration
    return total
