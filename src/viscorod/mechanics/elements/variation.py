"""Strains at a Gauss point and their first and second derivatives, as formulas in the point's own coordinates.

With ``z = conj(q~) q~'/|q~|^2 = (z0, U/2)`` and the flat increments (c, y, b) of ``strain`` the strains vary by

    dV = c + 2 V x yv          dU = 2 bv - y0 U - 2 z0 yv + U x yv

and once more, by (c1, y1, b1) of another increment, by the second derivatives in :func:`second_variation`. The
generalised forces conjugate to (c, y, b) are the adjoint of the first, their change at constant section force that of
the second. These formulas contain no nodes: nodes only map their increments to (c, y, b), and forces back (``lanes``).
"""

from __future__ import annotations

from typing import TypeAlias

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.rotations.vectors import Quaternion, Vector, cross, dot, plus, product, scaled

Flat: TypeAlias = tuple[Vector, Quaternion, Quaternion]
"""Increments (c, y, b) of a Gauss point, or the forces conjugate to them."""


@lane_kernel
def strain_measures(t: Vector, f: Quaternion, g: Quaternion) -> tuple[Vector, Vector, float, Quaternion]:
    """Return ``V, U, z0, conj(q~)/|q~|^2`` from ``t = r'``, ``f = q~`` and ``g = q~'``."""
    norm2 = f[0] * f[0] + dot(f[1], f[1])
    inverse = f[0] / norm2, scaled(-1.0 / norm2, f[1])
    z0, zv = product(inverse, g)
    # R^T t = conj(q~) t q~/|q~|^2, written as t + 2 (x0 t x xv + (t x xv) x xv)/|q~|^2
    w = cross(t, f[1])
    V = plus(t, 2.0 / norm2, plus(cross(w, f[1]), f[0], w))
    return V, scaled(2.0, zv), z0, inverse


@lane_kernel
def first_variation(V: Vector, U: Vector, z0: float, flat: Flat) -> tuple[Vector, Vector]:
    """Return ``(dV, dU)``."""
    c, (y0, y), (_, b) = flat
    dU = plus(plus(plus(scaled(2.0, b), -y0, U), -2.0 * z0, y), 1.0, cross(U, y))
    return plus(c, 2.0, cross(V, y)), dU


@lane_kernel
def second_variation(V: Vector, U: Vector, z0: float, one: Flat, other: Flat) -> tuple[Vector, Vector]:
    """Return the second derivatives of (V, U) along ``one`` and ``other``."""
    c1, (p0, p), (a0, a) = one
    c, (y0, y), (b0, b) = other
    py = dot(p, y)
    Vp, Vy = dot(V, p), dot(V, y)
    # (p0 y + y0 p) x V and the symmetric products; c1 and c turn by -2 y x
    mixed = plus(scaled(p0, y), y0, p)
    d2V = plus(scaled(2.0 * Vy, p), 2.0 * Vp, y)
    d2V = plus(plus(d2V, -4.0 * py, V), 2.0, cross(mixed, V))
    d2V = plus(plus(d2V, -2.0, cross(p, c)), -2.0, cross(y, c1))
    d2U = plus(scaled(2.0 * (p0 * y0 - py), U), 4.0 * z0, mixed)
    d2U = plus(d2U, 2.0, cross(mixed, U))
    d2U = plus(plus(d2U, -2.0 * y0, a), -2.0 * p0, b)
    d2U = plus(plus(d2U, -2.0 * a0, y), -2.0 * b0, p)
    return d2V, plus(plus(d2U, 2.0, cross(a, y)), 2.0, cross(b, p))


@lane_kernel
def conjugate_forces(V: Vector, U: Vector, z0: float, N: Vector, M: Vector) -> Flat:
    """Return the forces ``(Fc, Fy, Fb)`` with ``Fc.c + Fy.y + Fb.b = N.dV + M.dU``."""
    Fy = plus(plus(scaled(2.0, cross(N, V)), -2.0 * z0, M), 1.0, cross(M, U))
    return N, (-dot(M, U), Fy), (0.0, scaled(2.0, M))


@lane_kernel
def turned_forces(V: Vector, U: Vector, z0: float, N: Vector, M: Vector, flat: Flat) -> Flat:
    """Return the change of the conjugate forces of constant ``(N, M)``: the gradient of ``N.d2V + M.d2U``."""
    c, (y0, y), (b0, b) = flat
    MU = dot(M, U)
    My = dot(M, y)
    h = plus(plus(scaled(2.0, cross(V, N)), 4.0 * z0, M), 2.0, cross(U, M))
    Fc = scaled(-2.0, cross(N, y))
    F0 = 2.0 * MU * y0 + dot(h, y) - 2.0 * dot(M, b)
    Fy = plus(plus(scaled(y0, h), 2.0 * dot(V, y), N), 2.0 * dot(N, y), V)
    Fy = plus(plus(Fy, -4.0 * dot(N, V) - 2.0 * MU, y), -2.0 * b0, M)
    Fy = plus(plus(Fy, 2.0, cross(M, b)), 2.0, cross(N, c))
    return Fc, (F0, Fy), (-2.0 * My, plus(scaled(-2.0 * y0, M), -2.0, cross(M, y)))


@lane_kernel
def node_in_section(p: Quaternion, a: Vector) -> Vector:
    """Return ``R^T R_k a``, a vector of node k in the axes of the section, with ``p = conj(q~) q_k/|q~|^2``."""
    w = cross(p[1], a)
    return plus(a, 2.0 / (p[0] * p[0] + dot(p[1], p[1])), plus(cross(p[1], w), p[0], w))


@lane_kernel
def section_in_node(p: Quaternion, a: Vector) -> Vector:
    """Return ``R_k^T R a``, the inverse of :func:`node_in_section`."""
    w = cross(p[1], a)
    return plus(a, 2.0 / (p[0] * p[0] + dot(p[1], p[1])), plus(cross(p[1], w), -p[0], w))


@lane_kernel
def flat_turn(p: Quaternion, theta: Vector) -> Quaternion:
    """Return ``L theta = p (0, theta)/2``: what turns of node k add to (y, b), but for its shape and slope."""
    return product(p, (0.0, scaled(0.5, theta)))


@lane_kernel
def turning_moment(p: Quaternion, f: Quaternion) -> Vector:
    """Return ``L^T f``, the moment on node k of forces conjugate to (y, b)."""
    return scaled(0.5, plus(plus(scaled(p[0], f[1]), -f[0], p[1]), -1.0, cross(p[1], f[1])))
