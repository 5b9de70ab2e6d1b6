"""Operations on arrays of unit quaternions (w, x, y, z) in plain NumPy, for use outside the kernels."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats


def from_matrices(R: Floats) -> Floats:
    """Return the quaternions ``(n, 4)`` of rotation matrices ``(n, 3, 3)``.

    Every row of ``4 q q^T`` is a multiple of q; the one with the largest diagonal entry keeps all digits.
    """
    x, y, z = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    outer = np.empty((len(R), 4, 4))
    outer[:, 0, 0], outer[:, 1, 1] = 1 + x + y + z, 1 + x - y - z
    outer[:, 2, 2], outer[:, 3, 3] = 1 - x + y - z, 1 - x - y + z
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        outer[:, 0, 1 + i] = outer[:, 1 + i, 0] = R[:, k, j] - R[:, j, k]
        outer[:, 1 + i, 1 + j] = outer[:, 1 + j, 1 + i] = R[:, i, j] + R[:, j, i]
    largest = np.argmax(np.einsum("nii->ni", outer), axis=1)
    q: Floats = outer[np.arange(len(R)), largest]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return q


def matrices(q: Floats) -> Floats:
    """Return the rotation matrices ``(n, 3, 3)`` of unit quaternions ``(n, 4)``."""
    w, x, y, z = q.T
    R = np.empty((len(q), 3, 3))
    R[:, 0, 0], R[:, 1, 1], R[:, 2, 2] = (
        1 - 2 * (y * y + z * z),
        1 - 2 * (x * x + z * z),
        1 - 2 * (x * x + y * y),
    )
    R[:, 0, 1], R[:, 1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    R[:, 0, 2], R[:, 2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    R[:, 1, 2], R[:, 2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)
    return R


def conjugate(q: Floats) -> Floats:
    """Return the inverse of unit quaternions ``(..., 4)``."""
    inverse: Floats = q * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def product(p: Floats, q: Floats) -> Floats:
    """Return the quaternion product ``p q``, shapes ``(..., 4)``."""
    p0, p1, p2, p3 = (p[..., i] for i in range(4))
    q0, q1, q2, q3 = (q[..., i] for i in range(4))
    parts = [
        p0 * q0 - (p1 * q1 + p2 * q2 + p3 * q3),
        p0 * q1 + q0 * p1 + (p2 * q3 - p3 * q2),
        p0 * q2 + q0 * p2 + (p3 * q1 - p1 * q3),
        p0 * q3 + q0 * p3 + (p1 * q2 - p2 * q1),
    ]
    return np.stack(parts, axis=-1)


def mean(q: Floats, weights: Floats) -> Floats:
    """Return the unit quaternion of a weighted sum, ``(k, 4)`` and ``(k,)``, taken in one hemisphere."""
    signs = np.where(q @ q[np.argmax(np.abs(weights))] < 0.0, -1.0, 1.0)
    total = (weights * signs) @ q
    unit: Floats = total / np.linalg.norm(total)
    return unit


def rotation_vectors(q: Floats) -> Floats:
    """Return the rotation vectors [rad] of unit quaternions ``(n, 4)``, the shorter way round ``(n, 3)``."""
    sine = np.linalg.norm(q[:, 1:], axis=1)
    sign = np.where(q[:, 0] < 0.0, -1.0, 1.0)
    angle = 2.0 * np.arctan2(sine, np.abs(q[:, 0]))
    factor = np.where(sine < 1e-12, 2.0, angle / np.maximum(sine, 1e-300))
    vectors: Floats = (sign * factor)[:, None] * q[:, 1:]
    return vectors


def rotation_vector(q: Floats) -> Floats:
    """Return the rotation vector [rad] of a unit quaternion ``(4,)``, the shorter way round."""
    sine = float(np.linalg.norm(q[1:]))
    cosine = float(q[0])
    if cosine < 0.0:
        cosine, q = -cosine, -q
    factor = 2.0 if sine < 1e-12 else 2.0 * np.arctan2(sine, cosine) / sine
    vector: Floats = factor * q[1:]
    return vector
