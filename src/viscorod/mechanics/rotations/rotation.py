"""Rotations and rigid motions: quaternions, exponential maps and their tangents.

A pose is a position ``r`` (global) and a unit quaternion ``q = (q0, q1, q2, q3)`` whose matrix ``R`` takes body
components to global ones. Increments ``(a, theta)`` act from the right, in the body frame: they are logarithms on
SE(3).
"""

from __future__ import annotations

import math

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.vectors import dot, vector
from viscorod.typing import Floats


@part
def cross(a: Floats, b: Floats, out: Floats) -> None:
    """Write ``a x b`` into ``out`` (which must be neither)."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@part
def add_skew(a: Floats, factor: float, out: Floats) -> None:
    """Add ``factor [a]x`` to the 3x3 ``out``, where ``[a]x b = a x b``."""
    out[0, 1] -= factor * a[2]
    out[0, 2] += factor * a[1]
    out[1, 0] += factor * a[2]
    out[1, 2] -= factor * a[0]
    out[2, 0] -= factor * a[1]
    out[2, 1] += factor * a[0]


@part
def rotation_matrix(q: Floats, out: Floats) -> None:
    """Write the rotation matrix of the quaternion ``q`` (any length but zero) into ``out``."""
    n = 1.0 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    xx, yy, zz = 2 * n * q[1] * q[1], 2 * n * q[2] * q[2], 2 * n * q[3] * q[3]
    xy, xz, yz = 2 * n * q[1] * q[2], 2 * n * q[1] * q[3], 2 * n * q[2] * q[3]
    wx, wy, wz = 2 * n * q[0] * q[1], 2 * n * q[0] * q[2], 2 * n * q[0] * q[3]
    out[0, 0], out[0, 1], out[0, 2] = 1.0 - yy - zz, xy - wz, xz + wy
    out[1, 0], out[1, 1], out[1, 2] = xy + wz, 1.0 - xx - zz, yz - wx
    out[2, 0], out[2, 1], out[2, 2] = xz - wy, yz + wx, 1.0 - xx - yy


@part
def rotate(q: Floats, a: Floats, out: Floats) -> None:
    """Write ``R(q) a`` into ``out`` for a unit quaternion ``q``."""
    t0 = 2.0 * (q[2] * a[2] - q[3] * a[1])
    t1 = 2.0 * (q[3] * a[0] - q[1] * a[2])
    t2 = 2.0 * (q[1] * a[1] - q[2] * a[0])
    out[0] = a[0] + q[0] * t0 + q[2] * t2 - q[3] * t1
    out[1] = a[1] + q[0] * t1 + q[3] * t0 - q[1] * t2
    out[2] = a[2] + q[0] * t2 + q[1] * t1 - q[2] * t0


@part
def rotate_back(q: Floats, a: Floats, out: Floats) -> None:
    """Write ``R(q)^T a`` into ``out`` for a unit quaternion ``q``."""
    t0 = 2.0 * (q[2] * a[2] - q[3] * a[1])
    t1 = 2.0 * (q[3] * a[0] - q[1] * a[2])
    t2 = 2.0 * (q[1] * a[1] - q[2] * a[0])
    out[0] = a[0] - q[0] * t0 + q[2] * t2 - q[3] * t1
    out[1] = a[1] - q[0] * t1 + q[3] * t0 - q[1] * t2
    out[2] = a[2] - q[0] * t2 + q[1] * t1 - q[2] * t0


@kernel
def rotate_rows(q: Floats, vectors: Floats, out: Floats) -> None:
    """Write ``R(q_k) a_k`` for every row into ``out (n, 3)``."""
    for k in range(q.shape[0]):
        rotate(q[k], vectors[k], out[k])


@part
def quaternion_product(p: Floats, q: Floats, out: Floats) -> None:
    """Write the quaternion product ``p q`` into ``out`` (which must be neither)."""
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3]
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2]
    out[2] = p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3]
    out[3] = p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]


@part
def versine_coefficients(phi2: float) -> tuple[float, float]:
    """Return ``(1 - cos phi)/phi^2`` and ``(phi - sin phi)/phi^3`` for ``phi2 = phi^2``."""
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
def inverse_coefficients(phi2: float) -> tuple[float, float]:
    """Return ``c = (1 - (phi/2) cot(phi/2))/phi^2`` and ``c'(phi)/phi`` for ``phi2 = phi^2`` (below ``4 pi^2``)."""
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


