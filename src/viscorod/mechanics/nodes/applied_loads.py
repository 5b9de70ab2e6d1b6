"""External loads: dead and following wrenches at nodes, gravity, and wrenches at any point of an element."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.strain import element_poses, gauss_point, half_products
from viscorod.mechanics.nodes.attached_poses import ElementNodes, PointWrench, link_map, map_columns, map_rows
from viscorod.mechanics.rotations.rotation import add_skew, rotate_back, rotation_matrix
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    quaternion,
    rotated_back,
    stage_vector,
    vector,
)
from viscorod.typing import Floats, Integers


@part
def add_turning(f: Vector, row: int, slot: int, blocks: Floats) -> None:
    """Subtract the derivative ``[f]x`` of a vector that stays in space, from three rows of a block, body axes."""
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        blocks[slot, 3 + b, row + a] += f[c]
        blocks[slot, 3 + c, row + a] -= f[b]


@part
def add_levers(
    levers: Floats, k: int, turn: Quaternion, with_tangent: bool, external: Floats, blocks: Floats, slot: int
) -> None:
    """Add the moment of dead forces at arms to ``external (n, 6)``, and subtract its derivative from a block.

    Args:
        levers: sums of arms (body axes) times forces (global axes) ``(n, 3, 3)`` [N m]; k, turn: the node.
    """
    # arms times forces in body axes
    N = (
        rotated_back(turn, stage_vector(levers, k, 0, 0)),
        rotated_back(turn, stage_vector(levers, k, 1, 0)),
        rotated_back(turn, stage_vector(levers, k, 2, 0)),
    )
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        external[k, 3 + a] += N[b][c] - N[c][b]
        if with_tangent:
            # forces turn back in body axes, N[b] x theta
            blocks[slot, 3 + a, 3 + a] += N[b][b] + N[c][c]
            blocks[slot, 3 + b, 3 + a] -= N[b][a]
            blocks[slot, 3 + c, 3 + a] -= N[c][a]


@kernel
def add_nodal_loads(
    nodes: Integers,
    q: Floats,
    dead: Floats,
    following: Floats,
    gravity: Floats,
    levers: Floats,
    mass: Floats,
    with_tangent: bool,
    external: Floats,
    blocks: Floats,
    diagonal: Integers,
) -> None:
    """Add nodal loads to ``external`` and subtract their derivative from the matrix.

    Args:
        nodes: the loaded nodes.
        q: unit quaternions of all nodes.
        dead: wrenches in global axes ``(n, 6)`` [N, N m]; following: in body axes ``(n, 6)``.
        gravity: acceleration, global axes [m/s^2], acting on the nodal ``mass`` ``(n, 6, 6)``, off-centre mass
            included.
        levers: sums of arms (body axes) times dead forces that act there (global axes) ``(n, 3, 3)`` [N m], or no rows.
        external: ``(n, 6)``, body components, added to.
        blocks: of the matrix ``(b, 6, 6)`` (see ``geometric_element.assemble``); diagonal: those of the nodes ``(n,)``.
    """
    heavy = gravity[0] != 0.0 or gravity[1] != 0.0 or gravity[2] != 0.0
    for k in nodes:
        turn, slot = quaternion(q, k), diagonal[k]
        f, m = rotated_back(turn, vector(dead, k, 0)), rotated_back(turn, vector(dead, k, 3))
        for i in range(3):
            external[k, i] += f[i] + following[k, i]
            external[k, 3 + i] += m[i] + following[k, 3 + i]
        if with_tangent:
            add_turning(f, 0, slot, blocks)
            add_turning(m, 3, slot, blocks)
        if levers.shape[0] > 0:
            add_levers(levers, k, turn, with_tangent, external, blocks, slot)
        if heavy:
            g0, g1, g2 = rotated_back(turn, (gravity[0], gravity[1], gravity[2]))
            for i in range(6):
                external[k, i] += mass[k, i, 0] * g0 + mass[k, i, 1] * g1 + mass[k, i, 2] * g2
                if with_tangent:
                    blocks[slot, 3, i] -= mass[k, i, 1] * g2 - mass[k, i, 2] * g1
                    blocks[slot, 4, i] -= mass[k, i, 2] * g0 - mass[k, i, 0] * g2
                    blocks[slot, 5, i] -= mass[k, i, 0] * g1 - mass[k, i, 1] * g0


class StationWork(NamedTuple):
    """Scratch of a wrench inside an element of at most ``m`` nodes: poses, products of quaternions, nodal forces, maps.

    The rest are vectors and one block.
    """

    r: Floats
    q: Floats
    p: Floats
    Q: Floats
    L: Floats
    f: Floats
    X: Floats
    slope: Floats
    frame: Floats
    wrench: Floats
    block: Floats

    @classmethod
    def of(cls, m: int) -> StationWork:
        """Allocate for ``m`` nodes."""
        r, q, p, f = np.zeros((m, 3)), np.zeros((m, 4)), np.zeros((m, 4)), np.zeros((m, 6))
        Q, L, X = np.zeros((m, 3, 3)), np.zeros((m, 4, 3)), np.zeros((m, 6, 6))
        return cls(r, q, p, Q, L, f, X, np.zeros(m), np.zeros(4), np.zeros((5, 3)), np.zeros((6, 6)))


@kernel
def add_station_load(
    own: ElementNodes,
    load: PointWrench,
    r: Floats,
    q: Floats,
    with_tangent: bool,
    external: Floats,
    blocks: Floats,
    slots: Integers,
    work: StationWork,
) -> None:
    """Add one concentrated wrench inside an element to ``external`` and subtract its derivative from the matrix.

    The nodal forces are work-conjugate to the interpolated displacement and to the body rotation of the interpolated
    frame, ``sum N_k A_k theta_k`` with ``A_k = 2 L_k`` (vector rows, see ``strain``); ``slots (m, m)`` are those of the
    element.
    """
    nodes, links, link_positions, link_quaternions = own
    shape, dead, following = load
    n = nodes.shape[0]
    re, qe, p = work.r[:n], work.q[:n], work.p[:n]
    Q, L, f, X, slope, frame = work.Q, work.L, work.f, work.X, work.slope[:n], work.frame
    F, m, md, V, U = work.wrench[0], work.wrench[1], work.wrench[2], work.wrench[3], work.wrench[4]
    element_poses(nodes, links, link_positions, link_quaternions, r, q, re, qe)
    gauss_point(shape, slope, re, qe, V, U, p, frame)
    rotate_back(frame, dead[0:3], F)
    rotate_back(frame, dead[3:6], md)
    for i in range(3):
        F[i] += following[i]
        m[i] = md[i] + following[3 + i]
    for k in range(n):
        rotation_matrix(p[k], Q[k])
        half_products(p[k], L[k])
        for i in range(3):
            f[k, i] = shape[k] * (Q[k, 0, i] * F[0] + Q[k, 1, i] * F[1] + Q[k, 2, i] * F[2])
            f[k, 3 + i] = 2.0 * shape[k] * (L[k, 1, i] * m[0] + L[k, 2, i] * m[1] + L[k, 3, i] * m[2])
        if links[k] >= 0:
            link_map(link_positions[links[k]], link_quaternions[links[k]], X[k])
        for i in range(6):
            if links[k] >= 0:
                for a in range(6):
                    external[nodes[k], i] += X[k, a, i] * f[k, a]
            else:
                external[nodes[k], i] += f[k, i]
    if with_tangent:
        add_station_tangent(load, md, m, links, blocks, slots, work)


@part
def add_station_tangent(
    load: PointWrench,
    md: Floats,
    m: Floats,
    links: Integers,
    blocks: Floats,
    slots: Integers,
    work: StationWork,
) -> None:
    """Subtract the derivative; ``md`` and ``m (3,)`` are the dead moment and the whole one in the section's axes."""
    shape, following = load.shape, load.following
    p, Q, L, f, X, block = work.p, work.Q, work.L, work.f, work.X, work.block
    K, n = block[:, 3:6], shape.shape[0]
    for k in range(n):
        for j in range(n):
            block[:, :] = 0.0
            if j == k:
                add_skew(f[k, 0:3], 1.0, K[0:3, :])
                add_skew(f[k, 3:6], 0.5, K[3:6, :])
                trace = 0.5 * shape[k] * (m[0] * p[k, 1] + m[1] * p[k, 2] + m[2] * p[k, 3])
                for i in range(3):
                    K[3 + i, i] -= trace
            for i in range(3):
                y = shape[j] * L[j, 0, i], shape[j] * L[j, 1, i], shape[j] * L[j, 2, i], shape[j] * L[j, 3, i]
                dot = m[0] * y[1] + m[1] * y[2] + m[2] * y[3]
                for a in range(3):
                    b, c = (a + 1) % 3, (a + 2) % 3
                    turned = 2.0 * (following[c] * y[1 + b] - following[b] * y[1 + c])
                    couple = -2.0 * (m[a] * y[0] + m[b] * y[1 + c] - m[c] * y[1 + b])
                    couple += 4.0 * (md[b] * y[1 + c] - md[c] * y[1 + b])
                    for row in range(3):
                        K[row, i] += shape[k] * Q[k, a, row] * turned
                        K[3 + row, i] += shape[k] * L[k, 1 + a, row] * couple
                for row in range(3):
                    K[3 + row, i] -= 2.0 * shape[k] * L[k, 0, row] * dot
            if links[j] >= 0:
                map_columns(block, 0, X[j])
            if links[k] >= 0:
                map_rows(block, 0, X[k])
            for i in range(6):
                for row in range(6):
                    blocks[slots[k, j], i, row] -= block[row, i]
