"""Supports: which motions of a place are fixed or prescribed, and in which axes."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from viscorod.model.described import Described, RefusedError, nearest, show
from viscorod.model.place import Place, PlaceField
from viscorod.model.time_function import TimeFunction
from viscorod.model.time_table import time_function
from viscorod.model.values import (
    Direction,
    OptionalDirection,
    Triple,
    choose,
    direction,
    one_of,
    optional,
    sequence,
)
from viscorod.typing import Floats

__all__ = [
    "MOTIONS",
    "SUPPORTS",
    "AnySupport",
    "BodyVelocity",
    "Clamp",
    "Guide",
    "Pin",
    "ResolvedSupport",
    "Roller",
    "Support",
]

MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
"""Displacements (m) and components of the rotation vector from the reference orientation (rad)."""

VELOCITIES = ("v1", "v2", "v3", "w1", "w2", "w3")
"""Velocities (m/s) and angular velocities (rad/s) along the axes d1, d2, d3 of the moving section."""

Motion = Mapping[str, TimeFunction]


Frame: TypeAlias = Literal["global", "node", "axes", "body"]


@dataclass(frozen=True, eq=False)
class ResolvedSupport:
    """A support as the analysis needs it.

    Attributes:
        path: key path, ``supports[0]``.
        label: kind and place, ``clamp at beam.start``.
        place: the supported station.
        frame: "global", "node" (the rod's d1, d2, d3 there), "axes" (the support's own directions, fixed
            in space) or "body" (the axes of the moving section: velocities are held, not positions).
        axes: the directions x, y, z of the motion words as columns (3, 3), global components, in the
            reference shape; the unit matrix for "global", zero for "body".
        fixed: motion words that stay zero, in the order of `MOTIONS`.
        motion: motion words that follow a function of time (m or rad), in the same order.
    """

    path: str
    label: str
    place: Place
    frame: Frame
    axes: Floats
    fixed: tuple[str, ...]
    motion: dict[str, TimeFunction]

    @property
    def held(self) -> tuple[str, ...]:
        """All motion words that are fixed or prescribed, in the order of `MOTIONS`."""
        return tuple(word for word in MOTIONS if word in self.fixed or word in self.motion)


def motion_word(value: Any) -> str:
    """`value` if it is one of the six motion words."""
    if value not in MOTIONS if isinstance(value, str) else True:
        close = nearest(value, MOTIONS) if isinstance(value, str) else None
        hint = f"did you mean {close!r}? " if close else ""
        raise RefusedError("not a motion", f"{hint}give one of {', '.join(MOTIONS)}", found=show(value))
    return str(value)


def velocity_word(value: Any) -> str:
    """`value` if it is one of the six velocity words."""
    if value not in VELOCITIES if isinstance(value, str) else True:
        raise RefusedError("not a velocity", f"give one of {', '.join(VELOCITIES)}", found=show(value))
    return str(value)


def _fixed(value: Any) -> tuple[str, ...]:
    return _words(value, motion_word, MOTIONS)


def _words(value: Any, check: Callable[[Any], str], known: tuple[str, ...]) -> tuple[str, ...]:
    words = []
    for index, item in enumerate(sequence(value)):
        try:
            words.append(check(item))
        except RefusedError as error:
            raise RefusedError(error.why, error.instead, found=error.found, at=(index,)) from None
        if words.count(words[-1]) > 1:
            raise RefusedError("the same motion twice", "give it once", found=show(item), at=(index,))
    return tuple(word for word in known if word in words)


def _velocity_words(value: Any) -> tuple[str, ...]:
    return _words(value, velocity_word, VELOCITIES)


def _motion(value: Any) -> dict[str, TimeFunction]:
    return _functions(value, motion_word, MOTIONS, "motion", "rz")


def _velocity(value: Any) -> dict[str, TimeFunction]:
    return _functions(value, velocity_word, VELOCITIES, "velocity", "v1")


def _functions(
    value: Any, check: Callable[[Any], str], known: tuple[str, ...], noun: str, example: str
) -> dict[str, TimeFunction]:
    """A table of functions of time that do not jump and have derivatives, by their words."""
    if not isinstance(value, Mapping):
        plural = noun.replace("y", "ie") + "s"
        raise RefusedError(
            f"a table of {plural} is needed here",
            f"give a table such as {{ {example} = {{ kind = 'ramp', ... }} }}",
        )
    parsed = {}
    for key, item in value.items():
        try:
            parsed[check(key)] = time_function(item)
        except RefusedError as error:
            found = show(item) if error.found is None else error.found
            raise RefusedError(error.why, error.instead, found=found, at=(str(key), *error.at)) from None
    for key, given in parsed.items():
        if given.jumps:
            raise RefusedError(
                f"a prescribed {noun} must not jump; this one does at t = {given.jumps[0]:.6g} s",
                "give a ramp, or another continuous function of time",
                found=type(given).__name__,
                at=(key,),
            )
        try:
            given.require_derivatives()
        except RefusedError as error:
            raise RefusedError(error.why, error.instead, found=error.found, at=(key,)) from None
    return {word: parsed[word] for word in known if word in parsed}


def _two_directions(value: Any) -> tuple[Triple, Triple]:
    items = sequence(value)
    if len(items) != 2:
        raise RefusedError("two directions are needed here", "give [[x, y, z], [x, y, z]], perpendicular")
    first, second = direction(items[0]), direction(items[1])
    cosine = sum(a * b for a, b in zip(first, second, strict=True))
    if abs(cosine) > 1e-6:
        raise RefusedError("the two directions are not perpendicular", "give two that are")
    x = np.array(first)
    y = np.array(second) - cosine * x
    a, b, c = (y / np.linalg.norm(y)).tolist()
    return first, (a, b, c)


MotionField = Annotated[Motion, PlainValidator(_motion)]


class AnySupport(Described):
    """What all supports have in common: a place, and motions that follow functions of time."""

    tag: ClassVar[str | None] = "kind"

    at: PlaceField = Field(description="place, such as 'beam.start'")
    motion: MotionField = Field(default={}, kw_only=True)

    @property
    def label(self) -> str:
        """Kind and place, for messages and results: ``clamp at beam.start``."""
        return f"{type(self).model_fields['kind'].default} at {self.at}"

    @abstractmethod
    def held(self) -> tuple[str, ...]:
        """The motion words that are fixed or prescribed."""

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """The frame's word and axes (3, 3), columns, for the rod's frame `node` (3, 3) at the place."""
        del node
        return "global", np.eye(3)

    def resolve(self, path: str, place: Place, node: Floats) -> ResolvedSupport:
        """The support with its axes.

        Args:
            path: key path of the support.
            place: station that `at` names.
            node: the rod's frame there in the reference shape (3, 3), columns d1, d2, d3.
        """
        frame, axes = self.axes_at(node)
        fixed = tuple(word for word in self.held() if word not in self.motion)
        return ResolvedSupport(path, self.label, place, frame, axes, fixed, dict(self.motion))

    @model_validator(mode="after")
    def _moves_what_it_holds(self) -> Self:
        for word in self.motion:
            if not self.held():
                raise RefusedError(
                    "this kind of support holds velocities, no positions",
                    "give velocity, a table of functions of time, in place of motion",
                    found=f"a motion {word}",
                    at=("motion", word),
                )
            if word not in self.held():
                raise RefusedError(
                    f"this kind of support does not hold {word}, so it cannot move it",
                    f"move one of {', '.join(self.held())}, or use kind = 'support'",
                    found=f"a motion {word}",
                    at=("motion", word),
                )
        return self


class Support(AnySupport):
    """Any subset of the six motions.

    Args:
        at: place.
        fixed: motion words that stay zero.
        frame: "global" axes, or "node": the rod's d1, d2, d3 at the place.
        axes: other axes for the motion words: directions x and y, perpendicular, global components (z = x
            cross y).
        motion: motion words with functions of time (m or rad); by name only. A rotation prescribed at a place that is
            not held completely must stay below a full turn.
    """

    kind: Literal["support"] = Field(default="support", kw_only=True, repr=False)
    fixed: Annotated[tuple[str, ...], PlainValidator(_fixed)] = ()
    frame: Annotated[Literal["global", "node"], one_of("global", "node")] = "global"
    axes: Annotated[tuple[Triple, Triple] | None, PlainValidator(optional(_two_directions))] = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.axes is not None and self.frame == "node":
            raise RefusedError(
                "a support has either the node's axes or its own",
                "leave frame or axes out",
                found="",
                at=("axes",),
            )
        both = [word for word in self.fixed if word in self.motion]
        if both:
            raise RefusedError(
                "a motion cannot be both fixed and prescribed",
                f"leave {both[0]} out of fixed or out of motion",
                found=f"{both[0]} in both",
                at=("motion", both[0]),
            )
        if not self.held():
            raise RefusedError(
                "this support holds nothing",
                f"give fixed, a list of some of {', '.join(MOTIONS)}",
                found="",
                at=("fixed",),
            )
        return self

    def held(self) -> tuple[str, ...]:
        """Those in `fixed` and in `motion`."""
        return tuple(word for word in MOTIONS if word in self.fixed or word in self.motion)

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """The global axes, the node's or the given ones."""
        if self.frame == "node":
            return "node", node
        if self.axes is None:
            return "global", np.eye(3)
        return "axes", np.column_stack([*self.axes, np.cross(*self.axes)])


