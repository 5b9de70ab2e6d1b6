"""Places on rods: ``"beam.start"``, ``"beam.end"`` and ``"beam@0.15"`` (arc length in m)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import PlainValidator

from viscorod.model.described import RefusedError, nearest, show
from viscorod.model.rod import Rod
from viscorod.model.values import word

__all__ = ["Place", "PlaceField", "find_place", "find_rod", "place_text"]

ROUND_OFF = 1e-9
"""Part of a rod's length within which a station counts as the rod's end, or as another station."""

_FORM = re.compile(r"(?P<rod>[A-Za-z_][\w-]*)(?:\.(?P<end>start|end)|@(?P<s>[^@]+))", flags=re.ASCII)
_ADVICE = 'give "ROD.start", "ROD.end" or "ROD@0.15" (arc length in m)'


@dataclass(frozen=True)
class Place:
    """A station of a rod.

    `rod` is the rod's name, `s` the arc length in m.
    """

    rod: str
    s: float

    def __str__(self) -> str:
        return f"{self.rod}@{self.s:.9g}"


def place_text(value: Any) -> str:
    """`value` if it has the form of a place."""
    parts = _FORM.fullmatch(word(value))
    if parts is None:
        raise RefusedError("this is not a place on a rod", _ADVICE)
    if parts["s"] is not None:
        _station(parts["s"])
    return str(value)


def _station(text: str) -> float:
    if not re.fullmatch(r"[0-9.eE+-]+", text):
        raise RefusedError("what follows @ is not a number", _ADVICE)
    try:
        s = float(text)
    except ValueError:
        raise RefusedError("what follows @ is not a number", _ADVICE) from None
    if not 0.0 <= s < float("inf"):
        raise RefusedError("a station is a finite arc length >= 0", _ADVICE)
    return s


PlaceField = Annotated[str, PlainValidator(place_text)]


def find_rod(name: str, rods: Mapping[str, Rod]) -> Rod:
    """The rod called `name`.

    Raises:
        RefusedError: there is none; the nearest name is suggested.
    """
    if name in rods:
        return rods[name]
    close = nearest(name, rods)
    hint = f"did you mean {close!r}? " if close else ""
    known = f"the rods are {', '.join(rods)}" if rods else "add a rod first"
    raise RefusedError("there is no rod of this name", hint + known, found=show(name))


def find_place(text: str, rods: Mapping[str, Rod]) -> Place:
    """The station that `text` names; stations within round-off of an end are that end.

    Raises:
        RefusedError: the text is no place, there is no such rod, or the station is beyond the rod's end.
    """
    parts = _FORM.fullmatch(place_text(text))
    assert parts is not None
    rod = find_rod(parts["rod"], rods)
    if parts["end"] is not None:
        return Place(parts["rod"], 0.0 if parts["end"] == "start" else rod.length)
    return Place(parts["rod"], station_on(rod, _station(parts["s"]), parts["rod"]))


def station_on(rod: Rod, s: float, name: str) -> float:
    """`s` if it lies on the rod, with stations within round-off of an end moved there."""
    if s > rod.length * (1.0 + ROUND_OFF):
        raise RefusedError(
            f"the rod {name} is only {rod.length:.9g} m long",
            f"give a station from 0 to {rod.length:.9g}",
            found=show(s),
        )
    if s <= ROUND_OFF * rod.length:
        return 0.0
    return rod.length if s >= rod.length * (1.0 - ROUND_OFF) else s
