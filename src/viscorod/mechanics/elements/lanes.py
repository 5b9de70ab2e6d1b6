"""Gauss points in lanes: every number of a formula is a row of LANES Gauss points, so that loops vectorise.

A batch has an array ``point`` with the rows below, an array ``node`` with rows for each of the m element nodes, and
the section matrices of its points. Loops run over lanes innermost; none of them branches. The map of node k from its
body increments ``(a, theta)`` to the flat increments of the point (see ``strain``) is kept as three directions:
``c = s Q a``, ``y = n L theta``, ``b = s L theta`` with the columns of ``Q = R^T R_k`` and of ``L``,
``L theta = p (0, theta)/2``, and ``n, s`` the basis function and its slope. Forces use the same map backwards.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.elements.variation import (
    Flat,
    conjugate_forces,
    first_variation,
    strain_measures,
)
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    dot,
    load,
    load4,
    plus,
    product,
    scaled,
    store,
    store4,
)
from viscorod.typing import Floats

LANES = 16
"""With fewer, the compiler finds the check that arrays do not overlap too expensive; more exceed the L1 cache."""
REGISTER = 8
"""Lanes of the widest vector registers, a power of two; :data:`LANES` is a multiple of it."""

# rows of ``point`` (1, rows, LANES): r', q~, q~'; V, U, z0, conj(q~)/|q~|^2; flat rates; strain, rate, section force,
# stress iterate (weighted), weight; forces conjugate to (c, y, b)
AT_T, AT_F, AT_G = 0, 3, 7
AT_V, AT_U, AT_Z0, AT_INVERSE = 11, 14, 17, 18
AT_C, AT_Y, AT_B = 22, 25, 29
AT_STRAIN, AT_RATE, AT_FORCE, AT_STRESS, AT_WEIGHT = 33, 39, 45, 51, 57
AT_FC, AT_FY, AT_FB = 58, 61, 65
POINT_ROWS = 69

# rows of ``node[k]``: position, quaternion, twist; n and s; p = conj(q~) q_k/|q~|^2
AT_R, AT_Q, AT_TWIST, AT_SHAPE, AT_SLOPE, AT_P = 0, 3, 7, 13, 14, 15
NODE_ROWS = 19
# rows of ``maps[3 k + j]``: column j of Q and of L of node k
MAP_ROWS = 7


@lane_kernel
def interpolate(count: int, point: Floats, node: Floats, maps: Floats) -> None:
    """Evaluate the strains V, U of all lanes and the maps of all nodes."""
    for i in range(AT_V):
        for lane in range(count):
            point[0, i, lane] = 0.0
    for k in range(node.shape[0]):
        for lane in range(count):
            n, s = node[k, AT_SHAPE, lane], node[k, AT_SLOPE, lane]
            # slopes sum to zero: differences to the first node lose no digits far from the origin
            for i in range(3):
                point[0, AT_T + i, lane] += s * (node[k, AT_R + i, lane] - node[0, AT_R + i, lane])
            for i in range(4):
                point[0, AT_F + i, lane] += n * node[k, AT_Q + i, lane]
                point[0, AT_G + i, lane] += s * (node[k, AT_Q + i, lane] - node[0, AT_Q + i, lane])
    for lane in range(count):
        V, U, z0, inverse = strain_measures(
            load(point, 0, AT_T, lane), load4(point, 0, AT_F, lane), load4(point, 0, AT_G, lane)
        )
        store(point, 0, AT_V, lane, V)
        store(point, 0, AT_U, lane, U)
        point[0, AT_Z0, lane] = z0
        store4(point, 0, AT_INVERSE, lane, inverse)
    for k in range(node.shape[0]):
        for lane in range(count):
            p = product(load4(point, 0, AT_INVERSE, lane), load4(node, k, AT_Q, lane))
            store4(node, k, AT_P, lane, p)
            p0, (p1, p2, p3) = p
            n2 = 2.0 / (p0 * p0 + p1 * p1 + p2 * p2 + p3 * p3)
            xx, yy, zz = n2 * p1 * p1, n2 * p2 * p2, n2 * p3 * p3
            xy, xz, yz = n2 * p1 * p2, n2 * p1 * p3, n2 * p2 * p3
            wx, wy, wz = n2 * p0 * p1, n2 * p0 * p2, n2 * p0 * p3
            store(maps, 3 * k, 0, lane, (1.0 - yy - zz, xy + wz, xz - wy))
            store(maps, 3 * k + 1, 0, lane, (xy - wz, 1.0 - xx - zz, yz + wx))
            store(maps, 3 * k + 2, 0, lane, (xz + wy, yz - wx, 1.0 - xx - yy))
            store4(maps, 3 * k, 3, lane, (-0.5 * p1, (0.5 * p0, 0.5 * p3, -0.5 * p2)))
            store4(maps, 3 * k + 1, 3, lane, (-0.5 * p2, (-0.5 * p3, 0.5 * p0, 0.5 * p1)))
            store4(maps, 3 * k + 2, 3, lane, (-0.5 * p3, (0.5 * p2, -0.5 * p1, 0.5 * p0)))


@lane_kernel
def turned_vector(maps: Floats, k: int, lane: int, a: Vector) -> Vector:
    """Return ``Q a`` of one node in one lane."""
    first = scaled(a[0], load(maps, 3 * k, 0, lane))
    return plus(plus(first, a[1], load(maps, 3 * k + 1, 0, lane)), a[2], load(maps, 3 * k + 2, 0, lane))


@lane_kernel
def nodal_force(
    node: Floats, maps: Floats, k: int, lane: int, Fc: Vector, Fy: Quaternion, Fb: Quaternion
) -> tuple[Vector, Vector]:
    """Return force and moment ``(s Q^T Fc, L^T (n Fy + s Fb))`` on a node from the forces conjugate to (c, y, b)."""
    n, s = node[k, AT_SHAPE, lane], node[k, AT_SLOPE, lane]
    f = scaled(s, Fc)
    g0 = n * Fy[0] + s * Fb[0]
    g = plus(scaled(n, Fy[1]), s, Fb[1])
    one, two, three = 3 * k, 3 * k + 1, 3 * k + 2
    force = (
        dot(load(maps, one, 0, lane), f),
        dot(load(maps, two, 0, lane), f),
        dot(load(maps, three, 0, lane), f),
    )
    moment = (
        maps[one, 3, lane] * g0 + dot(load(maps, one, 4, lane), g),
        maps[two, 3, lane] * g0 + dot(load(maps, two, 4, lane), g),
        maps[three, 3, lane] * g0 + dot(load(maps, three, 4, lane), g),
    )
    return force, moment


@lane_kernel
def rates(count: int, point: Floats, node: Floats, maps: Floats) -> None:
    """Sum the flat rates (c, y, b) of the nodal twists, and evaluate the strain rate."""
    for i in range(AT_C, AT_STRAIN):
        for lane in range(count):
            point[0, i, lane] = 0.0
    for k in range(node.shape[0]):
        for lane in range(count):
            n, s = node[k, AT_SHAPE, lane], node[k, AT_SLOPE, lane]
            c = turned_vector(maps, k, lane, load(node, k, AT_TWIST, lane))
            x0, x = product(load4(node, k, AT_P, lane), (0.0, load(node, k, AT_TWIST + 3, lane)))
            store(point, 0, AT_C, lane, plus(load(point, 0, AT_C, lane), s, c))
            point[0, AT_Y, lane] += 0.5 * n * x0
            store(point, 0, AT_Y + 1, lane, plus(load(point, 0, AT_Y + 1, lane), 0.5 * n, x))
            point[0, AT_B, lane] += 0.5 * s * x0
            store(point, 0, AT_B + 1, lane, plus(load(point, 0, AT_B + 1, lane), 0.5 * s, x))
    for lane in range(count):
        V_rate, U_rate = first_variation(
            load(point, 0, AT_V, lane),
            load(point, 0, AT_U, lane),
            point[0, AT_Z0, lane],
            flat_rates(point, lane),
        )
        store(point, 0, AT_RATE, lane, V_rate)
        store(point, 0, AT_RATE + 3, lane, U_rate)


@lane_kernel
def flat_rates(point: Floats, lane: int) -> Flat:
    """Return the flat rates that :func:`rates` has summed."""
    return load(point, 0, AT_C, lane), load4(point, 0, AT_Y, lane), load4(point, 0, AT_B, lane)


@lane_kernel
def section_forces(count: int, coupled: bool, viscous: bool, C: Floats, D: Floats, point: Floats) -> None:
    """Evaluate ``S = C eps + D eps_t``; on entry the rows of ``AT_STRAIN`` hold minus the reference strain."""
    for i in range(6):
        for lane in range(count):
            point[0, AT_STRAIN + i, lane] += point[0, AT_V + i, lane]
        for lane in range(count):
            point[0, AT_FORCE + i, lane] = C[i, i, lane] * point[0, AT_STRAIN + i, lane]
        if viscous:
            for lane in range(count):
                point[0, AT_FORCE + i, lane] += D[i, i, lane] * point[0, AT_RATE + i, lane]
        else:
            for lane in range(count):
                point[0, AT_RATE + i, lane] = 0.0
    if coupled:
        for i in range(6):
            for j in range(6):
                if j != i:
                    for lane in range(count):
                        point[0, AT_FORCE + i, lane] += C[i, j, lane] * point[0, AT_STRAIN + j, lane]
                    if viscous:
                        for lane in range(count):
                            point[0, AT_FORCE + i, lane] += D[i, j, lane] * point[0, AT_RATE + j, lane]


@lane_kernel
def conjugate_section_forces(count: int, point: Floats) -> None:
    """Evaluate the weighted conjugate forces of the section forces."""
    for lane in range(count):
        weight = point[0, AT_WEIGHT, lane]
        Fc, Fy, Fb = conjugate_forces(
            load(point, 0, AT_V, lane),
            load(point, 0, AT_U, lane),
            point[0, AT_Z0, lane],
            scaled(weight, load(point, 0, AT_FORCE, lane)),
            scaled(weight, load(point, 0, AT_FORCE + 3, lane)),
        )
        store(point, 0, AT_FC, lane, Fc)
        store4(point, 0, AT_FY, lane, Fy)
        store4(point, 0, AT_FB, lane, Fb)


@lane_kernel
def forces_on(count: int, point: Floats, node: Floats, maps: Floats, k: int, out: Floats) -> None:
    """Write force and moment of the section forces on one node into ``out`` (6, LANES)."""
    for lane in range(count):
        force, moment = nodal_force(
            node,
            maps,
            k,
            lane,
            load(point, 0, AT_FC, lane),
            load4(point, 0, AT_FY, lane),
            load4(point, 0, AT_FB, lane),
        )
        store(out, 0, 0, lane, force)
        store(out, 0, 3, lane, moment)
