"""Rigid attachments: rod ends at a constant pose in the frame of the node they share."""

from __future__ import annotations

from typing import NamedTuple

from viscorod.mechanics.compilation.compiled import kernel, lane_kernel, part
from viscorod.mechanics.rotations.rotation import rotation_matrix
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    cross,
    plus,
    product,
    rotated,
    rotated_back,
)
from viscorod.typing import Floats, Integers


class ElementNodes(NamedTuple):
    """Nodes of one element: shared node and attachment (or -1) of each, and the poses of all attachments."""

    nodes: Integers
    links: Integers
    link_positions: Floats
    link_quaternions: Floats


class PointWrench(NamedTuple):
    """A wrench inside an element, where the basis has the values ``shape (m,)``.

    Attributes:
        dead: in global axes ``(6,)`` [N, N m]; following: in the section's axes.
    """

    shape: Floats
    dead: Floats
    following: Floats


@kernel
def link_map(position: Floats, quaternion: Floats, X: Floats) -> None:
    """Write ``X`` (6, 6): the body increment at a rigidly attached pose from that of the shared node."""
    X[:, :] = 0.0
    R = X[3:6, 0:3]  # for the moment
    rotation_matrix(quaternion, R)
    for i in range(3):
        for j in range(3):
            X[i, j] = R[j, i]
            X[3 + i, 3 + j] = R[j, i]
        # R^T (theta x d)
        X[i, 3] = R[2, i] * position[1] - R[1, i] * position[2]
        X[i, 4] = R[0, i] * position[2] - R[2, i] * position[0]
        X[i, 5] = R[1, i] * position[0] - R[0, i] * position[1]
    R[:, :] = 0.0


@part
def map_columns(A: Floats, col: int, X: Floats) -> None:
    """Multiply six columns of ``A`` from ``col`` on by ``X`` (6, 6)."""
    for i in range(A.shape[0]):
        old = A[i, col], A[i, col + 1], A[i, col + 2], A[i, col + 3], A[i, col + 4], A[i, col + 5]
        for j in range(6):
            A[i, col + j] = 0.0
            for a in range(6):
                A[i, col + j] += old[a] * X[a, j]


@part
def map_rows(A: Floats, first: int, X: Floats) -> None:
    """Multiply six rows of ``A`` from ``first`` on by the transpose of ``X`` (6, 6)."""
    n = first
    for j in range(A.shape[1]):
        old = A[n, j], A[n + 1, j], A[n + 2, j], A[n + 3, j], A[n + 4, j], A[n + 5, j]
        for i in range(6):
            A[n + i, j] = 0.0
            for a in range(6):
                A[n + i, j] += X[a, i] * old[a]


@lane_kernel
def attached_pose(d: Vector, own: Quaternion, r: Vector, q: Quaternion) -> tuple[Vector, Quaternion]:
    """Return the pose at offset ``d`` and quaternion ``own`` in the frame of the shared node."""
    return plus(r, 1.0, rotated(q, d)), product(q, own)


@lane_kernel
def attached_twist(d: Vector, own: Quaternion, v: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Return ``X (v, w)``: twist or increment at a pose attached with offset ``d`` and quaternion ``own``."""
    return rotated_back(own, plus(v, 1.0, cross(w, d))), rotated_back(own, w)


@lane_kernel
def shared_wrench(d: Vector, own: Quaternion, f: Vector, m: Vector) -> tuple[Vector, Vector]:
    """Return ``X^T (f, m)``: the wrench on the attached pose as one on the shared node."""
    force = rotated(own, f)
    return force, plus(rotated(own, m), 1.0, cross(d, force))


@lane_kernel
def attached_wrench(d: Vector, own: Quaternion, f: Vector, m: Vector) -> tuple[Vector, Vector]:
    """Return ``X^-T (f, m)``, the inverse of :func:`shared_wrench`."""
    return rotated_back(own, f), rotated_back(own, plus(m, -1.0, cross(d, f)))
