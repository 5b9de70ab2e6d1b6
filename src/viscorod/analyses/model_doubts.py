"""What is allowed in a model but hardly meant, told with every result: equal loads, ends that meet."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from viscorod.analyses.doubtful_numbers import doubtful_numbers
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import some_of
from viscorod.model.rod import Rod
from viscorod.model.rod_checks import reaching_centre
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["loose_ends", "model_doubts"]

TOGETHER = 1e-4
"""Distance of two ends over the length of the shorter rod up to which they are at the same place."""


def model_doubts(model: ModelDescription, problem: Problem) -> list[str]:
    """Return what is hardly meant: numbers in other units, sections past a centre, equal loads, loose ends.

    Args:
        model: what the user said; problem: the model discretised.
    """
    curved = [text for name, rod in model.rods.items() for text in _past_centre(name, rod)]
    return [*doubtful_numbers(model), *curved, *_loads_twice(model), *loose_ends(problem)]


def _past_centre(name: str, rod: Rod) -> Iterator[str]:
    """Yield whether the section of a rod reaches past the centre of curvature of the reference shape."""
    found = reaching_centre(rod)
    if found is not None:
        s, radius = found
        yield (
            f"rod {name}: at s = {s:.4g} m its section reaches past the centre of curvature of the reference shape, "
            f"{radius:.4g} m away: parts of it would lie within each other, which no body does, and the rod is "
            "computed as if it were slender; make the section thinner or the radius larger (lengths are in m)"
        )


def _loads_twice(model: ModelDescription) -> Iterator[str]:
    """Yield which loads are there more than once."""
    if len(model.loads) < 2:
        return
    alike: dict[str, list[list[int]]] = {}
    for index, load in enumerate(model.loads):
        groups = alike.setdefault(repr(load), [])
        for numbers in groups:
            if model.loads[numbers[0]] == load:
                numbers.append(index)
                break
        else:
            groups.append([index])
    for numbers in (numbers for groups in alike.values() for numbers in groups if len(numbers) > 1):
        same = some_of([f"loads[{index}]" for index in numbers])
        yield (
            f"{same} are the same {model.loads[numbers[0]].word}: they add up to {len(numbers)} times one of them; "
            f"leave {'one' if len(numbers) == 2 else 'all but one'} out if it is meant once"
        )


def loose_ends(problem: Problem) -> Iterator[str]:
    """Yield which ends of rods are at the same place without being joined there."""
    if len(problem.rods) < 2:
        return
    nodes, positions, lengths = _ends(problem)
    pairs = _near(positions, TOGETHER * lengths)
    if not len(pairs):
        return
    part = _joined(problem)[nodes]
    loose = {tuple(sorted(part[pair].tolist())): pair for pair in pairs if part[pair[0]] != part[pair[1]]}
    if loose:
        names = [f"{rod}.{end}" for rod in problem.rods for end in ("start", "end")]
        couples = some_of([f"{names[a]} and {names[b]}" for a, b in loose.values()])
        yield (
            f"{couples} are at the same place, and nothing joins them there: they move apart; attach them (rigid), or "
            "give a joint or a support, if they belong together"
        )


def _ends(problem: Problem) -> tuple[Integers, Floats, Floats]:
    """Return node, position [m] and length of the rod [m] of the start and end of every rod, one after the other."""
    stations = problem.stations
    first = np.searchsorted(stations.rod, np.arange(len(problem.rods)))
    last = np.append(first[1:], len(stations.rod)) - 1
    at = np.column_stack([first, last]).ravel()
    nodes, links = stations.nodes[at], stations.links[at]
    positions = problem.positions[nodes].copy()
    away = links >= 0
    turn = matrices(problem.quaternions[nodes[away]])
    positions[away] += np.einsum("kij,kj->ki", turn, problem.link_positions[links[away]])
    return nodes, positions, np.repeat(problem.rod_lengths, 2)


def _near(positions: Floats, reach: Floats) -> Integers:
    """Return pairs of places (m, 2), a < b, no farther from each other than the reach of both."""
    from scipy.spatial import KDTree

    pairs = KDTree(positions).query_pairs(float(reach.max()), output_type="ndarray")
    distance = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
    return np.asarray(pairs[distance <= reach[pairs].min(axis=1)], dtype=np.int64)


def _joined(problem: Problem) -> Integers:
    """Return a number of every node; nodes that joints, springs or supports at the ground connect have the same."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ground = problem.size
    links = np.where(problem.joints.arrays.nodes < 0, ground, problem.joints.arrays.nodes)
    held = problem.supports.nodes
    a, b = np.append(links[:, 0], held), np.append(links[:, 1], np.full(len(held), ground))
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(ground + 1, ground + 1))
    return np.asarray(connected_components(graph, directed=False)[1])
