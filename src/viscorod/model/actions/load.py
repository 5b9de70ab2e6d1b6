"""Loads: forces and moments at places or along rods, moving forces, and gravity; each with a function of time.

A load acts with ``factor(t) = time(t) * (t < until)``. Dead loads keep their direction (components in the
global axes); following loads turn with the section (components along d1, d2, d3). A load knows all that is
asked of it: the places it names, where elements should end, its wrenches, and the arrows that are drawn of it.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.actions.load_effects import Arrows, Placing
from viscorod.model.actions.time_table import TimeField
from viscorod.model.actions.travel import on_rod, passages
from viscorod.model.connections.place import Place, PlaceField, find_rod, station_on
from viscorod.model.fields.definition import Definition, RefusedError, show, some_of
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    TRIPLE,
    Flag,
    Name,
    OptionalNonNegative,
    OptionalNumber,
    OptionalPositive,
    OptionalText,
    Vector,
    choose,
    vector,
)
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

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

ALONG = 9
"""Arrows of a load that is spread along a rod."""

Density: TypeAlias = Sequence[float] | Callable[[float], Sequence[float]]
"""Load per length: three numbers, or a function of the arc length (in Python only)."""

COMPONENTS = "{}, global components; along d1, d2, d3 if it follows"
FOLLOWING = "whether it turns with the section"


class AnyLoad(Definition):
    """Base class of loads: a factor that depends on the time."""

    tag: ClassVar[str | None] = "kind"

    #: Whether it is a moment.
    turning: ClassVar[bool] = False
    #: Whether its place or direction changes with time.
    travels: ClassVar[bool] = False

    name: OptionalText = Key(
        "by which stages of an equilibrium call it; its kind unless given", default=None, kw_only=True
    )
    time: TimeField = Key("function of time that scales it", default=None, kw_only=True)
    until: OptionalNumber = Key("time from which on it is zero", "s", default=None, kw_only=True)

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

    @property
    def word(self) -> str:
        """The word for its kind."""
        return str(type(self).model_fields["kind"].default)

    @property
    def follows(self) -> bool:
        """Whether it turns with the sections."""
        return bool(getattr(self, "following", False))

    def places(self) -> dict[str, str]:
        """Return the places that it names, by the key that names each."""
        return {}

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield what is wrong with it in this model, each with its key: by default the places that do not exist."""
        for key, text in self.places().items():
            yield from _refused(key, model.place, text)

    def breaks(self, model: ModelDescription) -> list[Place]:
        """Return the stations of rods where elements should end: by default the places that it names."""
        places = [model.place(text) for text in self.places().values()]
        return [place for place in places if isinstance(place, Place)]

    def passages(self, model: ModelDescription) -> list[float]:
        """Return the times at which it comes upon the model or leaves it, s, beside those of its factor."""
        del model
        return []

    @abstractmethod
    def place(self, model: ModelDescription, placing: Placing) -> None:
        """Put its wrenches on the model."""

    @abstractmethod
    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        """Return what is drawn of it at time `t`; asked once for all times unless it `travels`."""


def _refused(key: str, check: Callable[..., object], *values: object) -> Iterator[RefusedError]:
    """Yield what `check` refuses, under `key`."""
    try:
        check(*values)
    except RefusedError as error:
        yield RefusedError(error.why, error.instead, found=error.found or "", at=(key,))


def _refused_rod(name: str, model: ModelDescription) -> Iterator[RefusedError]:
    """Yield why a rod cannot be loaded along its length."""
    if name in model.bodies:
        yield RefusedError(
            "this is a rigid body, and such a load acts along a rod",
            f"load the body with a force or moment at {name!r}, or name one of {some_of(model.rods)}",
            found=show(name),
            at=("rod",),
        )
    else:
        yield from _refused("rod", find_rod, name, model.rods)


class _AtPlace(AnyLoad):
    at: PlaceField = Key("place")

    def places(self) -> dict[str, str]:
        return {"at": self.at}

    @property
    @abstractmethod
    def wrench(self) -> Floats:
        """Force and moment (6,)."""

    def place(self, model: ModelDescription, placing: Placing) -> None:
        del model
        placing.at(self.at, self.wrench, self.factor, following=self.follows)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        del t
        values = self.wrench[None, 3:] if self.turning else self.wrench[None, :3]
        unit = "N m" if self.turning else "N"
        feet = (model.place(self.at),)
        return Arrows(f"{self.word} at {self.at}", unit, feet, values, self.follows, self.turning)


class Force(_AtPlace):
    """A force at a place."""

    kind: Literal["force"] = Field(default="force", kw_only=True, repr=False)
    value: Vector = Key(COMPONENTS, "N")
    following: Flag = Key(FOLLOWING, default=False)

    @property
    def wrench(self) -> Floats:
        """The force, and no moment."""
        return np.array([*self.value, 0.0, 0.0, 0.0])


