"""Loads that a support takes over where they act, so that they change nothing but its reaction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from viscorod.model.actions.load import Force, Moment
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.support_base import ResolvedSupport
from viscorod.model.description.model_description import ModelDescription

__all__ = ["carried_loads"]

ALONG = 1e-9
"""Part of a force along an axis of a support that is none."""


def carried_loads(model: ModelDescription) -> Iterator[str]:
    """Yield which forces and moments act where a support holds all that they push."""
    loads = [
        (k, load)
        for k, load in enumerate(model.loads)
        if isinstance(load, Force | Moment) and np.any(load.wrench)
    ]
    if not loads:
        return
    supports = model.resolved_supports()
    for number, load in loads:
        place = model.place(load.at)
        for support in supports:
            if support.place == place and _holds(support, load):
                yield (
                    f"loads[{number}]: the {load.word} at {load.at} acts where {support.path}, the {support.label}, "
                    "holds what it pushes: it changes nothing but the reaction there; is another place meant?"
                )
                break


def _holds(support: ResolvedSupport, load: Force | Moment) -> bool:
    """Return whether a support holds a load whatever moves: all of its words, or those that a dead force has."""
    words = MOTIONS[3:] if isinstance(load, Moment) else MOTIONS[:3]
    if set(words) <= set(support.held):
        return True
    if isinstance(load, Moment) or load.following or support.frame not in ("global", "axes"):
        return False
    along = np.abs(support.axes.T @ np.array(load.value))
    needed = {word for word, part in zip(words, along, strict=True) if part > ALONG * along.max()}
    return needed <= set(support.held)
