"""Events that a run watches for: a quantity crosses a value, the motion has decayed, a steady state is reached."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import BeforeValidator, Field, PlainValidator

from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.values import (
    Flag,
    Number,
    OptionalPositive,
    choose,
    number,
    one_of,
    sequence,
    word,
)

__all__ = ["EVENTS", "QUANTITIES", "AnyEvent", "Crossing", "Decayed", "Events", "SteadyState"]

QUANTITIES = ("x", "y", "z", "ux", "uy", "uz", "vx", "vy", "vz")
"""Position [m], displacement from the reference shape [m] and velocity [m/s], global axes."""

_DIRECTIONS = ("rising", "falling", "both")


def _part(value: Any) -> float:
    found = number(value)
    if not 0.0 < found < 1.0:
        raise RefusedError("outside what is allowed", "give a number between 0 and 1")
    return found


class Crossing(Definition):
    """A coordinate of a place reaches a value.

    Args:
        at: the place, such as "beam.end" or "beam@0.15".
        quantity: "x", "y", "z" (position, m), "ux", "uy", "uz" (displacement from the reference shape, m), or "vx",
            "vy", "vz" (velocity, m/s), global axes.
        value: that is crossed; m or m/s.
        direction: "rising", "falling" or "both".
        stop: end the run there; otherwise every crossing is recorded.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["crossing"] = Field(default="crossing", kw_only=True, repr=False)
    at: Annotated[str, PlainValidator(word)] = Field(description="place")
    quantity: Annotated[str, one_of(*QUANTITIES)] = Field(description="x, y, z, ux, uy, uz, vx, vy or vz")
    value: Number = 0.0
    direction: Annotated[str, one_of(*_DIRECTIONS)] = "both"
    stop: Flag = True

    @property
    def label(self) -> str:
        """The event in words."""
        how = "crosses" if self.direction == "both" else f"crosses, {self.direction},"
        return f"{self.quantity} of {self.at} {how} {self.value:g}"


class Decayed(Definition):
    """The motion has decayed: the kinetic energy stays below a fraction of its largest value so far.

    Args:
        amplitude: part of the largest amplitude, 0 to 1; energies are compared with its square.
        during: how long, s; a period of the slowest vibration unless given.
        stop: end the run there.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["decayed"] = Field(default="decayed", kw_only=True, repr=False)
    amplitude: Annotated[float, PlainValidator(_part)] = 0.01
    during: OptionalPositive = None
    stop: Flag = True

    @property
    def label(self) -> str:
        """The event in words."""
        return f"the motion has decayed below {self.amplitude:g} of its largest amplitude"


class SteadyState(Definition):
    """Strains are constant, at rest or in a steady rotation.

    Args:
        change: part of the largest strains so far, in the norm of the elastic energy, that strains may change by in
            the time `during`.
        during: how long, s; a period of the slowest vibration unless given.
        stop: end the run there.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["steady"] = Field(default="steady", kw_only=True, repr=False)
    change: Annotated[float, PlainValidator(_part)] = 1e-4
    during: OptionalPositive = None
    stop: Flag = True

    @property
    def label(self) -> str:
        """The event in words."""
        return f"a steady state: strains change by less than {self.change:g} of the largest"


AnyEvent: TypeAlias = Crossing | Decayed | SteadyState

EVENTS: dict[str, type[Definition]] = {"crossing": Crossing, "decayed": Decayed, "steady": SteadyState}
"""The events by their word in a case file; a new one is one class and one line here."""


def _some_events(value: Any) -> Any:
    return tuple(sequence(value))


Events = Annotated[
    tuple[Annotated[AnyEvent, PlainValidator(choose("kind", EVENTS))], ...], BeforeValidator(_some_events)
]
"""A list of events, or of tables that describe them."""
