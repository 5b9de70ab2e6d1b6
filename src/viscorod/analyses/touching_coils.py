"""Helical rods whose turns come to lie within each other in a state: no contact is computed, which is told."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.centrelines.line_shapes import Helix
from viscorod.model.rod import Rod
from viscorod.model.sections.section_shapes import Annulus, Circle
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, station_reader
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["TOUCHING", "touching_coils", "touching_in"]

TOUCHING = 0.01
"""Part of the thickness of a wire by which turns that touch may lie within each other, as numbers are rounded."""
PER_TURN = 24
"""Places of a turn at which the distance to the next one is looked at; between them it is a parabola."""
BESIDE = PER_TURN // 4
"""Places before and behind a whole turn farther on within which the nearest one is sought."""
LOOKED_AT = 200
"""States of a history at most."""


def touching_coils(
    rods: Mapping[str, Rod], problem: Problem, states: Iterable[tuple[str, State]]
) -> Iterator[str]:
    """Yield which helical rods have turns that lie within each other in some state, and in which one first.

    Rods that do so where nothing acts are left out, which are told of as such.

    Args:
        rods: by their names; problem: the model discretised; states: in order, each with when it is, in words.
    """
    wound = {name: thick for name, rod in rods.items() if (thick := _thickness(rod))}
    if not wound:
        return
    reader, stations = station_reader(problem), problem.stations
    for when, state in states:
        positions, turns = reader.poses(state.r, state.q)
        for name in list(wound):
            line, mine = rods[name].centreline, np.flatnonzero(stations.rod == problem.rods.index(name))
            assert isinstance(line, Helix)
            curve = _curve(stations.s[mine], positions[mine], turns[mine])
            apart = _least_distance(curve, line.length, line.turns)
            if apart < (1.0 - TOUCHING) * wound[name]:
                yield (
                    f"rod {name}: {when} its turns come as near as {apart:.4g} m, and its section is "
                    f"{wound[name]:.4g} m thick: they would touch before, and no contact is computed; results beyond "
                    "that are those of turns that pass through each other"
                )
                del wound[name]
        if not wound:
            return


def touching_in(rods: Mapping[str, Rod], problem: Problem, history: History, words: str) -> Iterator[str]:
    """Yield the same of some of the states of a history, with what to say of its instants, such as "at {:.4g} s"."""
    if any(map(_thickness, rods.values())):
        # those that it holds, whatever samples a stream takes beside them
        kept = History.sample(history, LOOKED_AT)
        yield from touching_coils(rods, problem, ((words.format(at), shot.state) for at, shot in kept))


def _thickness(rod: Rod) -> float:
    """Return the diameter of the wire of a helix of more than a turn whose turns are apart [m]; 0 of other rods."""
    line, section = rod.centreline, rod.section_at(0.0)
    if not isinstance(line, Helix) or line.turns <= 1.0 or not isinstance(section, Circle | Annulus):
        return 0.0
    thick = 2.0 * (section.half_width or 0.0)
    return thick if line.apart >= (1.0 - TOUCHING) * thick else 0.0


def _curve(s: Floats, positions: Floats, turns: Floats) -> Callable[[Floats], Floats]:
    """Return the line through stations, along the normals of their sections."""
    from scipy.interpolate import CubicHermiteSpline

    once: Integers = np.flatnonzero(np.append(True, np.diff(s) > 0.0))
    line: Callable[[Floats], Floats] = CubicHermiteSpline(
        s[once], positions[once], matrices(turns[once])[:, :, 2]
    )
    return line


def _least_distance(curve: Callable[[Floats], Floats], length: float, turns: float) -> float:
    """Return the least distance [m] of a place on a helix from the line about one turn farther on."""
    step = length / (turns * PER_TURN)
    places = curve(np.arange(0.0, length, step))
    count = len(places)
    rows = np.arange(max(0, count - PER_TURN))[:, None]
    there = rows + PER_TURN + np.arange(-BESIDE, BESIDE + 1)
    squares = np.square(places[np.minimum(there, count - 1)] - places[rows]).sum(axis=2)
    squares[there >= count] = np.nan  # beyond the end
    whole = squares[np.isfinite(squares).all(axis=1)]
    if not len(whole):
        return np.inf
    near = np.clip(whole.argmin(axis=1), 1, whole.shape[1] - 2)
    before, here, after = (whole[np.arange(len(whole)), near + k] for k in (-1, 0, 1))
    bend = before - 2.0 * here + after
    lower = np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros(len(here)), where=bend > 0.0)
    return float(np.sqrt(max(float((here - lower).min()), 0.0)))
