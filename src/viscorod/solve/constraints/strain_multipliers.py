"""Strains that rods hold: their multipliers, element by element, and the blocks that these need."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.held_strains import HeldStrains
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.problem.mesh import Mesh, element_nodes
from viscorod.solve.problem.problem import ElementSet
from viscorod.typing import Integers


def multiplier_cliques(mesh: Mesh, first: int) -> tuple[list[Integers], int]:
    """Return the block rows that couple through held strains, and how many of them are multipliers.

    Args:
        first: block row of the first multiplier; those of an element follow each other, six to a row.
    """
    cliques, taken = [], 0
    for order in _orders(mesh):
        for i, rod in enumerate(mesh.rods):
            count = _rows(rod.order, sum(rod.rod.constrained_strains))
            if rod.order != order or count == 0:
                continue
            nodes = element_nodes(mesh.shared[i], order)
            rows = first + taken + np.arange(count * len(nodes)).reshape(len(nodes), count)
            cliques.append(np.concatenate([nodes, rows], axis=1))
            taken += rows.size
    return cliques, taken


def held_strains(sets: tuple[ElementSet, ...], pattern: Pattern, nodes: int, first: int) -> HeldStrains:
    """Return the held strains of all elements; ``first`` as in :func:`multiplier_cliques`, ``nodes`` counts nodes."""
    if not any(e.held.any() for e in sets):
        return HeldStrains.none()
    most = max(e.nodes.shape[1] for e in sets)
    found: list[tuple[int, int, int, int, float]] = []
    up: list[list[int]] = []
    down: list[list[int]] = []
    begin, row = 0, first
    for e in sets:
        for element, members in enumerate(e.nodes):
            held = np.argwhere(e.held[e.section[element]] > 0.0)
            for number, (point, component) in enumerate(held):
                weight = float(e.weights[point] * e.half_lengths[element])
                block = row + number // 6
                place = 6 * (block - nodes) + number % 6
                found.append((begin + element, int(point), int(component), place, weight))
                rest = [-1] * (most - len(members))
                up.append([pattern.slot(int(n), block) for n in members] + rest)
                down.append([pattern.slot(block, int(n)) for n in members] + rest)
            row += -(-len(held) // 6)
        begin += len(e.nodes)
    element_, point_, component_, place_, weight_ = zip(*found, strict=True)
    return HeldStrains(
        np.array(element_, dtype=np.int64),
        np.array(point_, dtype=np.int64),
        np.array(component_, dtype=np.int64),
        np.array(place_, dtype=np.int64),
        np.array(weight_),
        np.array(up, dtype=np.int64),
        np.array(down, dtype=np.int64),
    )


def _orders(mesh: Mesh) -> list[int]:
    return sorted({rod.order for rod in mesh.rods})


def _rows(order: int, strains: int) -> int:
    """Return the number of block rows of an element's multipliers."""
    return -(-order * strains // 6)
