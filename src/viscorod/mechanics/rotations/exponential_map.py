"""The exponential maps of rotations and rigid motions, and their right tangents, as formulas of tuples.

With ``R = R0 exp(theta)`` and ``phi = |theta|`` the body angular velocity is

    w = T(theta) theta_t = theta_t - A theta x theta_t + B theta x (theta x theta_t)
    A = (1 - cos phi)/phi^2     B = (phi - sin phi)/phi^3

and ``T^-1 x = x + theta x x/2 + C theta x (theta x x)`` with ``C = (1 - (phi/2) cot(phi/2))/phi^2``. SE(3) is the
dual-number extension of SO(3): the translational parts are the derivatives of these formulas along ``a``, the
translation of ``X = (a, theta)`` (model.md section 2; Sonneville, Cardona and Bruls 2014).
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import lane_kernel, part
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    cross,
    dot,
    normalised,
    plus,
    product,
    rotated,
    scaled,
)


@part
def versine_coefficients(phi2: float) -> tuple[float, float]:
    """Return ``A = (1 - cos phi)/phi^2`` and ``B = (phi - sin phi)/phi^3`` for ``phi2 = phi^2``."""
    if phi2 < 0.04:
        a = 0.5 - phi2 * (
            1 / 24 - phi2 * (1 / 720 - phi2 * (1 / 40320 - phi2 * (1 / 3628800 - phi2 / 479001600)))
        )
        b = 1 / 6 - phi2 * (
            1 / 120 - phi2 * (1 / 5040 - phi2 * (1 / 362880 - phi2 * (1 / 39916800 - phi2 / 6227020800)))
        )
        return a, b
    phi = math.sqrt(phi2)
    half = math.sin(0.5 * phi)
    return 2.0 * half * half / phi2, (phi - math.sin(phi)) / (phi2 * phi)


@part
def versine_slopes(phi2: float, A: float, B: float) -> tuple[float, float]:
    """Return the derivatives over ``phi`` of the two :func:`versine_coefficients`, divided by ``phi``."""
    if phi2 < 0.04:
        return (
            -1 / 12 + phi2 * (1 / 180 - phi2 * (1 / 6720 - phi2 / 453600)),
            -1 / 60 + phi2 * (1 / 1260 - phi2 * (1 / 60480 - phi2 / 4989600)),
        )
    return (1.0 - B * phi2 - 2.0 * A) / phi2, (A - 3.0 * B) / phi2


@part
def inverse_coefficients(phi2: float) -> tuple[float, float]:
    """Return ``C = (1 - (phi/2) cot(phi/2))/phi^2`` and ``C'(phi)/phi`` for ``phi2 = phi^2`` (below ``4 pi^2``)."""
    if phi2 < 0.09:
        c = 1 / 12 + phi2 * (
            1 / 720
            + phi2 * (1 / 30240 + phi2 * (1 / 1209600 + phi2 * (1 / 47900160 + phi2 * 691 / 1307674368000)))
        )
        d = 1 / 360 + phi2 * (
            1 / 7560 + phi2 * (1 / 201600 + phi2 * (1 / 5987520 + phi2 * 691 / 130767436800))
        )
        return c, d
    phi = math.sqrt(phi2)
    y = 0.5 * phi
    cot = math.cos(y) / math.sin(y)
    c = (1.0 - y * cot) / phi2
    slope = (0.5 * y * (1.0 + cot * cot) - 0.5 * cot) / phi2 - 2.0 * c / phi
    return c, slope / phi


@part
def exponential(theta: Vector) -> Quaternion:
    """Return the unit quaternion of the rotation vector ``theta``."""
    phi2 = dot(theta, theta)
    half = 0.5 * math.sqrt(phi2)
    if phi2 < 1e-4:
        return math.cos(half), scaled(0.5 * (1.0 - phi2 / 24 * (1.0 - phi2 / 80)), theta)
    return math.cos(half), scaled(math.sin(half) / (2.0 * half), theta)