class Moment(_AtPlace):
    """A moment at a place."""

    turning: ClassVar[bool] = True
    kind: Literal["moment"] = Field(default="moment", kw_only=True, repr=False)
    value: Vector = Key(COMPONENTS, "N m")
    following: Flag = Key(FOLLOWING, default=False)

    @property
    def wrench(self) -> Floats:
        """The moment, and no force."""
        return np.array([0.0, 0.0, 0.0, *self.value])


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

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        refused = list(_refused_rod(self.rod, model))
        yield from refused
        if refused:
            return
        rod = model.rods[self.rod]
        for key, s in (("from_s", self.from_s), ("to_s", self.to_s)):
            yield from _refused(key, station_on, rod, s or 0.0, self.rod)
        yield from _refused("value", self.density, rod.length / 2.0)

    def breaks(self, model: ModelDescription) -> list[Place]:
        del model
        return [Place(self.rod, s) for s in (self.from_s, self.to_s) if s is not None]

    def place(self, model: ModelDescription, placing: Placing) -> None:
        del model

        def wrench(s: float) -> Floats:
            none = np.zeros(3)
            return np.concatenate([none, self.density(s)] if self.turning else [self.density(s), none])

        start, end = self.from_s or 0.0, self.to_s
        placing.along(self.rod, wrench, self.factor, start=start, end=end, following=self.following)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        del t
        stations = np.linspace(self.from_s or 0.0, self.to_s or model.rods[self.rod].length, ALONG).tolist()
        unit, feet = "N m/m" if self.turning else "N/m", tuple(Place(self.rod, s) for s in stations)
        values = np.array([self.density(s) for s in stations])
        return Arrows(f"load along {self.rod}", unit, feet, values, self.following, self.turning)


class DistributedForce(_Distributed):
    """A force per reference length along a rod."""

    kind: Literal["distributed_force"] = Field(default="distributed_force", kw_only=True, repr=False)
    value: DensityField = Key(COMPONENTS, "N/m")


class DistributedMoment(_Distributed):
    """A moment per reference length along a rod."""

    turning: ClassVar[bool] = True
    kind: Literal["distributed_moment"] = Field(default="distributed_moment", kw_only=True, repr=False)
    value: DensityField = Key(COMPONENTS, "N m/m")


class Gravity(AnyLoad):
    """The weight of all rods and bodies."""

    kind: Literal["gravity"] = Field(default="gravity", kw_only=True, repr=False)
    acceleration: Vector = Key("{}, global axes", "m/s^2", default=(0.0, 0.0, -9.81))

    def place(self, model: ModelDescription, placing: Placing) -> None:
        """Let everything have weight."""
        del model
        placing.everywhere(np.array(self.acceleration), self.factor)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        """Return one arrow that stands nowhere."""
        del model, t
        return Arrows("gravity", "m/s²", (), np.array([self.acceleration]))


class MovingForce(AnyLoad):
    """A force whose place travels along a rod; it acts while it is on the rod."""

    travels: ClassVar[bool] = True
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
                "start goes with speed; position gives the place at all times",
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

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield why there is no such rod."""
        yield from _refused_rod(self.rod, model)

    def passages(self, model: ModelDescription) -> list[float]:
        """Return the times at which it passes an end of its rod, s."""
        length = model.rods[self.rod].length
        if self.position is not None:
            return passages(self.position, length)
        speed, start = self.speed or 0.0, self.arc_length(0.0)
        return sorted((s - start) / speed for s in (0.0, length)) if speed else []

    def place(self, model: ModelDescription, placing: Placing) -> None:
        """Let it travel."""
        length, wrench = model.rods[self.rod].length, np.array([*self.value, 0.0, 0.0, 0.0])
        position, factor = on_rod(self.arc_length, self.factor, length, self.passages(model))
        placing.travelling(self.rod, position, wrench, factor, following=self.following)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        """Return the arrow where it is at time `t`, or at the end of the rod that it is beyond."""
        s, length = self.arc_length(t), model.rods[self.rod].length
        label, feet = f"force travelling on {self.rod}", (Place(self.rod, min(max(s, 0.0), length)),)
        return Arrows(label, "N", feet, np.array([self.value]), self.following, acting=0.0 <= s <= length)


LOADS: dict[str, type[AnyLoad]] = {
    "force": Force,
    "moment": Moment,
    "distributed_force": DistributedForce,
    "distributed_moment": DistributedMoment,
    "gravity": Gravity,
    "moving_force": MovingForce,
}
"""The loads by their word in a case file; a new one is one class and one line here, or ``LOADS["word"] = Kind``."""

load = choose("kind", LOADS)
"""A load from a table or as it is."""
