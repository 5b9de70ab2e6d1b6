"""Loads: forces and moments at places, along rods, moving, and gravity; each with a function of time.

A load acts with ``factor(t) = time(t) * (t < until)``. Dead loads keep their direction (components in the
global axes); following loads are carried along by the section (components along d1, d2, d3).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.actions.time_table import TimeField
from viscorod.model.connections.place import PlaceField
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    TRIPLE,
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

COMPONENTS = "{}, global components; along d1, d2, d3 if it follows"
FOLLOWING = "whether it turns with the section"


class AnyLoad(Definition):
    """What all loads have in common: a factor that depends on the time."""

    tag: ClassVar[str | None] = "kind"

    time: TimeField = Key("function of time that scales it", default=None, kw_only=True)
    until: OptionalNumber = Key("time from which on it is zero", "s", default=None, kw_only=True)

    def factor(self, t: float, before: bool = False) -> float:
        """The factor at time `t` (the limit from the left if `before`)."""
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
    at: PlaceField = Key("place")


class Force(_AtPlace):
    """A force at a place."""

    kind: Literal["force"] = Field(default="force", kw_only=True, repr=False)
    value: Vector = Key(COMPONENTS, "N")
    following: Flag = Key(FOLLOWING, default=False)


class Moment(_AtPlace):
    """A moment at a place."""

    kind: Literal["moment"] = Field(default="moment", kw_only=True, repr=False)
    value: Vector = Key(COMPONENTS, "N m")
    following: Flag = Key(FOLLOWING, default=False)


@accepts(TRIPLE, "3 numbers", "or a function of the arc length")
def _density(value: Any) -> Density:
    return value if callable(value) else vector(value)


DensityField = Annotated[Density, _density]


class _Distributed(AnyLoad):
    rod: Name = Key("name of the rod")
    value: DensityField
    following: Flag = Key(FOLLOWING, default=False)
    from_s: OptionalNonNegative = Key(
        "arc length where it starts, {}; left out, the rod's start", "m", default=None, kw_only=True
    )
    to_s: OptionalPositive = Key(
        "arc length where it ends, {}; left out, the rod's end", "m", default=None, kw_only=True
    )

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
    """A force per reference length along a rod."""

    kind: Literal["distributed_force"] = Field(default="distributed_force", kw_only=True, repr=False)
    value: DensityField = Key(COMPONENTS, "N/m")


class DistributedMoment(_Distributed):
    """A moment per reference length along a rod."""

    kind: Literal["distributed_moment"] = Field(default="distributed_moment", kw_only=True, repr=False)
    value: DensityField = Key(COMPONENTS, "N m/m")


class Gravity(AnyLoad):
    """Weight of all rods."""

    kind: Literal["gravity"] = Field(default="gravity", kw_only=True, repr=False)
    acceleration: Vector = Key("{}, global axes", "m/s^2", default=(0.0, 0.0, -9.81))


class MovingForce(AnyLoad):
    """A force whose place travels along a rod; it acts while it is on the rod."""

    kind: Literal["moving_force"] = Field(default="moving_force", kw_only=True, repr=False)
    rod: Name = Key("name of the rod")
    value: Vector = Key(COMPONENTS, "N")
    speed: OptionalNumber = Key(
        "of an even travel from `start`, {} (negative: towards the rod's start)", "m/s", default=None
    )
    position: TimeField = Key(
        "arc length as a function of time, {}, instead of speed and start", "m", default=None
    )
    start: OptionalNumber = Key("arc length at t = 0", "m", default=None)
    following: Flag = Key(FOLLOWING, default=False)

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
        """Arc length at which the force is at time `t`, m; it acts only if that is on the rod."""
        if self.position is not None:
            return self.position.value(t, before)
        return (self.start or 0.0) + (self.speed or 0.0) * t

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Those of the factor and of the position."""
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
