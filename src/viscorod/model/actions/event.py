"""Events that a run watches for: a quantity crosses a value, the motion has decayed, a steady state is reached."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import BeforeValidator, Field

from viscorod.given_as import Amount, GivenAs
from viscorod.model.fields.definition import Definition
from viscorod.model.fields.forms import listed, of_kind, quantity
from viscorod.model.fields.metadata import TABLES, Accepts, Check, Key
from viscorod.model.fields.values import (
    Flag,
    OptionalPositive,
    Proportion,
    Text,
    choose,
    items,
    number,
    one_of,
)

__all__ = ["EVENTS", "QUANTITIES", "AnyEvent", "Crossing", "Decayed", "Events", "SteadyState"]

QUANTITIES = ("x", "y", "z", "ux", "uy", "uz", "vx", "vy", "vz")
"""Position [m], displacement from the reference shape [m] and velocity [m/s], global axes."""

_UNITS = {word: "m/s" if word.startswith("v") else "m" for word in QUANTITIES}
_value = Check(quantity() | {"x-unit-by": ["quantity", _UNITS]}, number.words, read=number.read)
_DIRECTIONS = ("rising", "falling", "both")


class Crossing(Definition):
    """A coordinate of a place reaches a value."""

    tag: ClassVar[str | None] = "kind"

    kind: Literal["crossing"] = Field(default="crossing", kw_only=True, repr=False)
    at: Text = Key('the place, such as "beam.end" or "beam@0.15"')
    quantity: Annotated[str, one_of(*QUANTITIES)] = Key(
        '"x", "y", "z" (position, m), "ux", "uy", "uz" (displacement from the reference shape, m), '
        'or "vx", "vy", "vz" (velocity, m/s), global axes'
    )
    value: Annotated[GivenAs[float, Amount], _value] = Key(
        "that is crossed; {} or {}", "m", "m/s", default=0.0
    )
    direction: Annotated[str, one_of(*_DIRECTIONS)] = Key('"rising", "falling" or "both"', default="both")
    stop: Flag = Key("end the run there; otherwise every crossing is recorded", default=True)

    @property
    def label(self) -> str:
        """The event in words."""
        how = "crosses" if self.direction == "both" else f"crosses, {self.direction},"
        return f"{self.quantity} of {self.at} {how} {self.value:g}"


class Decayed(Definition):
    """The motion has decayed: the kinetic energy stays below a fraction of its largest value so far."""

    tag: ClassVar[str | None] = "kind"

    kind: Literal["decayed"] = Field(default="decayed", kw_only=True, repr=False)
    amplitude: Proportion = Key(
        "part of the largest amplitude, 0 to 1; energies are compared with its square", default=0.01
    )
    during: OptionalPositive = Key(
        "how long, {}; a period of the slowest vibration unless given", "s", default=None
    )
    stop: Flag = Key("end the run there", default=True)

    @property
    def label(self) -> str:
        """The event in words."""
        return f"the motion has decayed below {self.amplitude:g} of its largest amplitude"


class SteadyState(Definition):
    """Strains are constant, at rest or in a steady rotation."""

    tag: ClassVar[str | None] = "kind"

    kind: Literal["steady"] = Field(default="steady", kw_only=True, repr=False)
    change: Proportion = Key(
        "part of the largest strains so far, in the norm of the elastic energy, that strains may "
        "change by in the time `during`",
        default=1e-4,
    )
    during: OptionalPositive = Key(
        "how long, {}; a period of the slowest vibration unless given", "s", default=None
    )
    stop: Flag = Key("end the run there", default=True)

    @property
    def label(self) -> str:
        """The event in words."""
        return f"a steady state: strains change by less than {self.change:g} of the largest"


AnyEvent: TypeAlias = Crossing | Decayed | SteadyState

EVENTS: dict[str, type[Definition]] = {"crossing": Crossing, "decayed": Decayed, "steady": SteadyState}
"""The events by their word in a case file; `analyses.motion_events` makes the monitor of each."""


Events = Annotated[
    GivenAs[
        tuple[Annotated[AnyEvent, choose("kind", EVENTS)], ...],
        Definition | Mapping[str, Any] | Sequence[Definition | Mapping[str, Any]],
    ],
    BeforeValidator(items),
    Accepts(listed(of_kind("event")), TABLES),
]
"""A list of events, or of tables that describe them."""