@kernel
def retract(r: Floats, q: Floats, increment: Floats, r_new: Floats, q_new: Floats) -> None:
    """Compose every pose with the exponential of its body-frame increment.

    Args:
        r, q: positions ``(n, 3)`` [m] and unit quaternions ``(n, 4)``.
        increment: ``(n, 6)``, translation [m] and rotation vector [rad] in the body frame (logarithm on SE(3)).
        r_new, q_new: outputs; may be ``r`` and ``q``.
    """
    u = np.empty(3)
    g = np.empty(3)
    for k in range(r.shape[0]):
        a0, a1, a2, t0, t1, t2 = increment[k]
        phi2 = t0 * t0 + t1 * t1 + t2 * t2
        a, b = versine_coefficients(phi2)
        # V(theta) translation = a + A theta x a + B theta x (theta x a)
        c0, c1, c2 = t1 * a2 - t2 * a1, t2 * a0 - t0 * a2, t0 * a1 - t1 * a0
        u[0] = a0 + a * c0 + b * (t1 * c2 - t2 * c1)
        u[1] = a1 + a * c1 + b * (t2 * c0 - t0 * c2)
        u[2] = a2 + a * c2 + b * (t0 * c1 - t1 * c0)
        rotate(q[k], u, g)
        r_new[k, 0] = r[k, 0] + g[0]
        r_new[k, 1] = r[k, 1] + g[1]
        r_new[k, 2] = r[k, 2] + g[2]
        if phi2 < 1e-4:
            e0 = 1.0 - phi2 / 8 * (1.0 - phi2 / 48)
            s = 0.5 * (1.0 - phi2 / 24 * (1.0 - phi2 / 80))
        else:
            phi = math.sqrt(phi2)
            e0 = math.cos(0.5 * phi)
            s = math.sin(0.5 * phi) / phi
        e1, e2, e3 = s * t0, s * t1, s * t2
        q0, q1, q2, q3 = q[k]
        n0 = q0 * e0 - q1 * e1 - q2 * e2 - q3 * e3
        n1 = q0 * e1 + q1 * e0 + q2 * e3 - q3 * e2
        n2 = q0 * e2 + q2 * e0 + q3 * e1 - q1 * e3
        n3 = q0 * e3 + q3 * e0 + q1 * e2 - q2 * e1
        scale = 1.0 / math.sqrt(n0 * n0 + n1 * n1 + n2 * n2 + n3 * n3)
        q_new[k, 0], q_new[k, 1], q_new[k, 2], q_new[k, 3] = scale * n0, scale * n1, scale * n2, scale * n3


@part
def turned(q: Floats, theta: Floats, out: Floats) -> None:
    """Write the unit quaternion ``q exp(theta)`` into ``out`` (which may not be ``q``)."""
    phi2 = theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2
    half = 0.5 * math.sqrt(phi2)
    s = 0.5 * (1.0 - phi2 / 24 * (1.0 - phi2 / 80)) if phi2 < 1e-4 else math.sin(half) / (2.0 * half)
    e0, e1, e2, e3 = math.cos(half), s * theta[0], s * theta[1], s * theta[2]
    out[0] = q[0] * e0 - q[1] * e1 - q[2] * e2 - q[3] * e3
    out[1] = q[0] * e1 + q[1] * e0 + q[2] * e3 - q[3] * e2
    out[2] = q[0] * e2 + q[2] * e0 + q[3] * e1 - q[1] * e3
    out[3] = q[0] * e3 + q[3] * e0 + q[1] * e2 - q[2] * e1
    scale = 1.0 / math.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2 + out[3] ** 2)
    for i in range(4):
        out[i] *= scale


@part
def rotation_tangent(theta: Floats, out: Floats) -> None:
    """Write ``T(theta)`` into ``out``: body angular velocity ``w = T theta_t`` where ``R = R0 exp(theta)``."""
    phi2 = theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2
    a, b = versine_coefficients(phi2)
    for i in range(3):
        for j in range(3):
            out[i, j] = b * theta[i] * theta[j]
        out[i, i] += 1.0 - b * phi2
    add_skew(theta, -a, out)


@part
def rotation_tangent_rate(theta: Floats, rate: Floats, out: Floats) -> None:
    """Write the directional derivative of ``T(theta)`` along ``rate`` into ``out``."""
    phi2 = theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2
    a, b = versine_coefficients(phi2)
    if phi2 < 0.04:
        a1 = -1 / 12 + phi2 * (1 / 180 - phi2 * (1 / 6720 - phi2 / 453600))
        b1 = -1 / 60 + phi2 * (1 / 1260 - phi2 * (1 / 60480 - phi2 / 4989600))
    else:
        a1 = (1.0 - b * phi2 - 2.0 * a) / phi2
        b1 = (a - 3.0 * b) / phi2
    t = theta[0] * rate[0] + theta[1] * rate[1] + theta[2] * rate[2]
    for i in range(3):
        for j in range(3):
            out[i, j] = b * (theta[i] * rate[j] + rate[i] * theta[j]) + b1 * t * theta[i] * theta[j]
        out[i, i] -= 2.0 * b * t + b1 * t * phi2
    add_skew(rate, -a, out)
    add_skew(theta, -a1 * t, out)


