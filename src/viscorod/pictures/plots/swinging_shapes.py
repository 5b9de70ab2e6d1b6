"""How far a shape that swings is drawn, and what is drawn of a rod that twists: its centre line does not move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices, product
from viscorod.typing import Floats

__all__ = ["Swing", "after_turn"]

_TURN = 0.6
"""Largest turn of a section of a rod that is drawn twisting [rad]."""
_STILL = 0.1
"""Of the reach: centre lines that move less, while sections turn by that much, are drawn by the edges of the rod."""
_EDGE = 0.4
"""From the centre line to an edge that is drawn, as a part of the reach."""


@dataclass(frozen=True)
class Swing:
    """A shape about a state, as large as it is drawn.

    Attributes:
        base, moved: positions of the state and displacements, (stations, 3) [m].
        still: rotations of the state, (stations, 4).
        turn: rotation vectors of the shape in axes of the sections, (stations, 3) [rad].
        edge: distance of the edges that are drawn [m], 0 for the centre line.
    """

    base: Floats
    moved: Floats
    still: Floats
    turn: Floats
    edge: float

    @classmethod
    def of(cls, base: Floats, shape: Floats, still: Floats, turn: Floats, reach: float) -> Swing:
        """Return a shape whose largest displacement is drawn ``reach`` long [m].

        Sections that turn about the centre line while it rests are drawn: their displacements are rounding.

        Args:
            base, shape: positions and displacements, (stations, 3); still, turn: rotations, see the class.
            reach: of the drawn displacements [m].
        """
        largest = float(np.max(np.linalg.norm(shape, axis=-1)))
        twist = float(np.max(np.abs(turn[:, 2])))
        if _STILL * reach * twist > _TURN * largest:
            size = _TURN / twist
            return cls(base, size * shape, still, size * turn, _EDGE * reach)
        size = reach / largest if largest > 0.0 else 1.0
        return cls(base, size * shape, still, size * turn, 0.0)

    def rotations(self, sign: float) -> Floats:
        """Return the rotations at rest (0) and at both ends of the swing (1, -1), (stations, 4)."""
        return after_turn(self.still, sign * self.turn)

    def lines(self, sign: float) -> list[Floats]:
        """Return what is drawn at rest (0) and at both ends of the swing: one line or two edges, (stations, 3) [m]."""
        middle = self.base + sign * self.moved
        if not self.edge or not sign:
            return [middle]
        across = self.edge * matrices(self.rotations(sign))[:, :, 0]
        return [middle + across, middle - across]

    @property
    def all_lines(self) -> Floats:
        """Everything that is drawn, (lines, stations, 3) [m]."""
        return np.stack([line for sign in (0.0, 1.0, -1.0) for line in self.lines(sign)])

    @property
    def swept(self) -> Floats:
        """Normals of what lines sweep over from end to end, long where they move far, (lines, stations, 3)."""
        along = matrices(self.still)[:, :, 2]
        pairs = zip(self.lines(1.0), self.lines(-1.0), strict=True)
        return np.stack([np.cross(along, ahead - behind) for ahead, behind in pairs])


def after_turn(rotations: Floats, turn: Floats) -> Floats:
    """Return rotations ``(stations, 4)`` after turns about their own axes, rotation vectors ``(stations, 3)``."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    small = np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(angle / (2.0 * np.pi)) * turn], axis=-1)
    found: Floats = product(rotations, small)
    return found
