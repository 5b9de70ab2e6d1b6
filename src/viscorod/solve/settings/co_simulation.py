"""Settings of a co-simulation."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import model_validator

from viscorod.given_as import GivenAs, Words
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import TEXT, listed
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    Positive,
    each,
    word,
)
from viscorod.solve.settings.motion import SimulateSettings

__all__ = ["CoSimulationSettings"]


LONGEST_COUPLING = 1e6
"""Simulated time [s] for which the settings of a co-simulation are chosen; it has no end of its own."""


@accepts(listed(TEXT), "list of places, in quotes")
def _ports(value: Any) -> tuple[str, ...]:
    return each(value, word)


class _Ports(Definition):
    ports: Annotated[GivenAs[tuple[str, ...], Words], _ports] = Key(
        'places where the other program acts, such as "beam.end"', default=()
    )


class CoSimulationSettings(SimulateSettings, _Ports):
    """How a model moves that another program drives step by step."""

    duration: Positive = Key("longest simulated time", "s", default=LONGEST_COUPLING, kw_only=True)

    @model_validator(mode="after")
    def _no_events(self) -> Self:
        if self.events:
            raise RefusedError(
                "a co-simulation is not watched for events",
                "leave events out and read positions and velocities between the steps",
                found=show(len(self.events)),
                at=("events",),
            )
        return self
