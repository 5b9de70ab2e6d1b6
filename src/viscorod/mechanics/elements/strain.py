"""Geometric element: positions and rotations at Gauss-Lobatto nodes, strains at Gauss points.

With ``r = sum N_k r_k`` and ``q~ = sum N_k q_k`` the strains are ``V = R(q~)^T r'`` and
``U = 2 vec(conj(q~) q~')/|q~|^2`` (Lang, Linn and Arnold 2011 for order 1; the element is objective for every order).
All derivatives are taken in the frame of the Gauss point: with ``p_k = conj(q~) q_k/|q~|^2`` and the flat increments

    c = R^T dr' = sum N'_k R^T R_k a_k     y = conj(q~) dq~/|q~|^2 = sum N_k L_k th_k     b = sum N'_k L_k th_k

where ``L_k th = p_k (0, th)/2``, the strains vary by (``z = conj(q~) q~'/|q~|^2 = (z0, U/2)``)

    dV = c + 2 V x yv          dU = 2 bv - y0 U - 2 z0 yv + U x yv

and to second order by quadratic forms in (c, y, b), see ``variation``. Nodal increments ``(a_k, th_k)`` and twists
``(v_k, w_k)`` are in the node's body frame.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.rotations.rotation import quaternion_product, rotate
from viscorod.typing import Floats, Integers


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
    """Write the strain measures at one Gauss point; ``slope`` is the derivative with respect to arc length.

    The outputs are ``V, U`` (3), ``p`` (nodes, 4) and the unit quaternion ``frame``; ``z0`` is returned.
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
