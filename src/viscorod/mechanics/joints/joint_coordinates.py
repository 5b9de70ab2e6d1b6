"""Coordinates of joints: scalars measured between two nodes, their gradients, and the derivatives of the gradients.

A coordinate depends on two points ``p = r + R rho`` and axes ``u = R u^`` that are fixed in its nodes a and b (or in
the ground, whose pose is the identity). Joints hold some of their coordinates at values that may follow functions of
time, springs and dampers act on others. Kinds:

    TRANSLATION   u . (p_b - p_a), u fixed in a
    ALIGNMENT     u . v, u fixed in a, v in b: 0 keeps the two axes perpendicular
    ANGLE         atan2(u1 . v1, u2 . v2): rotation about the one axis that a and b share
    ROTATION      component of the rotation vector psi of b's joint axes seen from a's, ``R_a Q_a exp(psi) = R_b Q_b``
    DISTANCE      |p_b - p_a|

Gradients are taken along body increments ``(a_a, theta_a, a_b, theta_b)``, so ``gradient . (x_a, x_b)`` is the rate of
a coordinate and ``-lambda gradient`` the wrenches of a force ``lambda`` that resists it.
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import lane_kernel, part
from viscorod.mechanics.rotations.exponential_map import inverse_coefficients, pulled
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    cross,
    dot,
    plus,
    product,
    quaternion,
    rotated,
    rotated_back,
    scaled,
    unit,
    vector,
)
from viscorod.typing import Floats, Integers

TRANSLATION, ALIGNMENT, ANGLE, ROTATION, DISTANCE = range(5)

AT_RHO_A, AT_RHO_B = 0, 3
"""Places of the points in a row of the geometry of coordinates, node axes [m]."""
AT_U1, AT_V1, AT_U2, AT_V2 = 6, 9, 12, 15
"""Places of axes: u fixed in a, v fixed in b."""
AT_Q_A, AT_Q_B, AT_COMPONENT = 18, 22, 26
"""Places of the quaternions of the joint axes in the nodes, and of the number of the component (ROTATION)."""
GEOMETRY = 27
"""Numbers that describe where a coordinate is."""


@lane_kernel
def place_of(r: Floats, q: Floats, node: int) -> tuple[Vector, Quaternion]:
    """Return the pose of a node; a negative one is the ground."""
    if node < 0:
        return (0.0, 0.0, 0.0), (1.0, (0.0, 0.0, 0.0))
    return vector(r, node, 0), quaternion(q, node)


@lane_kernel
def own_axes(geometry: Floats, c: int, at: int) -> Quaternion:
    """Return the quaternion of joint axes in their node."""
    return geometry[c, at], vector(geometry, c, at + 1)


@lane_kernel
def add_to(out: Floats, at: int, factor: float, a: Vector) -> None:
    """Add ``factor a`` to three numbers of a vector."""
    out[at] += factor * a[0]
    out[at + 1] += factor * a[1]
    out[at + 2] += factor * a[2]


@lane_kernel
def add_to_column(out: Floats, at: int, column: int, factor: float, a: Vector) -> None:
    """Add ``factor a`` to three numbers of a column."""
    out[at, column] += factor * a[0]
    out[at + 1, column] += factor * a[1]
    out[at + 2, column] += factor * a[2]


@lane_kernel
def relative(c: int, geometry: Floats, qa: Quaternion, qb: Quaternion) -> Vector:
    """Return the rotation vector of the joint axes of b relative to those of a, the shorter way round."""
    own_a, own_b = own_axes(geometry, c, AT_Q_A), own_axes(geometry, c, AT_Q_B)
    a = product(qa, own_a)
    d0, d = product((a[0], scaled(-1.0, a[1])), product(qb, own_b))
    sign = 1.0 if d0 >= 0.0 else -1.0
    s = math.sqrt(dot(d, d))
    factor = 2.0 * sign if s < 1e-8 else 2.0 * math.atan2(s, sign * d0) * sign / s
    return scaled(factor, d)


@lane_kernel
def pulled_change(psi: Vector, d: Vector, e: Vector, sign: float) -> Vector:
    """Return the change of :func:`pulled` when ``psi`` changes by ``d``."""
    c, slope = inverse_coefficients(dot(psi, psi))
    once, first = cross(psi, e), cross(d, e)
    total = scaled(-0.5 * sign, first)
    total = plus(total, c, cross(d, once))
    total = plus(total, c, cross(psi, first))
    return plus(total, slope * dot(psi, d), cross(psi, once))


@part
def add_product(
    u: Vector, v: Vector, qa: Quaternion, qb: Quaternion, factor: float, gradient: Floats
) -> float:
    """Add ``factor`` times the gradient of ``R_a u . R_b v`` to ``gradient (12,)``; return the product."""
    m, w = rotated_back(qa, rotated(qb, v)), rotated_back(qb, rotated(qa, u))
    add_to(gradient, 3, factor, cross(u, m))
    add_to(gradient, 9, factor, cross(v, w))
    return dot(u, m)


@part
def coordinate(
    c: int,
    kind: Integers,
    geometry: Floats,
    ra: Vector,
    qa: Quaternion,
    rb: Vector,
    qb: Quaternion,
    near: float,
    gradient: Floats,
) -> float:
    """Return the value of coordinate ``c`` and write its gradient ``(12,)``.

    Args:
        kind, geometry: of all coordinates ``(c,)``, ``(c, GEOMETRY)``.
        ra, qa, rb, qb: poses of its nodes.
        near: an angle includes the whole turns that bring it nearest to this.
    """
    for i in range(12):
        gradient[i] = 0.0
    which = kind[c]
    if which == ALIGNMENT:
        return add_product(vector(geometry, c, AT_U1), vector(geometry, c, AT_V1), qa, qb, 1.0, gradient)
    if which == ANGLE:
        u1, v1 = vector(geometry, c, AT_U1), vector(geometry, c, AT_V1)
        u2, v2 = vector(geometry, c, AT_U2), vector(geometry, c, AT_V2)
        sine, cosine = dot(rotated(qa, u1), rotated(qb, v1)), dot(rotated(qa, u2), rotated(qb, v2))
        square = sine * sine + cosine * cosine
        add_product(u1, v1, qa, qb, cosine / square, gradient)
        add_product(u2, v2, qa, qb, -sine / square, gradient)
        angle = math.atan2(sine, cosine)
        return angle + 2.0 * math.pi * round((near - angle) / (2.0 * math.pi))
    if which == ROTATION:
        psi = relative(c, geometry, qa, qb)
        component = int(geometry[c, AT_COMPONENT])
        e = unit(component)
        own_a, own_b = own_axes(geometry, c, AT_Q_A), own_axes(geometry, c, AT_Q_B)
        add_to(gradient, 3, -1.0, rotated(own_a, pulled(psi, e, -1.0)))
        add_to(gradient, 9, 1.0, rotated(own_b, pulled(psi, e, 1.0)))
        return dot(psi, e)
    rho_a, rho_b = vector(geometry, c, AT_RHO_A), vector(geometry, c, AT_RHO_B)
    d = plus(plus(rb, 1.0, rotated(qb, rho_b)), -1.0, plus(ra, 1.0, rotated(qa, rho_a)))
    if which == TRANSLATION:
        u = vector(geometry, c, AT_U1)
        s, w = rotated_back(qa, d), rotated_back(qb, rotated(qa, u))
        add_to(gradient, 0, -1.0, u)
        add_to(gradient, 3, 1.0, cross(u, plus(s, 1.0, rho_a)))
        add_to(gradient, 6, 1.0, w)
        add_to(gradient, 9, 1.0, cross(rho_b, w))
        return dot(u, s)
    length = math.sqrt(dot(d, d))
    n = scaled(1.0 / max(length, 1e-300), d)
    na, nb = rotated_back(qa, n), rotated_back(qb, n)
    add_to(gradient, 0, -1.0, na)
    add_to(gradient, 3, -1.0, cross(rho_a, na))
    add_to(gradient, 6, 1.0, nb)
    add_to(gradient, 9, 1.0, cross(rho_b, nb))
    return length


@part
def add_product_gradient_change(
    u: Vector, v: Vector, qa: Quaternion, qb: Quaternion, factor: float, out: Floats
) -> None:
    """Add ``factor`` times the derivative of the gradient of ``R_a u . R_b v`` to ``out (12, 12)``."""
    m, w = rotated_back(qa, rotated(qb, v)), rotated_back(qb, rotated(qa, u))
    for j in range(3):
        e = unit(j)
        # m turns back with a and forth with b, w the other way round
        add_to_column(out, 3, 3 + j, factor, cross(u, cross(m, e)))
        add_to_column(out, 3, 9 + j, factor, cross(u, rotated_back(qa, rotated(qb, cross(e, v)))))
        add_to_column(out, 9, 9 + j, factor, cross(v, cross(w, e)))
        add_to_column(out, 9, 3 + j, factor, cross(v, rotated_back(qb, rotated(qa, cross(e, u)))))


@part
def add_gradient_change(
    c: int,
    kind: Integers,
    geometry: Floats,
    ra: Vector,
    qa: Quaternion,
    rb: Vector,
    qb: Quaternion,
    factor: float,
    scratch: Floats,
    out: Floats,
) -> None:
    """Add ``factor`` times the derivative of the gradient of coordinate ``c`` along body increments.

    Args:
        scratch: ``(2, 12)``; out: ``(12, 12)``, rows of the gradient, columns of increments; the rest as in
            :func:`coordinate`.
    """
    which = kind[c]
    if which == ALIGNMENT:
        add_product_gradient_change(
            vector(geometry, c, AT_U1), vector(geometry, c, AT_V1), qa, qb, factor, out
        )
        return
    if which == ANGLE:
        u1, v1 = vector(geometry, c, AT_U1), vector(geometry, c, AT_V1)
        u2, v2 = vector(geometry, c, AT_U2), vector(geometry, c, AT_V2)
        for i in range(12):
            scratch[0, i] = scratch[1, i] = 0.0
        sine = add_product(u1, v1, qa, qb, 1.0, scratch[0])
        cosine = add_product(u2, v2, qa, qb, 1.0, scratch[1])
        square = sine * sine + cosine * cosine
        add_product_gradient_change(u1, v1, qa, qb, factor * cosine / square, out)
        add_product_gradient_change(u2, v2, qa, qb, -factor * sine / square, out)
        for i in range(12):
            for j in range(12):
                ds, dc = scratch[0, j], scratch[1, j]
                gs, gc = scratch[0, i], scratch[1, i]
                change = dc * gs - ds * gc
                change -= 2.0 * (cosine * gs - sine * gc) * (sine * ds + cosine * dc) / square
                out[i, j] += factor * change / square
        return
    if which == ROTATION:
        psi = relative(c, geometry, qa, qb)
        e = unit(int(geometry[c, AT_COMPONENT]))
        own_a, own_b = own_axes(geometry, c, AT_Q_A), own_axes(geometry, c, AT_Q_B)
        for j in range(6):
            # T^-1 (increment of b) - T^-T (increment of a), in joint axes
            if j < 3:
                d = scaled(-1.0, pulled(psi, rotated_back(own_a, unit(j)), 1.0))
            else:
                d = pulled(psi, rotated_back(own_b, unit(j - 3)), -1.0)
            column = 3 + j if j < 3 else 6 + j
            add_to_column(out, 3, column, -factor, rotated(own_a, pulled_change(psi, d, e, -1.0)))
            add_to_column(out, 9, column, factor, rotated(own_b, pulled_change(psi, d, e, 1.0)))
        return
    rho_a, rho_b = vector(geometry, c, AT_RHO_A), vector(geometry, c, AT_RHO_B)
    d = plus(plus(rb, 1.0, rotated(qb, rho_b)), -1.0, plus(ra, 1.0, rotated(qa, rho_a)))
    if which == TRANSLATION:
        u = vector(geometry, c, AT_U1)
        s, w = rotated_back(qa, d), rotated_back(qb, rotated(qa, u))
        for j in range(3):
            e = unit(j)
            add_to_column(out, 3, j, -factor, cross(u, e))
            add_to_column(out, 3, 3 + j, factor, cross(u, plus(cross(s, e), -1.0, cross(e, rho_a))))
            add_to_column(out, 3, 6 + j, factor, cross(u, rotated_back(qa, rotated(qb, e))))
            add_to_column(out, 3, 9 + j, factor, cross(u, rotated_back(qa, rotated(qb, cross(e, rho_b)))))
            turned_a, turned_b = rotated_back(qb, rotated(qa, cross(e, u))), cross(w, e)
            add_to_column(out, 6, 3 + j, factor, turned_a)
            add_to_column(out, 6, 9 + j, factor, turned_b)
            add_to_column(out, 9, 3 + j, factor, cross(rho_b, turned_a))
            add_to_column(out, 9, 9 + j, factor, cross(rho_b, turned_b))
        return
    length = max(math.sqrt(dot(d, d)), 1e-300)
    n = scaled(1.0 / length, d)
    na, nb = rotated_back(qa, n), rotated_back(qb, n)
    for j in range(12):
        e = unit(j % 3)
        own = e if j % 6 < 3 else cross(e, rho_a if j < 6 else rho_b)
        change = scaled(-1.0, rotated(qa, own)) if j < 6 else rotated(qb, own)
        dn = scaled(1.0 / length, plus(change, -dot(n, change), n))
        da, db = rotated_back(qa, dn), rotated_back(qb, dn)
        if 3 <= j < 6:
            da = plus(da, 1.0, cross(na, e))
        elif j >= 9:
            db = plus(db, 1.0, cross(nb, e))
        add_to_column(out, 0, j, -factor, da)
        add_to_column(out, 3, j, -factor, cross(rho_a, da))
        add_to_column(out, 6, j, factor, db)
        add_to_column(out, 9, j, factor, cross(rho_b, db))
