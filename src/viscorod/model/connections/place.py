"""Places on rods and bodies.

``"beam.start"``, ``"beam.end"``, ``"beam@0.15"`` (arc length in m); ``"plate"`` (a body's mass centre) and
``"plate.corner"`` (one of its named points).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, overload

from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.fields.definition import RefusedError, did_you_mean, show, some_of
from viscorod.model.fields.forms import TEXT
from viscorod.model.fields.metadata import accepts
from viscorod.model.fields.values import word
from viscorod.model.rod import Rod
from viscorod.units import si_value

__all__ = [
    "GROUND",
    "AnyPlace",
    "BodyPlace",
    "EndField",
    "Place",
    "PlaceField",
    "find_place",
    "find_rod",
    "place_text",
]

ROUND_OFF = 1e-9
"""Part of a rod's length within which a station counts as the rod's end, or as another station."""

GROUND = "ground"
"""The word for the fixed ground, one side of a joint or spring."""

_NAME = r"[A-Za-z_][\w-]*"
_FORM = re.compile(rf"(?P<part>{_NAME})(?:\.(?P<point>{_NAME})|@(?P<s>[^@]+))?", flags=re.ASCII)
_ADVICE = 'give "ROD.start", "ROD.end" or "ROD@0.15" (arc length in m), or "BODY" or "BODY.POINT"'


@dataclass(frozen=True)
class Place:
    """A station of a rod.

    `rod` is the rod's name, `s` the arc length in m.
    """

    rod: str
    s: float

    def __str__(self) -> str:
        return f"{self.rod}@{self.s:.9g}"


@dataclass(frozen=True)
class BodyPlace:
    """A point of a rigid body.

    `body` is the body's name, `point` the point's, None for the mass centre.
    """

    body: str
    point: str | None = None

    def __str__(self) -> str:
        return self.body if self.point is None else f"{self.body}.{self.point}"


AnyPlace: TypeAlias = Place | BodyPlace


@accepts(TEXT, "place, in quotes")
def place_text(value: Any) -> str:
    """Return `value` if it has the form of a place."""
    parts = _FORM.fullmatch(word(value))
    if parts is None:
        raise RefusedError("this is not a place on a rod or body", _ADVICE)
    if value == GROUND:
        raise RefusedError("the ground is not a place of the model", _ADVICE)
    if parts["s"] is not None:
        _station(parts["s"])
    return str(value)


@accepts(TEXT, 'place, or `"ground"`, in quotes')
def end_text(value: Any) -> str:
    """Return `value` if it is "ground" or has the form of a place."""
    if isinstance(value, str) and value == GROUND:
        return value
    try:
        return place_text(value)
    except RefusedError as error:
        raise RefusedError(error.why, f'{error.instead}, or "{GROUND}"') from None


def _station(text: str) -> float:
    try:
        s = float(text) if re.fullmatch(r"[0-9.eE+-]+", text) else si_value(text, "m", "an arc length")
    except ValueError as error:
        found = f" ({error.why})" if isinstance(error, RefusedError) else ""
        raise RefusedError(f"what follows @ is not a number{found}", _ADVICE) from None
    if not 0.0 <= s < float("inf"):
        raise RefusedError("a station is a finite arc length >= 0", _ADVICE)
    return s


PlaceField = Annotated[str, place_text]
EndField = Annotated[str, end_text]


def find_rod(name: str, rods: Mapping[str, Rod], bodies: Mapping[str, AnyBody] | None = None) -> Rod:
    """Return the rod called `name`.

    Raises:
        RefusedError: there is none; the nearest name is suggested.
    """
    if name in rods:
        return rods[name]
    if bodies and name in bodies:
        raise RefusedError(
            "this is a rigid body, and a rod is needed here",
            f"the rods are {some_of(rods)}",
            found=show(name),
        )
    hint = did_you_mean(name, rods)
    known = f"the rods are {some_of(rods)}" if rods else "add a rod first"
    raise RefusedError("there is no rod of this name", hint + known, found=show(name))


@overload
def find_place(text: str, rods: Mapping[str, Rod]) -> Place: ...


@overload
def find_place(text: str, rods: Mapping[str, Rod], bodies: Mapping[str, AnyBody]) -> AnyPlace: ...


def find_place(text: str, rods: Mapping[str, Rod], bodies: Mapping[str, AnyBody] | None = None) -> AnyPlace:
    """Return the place that `text` names; stations within round-off of an end of a rod are that end.

    Raises:
        RefusedError: the text is not a place, there is no such rod, body or point, or the station is beyond the
            rod's end.
    """
    parts = _FORM.fullmatch(place_text(text))
    assert parts is not None
    name, point, s = parts["part"], parts["point"], parts["s"]
    if bodies and name in bodies:
        return _point_of(bodies[name], name, point, s)
    if bodies and name not in rods:
        raise no_part(name, rods, bodies)
    rod = find_rod(name, rods)
    if s is not None:
        return Place(name, station_on(rod, _station(s), name))
    if point not in ("start", "end"):
        raise RefusedError(
            "a rod is not a place" if point is None else "a rod has no such point",
            f'give "{name}.start", "{name}.end" or "{name}@0.15" (arc length in m)',
            found=show(text),
        )
    return Place(name, 0.0 if point == "start" else rod.length)


def no_part(name: str, rods: Mapping[str, Rod], bodies: Mapping[str, AnyBody]) -> RefusedError:
    """Return the error for a name that neither a rod nor a body has."""
    hint = did_you_mean(name, (*rods, *bodies))
    known = f"the rods are {some_of(rods)}; the bodies are {some_of(bodies)}"
    return RefusedError("there is no rod or body of this name", hint + known, found=show(name))


def _point_of(body: AnyBody, name: str, point: str | None, s: str | None) -> BodyPlace:
    if s is not None:
        raise RefusedError(
            "a rigid body has no arc length",
            f'give "{name}", its mass centre, or a named point',
            found=show(f"{name}@{s}"),
        )
    if point is not None and point not in body.points:
        hint = did_you_mean(point, body.points, lambda close: f"{name}.{close}")
        known = (
            f"its points are {some_of(body.points)}" if body.points else f"name it in the points of {name}"
        )
        raise RefusedError(
            "the body has no point of this name", f"{hint}{known}", found=show(f"{name}.{point}")
        )
    return BodyPlace(name, point)


def station_on(rod: Rod, s: float, name: str) -> float:
    """Return `s` if it lies on the rod; stations within round-off of an end are moved there."""
    if s > rod.length * (1.0 + ROUND_OFF):
        raise RefusedError(
            f"the rod {name} is only {rod.length:.9g} m long",
            f"give a station from 0 to {rod.length:.9g}",
            found=show(s),
        )
    if s <= ROUND_OFF * rod.length:
        return 0.0
    return rod.length if s >= rod.length * (1.0 - ROUND_OFF) else s
