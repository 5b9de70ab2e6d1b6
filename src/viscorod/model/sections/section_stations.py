"""Sections known at stations along a rod, as tables of blades give them: listed, or the rows of a file."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, model_validator

from viscorod.errors import InputError
from viscorod.model.fields.definition import Definition, RefusedError, base_init, show
from viscorod.model.fields.forms import TEXT, listed, of_kind
from viscorod.model.fields.metadata import TABLES, Accepts, Key, accepts
from viscorod.model.fields.values import NonNegative, OptionalNumber, OptionalText, one_of, sequence, word
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_kinds import SectionField
from viscorod.model.sections.section_shapes import SHAPES
from viscorod.model.sections.station_file import STIFFNESS, station_rows
from viscorod.model.sections.stiffness_section import strain_times
from viscorod.model.sections.taper import Taper

__all__ = ["Station", "Stations", "TwistOfStations"]

MOST_KNOWN = 10_000
"""Sections along a rod that are kept."""


class Station(Definition):
    """A section at a station of a rod."""

    at: NonNegative = Key("arc length", "m")
    section: SectionField = Key("at the station; all have the same shape")
    twist: OptionalNumber = Key(
        "angle of the section about d3, relative to the rotation-minimising frame; {}; at all stations or at none",
        "rad",
        default=None,
    )


def _as_stations(value: Any) -> list[Any] | None:
    """Turn pairs (at, section), and triples with the twist, into tables."""
    if value is None:
        return None
    if isinstance(value, str):
        raise RefusedError("a text, where a list is needed", f"give a file by name: file={value!r}")
    items = sequence(value)
    if len(items) < 2:
        raise RefusedError("at least two stations are needed", "give the section at the start and at the end")
    names = ("at", "section", "twist")
    return [
        dict(zip(names, item, strict=False))
        if isinstance(item, list | tuple) and 2 <= len(item) <= 3
        else item
        for item in items
    ]


@accepts(
    {"type": "object", "additionalProperties": {"anyOf": [{"type": "integer", "minimum": 1}, TEXT]}},
    "table of numbers from 1, or names in quotes",
)
def _columns(value: Any) -> tuple[tuple[str, str | int], ...]:
    value = dict(value) if isinstance(value, tuple) else value  # as it was kept
    if not isinstance(value, Mapping):
        raise RefusedError(
            "a table of columns is needed here", "give what is where, such as { s = 1, EA = 4 }"
        )
    return tuple(
        (word(key), item if isinstance(item, int) and not isinstance(item, bool) else word(item))
        for key, item in value.items()
    )


class TwistOfStations:
    """The twist between stations, linear, as a function of the arc length.

    Args:
        stations: arc lengths (n,), m; angles: there (n,), rad.
    """

    def __init__(self, stations: Sequence[float], angles: Sequence[float]) -> None:
        self.stations, self._angles = tuple(stations), tuple(angles)

    def __call__(self, s: float) -> float:
        """Return the angle at the arc length `s` [m], rad."""
        return float(np.interp(s, self.stations, self._angles))


class Stations(Definition):
    """Sections at stations along a rod, from its start to its end; linear between them.

    Between two stations every dimension of a shape is linear, every entry of the matrices of a `StiffnessSection`, and
    the twist. A station that is given twice is a jump.

    They are listed, or the rows of a file with a head of names, units in brackets behind them (SI without): `s` is the
    distance along the rod, `twist` the angle of the sections. Beside these stand the dimensions of the `shape` by
    their names, such as `width` and `height`; or stiffnesses GA1, GA2, EA, EI1, EI2, GJ and, where something moves,
    `mass` per length, J1, J2 and, where it is not their sum, J3. Bending stiffness is about the tension centre, GJ
    about the shear centre, and inertia about the mass centre. `tension centre 1`, `tension centre 2`,
    `shear centre 1` and so on say where along d1 and d2 these are, if not on the rod's line.
    """

    stations: Annotated[
        tuple[Station, ...] | None,
        BeforeValidator(_as_stations),
        Accepts(listed(of_kind("sections.station"), 2), TABLES),
    ] = Key("pairs (at, section) or triples (at, section, twist), in order", default=None)
    file: OptionalText = Key(
        "in place of the list, a text file with columns, such as blade.csv; its path from the case file on",
        default=None,
        kw_only=True,
    )
    shape: Annotated[str, one_of(STIFFNESS, "given", *SHAPES)] = Key(
        'of the sections in the file: "stiffness", "given" or a shape such as "rectangle"',
        default=STIFFNESS,
        kw_only=True,
    )
    columns: Annotated[Mapping[str, str | int] | tuple[tuple[str, str | int], ...], _columns] = Key(
        "of a file with other names: what is read, each with the name or number of its column; the rest is left out",
        default=(),
        kw_only=True,
    )
    times: Annotated[Sequence[float] | None, strain_times] = Key(
        "retardation times of the six strains, for stiffnesses in a file; {}", "s", default=None, kw_only=True
    )

    @base_init
    def __init__(
        self,
        stations: Sequence[Station | tuple[float, AnySection] | tuple[float, AnySection, float]]
        | None = None,
        **given: Any,
    ) -> None:
        super().__init__(**({} if stations is None else {"stations": stations}), **given)

    @model_validator(mode="after")
    def _usable(self) -> Self:
        self._one_source()
        self._forward()
        for k in range(len(self.given) - 1):
            self._taper(k)
        return self

    def _one_source(self) -> None:
        if (self.stations is None) == (self.file is None):
            raise RefusedError(
                "sections along a rod are listed, or read from a file",
                "give stations, or file",
                found="neither" if self.file is None else "both",
                at=("stations",) if self.file is None else ("file",),
            )
        if self.file is None:
            for name in ("shape", "columns", "times"):
                if name in self.model_fields_set:
                    raise RefusedError(
                        "this belongs to a file", "leave it out: the sections say it", at=(name,), found=""
                    )
        elif self.times is not None and self.shape != STIFFNESS:
            raise RefusedError(
                "retardation times belong to stiffnesses; the damping of a shape is that of its material",
                "leave times out",
                found="",
                at=("times",),
            )

    def _forward(self) -> None:
        at = [station.at for station in self.given]
        if at[0] != 0.0:
            raise self._refused(
                0, "s", "the first station must be the start of the rod", "begin with 0", at[0]
            )
        for k in range(1, len(at)):
            thrice = k > 1 and at[k - 2] == at[k]
            if at[k] < at[k - 1] or thrice:
                raise self._refused(
                    k,
                    "s",
                    "the same station three times or more"
                    if thrice
                    else "each station must lie further along than the one before",
                    f"give a number above {show(at[k - 1])}, or the same once more for a jump",
                    at[k],
                )
            if (self.given[k].twist is None) != (self.given[0].twist is None):
                raise self._refused(
                    k, "twist", "it is given at some stations only", "give it at all, or at none", ""
                )
        if at[-1] == 0.0:
            raise self._refused(len(at) - 1, "s", "all stations are at the start", "give one at the end", 0.0)

    def _refused(self, k: int, key: str, why: str, instead: str, found: Any) -> RefusedError:
        """Return the error about a station: at its key, or at the line of the file."""
        text = found if isinstance(found, str) else show(found)
        if self.file is None:
            return RefusedError(why, instead, found=text, at=("stations", k, "at" if key == "s" else key))
        return RefusedError(
            f"line {self._read[1][k]}, column {key}: {why}", instead, found=text, at=("file",)
        )

    def _taper(self, k: int) -> Taper:
        """Return what is between stations k and k + 1."""
        try:
            return Taper(self.given[k].section, self.given[k + 1].section)
        except InputError as error:
            problem = error.problems[0]
            raise self._refused(k + 1, "section", problem.why, problem.instead, problem.found) from None

    @cached_property
    def _read(self) -> tuple[tuple[Station, ...], list[int]]:
        """Stations of the file, and the lines where they stand."""
        assert self.file is not None
        rows = station_rows(self.file, self.shape, dict(self.columns), self.times)
        return tuple(Station(row.at, row.section, row.twist) for row in rows), [row.line for row in rows]

    @property
    def given(self) -> tuple[Station, ...]:
        """The stations, listed or read."""
        return self._read[0] if self.file is not None else self.stations or ()

    @cached_property
    def _course(self) -> tuple[list[float], list[Taper], dict[float, AnySection]]:
        """Arc lengths, what is between them, and the sections that were asked for."""
        return (
            [station.at for station in self.given],
            [self._taper(k) for k in range(len(self.given) - 1)],
            {},
        )

    @property
    def breaks(self) -> tuple[float, ...]:
        """Arc lengths of interior stations where the section jumps, m."""
        at = [station.at for station in self.given]
        return tuple(s for s, after in pairwise(at) if s == after and 0.0 < s < at[-1])

    @cached_property
    def twist(self) -> TwistOfStations | None:
        """The twist as a function of the arc length, if the stations have one."""
        angles = [station.twist for station in self.given if station.twist is not None]
        return TwistOfStations([station.at for station in self.given], angles) if angles else None

    def at(self, s: float) -> AnySection:
        """Return the section at the arc length `s` [m]; where it jumps, the one that starts there."""
        places, tapers, known = self._course
        found = known.get(s)
        if found is None:  # every analysis asks for those at its Gauss points again
            k = min(max(bisect_right(places, s) - 1, 0), len(tapers) - 1)
            taper, width = tapers[k], places[k + 1] - places[k]
            part = min(max((s - places[k]) / width, 0.0), 1.0) if width > 0.0 else 1.0
            found = taper.start if taper.start == taper.end else taper.at(part)
            if len(known) < MOST_KNOWN:
                known[s] = found
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the stations as a table of the case file: their numbers, wherever they were read."""
        return {"stations": [station.to_dict() for station in self.given]}
