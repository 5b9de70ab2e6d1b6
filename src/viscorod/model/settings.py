"""Settings of the analyses: tables of a case file and keyword arguments of the API in one."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, PlainValidator, model_validator

from viscorod.model.described import Described, RefusedError, show
from viscorod.model.values import (
    OptionalPositive,
    OptionalUnitInterval,
    Positive,
    one_of,
    optional,
    whole_number,
)

LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-10, 0.1

__all__ = ["EquilibriumSettings", "SimulateSettings"]


class SimulateSettings(Described):
    """How a motion is computed.

    Args:
        duration: simulated time, s.
        time_step: s; the step of integrators with equal steps (None: chosen from the lowest modes), the largest step of
            the others.
        tolerance: wanted accuracy of the motion: displacements over the size of the model and rotations in rad; the
            steps follow from it. 1e-4 for "radau" unless given; "generalized_alpha" has equal steps without it.
        initial: what the motion starts from: "equilibrium" under the loads at t = 0-, or the "reference"
            shape.
        integrator: "radau" (order 5, steps that follow the error), "generalized_alpha" or "midpoint" (order 2, which
            keeps energy exactly).
        spectral_radius: of "generalized_alpha" at infinite frequency, 0 (strong damping of what is not resolved)
            to 1 (none); 0.6 unless given.
        output_interval: time between stored states, s; None stores every step.
        formulation: "geometric" (strains follow from positions and rotations) or "intrinsic" (strains and body
            velocities; positions follow by integration in time), which goes with "radau" and "midpoint".
        damping: "full" Kelvin-Voigt damping, which never damps rigid motions, or "linearised" (Artola, Wynn and
            Palacios), which also damps rotations of bent rods; the latter with the intrinsic formulation.
        dynamics: "nonlinear", or "linear" about the state that the motion starts from, with linearised damping.
    """

    duration: Positive = Field(description="simulated time, s")
    time_step: OptionalPositive = None
    tolerance: OptionalPositive = None
    initial: Annotated[Literal["equilibrium", "reference"], one_of("equilibrium", "reference")] = (
        "equilibrium"
    )
    integrator: Annotated[
        Literal["radau", "generalized_alpha", "midpoint"], one_of("radau", "generalized_alpha", "midpoint")
    ] = "radau"
    spectral_radius: OptionalUnitInterval = None
    output_interval: OptionalPositive = None
    formulation: Annotated[Literal["geometric", "intrinsic"], one_of("geometric", "intrinsic")] = "geometric"
    damping: Annotated[Literal["full", "linearised"], one_of("full", "linearised")] = "full"
    dynamics: Annotated[Literal["nonlinear", "linear"], one_of("nonlinear", "linear")] = "nonlinear"

    @model_validator(mode="after")
    def _fits_formulation(self) -> Self:
        if self.formulation == "geometric":
            for name, wanted in (("damping", "linearised"), ("dynamics", "linear")):
                if getattr(self, name) == wanted:
                    raise RefusedError(
                        "the geometric formulation has full damping and nonlinear dynamics only",
                        f"add formulation = 'intrinsic', or leave out {name}",
                        found=show(wanted),
                        at=(name,),
                    )
        elif self.integrator == "generalized_alpha":
            raise RefusedError(
                "generalised-alpha integrates the geometric formulation only",
                "give integrator = 'radau' or 'midpoint', or formulation = 'geometric'",
                found=show(self.integrator),
                at=("integrator",),
            )
        if self.dynamics == "linear" and self.damping == "full":
            raise RefusedError(
                "linear dynamics have linearised damping",
                "add damping = 'linearised', or leave out dynamics",
                found=show(self.dynamics),
                at=("dynamics",),
            )
        return self

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

    @model_validator(mode="after")
    def _fits_integrator(self) -> Self:
        if self.tolerance is not None:
            if self.integrator == "midpoint":
                raise RefusedError(
                    "the midpoint rule has equal steps and no error estimate",
                    "leave it out and give time_step, or take the integrator 'radau' or 'generalized_alpha'",
                    found=show(self.tolerance),
                    at=("tolerance",),
                )
            if not LEAST_TOLERANCE <= self.tolerance <= LARGEST_TOLERANCE:
                raise RefusedError(
                    "out of reach",
                    f"give {LEAST_TOLERANCE:g} to {LARGEST_TOLERANCE:g} (displacement over the size of the model)",
                    found=show(self.tolerance),
                    at=("tolerance",),
                )
        if self.spectral_radius is not None and self.integrator != "generalized_alpha":
            raise RefusedError(
                f"the integrator '{self.integrator}' has no such parameter",
                "leave it out, or add integrator = 'generalized_alpha'",
                found=show(self.spectral_radius),
                at=("spectral_radius",),
            )
        return self


class EquilibriumSettings(Described):
    """How a static equilibrium is computed.

    Args:
        load_steps: number of equal load steps to start with, 1 to 10 000; they are halved where needed.
    """

    load_steps: Annotated[int | None, PlainValidator(optional(whole_number(1, 10_000)))] = None