class Clamp(AnySupport):
    """Holds all six motions in the global axes.

    Args:
        at: place.
        motion: motion words that follow functions of time instead of staying zero (m or rad); by name only.
    """

    kind: Literal["clamp"] = Field(default="clamp", kw_only=True, repr=False)

    def held(self) -> tuple[str, ...]:
        """All six."""
        return MOTIONS


class Pin(AnySupport):
    """Holds the three displacements in the global axes; rotation is free.

    Args:
        at: place.
        motion: of ux, uy, uz, those that follow functions of time (m); by name only.
    """

    kind: Literal["pin"] = Field(default="pin", kw_only=True, repr=False)

    def held(self) -> tuple[str, ...]:
        """The displacements."""
        return MOTIONS[:3]


class Guide(AnySupport):
    """Lets the place slide along a fixed direction, x of the support's axes, and holds all other motions.

    Args:
        at: place.
        along: the direction, global axes; by default the rod's tangent there in the reference shape.
        motion: motion words (in the support's axes) that follow functions of time (m or rad); by name only.
    """

    kind: Literal["guide"] = Field(default="guide", kw_only=True, repr=False)
    along: OptionalDirection = None

    def held(self) -> tuple[str, ...]:
        """All but ux."""
        return MOTIONS[1:]

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """The direction of sliding first."""
        return "axes", node[:, [2, 0, 1]] if self.along is None else _axes_from(self.along)


