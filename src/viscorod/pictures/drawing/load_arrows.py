"""Arrows of loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from viscorod.model.actions.load import (
    AnyLoad,
    DistributedForce,
    DistributedMoment,
    Force,
    Gravity,
    Moment,
    MovingForce,
)
from viscorod.model.connections.resolved_places import position_of
from viscorod.model.description.model_description import ModelDescription
from viscorod.typing import Floats

ALONG = 9
"""Arrows of a load that is spread along a rod."""


@dataclass(frozen=True)
class Arrows:
    """A load in the reference shape.

    Attributes:
        text: size and what is special.
        unit: of the size; largest: size [N, N m, N/m or N m/m].
        turning: whether it is a moment.
        points: where it acts ``(n, 3)`` [m]; one, or a row along a rod.
        values: what acts there ``(n, 3)``, global components, largest 1.
    """

    text: str
    unit: str
    largest: float
    turning: bool
    points: Floats
    values: Floats


def arrows(model: ModelDescription) -> Iterator[Arrows]:
    """Yield all loads but gravity, without those that are zero."""
    for load in model.loads:
        if isinstance(load, Force | Moment):
            point, frame = position_of(model, model.place(load.at))
            frame = frame if load.following else np.eye(3)
            unit = "N m" if isinstance(load, Moment) else "N"
            yield from _scaled(load, unit, load.following, point[None], (frame @ load.value)[None])
        elif isinstance(load, DistributedForce | DistributedMoment):
            rod = model.rods[load.rod]
            s = np.linspace(load.from_s or 0.0, load.to_s or rod.length, ALONG)
            points, frames = rod.frames(s)
            values = np.array([load.density(float(x)) for x in s])
            if load.following:
                values = np.einsum("nij,nj->ni", frames, values)
            unit = "N m/m" if isinstance(load, DistributedMoment) else "N/m"
            yield from _scaled(load, unit, load.following, points, values)
        elif isinstance(load, MovingForce):
            rod = model.rods[load.rod]
            at = float(np.clip(load.arc_length(0.0), 0.0, rod.length))
            points, frames = rod.frames([at])
            value = np.array(load.value)
            yield from _scaled(
                load, "N", load.following, points, (frames[0] @ value if load.following else value)[None]
            )


def gravity(model: ModelDescription) -> Floats:
    """Return the sum of all gravity loads (3,) [m/s^2]."""
    values = [np.array(load.acceleration) for load in model.loads if isinstance(load, Gravity)]
    return np.sum(values, axis=0) if values else np.zeros(3)


def _scaled(load: AnyLoad, unit: str, following: bool, points: Floats, values: Floats) -> Iterator[Arrows]:
    sizes = np.linalg.norm(values, axis=1)
    largest = float(sizes.max())
    if largest == 0.0:
        return
    text = f"{largest:.3g} {unit}"
    if len(points) > 1 and float(sizes.min()) < 0.999 * largest:
        text = f"up to {text}"
    text += ", travels" if isinstance(load, MovingForce) else ""
    text += ", follows" if following else ""
    text += "" if load.time is None else ", varies in time"
    text += "" if load.until is None else f", until {load.until:g} s"
    turning = isinstance(load, Moment | DistributedMoment)
    yield Arrows(text, unit, largest, turning, points, values / largest)
