"""Forces and tangents of geometric elements: one pass over the Gauss points of all elements of one order.

The element is described in ``strain``; here its section forces are turned into nodal forces, and their derivative is
assembled into the band. Gauss points are taken in batches of LANES, so that the formulas of ``lanes`` and
``tangent_lanes`` run on whole vector registers; only gathering and scattering go point by point.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.attachment import attached_twist, attached_wrench, shared_wrench
from viscorod.mechanics.compiled import kernel, lane_kernel
from viscorod.mechanics.lanes import (
    AT_FORCE,
    AT_Q,
    AT_R,
    AT_RATE,
    AT_SHAPE,
    AT_SLOPE,
    AT_STRAIN,
    AT_STRESS,
    AT_TWIST,
    AT_WEIGHT,
    LANES,
    MAP_ROWS,
    NODE_ROWS,
    POINT_ROWS,
    forces_on,
    interpolate,
    rates,
    section_forces,
)
from viscorod.mechanics.strain import element_poses, gauss_point
from viscorod.mechanics.tangent_lanes import (
    FLAT_ROWS,
    add_turned_forces,
    add_turning_frame,
    block_of,
    conjugate_stress,
    follow_twist,
    force_columns,
    rate_columns,
    section_columns,
    strain_columns,
)
from viscorod.mechanics.vectors import (
    Quaternion,
    Vector,
    dot,
    load,
    plus,
    product,
    quaternion,
    rotated,
    scaled,
    store,
    store4,
    vector,
)
from viscorod.typing import Floats, Integers


@kernel
def strains(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    shapes: Floats,
    slopes: Floats,
    half_lengths: Floats,
    r: Floats,
    q: Floats,
    out: Floats,
    frames: Floats,
) -> None:
    """Evaluate ``(V, U)`` at every Gauss point of equal-order elements into ``out`` (elements, points, 6).

    ``frames`` (elements, points, 4) receives the unit quaternions of the sections.
    """
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


@lane_kernel
def gather_nodes(
    count: int,
    element: Integers,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    node: Floats,
) -> None:
    """Put poses and twists of the element nodes into their lanes, as ``strain.element_poses`` does for one element."""
    for lane in range(count):
        e = element[lane]
        before: Quaternion = (0.0, (0.0, 0.0, 0.0))
        for k in range(nodes.shape[1]):
            n, link = nodes[e, k], links[e, k]
            place, turn = vector(r, n, 0), quaternion(q, n)
            v, w = vector(twist, n, 0), vector(twist, n, 3)
            if link >= 0:
                d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
                place = plus(place, 1.0, rotated(turn, d))
                turn = product(turn, own)
                v, w = attached_twist(d, own, v, w)
            if before[0] * turn[0] + dot(before[1], turn[1]) < 0.0:
                turn = -turn[0], scaled(-1.0, turn[1])
            before = turn
            store(node, k, AT_R, lane, place)
            store4(node, k, AT_Q, lane, turn)
            store(node, k, AT_TWIST, lane, v)
            store(node, k, AT_TWIST + 3, lane, w)


@lane_kernel
def gather_sections(
    count: int,
    element: Integers,
    place: Integers,
    section: Integers,
    coupled: bool,
    matrices: Floats,
    out: Floats,
) -> None:
    """Put the section matrices into their lanes, their diagonals only unless ``coupled``."""
    for lane in range(count):
        s = section[element[lane], place[lane]]
        for i in range(6):
            out[i, i, lane] = matrices[s, i, i]
    if coupled:
        for lane in range(count):
            s = section[element[lane], place[lane]]
            for i in range(6):
                for j in range(6):
                    out[i, j, lane] = matrices[s, i, j]


@lane_kernel
def gather_rate_maps(
    count: int,
    element: Integers,
    j: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    rate_map: Floats,
    out: Floats,
) -> None:
    """Put the rate maps of nodes j into their lanes, as (column, row); ``X T X^-1`` for attached ones."""
    for lane in range(count):
        e = element[lane]
        n, link = nodes[e, j], links[e, j]
        for a in range(6):
            for b in range(6):
                out[b, a, lane] = rate_map[n, a, b]
        if link >= 0:
            d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
            for a in range(6):
                f, m = attached_wrench(d, own, row(out, 0, a, lane), row(out, 3, a, lane))
                for b in range(3):
                    out[b, a, lane] = f[b]
                    out[3 + b, a, lane] = m[b]
            for b in range(6):
                v, w = attached_twist(d, own, load(out, b, 0, lane), load(out, b, 3, lane))
                store(out, b, 0, lane, v)
                store(out, b, 3, lane, w)


@lane_kernel
def row(block: Floats, b: int, a: int, lane: int) -> Vector:
    """Return three entries of row ``a`` of a (column, row) block, from column ``b`` on."""
    return block[b, a, lane], block[b + 1, a, lane], block[b + 2, a, lane]


@lane_kernel
def add_blocks(
    count: int,
    element: Integers,
    k: int,
    j: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    block: Floats,
    band: Floats,
    diagonal: int,
) -> None:
    """Add the blocks (node k, node j) of all lanes to the band, those of attached nodes as seen by the shared ones."""
    for lane in range(count):
        e = element[lane]
        n, o = nodes[e, k], nodes[e, j]
        link = links[e, k]
        if link >= 0:
            d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
            for b in range(6):
                f, m = shared_wrench(d, own, load(block, b, 0, lane), load(block, b, 3, lane))
                store(block, b, 0, lane, f)
                store(block, b, 3, lane, m)
        link = links[e, j]
        if link >= 0:
            d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
            for a in range(6):
                f, m = shared_wrench(d, own, row(block, 0, a, lane), row(block, 3, a, lane))
                for b in range(3):
                    block[b, a, lane] = f[b]
                    block[3 + b, a, lane] = m[b]
        # unsigned indices: signed ones are tested for counting from the end, which costs more than the sum
        start = diagonal + 6 * (n - o)
        for b in range(6):
            column, top = np.uint64(6 * o + b), np.uint64(start - b)
            for a in range(6):
                band[column, top + np.uint64(a)] += block[b, a, lane]


@lane_kernel
def add_forces(
    count: int,
    element: Integers,
    k: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    nodal: Floats,
    force: Floats,
) -> None:
    """Add the wrenches ``nodal (1, 6, LANES)`` on nodes k to ``force``; of attached nodes at the shared one."""
    for lane in range(count):
        e = element[lane]
        n, link = nodes[e, k], links[e, k]
        f, m = load(nodal, 0, 0, lane), load(nodal, 0, 3, lane)
        if link >= 0:
            f, m = shared_wrench(vector(link_positions, link, 0), quaternion(link_quaternions, link), f, m)
        for i in range(3):
            force[n, i] += f[i]
            force[n, 3 + i] += m[i]


@kernel
def assemble(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    shapes: Floats,
    slopes: Floats,
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    stiffness: Floats,
    damping: Floats,
    coupled: bool,
    damped: bool,
    reference: Floats,
    stress: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    moving: bool,
    rate_map: Floats,
    with_tangent: bool,
    force: Floats,
    band: Floats,
    rate_band: Floats,
    diagonal: int,
    strain: Floats,
    strain_rate: Floats,
    section_force: Floats,
    operator: Floats,
) -> None:
    """Add the internal forces of equal-order elements, and their tangent, in one pass over the Gauss points.

    Args:
        nodes, links: ``(elements, m)``, shared node and attachment (or -1) of every element node.
        link_positions, link_quaternions: constant relative poses of the attachments.
        shapes, slopes: basis and its derivative in xi at the Gauss points ``(points, m)``; ``weights`` ``(points,)``.
        half_lengths: half the reference arc length of each element [m].
        section: index of the section at every Gauss point ``(elements, points)``.
        stiffness, damping: section matrices C and D ``(sections, 6, 6)``; ``coupled`` False takes them as diagonal,
            ``damped`` False skips D.
        reference: strains of the unstressed shape ``(elements, points, 6)``.
        stress: section force used in the geometric stiffness (the mixed iterate) ``(elements, points, 6)``.
        r, q, twist: nodal positions, unit quaternions and body twists; ``moving`` False means that all twists vanish.
        rate_map: d(twist)/d(increment) of every node ``(n, 6, 6)``; read only if ``damped and moving``.
        force: ``(n, 6)``, internal force in body frames is added.
        band: ``(6 n, columns)``, row j holds column j of the matrix, entry (i, j) at ``band[j, diagonal + i - j]``.
        rate_band: the derivative by the twists alone, laid out like ``band``; no rows if it is not wanted.
        strain, strain_rate, section_force: outputs ``(elements, points, 6)``: (V, U) - reference, its rate, C eps
            + D eps_t.
        operator: output ``(batches, m, 6, 6, LANES)``, change of the section force per nodal increment (column, row;
            with the tangent).

    model.md section 4: ``f = sum_g w_g B^T (C eps + D eps_t)``.
    """
    m = nodes.shape[1]
    points = shapes.shape[0]
    total = nodes.shape[0] * points
    viscous = damped and moving
    separate = damped and with_tangent and rate_band.shape[0] > 0
    point = np.zeros((1, POINT_ROWS, LANES))
    node = np.zeros((m, NODE_ROWS, LANES))
    maps = np.zeros((3 * m, MAP_ROWS, LANES))
    C = np.zeros((6, 6, LANES))
    D = np.zeros((6, 6, LANES))
    B = np.empty((6, 6, LANES))
    E = np.empty((6, 6, LANES))
    A = np.empty((6, 6, LANES))
    T = np.empty((6, 6, LANES))
    F = np.empty((6, FLAT_ROWS, LANES))
    block = np.empty((6, 6, LANES))
    nodal = np.empty((1, 6, LANES))
    element = np.empty(LANES, np.int64)
    place = np.empty(LANES, np.int64)
    e = g = 0
    for first in range(0, total, LANES):
        count = min(LANES, total - first)
        for lane in range(count):
            if g == points:
                e, g = e + 1, 0
            element[lane], place[lane] = e, g
            weight = weights[g] * half_lengths[e]
            point[0, AT_WEIGHT, lane] = weight
            for k in range(m):
                node[k, AT_SHAPE, lane] = shapes[g, k]
                node[k, AT_SLOPE, lane] = slopes[g, k] / half_lengths[e]
            for i in range(6):
                point[0, AT_STRAIN + i, lane] = -reference[e, g, i]
                point[0, AT_STRESS + i, lane] = weight * stress[e, g, i]
            g += 1
        gather_nodes(count, element, nodes, links, link_positions, link_quaternions, r, q, twist, node)
        gather_sections(count, element, place, section, coupled, stiffness, C)
        if damped:
            gather_sections(count, element, place, section, coupled, damping, D)
        interpolate(count, point, node, maps)
        if viscous:
            rates(count, point, node, maps)
        section_forces(count, coupled, viscous, C, D, point)
        for lane in range(count):
            at, of = element[lane], place[lane]
            for i in range(6):
                strain[at, of, i] = point[0, AT_STRAIN + i, lane]
                strain_rate[at, of, i] = point[0, AT_RATE + i, lane]
                section_force[at, of, i] = point[0, AT_FORCE + i, lane]
        for k in range(m):
            forces_on(count, point, node, maps, k, nodal)
            add_forces(count, element, k, nodes, links, link_positions, link_quaternions, nodal, force)
        if not with_tangent:
            continue
        conjugate_stress(count, point)
        for j in range(m):
            strain_columns(count, point, node, maps, j, B)
            section_columns(count, coupled, C, B, True, A)
            if viscous:
                gather_rate_maps(
                    count, element, j, nodes, links, link_positions, link_quaternions, rate_map, T
                )
                rate_columns(count, point, node, maps, j, E)
                follow_twist(count, B, T, E)
                section_columns(count, coupled, D, E, False, A)
            force_columns(count, point, A, F)
            add_turned_forces(count, point, node, maps, j, F)
            for b in range(6):
                for i in range(6):
                    for lane in range(count):
                        operator[first // LANES, j, b, i, lane] = A[b, i, lane]
            for k in range(m):
                block_of(count, node, maps, k, F, block)
                if k == j:
                    add_turning_frame(count, point, node, maps, k, block)
                add_blocks(
                    count,
                    element,
                    k,
                    j,
                    nodes,
                    links,
                    link_positions,
                    link_quaternions,
                    block,
                    band,
                    diagonal,
                )
            if separate:
                section_columns(count, coupled, D, B, True, A)
                force_columns(count, point, A, F)
                for k in range(m):
                    block_of(count, node, maps, k, F, block)
                    add_blocks(
                        count,
                        element,
                        k,
                        j,
                        nodes,
                        links,
                        link_positions,
                        link_quaternions,
                        block,
                        rate_band,
                        diagonal,
                    )


@kernel
def update_stress(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    section_force: Floats,
    operator: Floats,
    increment: Floats,
    stress: Floats,
) -> None:
    """Carry the section force of the last iterate along the Newton increment: ``stress = S + A dx``.

    This is the mixed (stress as an independent iterate) Newton step with the stress eliminated point by point.
    """
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
    weights: Floats, half_lengths: Floats, section: Integers, stiffness: Floats, strain: Floats
) -> float:
    """Return the elastic energy [J], ``1/2 int eps.C eps``, from the strains at the Gauss points."""
    total = 0.0
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            C = stiffness[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                for j in range(6):
                    total += 0.5 * weight * strain[e, g, i] * C[i, j] * strain[e, g, j]
    return total


@kernel
def viscous_loss(
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    damping: Floats,
    strain: Floats,
    earlier: Floats,
    duration: float,
) -> float:
    """Return the energy [J] lost between two strain states, ``int d_eps.D d_eps / duration`` (never negative).

    The mean rate of the step stands for the rate: of second order, and blind to ringing of the rates about their mean.
    """
    total = 0.0
    d = np.empty(6)
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            D = damping[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                d[i] = strain[e, g, i] - earlier[e, g, i]
            for i in range(6):
                for j in range(6):
                    total += weight * d[i] * D[i, j] * d[j] / duration
    return total
