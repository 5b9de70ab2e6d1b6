"""External loads: dead and following wrenches at nodes, gravity, and wrenches at any point of an element."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.strain import element_poses, gauss_point, half_products
from viscorod.mechanics.nodes.attached_poses import ElementNodes, PointWrench, link_map, map_columns, map_rows
from viscorod.mechanics.rotations.rotation import add_skew, rotate_back, rotation_matrix
from viscorod.typing import Floats, Integers


@part
def add_levers(lever: Floats, q: Floats, with_tangent: bool, external: Floats, block: Floats) -> None:
    """Add the moment of dead forces at arms to ``external (6,)``, and its derivative, negative, to ``block (6, 6)``.

    Args:
        lever: sum of arms (body axes) times forces (global axes) ``(3, 3)`` [N m]; q: quaternion of the node.
    """
    R = np.empty((3, 3))
    N = np.empty((3, 3))  # arms times forces in body axes
    rotation_matrix(q, R)
    for b in range(3):
        for c in range(3):
            N[b, c] = lever[b, 0] * R[0, c] + lever[b, 1] * R[1, c] + lever[b, 2] * R[2, c]
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        external[3 + a] += N[b, c] - N[c, b]
        if with_tangent:
            # forces turn back in body axes, N[b] x theta
            block[3 + a, 3 + a] += N[b, b] + N[c, c]
            block[3 + a, 3 + b] -= N[b, a]
            block[3 + a, 3 + c] -= N[c, a]


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
    f = np.empty(3)
    m = np.empty(3)
    g = np.empty(3)
    block = np.empty((6, 6))
    heavy = gravity[0] != 0.0 or gravity[1] != 0.0 or gravity[2] != 0.0
    for k in nodes:
        rotate_back(q[k], dead[k, 0:3], f)
        rotate_back(q[k], dead[k, 3:6], m)
        for i in range(3):
            external[k, i] += f[i] + following[k, i]
            external[k, 3 + i] += m[i] + following[k, 3 + i]
        if with_tangent:
            block[:, :] = 0.0
            add_skew(f, -1.0, block[0:3, 3:6])
            add_skew(m, -1.0, block[3:6, 3:6])
        if levers.shape[0] > 0:
            add_levers(levers[k], q[k], with_tangent, external[k], block)
        if heavy:
            rotate_back(q[k], gravity, g)
            for i in range(6):
                external[k, i] += mass[k, i, 0] * g[0] + mass[k, i, 1] * g[1] + mass[k, i, 2] * g[2]
                if with_tangent:
                    block[i, 3] -= mass[k, i, 1] * g[2] - mass[k, i, 2] * g[1]
                    block[i, 4] -= mass[k, i, 2] * g[0] - mass[k, i, 0] * g[2]
                    block[i, 5] -= mass[k, i, 0] * g[1] - mass[k, i, 1] * g[0]
        if with_tangent:
            for j in range(3, 6):
                for i in range(6):
                    blocks[diagonal[k], j, i] += block[i, j]


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
) -> None:
    """Add one concentrated wrench inside an element to ``external`` and subtract its derivative from the matrix.

    The nodal forces are work-conjugate to the interpolated displacement and to the body rotation of the interpolated
    frame, ``sum N_k A_k theta_k`` with ``A_k = 2 L_k`` (vector rows, see ``strain``); ``slots (m, m)`` are those of the
    element.
    """
    nodes, links, link_positions, link_quaternions = own
    shape, dead, following = load
    n = nodes.shape[0]
    re = np.empty((n, 3))
    qe = np.empty((n, 4))
    p = np.empty((n, 4))
    frame = np.empty(4)
    V = np.empty(3)
    U = np.empty(3)
    slope = np.zeros(n)
    Q = np.empty((n, 3, 3))
    L = np.empty((n, 4, 3))
    f = np.empty((n, 6))
    X = np.empty((n, 6, 6))
    element_poses(nodes, links, link_positions, link_quaternions, r, q, re, qe)
    gauss_point(shape, slope, re, qe, V, U, p, frame)
    md = np.empty(3)
    F = np.empty(3)
    rotate_back(frame, dead[0:3], F)
    rotate_back(frame, dead[3:6], md)
    m = np.empty(3)
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
    if not with_tangent:
        return
    block = np.empty((6, 6))
    K = block[:, 3:6]
    y = np.empty(4)
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
                for a in range(4):
                    y[a] = shape[j] * L[j, a, i]
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
