"""Checks of supports: pairs that hold the same motion, and supports of bodies away from their mass centres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, combinations
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import Fault
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import BodyPlace
from viscorod.model.connections.resolved_places import position_of, resolved_supports, size_of
from viscorod.model.connections.rigid_clusters import Piece, Pieces
from viscorod.model.connections.support_base import ResolvedSupport
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["clashes", "off_centre"]

APART = 1e-9
"""Distance of supports of one node, as a part of the model's size, from which on their points differ."""


def off_centre(model: ModelDescription) -> Iterator[Fault]:
    """Find supports at named points of bodies that hold some motions only: the held motions depend on the rotation."""
    for support in resolved_supports(model) if model.bodies else ():
        place = support.place
        if isinstance(place, BodyPlace) and place.point is not None and support.fixed != MOTIONS:
            yield Fault(
                f"{support.path}.at",
                support.label,
                "a point of a rigid body beside its mass centre can be clamped only",
                f"support the body at its centre, {place.body!r}, or use a joint to ground",
            )


def clashes(model: ModelDescription) -> Iterator[Fault]:
    """Find pairs of supports that hold the same motion of the same node.

    Two supports clash when the directions they hold are linearly dependent, whatever axes they are given in.
    Displacements of different points of one rigid piece do not clash.
    """
    if len(model.supports) < 2:
        return
    pieces = Pieces(model)
    size = APART * size_of(model)
    together: dict[Piece, list[ResolvedSupport]] = {}
    for support in resolved_supports(model):
        together.setdefault(pieces.of(support.place), []).append(support)
    for first, second in chain.from_iterable(combinations(group, 2) for group in together.values()):
        a, b = (position_of(model, support.place)[0] for support in (first, second))
        words_of = {"displacement": MOTIONS[:3], "rotation": MOTIONS[3:]}
        if pieces.has_body(first.place) and np.linalg.norm(a - b) > size:
            del words_of["displacement"]
        for noun, words in words_of.items():
            both = np.vstack([_directions(support, words) for support in (first, second)])
            if len(both) and np.linalg.matrix_rank(both, tol=1e-8) < len(both):
                common = [word for word in words if word in first.held and word in second.held]
                what = ", ".join(common) if common and first.frame == second.frame else f"a {noun}"
                yield Fault(
                    f"{second.path}.at",
                    f"{second.label}, with {first.label} ({first.path}) before it",
                    f"both hold {what} of the same node",
                    "leave one of the two supports out, or let each hold other motions",
                )
                break


def _directions(support: ResolvedSupport, words: Sequence[str]) -> Floats:
    columns = [index for index, word in enumerate(words) if word in support.held]
    return support.axes[:, columns].T.reshape(-1, 3)
