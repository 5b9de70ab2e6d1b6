"""Rotations and rigid motions of nodes, in arrays: poses that are turned and moved, tangents as matrices.

A pose is a position ``r`` (global) and a unit quaternion ``q = (q0, q1, q2, q3)`` whose matrix ``R`` takes body
components to global ones. Increments ``(a, theta)`` act from the right, in the body frame: they are logarithms on
SE(3).
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.exponential_map import (
    exponential,
    inverse_coefficients,
    logarithm,
    pose_after,
    screw_translation,
)
from viscorod.mechanics.rotations.vectors import (
    Vector,
    difference,
    dot,
    entries,
    put,
    put4,
    put_entries,
    quaternion,
    quaternion_of,
    rotated,
    rotated_back,
    vector,
)
from viscorod.typing import Floats


@part
def add_skew(a: Floats | Vector, factor: float, out: Floats) -> None:
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
    put_entries(out, 0, rotated(quaternion_of(q), entries(a, 0)))


@part
def rotate_back(q: Floats, a: Floats, out: Floats) -> None:
    """Write ``R(q)^T a`` into ``out`` for a unit quaternion ``q``."""
    put_entries(out, 0, rotated_back(quaternion_of(q), entries(a, 0)))


@kernel
def rotate_rows(q: Floats, vectors: Floats, out: Floats) -> None:
    """Write ``R(q_k) a_k`` for every row into ``out (n, 3)``."""
    for k in range(q.shape[0]):
        put(out, k, 0, rotated(quaternion(q, k), vector(vectors, k, 0)))


@kernel
def retract(r: Floats, q: Floats, increment: Floats, r_new: Floats, q_new: Floats) -> None:
    """Compose every pose with the exponential of its body-frame increment.

    Args:
        r, q: positions ``(n, 3)`` [m] and unit quaternions ``(n, 4)``.
        increment: ``(n, 6)``, translation [m] and rotation vector [rad] in the body frame (logarithm on SE(3)).
        r_new, q_new: outputs; may be ``r`` and ``q``.
    """
    for k in range(r.shape[0]):
        a, theta = vector(increment, k, 0), vector(increment, k, 3)
        u = screw_translation(a, theta)
        here, turn = pose_after(vector(r, k, 0), quaternion(q, k), u, exponential(theta))
        put(r_new, k, 0, here)
        put4(q_new, k, turn)


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
        # T^-1 of rotations, and its derivative along a; slices would cost more than the formula
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


@kernel
def motion_extent(
    r0: Floats, q0: Floats, r: Floats, q: Floats, twist: Floats, length: float
) -> tuple[float, float]:
    """Return how far nodes moved, and how fast they are: displacements over ``length``, rotations in rad.

    Args:
        r0, q0: where they come from, ``(n, 3)`` [m], ``(n, 4)``; r, q, twist: where they are, body twists ``(n, 6)``.
    """
    far = turned = fast = spin = 0.0
    for k in range(r.shape[0]):
        away = difference(vector(r, k, 0), vector(r0, k, 0))
        far = max(far, dot(away, away))
        near = other = 0.0  # squared chords to both quaternions of the orientation
        for a in range(4):
            near += (q[k, a] - q0[k, a]) ** 2
            other += (q[k, a] + q0[k, a]) ** 2
        turned = max(turned, min(near, other))
        v, w = vector(twist, k, 0), vector(twist, k, 3)
        fast, spin = max(fast, dot(v, v)), max(spin, dot(w, w))
    return (
        max(math.sqrt(far) / length, 2.0 * math.sqrt(turned)),
        max(math.sqrt(fast) / length, math.sqrt(spin)),
    )


@part
def rotation_vector(q: Floats, out: Floats) -> None:
    """Write the rotation vector of the unit quaternion ``q`` (the shorter way round, |out| <= pi) into ``out``."""
    put_entries(out, 0, logarithm(quaternion_of(q)))
