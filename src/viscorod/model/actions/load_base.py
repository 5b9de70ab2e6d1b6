"""What every load is: a factor that depends on the time, and what is asked of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, ClassVar, Self

from pydantic import model_validator

from viscorod.model.actions.load_effects import Arrows, Placing
from viscorod.model.actions.time_function_kinds import TimeField
from viscorod.model.connections.place import Place, find_rod, station_on
from viscorod.model.fields.definition import Definition, RefusedError, show, some_of
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import (
    Name,
    OptionalNonNegative,
    OptionalPositive,
    OptionalText,
)

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["ALONG", "AlongRod", "AnyLoad", "refused", "refused_rod"]

ALONG = 9
"""Arrows of a load that is spread along a rod."""


class AnyLoad(Definition):
    """Base class of loads: a factor that depends on the time."""

    tag: ClassVar[str | None] = "kind"

    #: Whether it is a moment.
    turning: ClassVar[bool] = False
    #: Whether its place or direction changes with time.
    travels: ClassVar[bool] = False
    #: Whether it depends on how the model moves.
    sees_motion: ClassVar[bool] = False

    name: OptionalText = Key(
        "by which stages of an equilibrium call it; its kind unless given", default=None, kw_only=True
    )
    time: TimeField = Key("function of time that scales it", default=None, kw_only=True)
    until: OptionalNonNegative = Key("time from which on it is zero", "s", default=None, kw_only=True)

    def factor(self, t: float, before: bool = False) -> float:
        """Return the factor at time `t` (the limit from the left if `before`)."""
        if self.until is not None and not (t < self.until or (before and t == self.until)):
            return 0.0
        return self.course(t, before)

    def course(self, t: float, before: bool = False) -> float:
        """Return the value of its function of time at `t`, whether it still acts or not.

        Raises:
            InputError: a function of the user fails there.
        """
        if self.time is None:
            return 1.0
        try:
            return self.time.value(t, before)
        except RefusedError as error:
            place = next((f" at {at}" for at in (getattr(self, key, "") for key in ("at", "rod")) if at), "")
            why = f"the time of the {getattr(self, 'kind', 'load')}{place}: {error.why}"
            raise RefusedError(why, error.instead, found=error.found) from error

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
            yield from refused(key, model.place, text)

    def breaks(self, model: ModelDescription) -> list[Place]:
        """Return the stations of rods where elements should end: by default the places that it names."""
        places = [model.place(text) for text in self.places().values()]
        return [place for place in places if isinstance(place, Place)]

    def passages(self, model: ModelDescription) -> list[float]:
        """Return the times at which it comes upon the model or leaves it, s, beside those of its factor."""
        del model
        return []

    def figures(self) -> dict[str, float | str]:
        """Return what ``viscorod check`` prints of a load that sees motion, by heading; nothing by default."""
        return {}

    @abstractmethod
    def place(self, model: ModelDescription, placing: Placing) -> None:
        """Put its wrenches on the model."""

    @abstractmethod
    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        """Return what is drawn of it at time `t`; asked once for all times unless it `travels`."""


def refused(key: str, check: Callable[..., object], *values: object) -> Iterator[RefusedError]:
    """Yield what `check` refuses, under `key`."""
    try:
        check(*values)
    except RefusedError as error:
        yield RefusedError(error.why, error.instead, found=error.found or "", at=(key,))


def refused_rod(name: str, model: ModelDescription) -> Iterator[RefusedError]:
    """Yield why a rod cannot be loaded along its length."""
    if name in model.bodies:
        yield RefusedError(
            "this is a rigid body, and such a load acts along a rod",
            f"load the body with a force or moment at {name!r}, or name one of {some_of(model.rods)}",
            found=show(name),
            at=("rod",),
        )
    else:
        yield from refused("rod", find_rod, name, model.rods)


class AlongRod(AnyLoad):
    """Base class of loads per length of a rod."""

    rod: Name = Key("name of the rod")
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

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield why there is no such rod, or no such part of it."""
        faults = list(refused_rod(self.rod, model))
        yield from faults
        if faults:
            return
        rod = model.rods[self.rod]
        for key, s in (("from_s", self.from_s), ("to_s", self.to_s)):
            yield from refused(key, station_on, rod, s or 0.0, self.rod)

    def breaks(self, model: ModelDescription) -> list[Place]:
        """Return the stations where it starts and ends."""
        del model
        return [Place(self.rod, s) for s in (self.from_s, self.to_s) if s is not None]

    def feet(self, model: ModelDescription) -> list[float]:
        """Return the arc lengths of the arrows that are drawn of it, m."""
        start, end = self.from_s or 0.0, self.to_s or model.rods[self.rod].length
        return [start + k / (ALONG - 1) * (end - start) for k in range(ALONG)]
