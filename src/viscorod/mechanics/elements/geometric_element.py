"""Forces and tangents of geometric elements: one pass over the Gauss points of all elements of one order.

The element is described in ``strain``; here its section forces are turned into nodal forces, and their derivative is
assembled into the blocks of a matrix. Gauss points are taken in batches of LANES, so that the formulas of ``lanes``
and ``tangent_lanes`` run on whole vector registers; only the functions of ``gathering`` go point by point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.elements.gathering import add_forces, gather_nodes
from viscorod.mechanics.elements.gauss_batch import (
    Batch,
    ElementGroup,
    PointFields,
    add_column,
    change_by_node,
    gather_points,
    keep_columns,
    respond,
    scatter_points,
    whole_registers,
)
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.lanes import (
    LANES,
    MAP_ROWS,
    NODE_ROWS,
    POINT_ROWS,
    conjugate_section_forces,
    forces_on,
    interpolate,
    rates,
)
from viscorod.mechanics.elements.section_laws import stored_and_lost
from viscorod.mechanics.elements.strain import element_poses, gauss_point
from viscorod.mechanics.elements.tangent_lanes import (
    FLAT_ROWS,
    add_turned_forces,
    conjugate_stress,
    force_columns,
    section_columns,
    strain_columns,
)
from viscorod.mechanics.nodes.attached_poses import attached_twist
from viscorod.mechanics.rotations.vectors import (
    quaternion,
    vector,
)
from viscorod.typing import Floats


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
def strains(elements: Elements, r: Floats, q: Floats, out: Floats, frames: Floats) -> None:
    """Evaluate ``(V, U)`` at every Gauss point into ``out`` (e, points, 6).

    ``frames`` (e, points, 4) receives the unit quaternions of the sections.
    """
    nodes, links, shapes, slopes = elements.nodes, elements.links, elements.shapes, elements.slopes
    most = nodes.shape[1]
    re, qe, p, slope = np.empty((most, 3)), np.empty((most, 4)), np.empty((most, 4)), np.empty(most)
    for e in range(nodes.shape[0]):
        order = elements.order[e]
        m = order + 1
        element_poses(
            nodes[e, :m],
            links[e, :m],
            elements.link_positions,
            elements.link_quaternions,
            r,
            q,
            re[:m],
            qe[:m],
        )
        for g in range(order):
            for k in range(m):
                slope[k] = slopes[order, g, k] / elements.half_lengths[e]
            V, U = out[e, g, 0:3], out[e, g, 3:6]
            gauss_point(shapes[order, g, :m], slope[:m], re[:m], qe[:m], V, U, p[:m], frames[e, g])


@kernel
def assemble(
    elements: Elements,
    group: ElementGroup,
    fields: PointFields,
    r: Floats,
    q: Floats,
    twist: Floats,
    moving: bool,
    rate_map: Floats,
    with_tangent: bool,
    out: Assembled,
) -> None:
    """Add the internal forces of a group of elements, and their tangent, in one pass over the Gauss points.

    Args:
        fields: stress and prestress are read, the others are written; operators with the tangent only.
        r, q, twist: nodal positions, unit quaternions and body twists; ``moving`` False means that all twists vanish.
        rate_map: d(twist)/d(increment) of every node ``(n, 6, 6)``; read only if sections are damped and ``moving``.
        out: added to.

    model.md section 4: ``f = sum_g w_g B^T S``, and ``df = sum_g w_g [B^T (C B + D (E + B T)) + geometric] d``.
    """
    nodes, links, link_positions, link_quaternions = elements[1:5]
    m, total = group.order + 1, group.size * group.order
    viscous = group.damped and moving
    separate = group.damped and with_tangent and out.rate_blocks.shape[0] > 0
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
        lanes = whole_registers(count)
        gather_points(elements, group, fields.stress, first, count, lanes, batch)
        gather_nodes(lanes, element, nodes, links, link_positions, link_quaternions, r, q, twist, node)
        interpolate(lanes, point, node, maps)
        if viscous:
            rates(lanes, point, node, maps)
        respond(elements, group, fields.prestress, viscous, lanes, batch)
        conjugate_section_forces(lanes, point)
        scatter_points(fields, count, batch)
        for k in range(m):
            forces_on(lanes, point, node, maps, k, nodal)
            add_forces(count, element, k, nodes, links, link_positions, link_quaternions, nodal, out.force)
        if not with_tangent:
            continue
        conjugate_stress(lanes, point)
        for j in range(m):
            strain_columns(lanes, point, node, maps, j, batch.B)
            if fields.strain_operator.shape[0] > 0:
                keep_columns(lanes, batch.B, fields.strain_operator[number, j])
            change_by_node(elements, group, viscous, rate_map, lanes, j, batch)
            keep_columns(lanes, batch.A, fields.operator[number, j])
            force_columns(lanes, point, batch.A, batch.F)
            add_turned_forces(lanes, point, node, maps, j, batch.F)
            add_column(elements, True, count, lanes, j, batch, out.blocks)
            if separate:  # the damping matrix alone
                section_columns(lanes, group.coupled, batch.D, batch.B, True, batch.A)
                force_columns(lanes, point, batch.A, batch.F)
                add_column(elements, False, count, lanes, j, batch, out.rate_blocks)


@kernel
def update_stress(
    elements: Elements, group: ElementGroup, fields: PointFields, increment: Floats, stress: Floats
) -> None:
    """Update the section force of the last iterate by the Newton increment: ``stress = S + A dx``.

    This is the mixed (stress as an independent iterate) Newton step with the stress eliminated point by point.
    """
    nodes, links, link_positions, link_quaternions = elements[1:5]
    section_force, operator = fields.section_force, fields.operator
    points = group.order
    total = group.size * points
    change = np.empty((6, LANES))
    x = np.empty((6, LANES))
    for first in range(0, total, LANES):
        count = min(LANES, total - first)
        batch = first // LANES
        for i in range(6):
            for lane in range(count):
                change[i, lane] = 0.0
        for k in range(points + 1):
            for lane in range(count):
                e = group.first + (first + lane) // points
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
            e += group.first
            for i in range(6):
                stress[e, g, i] = section_force[e, g, i] + change[i, lane]


@kernel
def viscous_loss(elements: Elements, strain: Floats, earlier: Floats, duration: float) -> float:
    """Return the energy [J] lost between two strain states, ``int d_eps.D d_eps / duration`` (never negative).

    The mean rate of the step replaces the rate: of second order, and insensitive to ringing about the mean.
    """
    orders, section, damping, laws = elements.order, elements.section, elements.damping, elements.laws
    total = 0.0
    d, middle = np.empty(6), np.empty(6)
    for e in range(strain.shape[0]):
        for g in range(orders[e]):
            D = damping[section[e, g]]
            weight = elements.weights[orders[e], g] * elements.half_lengths[e]
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
