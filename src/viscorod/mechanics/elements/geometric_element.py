"""Forces and tangents of geometric elements: one pass over the Gauss points of all elements of one order.

The element is described in ``strain``; here its section forces are turned into nodal forces, and their derivative is
assembled into the blocks of a matrix. Gauss points are taken in batches of LANES, so that the formulas of ``lanes``
and ``tangent_lanes`` run on whole vector registers; only the functions of ``gathering`` go point by point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, lane_kernel
from viscorod.mechanics.elements.gathering import (
    add_blocks,
    add_forces,
    gather_nodes,
    gather_rate_maps,
    gather_sections,
)
from viscorod.mechanics.elements.lanes import (
    AT_FORCE,
    AT_RATE,
    AT_SHAPE,
    AT_SLOPE,
    AT_STRAIN,
    AT_STRESS,
    AT_WEIGHT,
    LANES,
    MAP_ROWS,
    NODE_ROWS,
    POINT_ROWS,
    conjugate_section_forces,
    forces_on,
    interpolate,
    rates,
    section_forces,
)
from viscorod.mechanics.elements.section_laws import SectionLaws, add_lane_laws, stored_and_lost
from viscorod.mechanics.elements.strain import element_poses, gauss_point
from viscorod.mechanics.elements.tangent_lanes import (
    FLAT_ROWS,
    add_frame_rotation,
    add_turned_forces,
    block_of,
    conjugate_stress,
    follow_twist,
    force_columns,
    rate_columns,
    section_columns,
    strain_columns,
)
from viscorod.mechanics.nodes.attached_poses import attached_twist
from viscorod.mechanics.rotations.vectors import (
    quaternion,
    vector,
)
from viscorod.typing import Floats, Integers


class EqualElements(NamedTuple):
    """Elements of one order, which have m nodes and points Gauss points each.

    Attributes:
        nodes, links: ``(elements, m)``, shared node and attachment (or -1) of every element node.
        slots: ``(elements, m, m)``, number of the block in the row of node k and the column of node j.
        link_positions, link_quaternions: constant relative poses of the attachments.
        shapes, slopes: basis and its derivative in xi at the Gauss points ``(points, m)``; weights ``(points,)``.
        half_lengths: half the reference arc length of each element [m].
        section: index of the section at every Gauss point ``(elements, points)``.
        stiffness, damping: section matrices C and D ``(sections, 6, 6)``; ``coupled`` False takes them as diagonal,
            ``damped`` False skips D.
        held: marks strains whose section force is the stress ``(sections, 6)``; ``constrained`` False: there are none.
        reference: strains of the unstressed shape ``(elements, points, 6)``.
        prestress: section forces in addition to C eps + D eps_t, likewise; no elements if there are none.
        laws: of the sections, beside C and D; where there are any, ``coupled`` and ``damped`` are True.
    """

    nodes: Integers
    links: Integers
    slots: Integers
    link_positions: Floats
    link_quaternions: Floats
    shapes: Floats
    slopes: Floats
    weights: Floats
    half_lengths: Floats
    section: Integers
    stiffness: Floats
    damping: Floats
    held: Floats
    coupled: bool
    damped: bool
    constrained: bool
    reference: Floats
    prestress: Floats
    laws: SectionLaws


class PointArrays(NamedTuple):
    """Fields at the Gauss points of equal-order elements ``(elements, points, 6)``.

    Attributes:
        stress: section force used in the geometric stiffness (the mixed iterate), the only input.
        strain, strain_rate, section_force: (V, U) - reference, its rate, C eps + D eps_t + prestress.
        operator: change of the section force per nodal increment ``(batches, m, 6, 6, LANES)`` (column, row).
        strain_operator: change of the strain, laid out like ``operator``; no batches if it is not wanted.
    """

    stress: Floats
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    operator: Floats
    strain_operator: Floats


class Assembled(NamedTuple):
    """Where elements are added to.

    Attributes:
        force: ``(n, 6)``, internal forces in body frames.
        blocks: of the matrix ``(b, 6, 6)``, entry (i, j) of block s at ``blocks[s, j, i]``.
        rate_blocks: the derivative by the twists alone, laid out like ``blocks``; none if it is not wanted.
    """

    force: Floats
    blocks: Floats
    rate_blocks: Floats


@kernel
def strains(elements: EqualElements, r: Floats, q: Floats, out: Floats, frames: Floats) -> None:
    """Evaluate ``(V, U)`` at every Gauss point of equal-order elements into ``out`` (elements, points, 6).

    ``frames`` (elements, points, 4) receives the unit quaternions of the sections.
    """
    nodes, links, _, link_positions, link_quaternions, shapes, slopes = elements[:7]
    half_lengths = elements.half_lengths
    m = nodes.shape[1]
    re = np.empty((m, 3))
    qe = np.empty((m, 4))
    p = np.empty((m, 4))
    slope = np.empty(m)
    for e in range(nodes.shape[0]):
        element_poses(nodes[e], links[e], link_positions, link_quaternions, r, q, re, qe)
        for g in range(shapes.shape[0]):
            for k in range(m):
                slope[k] = slopes[g, k] / half_lengths[e]
            gauss_point(shapes[g], slope, re, qe, out[e, g, 0:3], out[e, g, 3:6], p, frames[e, g])


class Batch(NamedTuple):
    """Up to LANES Gauss points with all that an assembly works on: rows of ``lanes``, one lane a point.

    Attributes:
        element, place: of every lane, the element and the Gauss point in it.
        point, node, maps: see ``lanes``; C, D: section matrices ``(6, 6, LANES)``.
        B, E, A, F: columns of one node (see ``tangent_lanes``); T: rate maps; block: between two nodes.
        nodal: ``(1, 6, LANES)``, wrenches on one node; strain, rate: of one point ``(6,)``, for its law.
    """

    element: Integers
    place: Integers
    point: Floats
    node: Floats
    maps: Floats
    C: Floats
    D: Floats
    B: Floats
    E: Floats
    A: Floats
    F: Floats
    T: Floats
    block: Floats
    nodal: Floats
    strain: Floats
    rate: Floats


@lane_kernel
def gather_points(elements: EqualElements, stress: Floats, first: int, count: int, batch: Batch) -> None:
    """Put the Gauss points from number ``first`` on into the lanes: weights, basis, stress, minus reference strain."""
    element, place, point, node = batch.element, batch.place, batch.point, batch.node
    points, m = elements.shapes.shape
    e, g = first // points, first % points
    for lane in range(count):
        if g == points:
            e, g = e + 1, 0
        element[lane], place[lane] = e, g
        weight = elements.weights[g] * elements.half_lengths[e]
        point[0, AT_WEIGHT, lane] = weight
        for k in range(m):
            node[k, AT_SHAPE, lane] = elements.shapes[g, k]
            node[k, AT_SLOPE, lane] = elements.slopes[g, k] / elements.half_lengths[e]
        for i in range(6):
            point[0, AT_STRAIN + i, lane] = -elements.reference[e, g, i]
            point[0, AT_STRESS + i, lane] = weight * stress[e, g, i]
        g += 1


@lane_kernel
def respond(elements: EqualElements, viscous: bool, count: int, batch: Batch) -> None:
    """Evaluate the section forces ``S = C eps + D eps_t + s + prestress``; those of held strains are their stress."""
    element, place, point, section = batch.element, batch.place, batch.point, elements.section
    gather_sections(count, element, place, section, elements.coupled, elements.stiffness, batch.C)
    if elements.damped:
        gather_sections(count, element, place, section, elements.coupled, elements.damping, batch.D)
    section_forces(count, elements.coupled, viscous, batch.C, batch.D, point)
    if elements.laws.present:
        add_lane_laws(
            count, element, place, section, elements.laws, point, batch.C, batch.D, batch.strain, batch.rate
        )
    if elements.prestress.shape[0] > 0:
        for lane in range(count):
            for i in range(6):
                point[0, AT_FORCE + i, lane] += elements.prestress[element[lane], place[lane], i]
    if elements.constrained:
        for lane in range(count):
            of = section[element[lane], place[lane]]
            for i in range(6):
                if elements.held[of, i] != 0.0:
                    point[0, AT_FORCE + i, lane] = point[0, AT_STRESS + i, lane] / point[0, AT_WEIGHT, lane]


@lane_kernel
def scatter_points(fields: PointArrays, count: int, batch: Batch) -> None:
    """Write strains, their rates and section forces of all lanes."""
    for lane in range(count):
        e, g = batch.element[lane], batch.place[lane]
        for i in range(6):
            fields.strain[e, g, i] = batch.point[0, AT_STRAIN + i, lane]
            fields.strain_rate[e, g, i] = batch.point[0, AT_RATE + i, lane]
            fields.section_force[e, g, i] = batch.point[0, AT_FORCE + i, lane]


@lane_kernel
def keep_columns(count: int, columns: Floats, out: Floats) -> None:
    """Write six columns ``(column, row, LANES)`` of all lanes."""
    for b in range(6):
        for i in range(6):
            for lane in range(count):
                out[b, i, lane] = columns[b, i, lane]


@lane_kernel
def change_by_node(
    elements: EqualElements, viscous: bool, rate_map: Floats, count: int, j: int, batch: Batch
) -> None:
    """Write what increments of nodes j change the section force by, ``A = C B + D (E + B T)``."""
    point, node, maps = batch.point, batch.node, batch.maps
    section_columns(count, elements.coupled, batch.C, batch.B, True, batch.A)
    if viscous:
        gather_rate_maps(
            count,
            batch.element,
            j,
            elements.nodes,
            elements.links,
            elements.link_positions,
            elements.link_quaternions,
            rate_map,
            batch.T,
        )
        rate_columns(count, point, node, maps, j, batch.E)
        follow_twist(count, batch.B, batch.T, batch.E)
        section_columns(count, elements.coupled, batch.D, batch.E, False, batch.A)


@lane_kernel
def add_column(elements: EqualElements, own: bool, count: int, j: int, batch: Batch, blocks: Floats) -> None:
    """Add the blocks of all nodes' forces by increments of nodes j, from the conjugate forces ``F``.

    ``own``: the forces of node j turn with it.
    """
    for k in range(elements.nodes.shape[1]):
        block_of(count, batch.node, batch.maps, k, batch.F, batch.block)
        if k == j and own:
            add_frame_rotation(count, batch.point, batch.node, batch.maps, k, batch.block)
        add_blocks(
            count,
            batch.element,
            k,
            j,
            elements.links,
            elements.link_positions,
            elements.link_quaternions,
            elements.slots,
            batch.block,
            blocks,
        )


@kernel
def assemble(
    elements: EqualElements,
    fields: PointArrays,
    r: Floats,
    q: Floats,
    twist: Floats,
    moving: bool,
    rate_map: Floats,
    with_tangent: bool,
    out: Assembled,
) -> None:
    """Add the internal forces of equal-order elements, and their tangent, in one pass over the Gauss points.

    Args:
        fields: the stress is read, the others are written; operators with the tangent only.
        r, q, twist: nodal positions, unit quaternions and body twists; ``moving`` False means that all twists vanish.
        rate_map: d(twist)/d(increment) of every node ``(n, 6, 6)``; read only if sections are damped and ``moving``.
        out: added to.

    model.md section 4: ``f = sum_g w_g B^T S``, and ``df = sum_g w_g [B^T (C B + D (E + B T)) + geometric] d``.
    """
    nodes, links, _, link_positions, link_quaternions, shapes = elements[:6]
    m, total = nodes.shape[1], nodes.shape[0] * shapes.shape[0]
    viscous = elements.damped and moving
    separate = elements.damped and with_tangent and out.rate_blocks.shape[0] > 0
    square = (6, 6, LANES)
    batch = Batch(
        np.empty(LANES, np.int64), np.empty(LANES, np.int64), np.zeros((1, POINT_ROWS, LANES)),
        np.zeros((m, NODE_ROWS, LANES)), np.zeros((3 * m, MAP_ROWS, LANES)), np.zeros(square), np.zeros(square),
        np.empty(square), np.empty(square), np.empty(square), np.empty((6, FLAT_ROWS, LANES)), np.empty(square),
        np.empty(square), np.empty((1, 6, LANES)), np.empty(6), np.empty(6),
    )  # fmt: skip
    element, point, node, maps, nodal = batch.element, batch.point, batch.node, batch.maps, batch.nodal
    for first in range(0, total, LANES):
        count, number = min(LANES, total - first), first // LANES
        gather_points(elements, fields.stress, first, count, batch)
        gather_nodes(count, element, nodes, links, link_positions, link_quaternions, r, q, twist, node)
        interpolate(count, point, node, maps)
        if viscous:
            rates(count, point, node, maps)
        respond(elements, viscous, count, batch)
        conjugate_section_forces(count, point)
        scatter_points(fields, count, batch)
        for k in range(m):
            forces_on(count, point, node, maps, k, nodal)
            add_forces(count, element, k, nodes, links, link_positions, link_quaternions, nodal, out.force)
        if not with_tangent:
            continue
        conjugate_stress(count, point)
        for j in range(m):
            strain_columns(count, point, node, maps, j, batch.B)
            if fields.strain_operator.shape[0] > 0:
                keep_columns(count, batch.B, fields.strain_operator[number, j])
            change_by_node(elements, viscous, rate_map, count, j, batch)
            keep_columns(count, batch.A, fields.operator[number, j])
            force_columns(count, point, batch.A, batch.F)
            add_turned_forces(count, point, node, maps, j, batch.F)
            add_column(elements, True, count, j, batch, out.blocks)
            if separate:  # the damping matrix alone
                section_columns(count, elements.coupled, batch.D, batch.B, True, batch.A)
                force_columns(count, point, batch.A, batch.F)
                add_column(elements, False, count, j, batch, out.rate_blocks)


@kernel
def update_stress(elements: EqualElements, fields: PointArrays, increment: Floats, stress: Floats) -> None:
    """Update the section force of the last iterate by the Newton increment: ``stress = S + A dx``.

    This is the mixed (stress as an independent iterate) Newton step with the stress eliminated point by point.
    """
    nodes, links, _, link_positions, link_quaternions = elements[:5]
    section_force, operator = fields.section_force, fields.operator
    m = nodes.shape[1]
    points = section_force.shape[1]
    total = nodes.shape[0] * points
    change = np.empty((6, LANES))
    x = np.empty((6, LANES))
    for first in range(0, total, LANES):
        count = min(LANES, total - first)
        batch = first // LANES
        for i in range(6):
            for lane in range(count):
                change[i, lane] = 0.0
        for k in range(m):
            for lane in range(count):
                e = (first + lane) // points
                n, link = nodes[e, k], links[e, k]
                if link < 0:
                    for i in range(6):
                        x[i, lane] = increment[n, i]
                else:
                    v, w = vector(increment, n, 0), vector(increment, n, 3)
                    d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
                    v, w = attached_twist(d, own, v, w)
                    for i in range(3):
                        x[i, lane] = v[i]
                        x[3 + i, lane] = w[i]
            for j in range(6):
                for i in range(6):
                    for lane in range(count):
                        change[i, lane] += operator[batch, k, j, i, lane] * x[j, lane]
        for lane in range(count):
            e, g = divmod(first + lane, points)
            for i in range(6):
                stress[e, g, i] = section_force[e, g, i] + change[i, lane]


@kernel
def elastic_energy(
    weights: Floats, half_lengths: Floats, section: Integers, stiffness: Floats, laws: SectionLaws, strain: Floats
) -> float:
    """Return the elastic energy [J], ``1/2 int eps.C eps`` and that of laws, from the strains at the Gauss points."""
    total = 0.0
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            C = stiffness[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                for j in range(6):
                    total += 0.5 * weight * strain[e, g, i] * C[i, j] * strain[e, g, j]
            if laws.present:
                stored, _ = stored_and_lost(laws, section[e, g], strain[e, g], strain[e, g])
                total += weight * stored
    return total


@kernel
def viscous_loss(
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    damping: Floats,
    laws: SectionLaws,
    strain: Floats,
    earlier: Floats,
    duration: float,
) -> float:
    """Return the energy [J] lost between two strain states, ``int d_eps.D d_eps / duration`` (never negative).

    The mean rate of the step replaces the rate: of second order, and insensitive to ringing about the mean.
    """
    total = 0.0
    d, middle = np.empty(6), np.empty(6)
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            D = damping[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                d[i] = strain[e, g, i] - earlier[e, g, i]
            for i in range(6):
                for j in range(6):
                    total += weight * d[i] * D[i, j] * d[j] / duration
            if laws.present:
                for i in range(6):
                    middle[i], d[i] = strain[e, g, i] - 0.5 * d[i], d[i] / duration
                _, lost = stored_and_lost(laws, section[e, g], middle, d)
                total += weight * duration * lost
    return total
