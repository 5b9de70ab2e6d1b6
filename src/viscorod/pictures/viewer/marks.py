"""Points that move with the model and bear symbols: supports, loads, joints, bodies, places that leave a trace."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result
    from viscorod.results.result_places import ResultPlace

__all__ = ["Marks"]


class Marks:
    """Tracks of points and of orientations over the frames of a page.

    Args:
        result: whose stations they follow.
        positions, rotations: of all stations in the frames, ``(n, stations, 3)`` [m] and ``(n, stations, 4)``.
    """

    def __init__(self, result: Result, positions: Floats, rotations: Floats) -> None:
        self.positions, self.rotations = positions, rotations
        self._reference = np.asarray(result.data["reference_rotation"].values, dtype=float)
        self._points: list[Floats] = []
        self._turns: list[Floats] = []
        self._places: dict[tuple[int, ...], int] = {}

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.positions)

    def site(self, site: ResultPlace) -> int:
        """Add a point of a rod or body with the axes of its section; returns its number."""
        key = tuple(site.stations.tolist())
        if len(key) == 1 and key in self._places:
            return self._places[key]
        nearest = int(site.stations[np.argmax(np.abs(site.weights))])
        number = self.add(site.of(self.positions), self.rotations[:, nearest])
        if len(key) == 1:
            self._places[key] = number
        return number

    def add(self, track: Floats, turn: Floats | None = None) -> int:
        """Add a track ``(n, 3)`` [m] with orientations ``(n, 4)``, by default the global axes; returns its number."""
        still = np.tile([1.0, 0.0, 0.0, 0.0], (self.frames, 1))
        self._points.append(np.broadcast_to(track, (self.frames, 3)))
        self._turns.append(still if turn is None else turn)
        return len(self._points) - 1

    def turned(self, station: int, vector: Floats) -> Floats:
        """Return a direction (3,) of the reference shape, carried along by a station ``(n, 3)``; -1 is the ground."""
        if station < 0:
            return np.tile(vector, (self.frames, 1))
        q = product(self.rotations[:, station], conjugate(self._reference[station][None]))
        carried: Floats = np.einsum("nij,j->ni", matrices(q), vector)
        return carried

    @property
    def points(self) -> Floats:
        """All tracks ``(n, marks, 3)`` [m]."""
        return np.stack(self._points, axis=1) if self._points else np.zeros((self.frames, 0, 3))

    @property
    def turns(self) -> Floats:
        """All orientations ``(n, marks, 4)``."""
        return np.stack(self._turns, axis=1) if self._turns else np.zeros((self.frames, 0, 4))
