"""Settings of the analyses: tables of a case file and keyword arguments of the API in one."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, PlainValidator, model_validator

from viscorod.model.described import Described, RefusedError, show
from viscorod.model.values import OptionalPositive, Positive, UnitInterval, one_of, optional, whole_number

__all__ = ["EquilibriumSettings", "SimulateSettings"]


class SimulateSettings(Described):
    """How a motion is computed.

    Args:
        duration: simulated time, s.
        time_step: s; None lets the program choose from the lowest modes.
        initial: what the motion starts from: "equilibrium" under the loads at t = 0-, or the "reference"
            shape.
        integrator: "generalized_alpha".
        spectral_radius: of the integrator at infinite frequency, 0 (strong damping of what is not resolved)
            to 1 (none).
        output_interval: time between stored states, s; None stores every step.
    """

    duration: Positive = Field(description="simulated time, s")
    time_step: OptionalPositive = None
    initial: Annotated[Literal["equilibrium", "reference"], one_of("equilibrium", "reference")] = (
        "equilibrium"
    )
    integrator: Annotated[Literal["generalized_alpha"], one_of("generalized_alpha")] = "generalized_alpha"
    spectral_radius: UnitInterval = 0.6
    output_interval: OptionalPositive = None

    @model_validator(mode="after")
    def _fits_duration(self) -> Self:
        for name in ("time_step", "output_interval"):
            value = getattr(self, name)
            if value is not None and value > self.duration:
                raise RefusedError(
                    "longer than the whole simulation",
                    f"give at most the duration, {show(self.duration)} s",
                    found=show(value),
                    at=(name,),
                )
        return self


class EquilibriumSettings(Described):
    """How a static equilibrium is computed.

    Args:
        load_steps: number of equal load steps to start with, 1 to 10 000; they are halved where needed.
    """

    load_steps: Annotated[int | None, PlainValidator(optional(whole_number(1, 10_000)))] = None
