"""Arrows of loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from viscorod.model.actions.load import AnyLoad
from viscorod.model.actions.load_effects import Arrows
from viscorod.model.connections.resolved_places import position_of
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.text_numbers import quantity
from viscorod.typing import Floats


@dataclass(frozen=True)
class DrawnLoad:
    """A load in the reference shape.

    Attributes:
        text: size and what is special.
        unit: of the size; largest: size [N, N m, N/m or N m/m].
        turning: whether it is a moment.
        points: where it acts ``(n, 3)`` [m].
        values: what acts there ``(n, 3)``, global components, largest 1.
    """

    text: str
    unit: str
    largest: float
    turning: bool
    points: Floats
    values: Floats

    @property
    def spread(self) -> bool:
        """Whether it is a load per length, with its points in a row along a rod."""
        return self.unit.endswith("/m")


def arrows(model: ModelDescription) -> Iterator[DrawnLoad]:
    """Yield all loads but gravity, without those that are zero."""
    for load in model.loads:
        drawn = load.arrows(model, 0.0)
        if not drawn.feet or not drawn.values.any():
            continue
        points, frames = (
            np.stack(part) for part in zip(*(position_of(model, foot) for foot in drawn.feet), strict=True)
        )
        values = np.einsum("nij,nj->ni", frames, drawn.values) if drawn.following else drawn.values
        sizes = np.linalg.norm(values, axis=1)
        largest = float(sizes.max())
        text = _text(load, drawn, sizes)
        yield DrawnLoad(text, drawn.unit, largest, drawn.turning, points, values / largest)


def gravity(model: ModelDescription) -> Floats:
    """Return the sum of all gravity loads (3,) [m/s^2]: of those that act on everything."""
    drawn = [load.arrows(model, 0.0) for load in model.loads]
    total: Floats = np.sum([np.zeros(3), *(each.values[0] for each in drawn if not each.feet)], axis=0)
    return total


def _text(load: AnyLoad, drawn: Arrows, sizes: Floats) -> str:
    """Return its size and what is special."""
    text = quantity(float(sizes.max()), drawn.unit, 3)
    if float(sizes.min()) < 0.999 * sizes.max():
        text = f"up to {text}"
    text += ", travels" if load.travels else ""
    text += ", follows" if drawn.following else ""
    text += "" if load.time is None else ", varies in time"
    return text + ("" if load.until is None else f", until {quantity(load.until, 's')}")
