"""Nodes that supports hold in part: poses and velocities that these allow, where a state comes from elsewhere.

A step ends, and states within it are interpolated, with errors along held directions too; these are taken away. For
directions and their duals see ``support_rows``.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.nodes.support_rows import Directions, SupportedNodes, in_body, support_directions
from viscorod.mechanics.rotations.rotation import retract
from viscorod.typing import Floats, Integers

__all__ = ["correct_poses", "project_twists"]


@kernel
def project_twists(
    supports: SupportedNodes,
    rows: Integers,
    target: Floats,
    rate: Floats,
    turning: Floats,
    r: Floats,
    q: Floats,
    directions: Directions,
    twist: Floats,
) -> None:
    """Give nodes that are held in part exactly the prescribed velocity components, along free directions nothing more.

    Args:
        rows: of these supports ``(p,)``; target, rate: prescribed values of all and their rates ``(m, 6)``.
        turning: body twists with which their held rotations alone would turn them ``(p, 6)``.
        r, q, twist: of all nodes; directions: scratch of one support.
    """
    nodes, fixed, axes = supports.nodes, supports.fixed, supports.axes
    G, Z, gap = directions.G, directions.Z, directions.value
    for i in range(rows.shape[0]):
        s = rows[i]
        k = nodes[s]
        support_directions(supports, s, target, r, q, 0, directions)
        for a in range(6):
            wanted = rate[s, a]
            if a >= 3 and not in_body(axes[s]):
                wanted = 0.0
                for b in range(3, 6):
                    wanted += G[0, a, b] * turning[i, b]
            for b in range(6):
                wanted -= G[0, a, b] * twist[k, b]
            gap[0, a] = fixed[s, a] * wanted
        for a in range(6):
            for b in range(6):
                twist[k, a] += Z[0, a, b] * gap[0, b]


@kernel
def correct_poses(
    supports: SupportedNodes,
    rows: Integers,
    target: Floats,
    r: Floats,
    q: Floats,
    directions: Directions,
    change: Floats,
) -> None:
    """Put the held components of nodes that are held in part exactly where they are to be.

    Args:
        rows: of these supports ``(p,)``; target: prescribed values of all ``(m, 6)``.
        r, q: of all nodes; directions, change: scratch of one support, and of one node ``(1, 6)``.
    """
    nodes, fixed, Z, value = supports.nodes, supports.fixed, directions.Z, directions.value
    for i in range(rows.shape[0]):
        s = rows[i]
        k = nodes[s]
        support_directions(supports, s, target, r, q, 0, directions)
        for a in range(6):
            change[0, a] = 0.0
            for b in range(6):
                change[0, a] += Z[0, a, b] * (fixed[s, b] * (target[s, b] - value[0, b]))
        retract(r[k : k + 1], q[k : k + 1], change, r[k : k + 1], q[k : k + 1])
