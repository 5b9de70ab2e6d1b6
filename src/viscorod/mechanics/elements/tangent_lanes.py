"""Tangent of a batch of Gauss points, column by column of one node, then row by row of the nodes (see ``lanes``).

The columns of node j are six increments; each changes the strain (``B``), the strain rate at constant twist (``E``),
the section force (``A = C B + D (E + B T)`` with T the rate map) and the forces conjugate to the flat increments
(``F``: from A, and at constant section force from the second derivatives). The rows of node k are the map of nodal
forces applied to F, plus the effect of the rotation of the node's own frame if k = j.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.elements.lanes import (
    AT_FB,
    AT_FC,
    AT_FY,
    AT_P,
    AT_SHAPE,
    AT_SLOPE,
    AT_STRESS,
    AT_TWIST,
    AT_U,
    AT_V,
    AT_WEIGHT,
    AT_Z0,
    flat_rates,
    nodal_force,
    turned_vector,
)
from viscorod.mechanics.elements.variation import (
    Flat,
    conjugate_forces,
    first_variation,
    second_variation,
    turned_forces,
)
from viscorod.mechanics.rotations.vectors import (
    Vector,
    cross,
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

FLAT_ROWS = 11


@lane_kernel
def translation(node: Floats, maps: Floats, k: int, j: int, lane: int) -> Vector:
    """Return ``c`` of the unit translation j of a node."""
    return scaled(node[k, AT_SLOPE, lane], load(maps, 3 * k + j, 0, lane))


@lane_kernel
def rotation(node: Floats, maps: Floats, k: int, j: int, lane: int) -> Flat:
    """Return ``(0, y, b)`` of the unit rotation j of a node."""
    n, s = node[k, AT_SHAPE, lane], node[k, AT_SLOPE, lane]
    x0, x = load4(maps, 3 * k + j, 3, lane)
    return (0.0, 0.0, 0.0), (n * x0, scaled(n, x)), (s * x0, scaled(s, x))


@lane_kernel
def strain_columns(count: int, point: Floats, node: Floats, maps: Floats, k: int, B: Floats) -> None:
    """Write the strain per nodal increment into ``B`` (column, row, lane)."""
    for j in range(3):
        for lane in range(count):
            store(B, j, 0, lane, translation(node, maps, k, j, lane))
            store(B, j, 3, lane, (0.0, 0.0, 0.0))
        for lane in range(count):
            V, U, z0 = load(point, 0, AT_V, lane), load(point, 0, AT_U, lane), point[0, AT_Z0, lane]
            dV, dU = first_variation(V, U, z0, rotation(node, maps, k, j, lane))
            store(B, 3 + j, 0, lane, dV)
            store(B, 3 + j, 3, lane, dU)


@lane_kernel
def rate_columns(count: int, point: Floats, node: Floats, maps: Floats, k: int, E: Floats) -> None:
    """Write the strain rate per nodal increment at constant twist into ``E``.

    It contains the second derivatives, and the first ones of the nodal velocities ``R_k v`` and ``q_k w/2``, which turn
    with the node.
    """
    for j in range(3):
        for lane in range(count):
            _, (_, y), _ = flat_rates(point, lane)
            store(E, j, 0, lane, scaled(-2.0, cross(y, translation(node, maps, k, j, lane))))
            store(E, j, 3, lane, (0.0, 0.0, 0.0))
        for lane in range(count):
            V, U, z0 = load(point, 0, AT_V, lane), load(point, 0, AT_U, lane), point[0, AT_Z0, lane]
            n, s = node[k, AT_SHAPE, lane], node[k, AT_SLOPE, lane]
            turn = rotation(node, maps, k, j, lane)
            dV, dU = second_variation(V, U, z0, flat_rates(point, lane), turn)
            column = load(maps, 3 * k + j, 0, lane)
            c = scaled(s, cross(column, turned_vector(maps, k, lane, load(node, k, AT_TWIST, lane))))
            half = load4(maps, 3 * k + j, 3, lane)
            x0, x = product(half, (0.0, scaled(0.5, load(node, k, AT_TWIST + 3, lane))))
            eV, eU = first_variation(V, U, z0, (c, (n * x0, scaled(n, x)), (s * x0, scaled(s, x))))
            store(E, 3 + j, 0, lane, plus(dV, 1.0, eV))
            store(E, 3 + j, 3, lane, plus(dU, 1.0, eU))


@lane_kernel
def follow_twist(count: int, B: Floats, T: Floats, E: Floats) -> None:
    """Add ``B T`` to ``E``: the twist changes by T per increment."""
    for j in range(6):
        for lane in range(count):
            for i in range(6):
                total = 0.0
                for a in range(6):
                    if a >= 3 or i < 3:  # translations do not bend
                        total += B[a, i, lane] * T[j, a, lane]
                E[j, i, lane] += total


@lane_kernel
def section_columns(count: int, coupled: bool, C: Floats, X: Floats, first: bool, A: Floats) -> None:
    """Write ``A = C X`` if ``first``, else ``A += C X``, for six columns."""
    for j in range(6):
        for i in range(6):
            if first:
                for lane in range(count):
                    A[j, i, lane] = C[i, i, lane] * X[j, i, lane]
            else:
                for lane in range(count):
                    A[j, i, lane] += C[i, i, lane] * X[j, i, lane]
        if coupled:
            for i in range(6):
                for a in range(6):
                    if a != i:
                        for lane in range(count):
                            A[j, i, lane] += C[i, a, lane] * X[j, a, lane]


@lane_kernel
def force_columns(count: int, point: Floats, A: Floats, F: Floats) -> None:
    """Write the weighted conjugate forces ``F`` (column, FLAT_ROWS, lane) of the section forces in ``A``."""
    for j in range(6):
        for lane in range(count):
            weight = point[0, AT_WEIGHT, lane]
            Fc, Fy, Fb = conjugate_forces(
                load(point, 0, AT_V, lane),
                load(point, 0, AT_U, lane),
                point[0, AT_Z0, lane],
                scaled(weight, load(A, j, 0, lane)),
                scaled(weight, load(A, j, 3, lane)),
            )
            store(F, j, 0, lane, Fc)
            store4(F, j, 3, lane, Fy)
            store4(F, j, 7, lane, Fb)


@lane_kernel
def add_turned_forces(count: int, point: Floats, node: Floats, maps: Floats, k: int, F: Floats) -> None:
    """Add the change of the conjugate forces of the (weighted) stress iterate: the geometric stiffness."""
    for j in range(3):
        for lane in range(count):
            c, N = translation(node, maps, k, j, lane), load(point, 0, AT_STRESS, lane)
            store(F, j, 4, lane, plus(load(F, j, 4, lane), 2.0, cross(N, c)))
        for lane in range(count):
            V, U, z0 = load(point, 0, AT_V, lane), load(point, 0, AT_U, lane), point[0, AT_Z0, lane]
            N, M = load(point, 0, AT_STRESS, lane), load(point, 0, AT_STRESS + 3, lane)
            Fc, (y0, y), (b0, b) = turned_forces(V, U, z0, N, M, rotation(node, maps, k, j, lane))
            store(F, 3 + j, 0, lane, plus(load(F, 3 + j, 0, lane), 1.0, Fc))
            F[3 + j, 3, lane] += y0
            store(F, 3 + j, 4, lane, plus(load(F, 3 + j, 4, lane), 1.0, y))
            F[3 + j, 7, lane] += b0
            store(F, 3 + j, 8, lane, plus(load(F, 3 + j, 8, lane), 1.0, b))


@lane_kernel
def conjugate_stress(count: int, point: Floats) -> None:
    """Replace the conjugate forces of the section force by those of the (weighted) stress iterate."""
    for lane in range(count):
        Fc, Fy, Fb = conjugate_forces(
            load(point, 0, AT_V, lane),
            load(point, 0, AT_U, lane),
            point[0, AT_Z0, lane],
            load(point, 0, AT_STRESS, lane),
            load(point, 0, AT_STRESS + 3, lane),
        )
        store(point, 0, AT_FC, lane, Fc)
        store4(point, 0, AT_FY, lane, Fy)
        store4(point, 0, AT_FB, lane, Fb)


@lane_kernel
def block_of(count: int, node: Floats, maps: Floats, k: int, F: Floats, block: Floats) -> None:
    """Write the forces on one node per increment of another: ``block`` (column, row, lane) from that one's ``F``."""
    for j in range(6):
        for lane in range(count):
            force, moment = nodal_force(
                node, maps, k, lane, load(F, j, 0, lane), load4(F, j, 3, lane), load4(F, j, 7, lane)
            )
            store(block, j, 0, lane, force)
            store(block, j, 3, lane, moment)


