"""Poses along a rod from its strains: ``R' = R U~``, ``r' = R V`` integrated over elements, for whole arrays.

Strains are polynomials through the Gauss points of an element. A step takes the exponential of the motion group of the
fourth-order Magnus expansion (Iserles, Munthe-Kaas, Norsett and Zanna 2000, 5.1), which is exact for constant strains.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.basis import gauss, lobatto
from viscorod.mechanics.rotations.quaternion import product
from viscorod.typing import Floats

STEPS = 6
"""Steps between neighbouring nodes: their error is far below that of the strains' polynomials."""


def rotated(q: Floats, a: Floats) -> Floats:
    """Rotate vectors ``a (..., 3)`` by unit quaternions ``q (..., 4)``."""
    t = 2.0 * np.cross(q[..., 1:], a)
    return np.asarray(a + q[..., :1] * t + np.cross(q[..., 1:], t))


def exponential(motion: Floats) -> tuple[Floats, Floats]:
    """Return displacement ``(..., 3)`` and unit quaternion ``(..., 4)`` of constant motions ``(v, w) (..., 6)``."""
    v, w = motion[..., :3], motion[..., 3:]
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    small = angle < 1e-3
    safe = np.where(small, 1.0, angle)
    square = angle**2
    half = np.where(small, 0.5 - square / 48.0, np.sin(0.5 * safe) / safe)
    q = np.concatenate([np.cos(0.5 * angle), half * w], axis=-1)
    a = np.where(small, 0.5 - square / 24.0, 2.0 * (np.sin(0.5 * safe) / safe) ** 2)
    b = np.where(small, 1.0 / 6.0 - square / 120.0, (safe - np.sin(safe)) / safe**3)
    turned = np.cross(w, v)
    return v + a * turned + b * np.cross(w, turned), q


def bracket(a: Floats, b: Floats) -> Floats:
    """Return the bracket ``ad(a) b`` of motions ``(..., 6)``."""
    va, wa, vb, wb = a[..., :3], a[..., 3:], b[..., :3], b[..., 3:]
    return np.concatenate([np.cross(wa, vb) + np.cross(va, wb), np.cross(wa, wb)], axis=-1)


def along_element(order: int, half_length: Floats, strain: Floats) -> tuple[Floats, Floats]:
    """Return the poses of the nodes of elements relative to their first nodes.

    Args:
        order: of all elements.
        half_length: half their reference arc length ``(e,)`` [m].
        strain: total strains ``(V, U)`` at the Gauss points ``(..., e, order, 6)``.

    Returns:
        positions ``(..., e, order + 1, 3)`` [m] and unit quaternions ``(..., e, order + 1, 4)``.
    """
    nodes, points = lobatto(order)[0], gauss(order)[0]
    shape = strain.shape[:-2]
    r, q = np.zeros((*shape, 3)), np.zeros((*shape, 4))
    q[..., 0] = 1.0
    positions, turns = [r], [q]
    offset = 0.5 / np.sqrt(3.0)
    for k in range(order):
        width = (nodes[k + 1] - nodes[k]) / STEPS
        h = (width * half_length)[:, None]
        for step in range(STEPS):
            middle = nodes[k] + (step + 0.5) * width
            weights = _through(points, np.array([middle - offset * width, middle + offset * width]))
            first, second = np.moveaxis(np.einsum("kg,...ga->...ka", weights, strain), -2, 0)
            motion = 0.5 * h * (first + second) + np.sqrt(3.0) / 12.0 * h**2 * bracket(first, second)
            d, turn = exponential(motion)
            r, q = r + rotated(q, d), product(q, turn)
        positions.append(r)
        turns.append(q)
    return np.stack(positions, axis=-2), np.stack(turns, axis=-2)


def along_rod(
    order: int, half_length: Floats, strain: Floats, r0: Floats, q0: Floats
) -> tuple[Floats, Floats]:
    """Return the poses of the nodes of a rod's elements, one after the other, from the pose of its start.

    Args:
        order, half_length, strain: as in :func:`along_element`, in order of arc length.
        r0, q0: pose of the start ``(..., 3)``, ``(..., 4)``.

    Returns:
        positions ``(..., e order + 1, 3)`` [m] and unit quaternions ``(..., e order + 1, 4)``.
    """
    d, turn = along_element(order, half_length, strain)
    r, q = r0, q0
    positions, turns = [r[..., None, :]], [q[..., None, :]]
    for e in range(len(half_length)):
        start = np.broadcast_to(q[..., None, :], turn[..., e, 1:, :].shape)
        positions.append(r[..., None, :] + rotated(start, d[..., e, 1:, :]))
        turns.append(product(start, turn[..., e, 1:, :]))
        r, q = positions[-1][..., -1, :], turns[-1][..., -1, :]
    return np.concatenate(positions, axis=-2), np.concatenate(turns, axis=-2)


def _through(points: Floats, xi: Floats) -> Floats:
    """Return the Lagrange polynomials on ``points (g,)`` at ``xi (k,)``: ``(k, g)``."""
    values = np.ones((len(xi), len(points)))
    for g, point in enumerate(points):
        for other in np.delete(points, g):
            values[:, g] *= (xi - other) / (point - other)
    return values
