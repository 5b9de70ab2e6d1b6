"""The frozen Jacobian of a collocation step: its matrices from an assembly, and the two that are factorised."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.nodes.support_rows import (
    Directions,
    SupportedNodes,
    in_body,
    subtract_reaction_stiffness,
    support_directions,
)
from viscorod.solve.linear.pattern import Pattern
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
    mass: Floats,
    twist: Floats,
    ad: Floats,
    K: Floats,
    C: Floats,
    diagonal: Integers,
    mass_ad: Floats,
    N: Floats,
) -> None:
    """Add the inertial parts of the Jacobian: ``C += N + M ad(x)`` and ``K += N ad(x)`` with ``N = d(L1 M x)/dx``.

    Args:
        mass: ``(n, 6, 6)``; ad: ``ad(x)`` of every node.
        K, C: blocks ``(b, 6, 6)``; diagonal: those of the nodes ``(n,)``.
        mass_ad: output ``M ad(x)``; N: scratch ``(6, 6)``.
    """
    for k in range(mass.shape[0]):
        M, A = mass[k], ad[k]
        p0 = p1 = p2 = h0 = h1 = h2 = 0.0  # the momentum
        for j in range(6):
            p0, p1, p2 = p0 + M[0, j] * twist[k, j], p1 + M[1, j] * twist[k, j], p2 + M[2, j] * twist[k, j]
            h0, h1, h2 = h0 + M[3, j] * twist[k, j], h1 + M[4, j] * twist[k, j], h2 + M[5, j] * twist[k, j]
        for i in range(6):
            for j in range(6):
                mass_ad[k, i, j] = 0.0
                N[i, j] = 0.0
                for a in range(6):
                    mass_ad[k, i, j] += M[i, a] * A[a, j]
                    # L1(x) = -ad(x)^T
                    N[i, j] -= A[a, i] * M[a, j]
        # derivative of L1(x) at constant momentum: -[p~] and -[h~]
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
        slot = diagonal[k]
        for j in range(6):
            for i in range(6):
                C[slot, j, i] += N[i, j] + mass_ad[k, i, j]
                total = 0.0
                for a in range(6):
                    total += N[i, a] * A[a, j]
                K[slot, j, i] += total


@part
def project_rows(
    s: int,
    supports: SupportedNodes,
    directions: Directions,
    starts: Integers,
    across: Integers,
    blocks: Floats,
    old: Floats,
) -> None:
    """Project the rows of the node that support ``s`` holds on its free directions; ``old (6,)`` is scratch."""
    k, fixed, Z = supports.nodes[s], supports.fixed, directions.Z
    for transposed in range(starts[k], starts[k + 1]):
        slot = across[transposed]
        for j in range(6):
            for i in range(6):
                old[i] = blocks[slot, j, i]
            for i in range(6):
                blocks[slot, j, i] = 0.0
                if fixed[s, i] == 0.0:
                    for a in range(6):
                        blocks[slot, j, i] += Z[s, a, i] * old[a]


@kernel
def project_blocks(
    supports: SupportedNodes,
    directions: Directions,
    starts: Integers,
    across: Integers,
    blocks: Floats,
    old: Floats,
) -> None:
    """Do what :func:`project` does to the matrices to one more, real or complex, with its ``directions``."""
    for s in range(supports.nodes.shape[0]):
        project_rows(s, supports, directions, starts, across, blocks, old)


@kernel
def project(
    supports: SupportedNodes,
    target: Floats,
    reaction: Floats,
    r: Floats,
    q: Floats,
    pattern: Pattern,
    K: Floats,
    C: Floats,
    mass: Floats,
    directions: Directions,
    old: Floats,
) -> None:
    """Project the rows of supported nodes on their free directions, clear the held ones; write the ``directions``.

    Reactions ``(m, 6)`` turn with their nodes: their derivative is subtracted from ``K``. ``old (6,)`` is scratch.
    """
    nodes, fixed, axes = supports[:3]
    starts, across, diagonal = pattern.starts, pattern.across, pattern.diagonal
    G, Z = directions.G, directions.Z
    for s in range(nodes.shape[0]):
        k = nodes[s]
        support_directions(supports, s, target, r, q, s, directions)
        complete = True
        for i in range(6):
            if fixed[s, i] == 0.0:
                complete = False
        if complete:
            for i in range(6):
                for j in range(6):
                    G[s, i, j] = 1.0 if i == j else 0.0
        elif not in_body(axes[s]):
            subtract_reaction_stiffness(s, directions, reaction, diagonal[k], K)
        project_rows(s, supports, directions, starts, across, K, old)
        project_rows(s, supports, directions, starts, across, C, old)
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
    supports: SupportedNodes,
    directions: Directions,
    pattern: Pattern,
    scales: Floats,
    row_scales: Floats,
    out: Floats,
) -> None:
    """Write ``mu^2 M + mu C + K`` with held components as constraints into the blocks ``out``, scaled.

    Args:
        mu: eigenvalue over the step [1/s], real or complex like ``out``.
        pattern: with N block rows.
        scales: of the unknowns ``(6 N,)`` (also of the balance rows); row_scales: output, those of all rows.
    """
    nodes, fixed, G = supports.nodes, supports.fixed, directions.G
    block_rows, block_columns, starts, diagonal = (
        pattern.rows,
        pattern.columns,
        pattern.starts,
        pattern.diagonal,
    )
    for i in range(scales.shape[0]):
        row_scales[i] = scales[i]
    for s in range(out.shape[0]):
        row, column = 6 * block_rows[s], 6 * block_columns[s]
        for j in range(6):
            for i in range(6):
                out[s, j, i] = (K[s, j, i] + mu * C[s, j, i]) * (scales[row + i] * scales[column + j])
    square = mu * mu
    for k in range(mass.shape[0]):
        slot = diagonal[k]
        for j in range(6):
            for i in range(6):
                out[slot, j, i] += square * mass[k, i, j] * (scales[6 * k + i] * scales[6 * k + j])
    for m in range(nodes.shape[0]):
        k = nodes[m]
        for half in (0, 3):
            # constraint rows as large as the balance rows, so that pivoting sees no difference in scale
            weight = 0.0
            for s in range(starts[k], starts[k + 1]):
                for j in range(half, half + 3):
                    for i in range(6):
                        weight = max(weight, abs(out[s, j, i]))
            for i in range(half, half + 3):
                if fixed[m, i] == 0.0:
                    continue
                row = 6 * k + i
                largest = 0.0
                for j in range(6):
                    largest = max(largest, abs(G[m, i, j]) * scales[6 * k + j])
                row_scales[row] = (weight if weight > 0.0 else 1.0) / largest
                for j in range(6):
                    out[diagonal[k], j, i] = row_scales[row] * G[m, i, j] * scales[6 * k + j]
