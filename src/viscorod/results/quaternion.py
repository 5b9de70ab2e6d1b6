"""Quaternions for reading results: plain NumPy, so that a file opens without compiling anything."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats


def conjugate(q: Floats) -> Floats:
    """Return the inverse of unit quaternions ``(..., 4)``."""
    inverse: Floats = q * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def product(p: Floats, q: Floats) -> Floats:
    """Return the quaternion product ``p q``, shapes ``(..., 4)``."""
    vector = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    scalar = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    return np.concatenate([scalar, vector], axis=-1)


def mean(q: Floats, weights: Floats) -> Floats:
    """Return the unit quaternion of a weighted sum, ``(k, 4)`` and ``(k,)``, taken in one hemisphere."""
    signs = np.where(q @ q[np.argmax(np.abs(weights))] < 0.0, -1.0, 1.0)
    total = (weights * signs) @ q
    unit: Floats = total / np.linalg.norm(total)
    return unit


def rotation_vector(q: Floats) -> Floats:
    """Return the rotation vector [rad] of a unit quaternion ``(4,)``, the shorter way round."""
    sine = float(np.linalg.norm(q[1:]))
    cosine = float(q[0])
    if cosine < 0.0:
        cosine, q = -cosine, -q
    factor = 2.0 if sine < 1e-12 else 2.0 * np.arctan2(sine, cosine) / sine
    vector: Floats = factor * q[1:]
    return vector
