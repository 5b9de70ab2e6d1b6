"""Small motions as states that follow each other: every mode swings once, with an amplitude that can be seen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.mechanics.rotations.quaternion import product
from viscorod.results.modes_result import Modes
from viscorod.results.run import Equilibrium
from viscorod.results.steady_result import Steady
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MOST_MODES", "film_of"]

MOST_MODES = 40
"""Modes of a page at most."""
PHASES = 24
"""States of one swing; its first one comes again at its end."""
REACH, TURN = 0.1, 0.6
"""Largest displacement over the size of the model, and largest rotation [rad]; the smaller of the two."""


def film_of(result: Modes | Steady) -> tuple[Equilibrium, list[dict[str, Any]]]:
    """Return the states of all swings, along the number of the swing, and what is told of each mode.

    A mode moves as ``Re(shape exp(i phase))`` about its state, without growing or fading; that of a steady rotation
    seen from the turning axes.
    """
    modes = result.modes if isinstance(result, Steady) else result
    count = min(len(modes.eigenvalues), MOST_MODES)
    phase = np.exp(2j * np.pi * np.arange(PHASES + 1) / PHASES)
    state = np.asarray(result.data["rotation"].values, dtype=float)[-1]
    size = float(np.ptp(modes.positions, axis=0).max()) or 1.0
    positions: list[Floats] = []
    rotations: list[Floats] = []
    told: list[dict[str, Any]] = []
    for k in range(count):
        shape, turned = modes.shapes[k], modes.rotations[k]
        reach, turn = (max(float(np.abs(part).max()), 1e-300) for part in (shape, turned))
        amplitude = min(REACH * size / reach, TURN / turn)
        # real roots have no phase: they swing all the same, to be seen
        moved = amplitude * (shape[None] * phase[:, None, None]).real
        angle = amplitude * (turned[None] * phase[:, None, None]).real
        positions.append(modes.positions[None] + moved)
        rotations.append(_turned(state, angle))
        s = complex(modes.eigenvalues[k])
        told.append(
            {
                "name": str(modes.names[k]),
                "frequency": float(modes.frequencies[k]),
                "damping": float(modes.damping_ratios[k]),
                "swings": abs(s.imag) > 1e-9 * abs(s) or abs(s) == 0.0,
                "first": k * (PHASES + 1),
                "last": k * (PHASES + 1) + PHASES,
            }
        )
    return Equilibrium(_states(result, np.concatenate(positions), np.concatenate(rotations))), told


def _turned(state: Floats, angle: Floats) -> Floats:
    """Return rotations ``(stations, 4)`` turned by rotation vectors in body axes ``(n, stations, 3)``."""
    size = np.linalg.norm(angle, axis=-1, keepdims=True)
    ratio = 0.5 * np.sinc(size / (2.0 * np.pi))
    turn = np.concatenate([np.cos(0.5 * size), ratio * angle], axis=-1)
    whole = np.broadcast_to(state, turn.shape)
    return product(whole.reshape(-1, 4), turn.reshape(-1, 4)).reshape(turn.shape)


def _states(result: Modes | Steady, positions: Floats, rotations: Floats) -> xr.Dataset:
    """Return the data set of an equilibrium with these states of a result's stations."""
    data, n = result.data, len(positions)
    moving = [
        name
        for name, variable in data.variables.items()
        if {result.dimension, "small_motion", "point"} & set(variable.dims) or name == "part"
    ]
    kept = data.drop_vars(moving)
    spare = [name for name in kept.data_vars if not str(name).startswith(("reference", "connection"))]
    found = kept.drop_vars(spare).assign_coords(load_factor=np.arange(n) / PHASES)
    return found.assign(
        position=(("load_factor", "station", "axis"), positions),
        rotation=(("load_factor", "station", "quaternion"), rotations),
        elastic=("load_factor", np.zeros(n)),
    ).assign_attrs(kind=Equilibrium.kind)
