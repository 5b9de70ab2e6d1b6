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

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.elements.variation import strain_measures
from viscorod.mechanics.nodes.attached_poses import attached_pose
from viscorod.mechanics.rotations.vectors import (
    difference,
    normalised,
    plus,
    plus4,
    product,
    put,
    put4,
    put_entries,
    put_quaternion,
    quaternion,
    same_hemisphere,
    vector,
)
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
    before = (0.0, (0.0, 0.0, 0.0))
    for k in range(nodes.shape[0]):
        n, link = nodes[k], links[k]
        place, turn = vector(r, n, 0), quaternion(q, n)
        if link >= 0:
            place, turn = attached_pose(
                vector(link_positions, link, 0), quaternion(link_quaternions, link), place, turn
            )
        before = turn = same_hemisphere(before, turn)
        put(re, k, 0, place)
        put4(qe, k, turn)


@part
def gauss_point(
    shape: Floats, slope: Floats, re: Floats, qe: Floats, V: Floats, U: Floats, p: Floats, frame: Floats
) -> float:
    """Write the strain measures at one Gauss point; ``slope`` is the derivative with respect to arc length.

    The outputs are ``V, U`` (3), ``p`` (nodes, 4) and the unit quaternion ``frame``; ``z0`` is returned.
    """
    t, f, df = (0.0, 0.0, 0.0), (0.0, (0.0, 0.0, 0.0)), (0.0, (0.0, 0.0, 0.0))
    for k in range(re.shape[0]):
        # slopes sum to zero: differences to the first node lose no digits far from the origin
        t = plus(t, slope[k], difference(vector(re, k, 0), vector(re, 0, 0)))
        f = plus4(f, shape[k], quaternion(qe, k))
        df = plus4(df, slope[k], plus4(quaternion(qe, k), -1.0, quaternion(qe, 0)))
    stretch, curvature, z0, inverse = strain_measures(t, f, df)
    for k in range(re.shape[0]):
        put4(p, k, product(inverse, quaternion(qe, k)))
    put_entries(V, 0, stretch)
    put_entries(U, 0, curvature)
    put_quaternion(frame, normalised(f))
    return z0


@part
def half_products(p: Floats, L: Floats) -> None:
    """Write ``L`` (4, 3) with ``L theta = p (0, theta)/2``."""
    h0, h1, h2, h3 = 0.5 * p[0], 0.5 * p[1], 0.5 * p[2], 0.5 * p[3]
    L[0, 0], L[0, 1], L[0, 2] = -h1, -h2, -h3
    L[1, 0], L[1, 1], L[1, 2] = h0, -h3, h2
    L[2, 0], L[2, 1], L[2, 2] = h3, h0, -h1
    L[3, 0], L[3, 1], L[3, 2] = -h2, h1, h0
