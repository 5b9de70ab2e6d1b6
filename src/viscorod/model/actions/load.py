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

from viscorod.model.actions.drag import Drag
from viscorod.model.actions.load_base import AlongRod, AnyLoad, refused, refused_rod
from viscorod.model.actions.load_effects import Arrows, Placing
from viscorod.model.actions.loads_in_space import DistributedForceTowards, ForceOnLine, ForceTowards
from viscorod.model.actions.time_function_kinds import TimeField
from viscorod.model.actions.travel import on_rod, passages
from viscorod.model.connections.place import Place, PlaceField
from viscorod.model.fields.definition import RefusedError, some_of
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import (
    TRIPLE,
    Flag,
    Name,
    OptionalNumber,
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
    "DistributedForceTowards",
    "DistributedMoment",
    "Drag",
    "Force",
    "ForceOnLine",
    "ForceTowards",
    "Gravity",
    "Moment",
    "MovingForce",
    "load",
]

Density: TypeAlias = Sequence[float] | Callable[[float], Sequence[float]]
"""Load per length: three numbers, or a function of the arc length (in Python only)."""

COMPONENTS = "{}, global components; along d1, d2, d3 if it follows"
FOLLOWING = "whether it turns with the section"


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
        """The force, N, and no moment (6,); global components, along d1, d2, d3 if it follows."""
        return np.array([*self.value, 0.0, 0.0, 0.0])


class Moment(_AtPlace):
    """A moment at a place."""

    turning: ClassVar[bool] = True
    kind: Literal["moment"] = Field(default="moment", kw_only=True, repr=False)
    value: Vector = Key(COMPONENTS, "N m")
    following: Flag = Key(FOLLOWING, default=False)

    @property
    def wrench(self) -> Floats:
        """No force, and the moment, N m (6,); global components, along d1, d2, d3 if it follows."""
        return np.array([0.0, 0.0, 0.0, *self.value])


@accepts(TRIPLE, "3 numbers", "or a function of the arc length")
def _density(value: Any) -> Density:
    return value if callable(value) else vector(value)


DensityField = Annotated[Density, _density]


class _Distributed(AlongRod):
    value: DensityField
    following: Flag = Key(FOLLOWING, default=False)

    def density(self, s: float) -> Floats:
        """Load per reference length (3,) at the arc length `s`, without factor and limits."""
        if not callable(self.value):
            return np.array(self.value)
        value = returned(
            self.value,
            s,
            check=vector,
            name=f"the function of the {self.word} along {self.rod!r}",
            where=f"at s = {s:.6g} m",
            instead="return three finite numbers",
            at=("value",),
        )
        return np.array(value)

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        yield from super().misfits(model)
        if self.rod in model.rods:
            yield from refused("value", self.density, model.rods[self.rod].length / 2.0)

    def place(self, model: ModelDescription, placing: Placing) -> None:
        del model

        def wrench(s: float) -> Floats:
            none = np.zeros(3)
            return np.concatenate([none, self.density(s)] if self.turning else [self.density(s), none])

        start, end = self.from_s or 0.0, self.to_s
        placing.along(self.rod, wrench, self.factor, start=start, end=end, following=self.following)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        del t
        stations = self.feet(model)
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

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield which rods have no weight."""
        without = [name for name, rod in model.rods.items() if not rod.has_inertia]
        if without:
            yield RefusedError(
                f"the weight of {some_of(without)} is not known: "
                "materials were given without density, or sections without inertia",
                "give the density, kg/m^3, or the sections' inertia, mass per length first",
                found="",
            )

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
        """Yield why there is no such rod, or why it is never on it."""
        missing = list(refused_rod(self.rod, model))
        yield from missing
        if missing or self.position is not None:
            return
        length, start, passages = model.rods[self.rod].length, self.start or 0.0, self.passages(model)
        if passages[-1] <= 0.0 if passages else not 0.0 <= start <= length:
            yield RefusedError(
                f"it is never on the rod {self.rod}, which is {length:.6g} m long: it begins at {start:.6g} m",
                "give a start on the rod, or a speed that leads onto it",
                at=("speed",),
            )

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
    "drag": Drag,
    "force_towards": ForceTowards,
    "distributed_force_towards": DistributedForceTowards,
    "force_on_line": ForceOnLine,
}
"""The loads by their word in a case file; a new one is one class and one line here, or ``LOADS["word"] = Kind``."""

load = choose("kind", LOADS)
"""A load from a table or as it is."""
