"""Loads: forces and moments at places or along rods, moving forces, and gravity; each with a function of time.

A load acts with ``factor(t) = time(t) * (t < until)``. Dead loads keep their direction (components in the
global axes); following loads turn with the section (components along d1, d2, d3).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from viscorod.model.actions.time_table import TimeField
from viscorod.model.connections.place import PlaceField
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.values import (
    Flag,
    Name,
    OptionalNonNegative,
    OptionalNumber,
    OptionalPositive,
    Vector,
    choose,
    vector,
)
from viscorod.typing import Floats

__all__ = [
    "LOADS",
    "AnyLoad",
    "DistributedForce",
    "DistributedMoment",
    "Force",
    "Gravity",
    "Moment",
    "MovingForce",
    "load",
]

Density: TypeAlias = Sequence[float] | Callable[[float], Sequence[float]]
"""Load per length: three numbers, or a function of the arc length (in Python only)."""


class AnyLoad(Definition):
    """Base class of loads: a factor that depends on the time.

    Args:
        time: function of time that scales the load; None for 1.
        until: time from which on the load is zero, s; None for never.
    """

    tag: ClassVar[str | None] = "kind"

    time: TimeField = Field(default=None, kw_only=True)
    until: OptionalNumber = Field(default=None, kw_only=True)

    def factor(self, t: float, before: bool = False) -> float:
        """Return the factor at time `t` (the limit from the left if `before`)."""
        if self.until is not None and not (t < self.until or (before and t == self.until)):
            return 0.0
        return 1.0 if self.time is None else self.time.value(t, before)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times at which the factor, its rate or its acceleration is not smooth, increasing, s."""
        return self._with_until(() if self.time is None else self.time.breakpoints)

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which the factor jumps, increasing, s."""
        times = self._with_until(() if self.time is None else self.time.jumps)
        return tuple(t for t in times if self.factor(t) != self.factor(t, before=True))

    def _with_until(self, times: tuple[float, ...]) -> tuple[float, ...]:
        if self.until is None:
            return times
        return (*(t for t in times if t < self.until), self.until)


class _AtPlace(AnyLoad):
    at: PlaceField = Field(description="place, such as 'beam.end'")


class Force(_AtPlace):
    """A force at a place.

    Args:
        at: place.
        value: N, global components; along d1, d2, d3 if it follows.
        following: whether it turns with the section.
        time: function of time that scales it.
        until: time from which on it is zero, s.
    """

    kind: Literal["force"] = Field(default="force", kw_only=True, repr=False)
    value: Vector = Field(description="three numbers, N")
    following: Flag = False


class Moment(_AtPlace):
    """A moment at a place.

    Args:
        at: place.
        value: N m, global components; along d1, d2, d3 if it follows.
        following: whether it turns with the section.
        time: function of time that scales it.
        until: time from which on it is zero, s.
    """

    kind: Literal["moment"] = Field(default="moment", kw_only=True, repr=False)
    value: Vector = Field(description="three numbers, N m")
    following: Flag = False


def _density(value: Any) -> Density:
    return value if callable(value) else vector(value)


class _Distributed(AnyLoad):
    rod: Name = Field(description="name of the rod")
    value: Annotated[Density, PlainValidator(_density)] = Field(description="three numbers, per metre")
    following: Flag = False
    from_s: OptionalNonNegative = Field(default=None, kw_only=True)
    to_s: OptionalPositive = Field(default=None, kw_only=True)

    @model_validator(mode="after")
    def _forward(self) -> Self:
        if self.to_s is not None and self.to_s <= (self.from_s or 0.0):
            raise RefusedError(
                "the loaded part must have a positive length",
                f"give a station above {show(self.from_s or 0.0)}",
                found=show(self.to_s),
                at=("to_s",),
            )
        return self

    def density(self, s: float) -> Floats:
        """Load per reference length (3,) at the arc length `s`, without factor and limits."""
        value = self.value(s) if callable(self.value) else self.value
        try:
            return np.array(vector(value))
        except RefusedError as error:
            raise RefusedError(
                f"the function of the load gave this at s = {s:.6g}: {error.why}",
                "return three finite numbers",
                found=show(value),
                at=("value",),
            ) from None


class DistributedForce(_Distributed):
    """A force per reference length along a rod.

    Args:
        rod: name.
        value: N/m, three numbers or a function of s; global components; along d1, d2, d3 if it follows.
        following: whether it turns with the sections.
        from_s: arc length where it starts, m; None for the rod's start.
        to_s: arc length where it ends, m; None for the rod's end.
        time: function of time that scales it.
        until: time from which on it is zero, s.
    """

    kind: Literal["distributed_force"] = Field(default="distributed_force", kw_only=True, repr=False)


class DistributedMoment(_Distributed):
    """A moment per reference length along a rod.

    Args:
        rod: name.
        value: N m/m, three numbers or a function of s; global components; along d1, d2, d3 if it follows.
        following: whether it turns with the sections.
        from_s: arc length where it starts, m; None for the rod's start.
        to_s: arc length where it ends, m; None for the rod's end.
        time: function of time that scales it.
        until: time from which on it is zero, s.
    """

    kind: Literal["distributed_moment"] = Field(default="distributed_moment", kw_only=True, repr=False)


class Gravity(AnyLoad):
    """The weight of all rods and bodies.

    Args:
        acceleration: m/s^2, global axes.
        time: function of time that scales it.
        until: time from which on it is zero, s.
    """

    kind: Literal["gravity"] = Field(default="gravity", kw_only=True, repr=False)
    acceleration: Vector = (0.0, 0.0, -9.81)


class MovingForce(AnyLoad):
    """A force whose place travels along a rod; it acts while it is on the rod.

    Args:
        rod: name.
        value: N, global components; along d1, d2, d3 if it follows.
        speed: of an even travel from `start`, m/s (negative: towards the rod's start).
        position: arc length as a function of time, m, instead of speed and start.
        start: arc length at t = 0, m.
        following: whether it turns with the section.
        time: function of time that scales it.
        until: time from which on it is zero, s.
    """

    kind: Literal["moving_force"] = Field(default="moving_force", kw_only=True, repr=False)
    rod: Name = Field(description="name of the rod")
    value: Vector = Field(description="three numbers, N")
    speed: OptionalNumber = None
    position: TimeField = None
    start: OptionalNumber = None
    following: Flag = False

    @model_validator(mode="after")
    def _one_travel(self) -> Self:
        if (self.speed is None) == (self.position is None):
            raise RefusedError(
                "a moving force needs either a speed or a position",
                "give speed (m/s), or position (m) as a function of time",
                found="both" if self.speed is not None else "",
            )
        if self.position is not None and self.start is not None:
            raise RefusedError(
                "start goes with speed; position tells the place at all times",
                "leave start out",
                at=("start",),
            )
        return self

    def arc_length(self, t: float, before: bool = False) -> float:
        """Return the arc length at which the force is at time `t`, m; it acts only if that is on the rod."""
        if self.position is not None:
            return self.position.value(t, before)
        return (self.start or 0.0) + (self.speed or 0.0) * t

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Breakpoints of the factor and of the position, s."""
        own = super().breakpoints
        return own if self.position is None else tuple(sorted({*own, *self.position.breakpoints}))


LOADS: dict[str, type[Definition]] = {
    "force": Force,
    "moment": Moment,
    "distributed_force": DistributedForce,
    "distributed_moment": DistributedMoment,
    "gravity": Gravity,
    "moving_force": MovingForce,
}
"""The loads by their word in a case file; a new one is one class and one line here."""

load = choose("kind", LOADS)
"""A load from a table or as it is."""
