"""From the words for a place ("beam.end", "beam@0.15", "plate", a station's number) to weights on the stations."""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.rotations.quaternion import mean
from viscorod.typing import Floats, Integers
from viscorod.units import si_value
from viscorod.wording import RefusedError

if TYPE_CHECKING:
    from viscorod.results.state_arrays import Stored

_PLACE = re.compile(r"(?P<rod>.+?)(?:\.(?P<end>start|end)|@(?P<s>[^@]+))")


@dataclass(frozen=True)
class ResultPlace:
    """A point of a rod or body as a combination of stored stations.

    Attributes:
        label: the place in words, "beam.end", "beam@0.15", "plate" or "plate.corner".
        rod: name of the rod, or the place on the body.
        s: arc length in the reference shape [m], 0 on bodies.
        stations: numbers of the stations that take part, shape (k,).
        weights: their weights, summing to one, shape (k,).
    """

    label: str
    rod: str
    s: float
    stations: Integers
    weights: Floats

    def of(self, values: Floats) -> Floats:
        """Return the value here of a field ``(..., station, components)``."""
        return self.mixed(values[..., self.stations, :])

    def mixed(self, values: Floats) -> Floats:
        """Return the value here of a field at the stations that take part ``(..., k, components)``."""
        result: Floats = np.einsum("...kc,k->...c", values, self.weights)
        return result

    def rotation(self, quaternions: Floats) -> Floats:
        """Return the unit quaternion here of the orientations ``(station, 4)``."""
        return mean(quaternions[self.stations], self.weights)


def _in_metres(place: str, text: str) -> float:
    """Return an arc length such as "150 mm" [m]."""
    try:
        return si_value(text, "m", place)
    except RefusedError as error:
        raise InputError(f"{place!r}: {text!r} is not an arc length ({error.why}); {error.instead}") from None


