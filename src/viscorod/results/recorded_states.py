"""A data set with stored states of a model, and what follows from it alone: places, vectors, ranges, a drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np

from viscorod.alike import Alike
from viscorod.attributes import WellNamed
from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.array_pieces import extremes
from viscorod.results.data_schema import AXES, DIMENSION, annotated
from viscorod.results.mesh_error import mesh_errors
from viscorod.results.result_places import ResultPlace, ResultPlaces
from viscorod.results.state_arrays import StateArrays, Stored
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing, on_paper
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.solve.stress.recorded_rods import RecordedRods

__all__ = ["Quantity", "RecordedStates"]

_ROUNDING = 1e-13
"""Of the size of the model, as which positions that rest are computed."""

Quantity: TypeAlias = Literal[
    "position",
    "displacement",
    "rotation",
    "frame",
    "velocity",
    "angular_velocity",
    "strain",
    "section_force",
    "dissipation",
]
"""What ``probe`` and ``history`` have, and a table of histories."""


class RecordedStates(WellNamed, Shown, Alike):
    """A data set with stored states of a model: positions of its stations, and more."""

    kind: ClassVar[str]
    _build: Callable[[], Stored]

    def __init__(self, data: xr.Dataset) -> None:
        if not hasattr(data, "data_vars"):
            raise InputError(
                f"data: {type(data).__name__}: a result is made of an xarray.Dataset; "
                "viscorod.load reads one from a file"
            )
        self.data = annotated(data, self.kind)

    @classmethod
    def owning(cls, data: xr.Dataset) -> Self:
        """Return a result of a data set that nobody else has; it is not copied."""
        result = cls.__new__(cls)
        result.data = annotated(data, cls.kind, own=True)
        return result

    @classmethod
    def later(cls, build: Callable[[], Stored]) -> Self:
        """Return a result whose arrays, and data set, are built on first use; ``build`` must not depend on when."""
        result = cls.__new__(cls)
        result._build = build
        return result

    @cached_property
    def data(self) -> xr.Dataset:
        """The ``xarray.Dataset`` behind everything; names and units are in ``viscorod.results.data_schema``."""
        made = self._built
        data = annotated(made.data_set() if isinstance(made, StateArrays) else made, self.kind, own=True)
        vars(self).pop("_built", None)
        del self._build
        return data

    @cached_property
    def _built(self) -> Stored:
        return self._build()

    @property
    def stored(self) -> Stored:
        """What numbers are read from: the data set, or before it is there the arrays that it will be made of.

        To arrange them as a data set takes several times as long as to read some numbers.
        """
        return self.data if "data" in vars(self) else self._built

    @cached_property
    def sites(self) -> ResultPlaces:
        """The stations, by rod and arc length."""
        stored = self.stored
        known = stored.sites if isinstance(stored, StateArrays) else None
        return ResultPlaces(stored) if known is None else known

    def _content(self) -> Any:
        return self.data

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.data,)

    @property
    def dimension(self) -> str:
        """Name of the dimension along which states are stored: "time" or "load_factor"."""
        return DIMENSION[self.kind]

    @property
    def title(self) -> str:
        """Title of the case, empty if it has none."""
        return str(self.stored.attrs.get("title", ""))

    @property
    def outcome(self) -> str:
        """The word "completed", or what stopped the solution."""
        return str(self.stored.attrs.get("outcome", "completed"))

    def vector(self, site: ResultPlace, quantity: Quantity) -> Floats:
        """Return a vector at a site, ``(time or load_factor, axis)``, global axes, SI; other stations are not read."""
        return site.mixed(self._field(quantity, slice(None), site.stations))

    @checked
    def field(
        self, quantity: Quantity, *, states: int | slice = slice(None), stations: Integers | None = None
    ) -> Floats:
        """Return a vector at all stations in all states, or in some; what is left out is not read.

        Args:
            quantity: as of ``history``.
            states: which of the stored states; one number leaves their dimension out.
            stations: numbers of the stations ``(k,)``.

        Returns:
            Array ``(time or load_factor, station, axis)``, global axes, SI.

        Raises:
            InputError: no such quantity.
        """
        return self._field(quantity, states, stations)

    def _field(self, quantity: Quantity, states: int | slice, stations: Integers | None) -> Floats:
        """Do what :meth:`field` does, whose arguments are checked."""
        stored = self.stored
        known = ("position", "displacement") + (("velocity",) if "velocity" in stored else ())
        if quantity not in known:
            raise InputError(f"quantity = {quantity!r} is not stored; it can be {', '.join(known)}")
        name = "velocity" if quantity == "velocity" else "position"
        found: Any = stored.variables[name]
        reference: Any = stored.variables["reference_position"]
        try:
            found = found.isel({self.dimension: states})
            if stations is not None:
                found, reference = found.isel(station=stations), reference.isel(station=stations)
        except (IndexError, KeyError, TypeError, ValueError) as error:
            sizes = f"{stored.sizes[self.dimension]} states and {stored.sizes['station']} stations"
            raise InputError(
                f"states, stations: {states!r}, {stations!r}: these are no numbers of states or stations ({error}); "
                f"there are {sizes}, numbered from 0"
            ) from None
        values = np.asarray(found.values, dtype=float)
        return values - reference.values if quantity == "displacement" else values

    @cached_property
    def recorded_rods(self) -> RecordedRods:
        """The sections of the rods, from what is kept of the model."""
        from viscorod.solve.stress.recorded_rods import RecordedRods

        lengths = {rod: float(self.sites.ends(rod)[1].s) for rod in self.sites.rods}
        return RecordedRods(self.stored.attrs, lengths)

    @cached_property
    def displacement_range(self) -> tuple[Floats, Floats]:
        """The least and the largest displacement of every station over all states [m], ``(station, axis)`` each."""
        reference = np.asarray(self.stored["reference_position"].values, dtype=float)
        low, high = extremes(self, "position")
        return low - reference, high - reference

    @cached_property
    def mesh_errors(self) -> dict[str, float]:
        """Estimated error of positions by the mesh, as a part of the length of each rod; see ``results.mesh_error``.

        The largest over the states that were compared with a mesh of elements half as long.
        """
        return mesh_errors(self)

    @cached_property
    def rests(self) -> bool:
        """Whether nothing moves from state to state, but for what rounding leaves; so it is of one state alone."""
        low, high = self.displacement_range
        size = float(np.abs(self.field("position", states=0)).max(initial=0.0))
        return float((high - low).max(initial=0.0)) <= _ROUNDING * size

    @cached_property
    def main_motion(self) -> tuple[ResultPlace, str]:
        """The station and the global axis whose displacement has the largest range; the largest where nothing moves."""
        low, high = self.displacement_range
        spread = np.abs(high) if self.rests else high - low
        station, axis = np.unravel_index(int(np.argmax(spread)), spread.shape)
        return self.sites.at(int(station)), AXES[int(axis)]

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.sites.rods), "rod")
        bodies = {place.partition(".")[0] for place in self.sites.bodies}
        if bodies:
            yield counted(len(bodies), "body", "bodies")
        yield counted(int(self.stored.sizes["station"]), "station")
        if self.outcome != "completed":
            yield self.outcome

    def _drawing(self) -> str:
        """Return the reference shape, dashed, and the shape in the last state."""
        reference = np.asarray(self.stored["reference_position"].values, dtype=float)
        return self._shapes(reference, self.field("position", states=-1))

    def _shapes(self, faint: Floats, main: Floats) -> str:
        """Return a small drawing of two shapes, positions of the stations ``(station, 3)`` each."""
        parts = [self.sites.stations(rod) for rod in self.sites.rods]
        bodies = np.array([int(self.sites.stations(body)[0]) for body in self.sites.bodies], dtype=int)
        seen = on_paper([*(faint[k] for k in parts), *(main[k] for k in parts), main[bodies]])
        drawing = Drawing()
        for number, line in enumerate(seen[:-1]):
            drawing.line(line, faint=number < len(parts))
        drawing.dots(seen[-1])
        return drawing.svg()
