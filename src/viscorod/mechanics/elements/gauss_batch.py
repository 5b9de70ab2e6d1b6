"""Gauss points of equal-order elements in batches of LANES: from elements to lanes, from lanes to forces and blocks.

Each function is one step of ``geometric_element.assemble``; the formulas are those of ``lanes`` and ``tangent_lanes``.
"""

from __future__ import annotations

from typing import NamedTuple

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.elements.gathering import add_blocks, gather_rate_maps, gather_sections
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.lanes import (
    AT_FORCE,
    AT_RATE,
    AT_SHAPE,
    AT_SLOPE,
    AT_STRAIN,
    AT_STRESS,
    AT_WEIGHT,
    REGISTER,
    section_forces,
)
from viscorod.mechanics.elements.section_laws import add_lane_laws
from viscorod.mechanics.elements.tangent_lanes import (
    add_frame_rotation,
    block_of,
    follow_twist,
    rate_columns,
    section_columns,
)
from viscorod.typing import Floats, Integers


class ElementGroup(NamedTuple):
    """Elements of one order, which stand next to each other in the arrays of all elements.

    Attributes:
        first, size: the first of them, and how many; order: of their polynomials.
        coupled: False takes section matrices as diagonal; damped: False skips D; constrained: any strain is held.
    """

    first: int
    size: int
    order: int
    coupled: bool
    damped: bool
    constrained: bool


class PointFields(NamedTuple):
    """Fields at the Gauss points of all elements ``(e, points, 6)``, and operators of a group of them.

    Attributes:
        stress: section force used in the geometric stiffness (the mixed iterate); prestress: section forces in addition
            to those of the law, no elements if there are none: the inputs.
        strain, strain_rate, section_force: (V, U) - reference, its rate, C eps + D eps_t + s + prestress.
        operator: change of the section force per nodal increment ``(batches, m, 6, 6, LANES)`` (column, row).
        strain_operator: change of the strain, laid out like ``operator``; no batches if it is not wanted.
    """

    stress: Floats
    prestress: Floats
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    operator: Floats
    strain_operator: Floats


@lane_kernel
def group_of(groups: Integers, g: int) -> ElementGroup:
    """Return one of the groups."""
    kinds = groups[g, 3] != 0, groups[g, 4] != 0, groups[g, 5] != 0
    return ElementGroup(groups[g, 0], groups[g, 1], groups[g, 2], kinds[0], kinds[1], kinds[2])


@lane_kernel
def points_of(groups: Integers, g: int, points: PointFields) -> PointFields:
    """Return the Gauss points with the operators of one group."""
    first, last = groups[g, 6], groups[g, 7]
    return PointFields(
        points.stress,
        points.prestress,
        points.strain,
        points.strain_rate,
        points.section_force,
        points.operator[first:last],
        points.strain_operator[first:last],
    )


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
def whole_registers(count: int) -> int:
    """Return how many lanes are worked on for so many points, which is no less.

    What does not fill a vector register would go lane by lane. That none is left the compiler sees by the last bits.
    """
    return (count + REGISTER - 1) & -REGISTER


@lane_kernel
def gather_points(
    elements: Elements, group: ElementGroup, stress: Floats, first: int, count: int, lanes: int, batch: Batch
) -> None:
    """Put a group's Gauss points from number ``first`` on into lanes: weight, basis, stress, minus reference strain.

    The last point is in all ``lanes`` beyond the ``count`` ones that are read.
    """
    element, place, point, node = batch.element, batch.place, batch.point, batch.node
    order = group.order
    e, g = group.first + first // order, first % order
    for lane in range(lanes):
        if g == order:
            e, g = e + 1, 0
        element[lane], place[lane] = e, g
        weight = elements.weights[order, g] * elements.half_lengths[e]
        point[0, AT_WEIGHT, lane] = weight
        for k in range(node.shape[0]):
            node[k, AT_SHAPE, lane] = elements.shapes[order, g, k]
            node[k, AT_SLOPE, lane] = elements.slopes[order, g, k] / elements.half_lengths[e]
        for i in range(6):
            point[0, AT_STRAIN + i, lane] = -elements.reference[e, g, i]
            point[0, AT_STRESS + i, lane] = weight * stress[e, g, i]
        if lane < count - 1:
            g += 1


@lane_kernel
def respond(
    elements: Elements, group: ElementGroup, prestress: Floats, viscous: bool, count: int, batch: Batch
) -> None:
    """Evaluate the section forces ``S = C eps + D eps_t + s + prestress``; those of held strains are their stress."""
    element, place, point, section = batch.element, batch.place, batch.point, elements.section
    gather_sections(count, element, place, section, group.coupled, elements.stiffness, batch.C)
    if group.damped:
        gather_sections(count, element, place, section, group.coupled, elements.damping, batch.D)
    section_forces(count, group.coupled, viscous, batch.C, batch.D, point)
    if elements.laws.present:
        add_lane_laws(
            count, element, place, section, elements.laws, point, batch.C, batch.D, batch.strain, batch.rate
        )
    if prestress.shape[0] > 0:
        for lane in range(count):
            for i in range(6):
                point[0, AT_FORCE + i, lane] += prestress[element[lane], place[lane], i]
    if group.constrained:
        for lane in range(count):
            of = section[element[lane], place[lane]]
            for i in range(6):
                if elements.laws.free[of, i] == 0.0:
                    point[0, AT_FORCE + i, lane] = point[0, AT_STRESS + i, lane] / point[0, AT_WEIGHT, lane]


@lane_kernel
def scatter_points(fields: PointFields, count: int, batch: Batch) -> None:
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
    elements: Elements, group: ElementGroup, viscous: bool, rate_map: Floats, count: int, j: int, batch: Batch
) -> None:
    """Write what increments of nodes j change the section force by, ``A = C B + D (E + B T)``."""
    point, node, maps = batch.point, batch.node, batch.maps
    section_columns(count, group.coupled, batch.C, batch.B, True, batch.A)
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
        section_columns(count, group.coupled, batch.D, batch.E, False, batch.A)


@lane_kernel
def add_column(
    elements: Elements, own: bool, count: int, lanes: int, j: int, batch: Batch, blocks: Floats
) -> None:
    """Add the blocks of all nodes' forces by increments of nodes j, from the conjugate forces ``F``.

    ``own``: the forces of node j turn with it; count: of points, which are in the first ``lanes``.
    """
    for k in range(batch.node.shape[0]):
        block_of(lanes, batch.node, batch.maps, k, batch.F, batch.block)
        if k == j and own:
            add_frame_rotation(lanes, batch.point, batch.node, batch.maps, k, batch.block)
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
