"""Clusters of places of a model that move as one rigid piece."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, TypeAlias

from viscorod.model.connections.place import ROUND_OFF, AnyPlace, BodyPlace, find_place

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["Piece", "Pieces"]

Piece: TypeAlias = tuple[str, float]
"""The representative of a piece: a body, or the first of its stations that was named."""


class Pieces:
    """Places that are the same station of a rod, are on one body, or are joined by attachments."""

    def __init__(self, model: ModelDescription) -> None:
        self._rods = model.rods
        self._stations: dict[str, list[float]] = {}
        self._before: dict[Piece, Piece] = {}
        self._bodies: set[Piece] = set()
        mentioned: dict[Piece, AnyPlace] = {}
        for attachment in model.attachments:
            ends = [find_place(text, model.rods, model.bodies) for text in (attachment.a, attachment.b)]
            first, second = (self._own(place) for place in ends)
            mentioned.setdefault(first, ends[0])
            mentioned.setdefault(second, ends[1])
            self._join(self._root(first), self._root(second))
        groups: dict[Piece, list[AnyPlace]] = {}
        for own, place in mentioned.items():
            groups.setdefault(self._root(own), []).append(place)
        self.groups = [tuple(group) for group in groups.values()]
        self._bodies.update(
            root for root, group in groups.items() if any(isinstance(p, BodyPlace) for p in group)
        )

    def of(self, place: AnyPlace) -> Piece:
        """Return a representative of the piece of a place, which is the same for all places of the piece."""
        return self._root(self._own(place))

    def has_body(self, place: AnyPlace) -> bool:
        """Return whether a rigid body belongs to the piece of a place."""
        return isinstance(place, BodyPlace) or self.of(place) in self._bodies

    def _own(self, place: AnyPlace) -> Piece:
        """Return a representative of the place alone; stations within round-off of an earlier one are that one."""
        if isinstance(place, BodyPlace):
            return place.body, -1.0
        known = self._stations.setdefault(place.rod, [])
        at = bisect_left(known, place.s)
        for s in known[max(at - 1, 0) : at + 1]:
            if abs(s - place.s) <= ROUND_OFF * self._rods[place.rod].length:
                return place.rod, s
        known.insert(at, place.s)
        return place.rod, place.s

    def _root(self, piece: Piece) -> Piece:
        while piece in self._before:
            above = self._before[piece]
            if above in self._before:
                self._before[piece] = self._before[above]
            piece = above
        return piece

    def _join(self, first: Piece, second: Piece) -> None:
        if first != second:
            self._before[second] = first
