"""Rigid attachments: rod ends at a constant pose in the frame of the node they share."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.rotation import rotation_matrix
from viscorod.typing import Floats


@kernel
def link_map(position: Floats, quaternion: Floats, X: Floats) -> None:
    """Write ``X`` (6, 6): the body increment at a rigidly attached pose from that of the shared node."""
    R = np.empty((3, 3))
    rotation_matrix(quaternion, R)
    X[:, :] = 0.0
    for i in range(3):
        for j in range(3):
            X[i, j] = R[j, i]
            X[3 + i, 3 + j] = R[j, i]
        # R^T (theta x d)
        X[i, 3] = R[2, i] * position[1] - R[1, i] * position[2]
        X[i, 4] = R[0, i] * position[2] - R[2, i] * position[0]
        X[i, 5] = R[1, i] * position[0] - R[0, i] * position[1]


@kernel
def inverse_link_map(position: Floats, quaternion: Floats, X: Floats) -> None:
    """Write the inverse of :func:`link_map` into ``X`` (6, 6): ``theta = R theta_k``, ``a = R a_k + d x theta``."""
    R = np.empty((3, 3))
    rotation_matrix(quaternion, R)
    for i in range(3):
        for j in range(3):
            X[i, j] = R[i, j]
            X[3 + i, 3 + j] = R[i, j]
            X[3 + i, j] = 0.0
    for j in range(3):
        X[0, 3 + j] = position[1] * R[2, j] - position[2] * R[1, j]
        X[1, 3 + j] = position[2] * R[0, j] - position[0] * R[2, j]
        X[2, 3 + j] = position[0] * R[1, j] - position[1] * R[0, j]


@kernel
def map_columns(A: Floats, col: int, X: Floats) -> None:
    """Multiply six columns of ``A`` from ``col`` on by ``X`` (6, 6)."""
    row = np.empty(6)
    for i in range(A.shape[0]):
        for j in range(6):
            row[j] = 0.0
            for a in range(6):
                row[j] += A[i, col + a] * X[a, j]
        for j in range(6):
            A[i, col + j] = row[j]


@kernel
def map_rows(A: Floats, first: int, X: Floats) -> None:
    """Multiply six rows of ``A`` from ``first`` on by the transpose of ``X`` (6, 6)."""
    column = np.empty(6)
    for j in range(A.shape[1]):
        for i in range(6):
            column[i] = 0.0
            for a in range(6):
                column[i] += X[a, i] * A[first + a, j]
        for i in range(6):
            A[first + i, j] = column[i]


@kernel
def attached_rate_map(
    link: int, positions: Floats, quaternions: Floats, n: int, rate_map: Floats, out: Floats
) -> None:
    """Write ``X T X^-1``: the rate map of an attached pose from that of its shared node ``n``."""
    X = np.empty((6, 6))
    link_map(positions[link], quaternions[link], X)
    for i in range(6):
        for j in range(6):
            total = 0.0
            for a in range(6):
                total += X[i, a] * rate_map[n, a, j]
            out[i, j] = total
    inverse_link_map(positions[link], quaternions[link], X)
    map_columns(out, 0, X)


@kernel
def attach_block(row: int, column: int, positions: Floats, quaternions: Floats, block: Floats) -> None:
    """Take a 6x6 block from attached poses (links ``row`` and ``column``, -1 for none) to the shared nodes."""
    X = np.empty((6, 6))
    if column >= 0:
        link_map(positions[column], quaternions[column], X)
        map_columns(block, 0, X)
    if row >= 0:
        link_map(positions[row], quaternions[row], X)
        map_rows(block, 0, X)