@lane_kernel
def add_frame_rotation(count: int, point: Floats, node: Floats, maps: Floats, k: int, block: Floats) -> None:
    """Add the change of a node's own forces (f, m) of the stress iterate by the rotation of its frame.

    ``f x theta`` and ``m x theta/2 - (g.p) theta/4``: L theta = p (0, theta)/2 turns through ``p (0, theta)/2``.
    """
    for lane in range(count):
        Fc, Fy, Fb = load(point, 0, AT_FC, lane), load4(point, 0, AT_FY, lane), load4(point, 0, AT_FB, lane)
        f, m = nodal_force(node, maps, k, lane, Fc, Fy, Fb)
        n, s = node[k, AT_SHAPE, lane], node[k, AT_SLOPE, lane]
        p0, p = load4(node, k, AT_P, lane)
        along = 0.25 * (n * (Fy[0] * p0 + dot(Fy[1], p)) + s * dot(Fb[1], p))
        block[3, 1, lane] += f[2]
        block[3, 2, lane] -= f[1]
        block[4, 0, lane] -= f[2]
        block[4, 2, lane] += f[0]
        block[5, 0, lane] += f[1]
        block[5, 1, lane] -= f[0]
        block[3, 3, lane] -= along
        block[3, 4, lane] += 0.5 * m[2]
        block[3, 5, lane] -= 0.5 * m[1]
        block[4, 3, lane] -= 0.5 * m[2]
        block[4, 4, lane] -= along
        block[4, 5, lane] += 0.5 * m[0]
        block[5, 3, lane] += 0.5 * m[1]
        block[5, 4, lane] -= 0.5 * m[0]
        block[5, 5, lane] -= along