@part
def inverse_rotation_tangent(theta: Floats, out: Floats) -> None:
    """Write ``T(theta)^-1`` into ``out``."""
    phi2 = theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2
    c, _ = inverse_coefficients(phi2)
    for i in range(3):
        for j in range(3):
            out[i, j] = c * theta[i] * theta[j]
        out[i, i] += 1.0 - c * phi2
    add_skew(theta, 0.5, out)


@kernel
def inverse_motion_tangent(increment: Floats, scale: float, out: Floats) -> None:
    """Write ``scale`` times the inverse right tangent of the exponential on SE(3) into ``out``.

    With ``H(t) = H0 exp(X(t))`` the body twist is ``x1 = T(X) X_t``; this is ``T(X)^-1``, node by node. SE(3) being the
    dual-number extension of SO(3), its off-diagonal block is the derivative of the rotational one along the
    translation.

    Args:
        increment: ``(n, 6)``, translation [m] and rotation [rad].
        scale: factor on the result.
        out: ``(n, 6, 6)``.
    """
    for k in range(increment.shape[0]):
        a = vector(increment, k, 0)
        theta = vector(increment, k, 3)
        phi2 = dot(theta, theta)
        t = dot(theta, a)
        c, d = inverse_coefficients(phi2)
        # as inverse_rotation_tangent, and its derivative along a; slices would cost more than the formula
        for i in range(3):
            for j in range(3):
                turn = c * theta[i] * theta[j]
                push = c * (theta[i] * a[j] + a[i] * theta[j]) + d * t * theta[i] * theta[j]
                if i == j:
                    turn += 1.0 - c * phi2
                    push -= (2.0 * c + d * phi2) * t
                elif j == (i + 1) % 3:
                    turn -= 0.5 * theta[3 - i - j]
                    push -= 0.5 * a[3 - i - j]
                else:
                    turn += 0.5 * theta[3 - i - j]
                    push += 0.5 * a[3 - i - j]
                out[k, i, j] = scale * turn
                out[k, i, 3 + j] = scale * push
                out[k, 3 + i, j] = 0.0
                out[k, 3 + i, 3 + j] = scale * turn


@kernel
def add_mapped(maps: Floats, x: Floats, factor: float, out: Floats) -> None:
    """Add ``factor`` times the product of every map ``(n, 6, 6)`` with its vector ``x (n, 6)`` to ``out``."""
    for k in range(x.shape[0]):
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += maps[k, i, j] * x[k, j]
            out[k, i] += factor * total


@kernel
def increment_size(increment: Floats, length: float) -> float:
    """Return the largest displacement over ``length`` or rotation [rad] of ``(n, 6)``; infinity if any is undefined."""
    size = 0.0
    for k in range(increment.shape[0]):
        for i in range(6):
            x = abs(increment[k, i])
            if i < 3:
                x /= length
            if not x <= 1e300:
                return math.inf
            size = max(size, x)
    return size


@part
def rotation_vector(q: Floats, out: Floats) -> None:
    """Write the rotation vector of the unit quaternion ``q`` (the shorter way round, |out| <= pi) into ``out``."""
    sign = 1.0 if q[0] >= 0.0 else -1.0
    s = math.sqrt(q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    factor = 2.0 * sign if s < 1e-8 else 2.0 * math.atan2(s, sign * q[0]) * sign / s
    for i in range(3):
        out[i] = factor * q[1 + i]


@part
def relative_rotation(q0: Floats, q: Floats, out: Floats) -> None:
    """Write the rotation vector of ``conj(q0) q`` into ``out``."""
    d = np.empty(4)
    d[0] = q0[0] * q[0] + q0[1] * q[1] + q0[2] * q[2] + q0[3] * q[3]
    d[1] = q0[0] * q[1] - q0[1] * q[0] - q0[2] * q[3] + q0[3] * q[2]
    d[2] = q0[0] * q[2] - q0[2] * q[0] - q0[3] * q[1] + q0[1] * q[3]
    d[3] = q0[0] * q[3] - q0[3] * q[0] - q0[1] * q[2] + q0[2] * q[1]
    rotation_vector(d, out)
