"""Shapes as states that follow each other: every one swings once, with an amplitude that can be seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.rotations.quaternion import product
from viscorod.results.buckling import Buckling
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.modes_result import Modes
from viscorod.results.steady_result import Steady
from viscorod.results.text_numbers import above_rounding, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MOST_MODES", "Film", "Filmed", "film_of"]

Filmed: TypeAlias = Modes | Steady | Buckling
"""Results whose shapes swing."""

MOST_MODES = 40
"""Modes of a page at most."""
PHASES = 24
"""States of one swing; its first one comes again at its end."""
REACH, TURN = 0.1, 0.6
"""Largest displacement over the size of the model, and largest rotation [rad]; the smaller of the two."""


@dataclass(frozen=True)
class Film:
    """States of all swings, along the number of the swing.

    Attributes:
        states: of them; title: of the table of the shapes; head: of its columns after the first.
        told: of every shape its name, the cells of its row, and its first and last state.
        start: number of the shape that is shown first.
    """

    states: Equilibrium
    title: str
    head: list[str]
    told: list[dict[str, Any]]
    start: int


def film_of(result: Filmed) -> Film:
    """Return the swings of all shapes of a result.

    A mode moves as ``Re(shape exp(i phase))`` about its state, without growing or fading; that of a steady rotation
    seen from the turning axes. What a model gives way in swings about the critical state.

    Raises:
        InputError: there is no shape.
    """
    if isinstance(result, Buckling):
        return _of_buckling(result)
    modes = result.modes if isinstance(result, Steady) else result
    told: list[dict[str, Any]] = []
    scale, unit = scaled("Hz", modes.frequencies[:MOST_MODES])
    for k, name in enumerate(modes.names[:MOST_MODES]):
        s, hertz = complex(modes.eigenvalues[k]), float(modes.frequencies[k])
        swings = abs(s.imag) > 1e-9 * abs(s) or abs(s) == 0.0
        ratio: float | str = ""
        if hertz > 0.0:
            away = "grows" if s.real > 0.0 else "overdamped"
            ratio = float(above_rounding(modes.damping_ratios[k])) if swings else away
        told.append({"name": str(name), "cells": [scale * hertz, ratio]})
    around = np.broadcast_to(modes.positions, modes.shapes.shape)
    first = next((k for k, one in enumerate(told) if one["cells"][0] > 0.0), 0)
    head = ["mode", f"frequency [{unit}]", "damping ratio"]
    states = _swings(result, told, around, modes.shapes, modes.rotations)
    return Film(states, "Modes; a row that is chosen swings", head, told, first)


def _of_buckling(result: Buckling) -> Film:
    """Return how a model gives way at its critical loads."""
    errors = result.errors
    told = []
    for k, factor in enumerate(result.load_factors[:MOST_MODES].tolist()):
        kind = ("snaps" if result.limit[k] else "buckles") if result.exact else "linear problem"
        told.append(
            {"name": f"load factor {factor:.6g}", "cells": [kind, float(errors[k]) if len(errors) else ""]}
        )
    if not told:
        raise InputError("no critical loads were found, so there is no shape to show; see the report")
    head = ["critical load", "what it is", "mesh error"]
    states = _swings(result, told, result.positions, result.shapes, result.rotations)
    return Film(states, "Critical loads; the shape of a row that is chosen swings", head, told, 0)


def _swings(
    result: Filmed, told: list[dict[str, Any]], around: Floats, shapes: np.ndarray, turns: np.ndarray
) -> Equilibrium:
    """Return the states of all swings about positions ``(k, stations, 3)``, and note where each begins and ends."""
    phase = np.exp(2j * np.pi * np.arange(PHASES + 1) / PHASES)
    state = np.asarray(result.data["rotation"].values, dtype=float)[-1]
    positions: list[Floats] = []
    rotations: list[Floats] = []
    for k, one in enumerate(told):
        reach, turn = (max(float(np.abs(part).max()), 1e-300) for part in (shapes[k], turns[k]))
        size = float(np.ptp(around[k], axis=0).max()) or 1.0
        amplitude = min(REACH * size / reach, TURN / turn)
        # real roots have no phase: they swing all the same, to be seen
        moved = amplitude * (shapes[k][None] * phase[:, None, None]).real
        angle = amplitude * (turns[k][None] * phase[:, None, None]).real
        positions.append(around[k][None] + moved)
        rotations.append(_turned(state, angle))
        one |= {"first": k * (PHASES + 1), "last": k * (PHASES + 1) + PHASES}
    return Equilibrium(_states(result, np.concatenate(positions), np.concatenate(rotations)))


def _turned(state: Floats, angle: Floats) -> Floats:
    """Return rotations ``(stations, 4)`` turned by rotation vectors in body axes ``(n, stations, 3)``."""
    size = np.linalg.norm(angle, axis=-1, keepdims=True)
    ratio = 0.5 * np.sinc(size / (2.0 * np.pi))
    turn = np.concatenate([np.cos(0.5 * size), ratio * angle], axis=-1)
    whole = np.broadcast_to(state, turn.shape)
    return product(whole.reshape(-1, 4), turn.reshape(-1, 4)).reshape(turn.shape)


def _states(result: Filmed, positions: Floats, rotations: Floats) -> xr.Dataset:
    """Return the data set of an equilibrium with these states of a result's stations."""
    data, n = result.data, len(positions)
    moving = [
        name
        for name, variable in data.variables.items()
        if {result.dimension, "small_motion", "point", "critical", "linear", "joint_coordinate"}
        & set(variable.dims)
        or name == "part"
    ]
    kept = data.drop_vars(moving)
    spare = [name for name in kept.data_vars if not str(name).startswith(("reference", "connection"))]
    found = kept.drop_vars(spare).assign_coords(load_factor=np.arange(n) / PHASES)
    return found.assign(
        position=(("load_factor", "station", "axis"), positions),
        rotation=(("load_factor", "station", "quaternion"), rotations),
        elastic=("load_factor", np.zeros(n)),
    ).assign_attrs(kind=Equilibrium.kind)