class ResultPlaces:
    """All stations of a data set: those of rods by arc length, and places on rigid bodies."""

    def __init__(self, data: Stored) -> None:
        self._take(*(data.variables[f"station_{name}"].values for name in ("rod", "s", "order")))

    @classmethod
    def of(cls, rods: np.ndarray, s: Floats, order: Integers) -> ResultPlaces:
        """Return stations by their rods, arc lengths [m] and orders of elements ``(k,)``, without a data set."""
        sites = cls.__new__(cls)
        sites._take(rods, s, order)
        return sites

    def _take(self, rods: np.ndarray, s: Floats, order: Integers) -> None:
        rods = np.asarray(rods, dtype=str)
        self._s = np.asarray(s, dtype=float)
        self._order = np.asarray(order, dtype=int)
        self._rod_of_station = rods
        self._bodies = {str(rods[k]): int(k) for k in np.flatnonzero(self._order == 0)}
        mine = self._order > 0
        self._stations = {
            rod: k[np.argsort(self._s[k], kind="stable")] for rod, k in by_name(rods, mine).items()
        }
        self._arc = {rod: self._s[stations] for rod, stations in self._stations.items()}

    @property
    def rods(self) -> tuple[str, ...]:
        """Names of the rods, in the order of the data set."""
        return tuple(self._stations)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The mass centres and named points of rigid bodies: "plate", "plate.corner"."""
        return tuple(self._bodies)

    def stations(self, part: str) -> Integers:
        """Return the station numbers of a rod, by increasing arc length, or the one of a place on a body."""
        if part in self._bodies:
            return np.array([self._bodies[part]], dtype=np.int64)
        return self._stations[part]

    def ends(self, rod: str) -> tuple[ResultPlace, ResultPlace]:
        """Return the two ends of a rod."""
        return self.at(f"{rod}.start"), self.at(f"{rod}.end")

    def at(self, place: str | int) -> ResultPlace:
        """Resolve a place.

        Args:
            place: "rod.start", "rod.end", "rod@s" with the arc length s [m], "body" (its mass centre), "body.point", or
                the number of a station. Between stations the value is that of the element's own polynomial.

        Raises:
            InputError: no such rod, body, point, station or form, or the arc length lies outside the rod.
        """
        if isinstance(place, (int, np.integer)):
            return self._numbered(int(place))
        if place in self._bodies:
            return self._numbered(self._bodies[place])
        match = _PLACE.fullmatch(place)
        rod = place.partition(".")[0] if match is None else match["rod"]
        if rod in self._bodies or (self._bodies and rod not in self._stations):
            near = difflib.get_close_matches(place, self._known(), n=1) or self.bodies
            raise InputError(f"{place!r}: there is no such place; did you mean {near[0]!r}?")
        if match is None:
            whole = place in self._stations
            rod = place if whole else self.rods[0]
            raise InputError(
                f"{place!r} is {'a rod, not a place on it' if whole else 'no place'}; "
                f"write {rod}.start, {rod}.end, {rod}@s with the arc length s in m, or the number of a station"
            )
        if rod not in self._stations:
            near = difflib.get_close_matches(rod, self.rods, n=1) or self.rods
            raise InputError(f"{place!r}: no rod is called {rod!r}; did you mean {near[0]!r}?")
        stations = self._stations[rod]
        if match["end"] is not None:
            return self._numbered(int(stations[0 if match["end"] == "start" else -1]))
        try:
            s = float(match["s"])
        except ValueError:
            s = _in_metres(place, match["s"])
        return self.along(rod, s)

    def along(self, rod: str, s: float) -> ResultPlace:
        """Return the site at arc length ``s`` [m] of a rod.

        Raises:
            InputError: ``s`` lies outside the rod.
        """
        stations, known = self._stations[rod], self._arc[rod]
        slack = 1e-9 * max(known[-1] - known[0], np.finfo(float).tiny)
        if not known[0] - slack <= s <= known[-1] + slack:
            raise InputError(
                f"{rod}@{s:g} lies outside the rod; its arc length runs from {known[0]:g} to {known[-1]:g} m"
            )
        after = int(np.searchsorted(known, s))
        nearest = min((k for k in (after - 1, after) if 0 <= k < known.size), key=lambda k: abs(known[k] - s))
        if abs(known[nearest] - s) <= slack:
            return self._numbered(int(stations[nearest]))
        chosen, weights = self.weights(rod, np.array([s]))
        return ResultPlace(f"{rod}@{s:g}", rod, float(s), chosen[0], weights[0])

    def weights(self, rod: str, s: Floats) -> tuple[Integers, Floats]:
        """Return stations ``(k, order + 1)`` and their weights at arc lengths ``s (k,)`` [m], all within the rod."""
        stations, known = self._stations[rod], self._arc[rod]
        order = int(self._order[stations[0]])
        ends = known[::order]
        element = np.clip(np.searchsorted(ends, s, side="right") - 1, 0, ends.size - 2)
        chosen = order * element[:, None] + np.arange(order + 1)
        return stations[chosen], lagrange_weights(known[chosen], s)

    def _known(self) -> list[str]:
        """Return all places that have names."""
        return [*self.bodies, *(f"{rod}.{end}" for rod in self.rods for end in ("start", "end"))]

    def _numbered(self, station: int) -> ResultPlace:
        count = self._s.size
        if not -count <= station < count:
            raise InputError(f"there is no station {station}; stations are numbered 0 to {count - 1}")
        station %= count
        rod = str(self._rod_of_station[station])
        at, one = np.array([station], dtype=np.int64), np.ones(1)
        if rod in self._bodies:
            return ResultPlace(rod, rod, 0.0, at, one)
        mine = self._stations[rod]
        if station == mine[0]:
            label = f"{rod}.start"
        elif station == mine[-1]:
            label = f"{rod}.end"
        else:
            label = f"{rod}@{self._s[station]:g}"
        return ResultPlace(label, rod, float(self._s[station]), at, one)


def by_name(names: np.ndarray, chosen: np.ndarray | None = None) -> dict[str, Integers]:
    """Return the places in ``names`` at which each of them stands, increasing, in the order in which they come.

    Args:
        names: texts ``(k,)``; chosen: which of them count ``(k,)``, by default all.
    """
    at = np.arange(len(names)) if chosen is None else np.flatnonzero(chosen)
    if not len(at):
        return {}
    unique, first, number = np.unique(names[at], return_index=True, return_inverse=True)
    order = np.argsort(number, kind="stable")
    groups = np.split(at[order], np.cumsum(np.bincount(number))[:-1])
    return {str(unique[k]): groups[k] for k in np.argsort(first)}


def lagrange_weights(nodes: Floats, s: Floats | float) -> Floats:
    """Return the values at ``s (...)`` of the Lagrange polynomials of ``nodes (..., n)``."""
    count = nodes.shape[-1]
    difference = nodes[..., :, None] - nodes[..., None, :]
    numerator = np.broadcast_to((np.asarray(s)[..., None] - nodes)[..., None, :], difference.shape).copy()
    own = np.arange(count)
    difference[..., own, own] = numerator[..., own, own] = 1.0
    weights: Floats = np.prod(numerator / difference, axis=-1)
    return weights
