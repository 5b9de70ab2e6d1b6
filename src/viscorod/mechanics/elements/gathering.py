"""Transfer between elements and lanes: nodes, sections and rate maps in, forces and blocks of the matrix out.

These loops go point by point and cost as much as all formulas, so they take no slices and test as little as they can.
A rigidly attached element node (link >= 0) is treated as a separate node here: poses and twists are mapped to it,
forces and blocks back to the node that it shares (see ``nodes.attached_poses``).
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.elements.lanes import AT_Q, AT_R, AT_TWIST
from viscorod.mechanics.nodes.attached_poses import (
    attached_pose,
    attached_twist,
    attached_wrench,
    shared_wrench,
)
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    load,
    quaternion,
    same_hemisphere,
    store,
    store4,
    vector,
)
from viscorod.typing import Floats, Integers


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
        for k in range(node.shape[0]):
            n, link = nodes[e, k], links[e, k]
            place, turn = vector(r, n, 0), quaternion(q, n)
            v, w = vector(twist, n, 0), vector(twist, n, 3)
            if link >= 0:
                d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
                place, turn = attached_pose(d, own, place, turn)
                v, w = attached_twist(d, own, v, w)
            before = turn = same_hemisphere(before, turn)
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
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    slots: Integers,
    block: Floats,
    blocks: Floats,
) -> None:
    """Add the blocks (node k, node j) of all lanes to the matrix; attached nodes are mapped to shared ones."""
    for lane in range(count):
        e = element[lane]
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
        slot = np.uint64(slots[e, k, j])
        for b in range(6):
            for a in range(6):
                blocks[slot, b, a] += block[b, a, lane]


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
    """Add the wrenches ``nodal (1, 6, LANES)`` on nodes k to ``force``; attached nodes are mapped to shared ones."""
    for lane in range(count):
        e = element[lane]
        n, link = nodes[e, k], links[e, k]
        f, m = load(nodal, 0, 0, lane), load(nodal, 0, 3, lane)
        if link >= 0:
            f, m = shared_wrench(vector(link_positions, link, 0), quaternion(link_quaternions, link), f, m)
        for i in range(3):
            force[n, i] += f[i]
            force[n, 3 + i] += m[i]