class Roller(AnySupport):
    """Holds the displacement along one direction, x of the support's axes; all else is free.

    Args:
        at: place.
        normal: the direction, global axes.
        motion: ux as a function of time (m); by name only.
    """

    kind: Literal["roller"] = Field(default="roller", kw_only=True, repr=False)
    normal: Direction = Field(description="direction that is held, three numbers")

    def held(self) -> tuple[str, ...]:
        """The displacement along the normal."""
        return MOTIONS[:1]

    def axes_at(self, node: Floats) -> tuple[Frame, Floats]:
        """The normal first."""
        del node
        return "axes", _axes_from(self.normal)


class _Travelled(TimeFunction):
    """The motion that belongs to a prescribed velocity of a support that measures no position: only its rate counts."""

    kind: Literal["travelled"] = Field(default="travelled", kw_only=True, repr=False)
    speed: TimeFunction

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Those of the velocity."""
        return self.speed.breakpoints

    def value(self, t: float, before: bool = False) -> float:
        """Zero: there is no position to be at."""
        del t, before
        return 0.0

    def rate(self, t: float, before: bool = False) -> float:
        """The velocity."""
        return self.speed.value(t, before)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Its derivative."""
        return self.speed.rate(t, before)


class BodyVelocity(AnySupport):
    """Holds velocities of the section along its own moving axes, as in the intrinsic equations of beams.

    What turns with the section is no position: the place may wander. Three zero velocities v1, v2, v3 are a ball joint,
    all six a clamp. Total section forces along the other components are following forces and moments.

    Args:
        at: place.
        fixed: velocity words v1, v2, v3 (m/s), w1, w2, w3 (rad/s) that stay zero.
        velocity: velocity words with functions of time; by name only. They are continuous.
        motion: none; positions are free.
    """

    kind: Literal["body_velocity"] = Field(default="body_velocity", kw_only=True, repr=False)
    fixed: Annotated[tuple[str, ...], PlainValidator(_velocity_words)] = ()
    velocity: Annotated[Motion, PlainValidator(_velocity)] = Field(default={}, kw_only=True)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        both = [word for word in self.fixed if word in self.velocity]
        if both:
            raise RefusedError(
                "a velocity cannot be both fixed and prescribed",
                f"leave {both[0]} out of fixed or out of velocity",
                found=f"{both[0]} in both",
                at=("velocity", both[0]),
            )
        if not self.fixed and not self.velocity:
            raise RefusedError(
                "this support holds nothing",
                f"give fixed, a list of some of {', '.join(VELOCITIES)}, or velocity",
                found="",
                at=("fixed",),
            )
        return self

    def held(self) -> tuple[str, ...]:
        """None: positions are free."""
        return ()

    def resolve(self, path: str, place: Place, node: Floats) -> ResolvedSupport:
        """See `AnySupport`; the words are those of the motions along the same axes."""
        del node
        word = dict(zip(VELOCITIES, MOTIONS, strict=True))
        motion: dict[str, TimeFunction] = {
            word[name]: _Travelled(speed=time_function(speed)) for name, speed in self.velocity.items()
        }
        fixed = tuple(word[name] for name in self.fixed)
        return ResolvedSupport(path, self.label, place, "body", np.zeros((3, 3)), fixed, motion)


SUPPORTS: dict[str, type[Described]] = {
    "support": Support,
    "clamp": Clamp,
    "pin": Pin,
    "guide": Guide,
    "roller": Roller,
    "body_velocity": BodyVelocity,
}
"""The supports by their word in a case file; a new one is one class and one line here."""

support = choose("kind", SUPPORTS, default="support")
"""A support from a table or as it is."""


def _axes_from(first: Triple) -> Floats:
    """Right-handed axes (3, 3), columns, with the unit vector `first` as x."""
    x = np.array(first)
    y = np.eye(3)[np.argmin(np.abs(x))]
    y = y - (y @ x) * x
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])
