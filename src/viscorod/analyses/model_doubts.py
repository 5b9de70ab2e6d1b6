"""What is allowed in a model but hardly meant, told with every result: equal loads, ends that meet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from viscorod.analyses.doubtful_numbers import doubtful_numbers
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.actions.load import Gravity
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import some_of
from viscorod.model.rod import Rod
from viscorod.model.rod_checks import reaching_centre
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["loose_ends", "model_doubts"]

EARTHLY = 2e-3
"""How far the acceleration of gravity differs on Earth from 9.81 m/s^2, as a part of it, as it is rounded in use."""
RECORD = 20
"""Rows from which on a table of time is a record; shorter ones are ramps, which end where they are to stay."""
HELD = 1e-3
"""Part of the largest value of a table beyond which one that is kept matters."""
TOGETHER = 1e-4
"""Distance of two ends over the length of the shorter rod up to which they are at the same place."""


def model_doubts(model: ModelDescription, problem: Problem, duration: float = 0.0) -> list[str]:
    """Return what is hardly meant: numbers in other units, sections past a centre, equal loads, springs that push.

    Args:
        model: what the user said; problem: the model discretised; duration: of its motion [s], which tables of time
            should cover.
    """
    shapes = [text for name, rod in model.rods.items() for text in _no_rod(name, rod)]
    tables = [text for where, table in _records(model) for text in _uncovered(where, table, duration)]
    return [
        *doubtful_numbers(model),
        *shapes,
        *_loads(model),
        *_pushing(model),
        *loose_ends(problem),
        *tables,
    ]


def _pushing(model: ModelDescription) -> Iterator[str]:
    """Yield which springs push what leaves its rest farther away."""
    for spring in model.springs:
        stiffness = getattr(spring, "stiffness", None)
        for word, value in stiffness.items() if isinstance(stiffness, Mapping) else [("", stiffness)]:
            if isinstance(value, float) and value < 0.0:
                along = f" along {word}" if word else ""
                yield (
                    f"{spring.label}: a stiffness of {value:.4g}{along} pushes away from rest what leaves it; springs "
                    "that pull back have positive numbers"
                )


def _no_rod(name: str, rod: Rod) -> Iterator[str]:
    """Yield whether a rod is thicker than long, or reaches past the centre of curvature of its reference shape."""
    half = rod.section_at(0.0).half_width or 0.0
    if half > rod.length:
        yield (
            f"rod {name}: its half width, {half:.4g} m, is more than its length, {rod.length:.4g} m: it is no rod; "
            "lengths are in m, and 1 mm is 1e-3 m"
        )
    found = reaching_centre(rod)
    if found is not None:
        s, radius = found
        yield (
            f"rod {name}: at s = {s:.4g} m its section reaches past the centre of curvature of the reference shape, "
            f"{radius:.4g} m away: parts of it would lie within each other, which no body does, and the rod is "
            "computed as if it were slender; make the section thinner or the radius larger (lengths are in m)"
        )


def _loads(model: ModelDescription) -> Iterator[str]:
    """Yield weights that look like those of another unit, and equal loads."""
    for index, load in enumerate(model.loads):
        if isinstance(load, Gravity):
            size = float(np.linalg.norm(load.acceleration))
            for unit, times in (("mm", 1000.0), ("cm", 100.0)):
                if abs(size / (9.81 * times) - 1.0) < EARTHLY:
                    yield (
                        f"loads[{index}].acceleration: {size:.6g} m/s2 is {times:g} times the weight on Earth; "
                        f"{size:.6g} {unit}/s2 are {size / times:.4g} m/s2"
                    )
    yield from _loads_twice(model)


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


def _records(model: ModelDescription) -> Iterator[tuple[str, TimeTable]]:
    """Yield tables of time that are records rather than ramps, with their key paths."""
    given: list[tuple[str, object]] = [(f"loads[{k}].time", load.time) for k, load in enumerate(model.loads)]
    for k, support in enumerate(model.supports):
        given += [(f"supports[{k}].motion.{word}", motion) for word, motion in support.motion.items()]
    for where, function in given:
        if isinstance(function, TimeTable) and (function.file is not None or len(function.knots) >= RECORD):
            yield where, function


def _uncovered(where: str, table: TimeTable, duration: float) -> Iterator[str]:
    """Yield which value a table keeps before its first or after its last time, while a motion goes on."""
    first, last = (float(table.knots[k]) for k in (0, -1))
    began, ended = table.value(first, before=True), table.value(last)
    least = HELD * float(np.abs(table.at(table.knots)).max())
    if duration and first > 0.0 and abs(began) > least:
        yield (
            f"{where}: the table begins at {first:.6g} s, and its first value, {began:.4g}, is taken from the "
            "beginning on; let it begin with 0, or at 0 s"
        )
    if last < duration and abs(ended) > least:
        yield (
            f"{where}: the table ends at {last:.6g} s, and its last value, {ended:.4g}, is kept up to the end of the "
            f"motion at {duration:.6g} s; let it end with 0, or give a shorter duration, if that is not meant"
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
