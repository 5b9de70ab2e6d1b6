"""The frozen Jacobian of a collocation step: its matrices from an assembly, and the two that are factorised."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.supports import in_body, reaction_stiffness, support_directions
from viscorod.typing import Floats, Integers


@kernel
def adjoint(twist: Floats, out: Floats) -> None:
    """Write ``ad(x1) = [[w~, v~], [0, w~]]`` of every node ``(n, 6, 6)``: how a body increment turns with the node."""
    out[:, :, :] = 0.0
    for k in range(twist.shape[0]):
        v0, v1, v2, w0, w1, w2 = twist[k]
        for first in (0, 3):
            o = out[k, first : first + 3, first : first + 3]
            o[0, 1], o[0, 2], o[1, 0], o[1, 2], o[2, 0], o[2, 1] = -w2, w1, w2, -w0, -w1, w0
        o = out[k, 0:3, 3:6]
        o[0, 1], o[0, 2], o[1, 0], o[1, 2], o[2, 0], o[2, 1] = -v2, v1, v2, -v0, -v1, v0


@kernel
def add_inertia(
    mass: Floats, twist: Floats, turning: Floats, K: Floats, C: Floats, mass_turning: Floats
) -> None:
    """Add the inertial parts of the Jacobian: ``C += N + M ad(x)`` and ``K += N ad(x)`` with ``N = d(L1 M x)/dx``.

    Args:
        mass: ``(n, 6, 6)``; turning: ``ad(x)`` of every node; K, C: bands of width 2 w + 1.
        mass_turning: output ``M ad(x)``.
    """
    N = np.empty((6, 6))
    momentum = np.empty(6)
    width = (K.shape[1] - 1) // 2
    for k in range(mass.shape[0]):
        M, A = mass[k], turning[k]
        for i in range(6):
            momentum[i] = 0.0
            for j in range(6):
                momentum[i] += M[i, j] * twist[k, j]
                mass_turning[k, i, j] = 0.0
                N[i, j] = 0.0
                for a in range(6):
                    mass_turning[k, i, j] += M[i, a] * A[a, j]
                    # L1(x) = -ad(x)^T
                    N[i, j] -= A[a, i] * M[a, j]
        # derivative of L1(x) at constant momentum: -[p~] and -[h~]
        p0, p1, p2, h0, h1, h2 = momentum
        N[0, 4] += p2
        N[0, 5] -= p1
        N[1, 3] -= p2
        N[1, 5] += p0
        N[2, 3] += p1
        N[2, 4] -= p0
        N[3, 1] += p2
        N[3, 2] -= p1
        N[4, 0] -= p2
        N[4, 2] += p0
        N[5, 0] += p1
        N[5, 1] -= p0
        N[3, 4] += h2
        N[3, 5] -= h1
        N[4, 3] -= h2
        N[4, 5] += h0
        N[5, 3] += h1
        N[5, 4] -= h0
        for j in range(6):
            for i in range(6):
                C[6 * k + j, width + i - j] += N[i, j] + mass_turning[k, i, j]
                total = 0.0
                for a in range(6):
                    total += N[i, a] * A[a, j]
                K[6 * k + j, width + i - j] += total


@kernel
def project(
    nodes: Integers,
    fixed: Floats,
    axes: Floats,
    r0: Floats,
    q0: Floats,
    target: Floats,
    reaction: Floats,
    r: Floats,
    q: Floats,
    K: Floats,
    C: Floats,
    mass: Floats,
    G: Floats,
    Z: Floats,
) -> None:
    """Project the rows of supported nodes on their free directions, clear the held ones; write directions ``G, Z``.

    Reactions ``(m, 6)`` turn with their nodes: their derivative is subtracted from ``K`` first.
    """
    value = np.empty(6)
    psi = np.empty(3)
    old = np.empty(6)
    turned = np.empty((6, 6))
    width = (K.shape[1] - 1) // 2
    size = K.shape[0]
    for s in range(nodes.shape[0]):
        k = nodes[s]
        support_directions(axes[s], r0[s], q0[s], fixed[s], target[s], r[k], q[k], value, G[s], Z[s], psi)
        complete = True
        for i in range(6):
            if fixed[s, i] == 0.0:
                complete = False
        if complete:
            for i in range(6):
                for j in range(6):
                    G[s, i, j] = 1.0 if i == j else 0.0
        elif not in_body(axes[s]):
            reaction_stiffness(G[s], psi, reaction[s], turned)
            for i in range(6):
                for j in range(6):
                    K[6 * k + j, width + i - j] -= turned[i, j]
        for band in (K, C):
            for j in range(max(0, 6 * k - width), min(size, 6 * k + 6 + width)):
                for i in range(6):
                    place = width + 6 * k + i - j
                    old[i] = band[j, place] if 0 <= place <= 2 * width else 0.0
                for i in range(6):
                    place = width + 6 * k + i - j
                    if 0 <= place <= 2 * width:
                        total = 0.0
                        if fixed[s, i] == 0.0:
                            for a in range(6):
                                total += Z[s, a, i] * old[a]
                        band[j, place] = total
        for j in range(6):
            for i in range(6):
                old[i] = mass[k, i, j]
            for i in range(6):
                mass[k, i, j] = 0.0
                if fixed[s, i] == 0.0:
                    for a in range(6):
                        mass[k, i, j] += Z[s, a, i] * old[a]


@kernel
def combine(
    K: Floats,
    C: Floats,
    mass: Floats,
    mu: complex,
    nodes: Integers,
    fixed: Floats,
    G: Floats,
    columns: Floats,
    rows: Floats,
    out: Floats,
) -> None:
    """Write ``mu^2 M + mu C + K`` with held components as constraints into ``out`` (LAPACK layout), scaled.

    Args:
        mu: eigenvalue over the step [1/s], real or complex like ``out``.
        columns: scales of the unknowns ``(6 n,)`` (also of the balance rows); rows: output, scales of all rows.
    """
    width = (K.shape[1] - 1) // 2
    size = K.shape[0]
    for i in range(size):
        rows[i] = columns[i]
    for j in range(size):
        first, last = max(0, j - width), min(size, j + width + 1)
        for i in range(first, last):
            out[j, 2 * width + i - j] = (K[j, width + i - j] + mu * C[j, width + i - j]) * (
                columns[i] * columns[j]
            )
    square = mu * mu
    for k in range(mass.shape[0]):
        for j in range(6):
            for i in range(6):
                out[6 * k + j, 2 * width + i - j] += (
                    square * mass[k, i, j] * (columns[6 * k + i] * columns[6 * k + j])
                )
    for s in range(nodes.shape[0]):
        k = nodes[s]
        for half in (0, 3):
            # constraint rows as large as the balance rows, so that pivoting sees no difference in scale
            weight = 0.0
            for j in range(6 * k + half, 6 * k + half + 3):
                for i in range(max(0, j - width), min(size, j + width + 1)):
                    weight = max(weight, abs(out[j, 2 * width + i - j]))
            for i in range(half, half + 3):
                if fixed[s, i] == 0.0:
                    continue
                row = 6 * k + i
                largest = 0.0
                for j in range(6):
                    largest = max(largest, abs(G[s, i, j]) * columns[6 * k + j])
                rows[row] = (weight if weight > 0.0 else 1.0) / largest
                for j in range(6):
                    out[6 * k + j, 2 * width + row - 6 * k - j] = rows[row] * G[s, i, j] * columns[6 * k + j]