@part
def logarithm(q: Quaternion) -> Vector:
    """Return the rotation vector of the unit quaternion ``q``, the shorter way round (at most pi long)."""
    sign = 1.0 if q[0] >= 0.0 else -1.0
    sine = math.sqrt(dot(q[1], q[1]))
    factor = 2.0 * sign if sine < 1e-8 else 2.0 * math.atan2(sine, sign * q[0]) * sign / sine
    return scaled(factor, q[1])


@part
def tangent_of(theta: Vector, x: Vector) -> Vector:
    """Return ``T(theta) x``: the body angular velocity where ``theta`` changes by ``x`` per time."""
    A, B = versine_coefficients(dot(theta, theta))
    once = cross(theta, x)
    return plus(plus(x, -A, once), B, cross(theta, once))


@part
def tangent_change(theta: Vector, rate: Vector, x: Vector) -> Vector:
    """Return the derivative of :func:`tangent_of` along ``rate`` at constant ``x``."""
    phi2 = dot(theta, theta)
    A, B = versine_coefficients(phi2)
    A_slope, B_slope = versine_slopes(phi2, A, B)
    along, once, first = dot(theta, rate), cross(theta, x), cross(rate, x)
    total = plus(scaled(-A, first), B, plus(cross(rate, once), 1.0, cross(theta, first)))
    return plus(plus(total, -A_slope * along, once), B_slope * along, cross(theta, once))


@lane_kernel
def pulled(theta: Vector, x: Vector, sign: float) -> Vector:
    """Return ``T(theta)^-T x`` for sign 1 and ``T(theta)^-1 x`` for -1."""
    C, _ = inverse_coefficients(dot(theta, theta))
    once = cross(theta, x)
    return plus(plus(x, -0.5 * sign, once), C, cross(theta, once))


@part
def screw_translation(a: Vector, theta: Vector) -> Vector:
    """Return the translation ``T(-theta) a`` of the exponential of ``(a, theta)``."""
    A, B = versine_coefficients(dot(theta, theta))
    g = cross(theta, a)
    return plus(plus(a, A, g), B, cross(theta, g))


@part
def screw_logarithm(u: Vector, theta: Vector) -> Vector:
    """Return ``T(-theta)^-1 u``, which is ``a`` of the coordinates ``(a, theta)`` with the translation ``u``."""
    C, _ = inverse_coefficients(dot(theta, theta))
    c = cross(theta, u)
    return plus(plus(u, -0.5, c), C, cross(theta, c))


@part
def body_twist(a: Vector, theta: Vector, a_rate: Vector, theta_rate: Vector) -> tuple[Vector, Vector]:
    """Return the body twist ``(v, w) = T(X) X_t`` of coordinates ``X = (a, theta)`` on SE(3)."""
    phi2 = dot(theta, theta)
    A, B = versine_coefficients(phi2)
    c = cross(theta, theta_rate)
    e = cross(theta, c)
    w = plus(plus(theta_rate, -A, c), B, e)
    # the formula of w, differentiated along (a, a_rate)
    f = plus(cross(theta, a_rate), 1.0, cross(a, theta_rate))
    A_slope, B_slope = versine_slopes(phi2, A, B)
    along = dot(theta, a)
    v = plus(plus(a_rate, -A, f), B, plus(cross(theta, f), 1.0, cross(a, c)))
    return plus(plus(v, -A_slope * along, c), B_slope * along, e), w


@part
def coordinate_rate(a: Vector, theta: Vector, v: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return ``X_t = T(X)^-1 (v, w)``, the inverse of :func:`body_twist`."""
    C, slope = inverse_coefficients(dot(theta, theta))
    c = cross(theta, w)
    e = cross(theta, c)
    # the formula of theta_t, differentiated along (a, v)
    h = plus(cross(theta, v), 1.0, cross(a, w))
    a_rate = plus(plus(v, 0.5, h), C, plus(cross(theta, h), 1.0, cross(a, c)))
    return plus(a_rate, slope * dot(theta, a), e), plus(plus(w, 0.5, c), C, e)


@part
def pose_after(r0: Vector, q0: Quaternion, u: Vector, x: Quaternion) -> tuple[Vector, Quaternion]:
    """Return the pose ``(r0, q0)`` followed by the translation ``u`` and the rotation ``x`` in its frame."""
    return plus(r0, 1.0, rotated(q0, u)), normalised(product(q0, x))
