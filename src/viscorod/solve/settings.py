"""Settings of the analyses: tables of a case file and keyword arguments of the API in one."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from viscorod.model.actions.event import Events
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import POSITIVE, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import (
    TRIPLE,
    OptionalDirection,
    OptionalNumber,
    OptionalPositive,
    OptionalText,
    OptionalUnitInterval,
    Positive,
    Triple,
    one_of,
    positive,
    vector,
    whole_number,
)

LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-10, 0.1

__all__ = ["AnySettings", "EquilibriumSettings", "PathSettings", "SimulateSettings", "SteadySettings"]


class SimulateSettings(Definition):
    """How a motion is computed."""

    duration: Positive = Key("simulated time", "s")
    time_step: OptionalPositive = Key(
        "{}; the step of integrators with equal steps (left out: chosen from the lowest modes), the "
        "largest step of the others",
        "s",
        default=None,
    )
    tolerance: OptionalPositive = Key(
        "wanted accuracy of the motion: displacements over the size of the model and rotations in rad; the steps "
        'follow from it. 1e-4 for "radau" unless given, less for free vibrations that start from displacements below '
        'a tenth of the size; "generalized_alpha" has equal steps without it',
        default=None,
    )
    initial: Annotated[Literal["equilibrium", "reference"], one_of("equilibrium", "reference")] = Key(
        'what the motion starts from: "equilibrium" under the loads at t = 0-, or the "reference" shape',
        default="equilibrium",
    )
    integrator: Annotated[
        Literal["radau", "generalized_alpha", "midpoint"], one_of("radau", "generalized_alpha", "midpoint")
    ] = Key(
        '"radau" (order 5, steps that follow the error), "generalized_alpha" or "midpoint" (order 2, '
        "which keeps energy exactly)",
        default="radau",
    )
    spectral_radius: OptionalUnitInterval = Key(
        'of "generalized_alpha" at infinite frequency, 0 (strong damping of what is not resolved) to '
        "1 (none); 0.6 unless given",
        default=None,
    )
    output_interval: OptionalPositive = Key(
        "time between stored states, {}; left out, every step", "s", default=None
    )
    formulation: Annotated[Literal["geometric", "intrinsic"], one_of("geometric", "intrinsic")] = Key(
        '"geometric" (strains follow from positions and rotations) or "intrinsic" (strains and body velocities; '
        'positions follow by integration in time), which goes with "radau" and "midpoint"',
        default="geometric",
    )
    damping: Annotated[Literal["full", "linearised"], one_of("full", "linearised")] = Key(
        '"full" Kelvin-Voigt damping, which never damps rigid motions, or "linearised" (Artola, Wynn and Palacios), '
        "which also damps rotations of bent rods; the latter with the intrinsic formulation",
        default="full",
    )
    dynamics: Annotated[Literal["nonlinear", "linear"], one_of("nonlinear", "linear")] = Key(
        '"nonlinear", or "linear" about the state that the motion starts from, with linearised damping',
        default="nonlinear",
    )
    events: Events = Key(
        "what is watched for and recorded, and may end the run: `Crossing`, `Decayed`, `SteadyState`",
        default=(),
    )

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


class EquilibriumSettings(Definition):
    """How a static equilibrium is computed."""

    load_steps: Annotated[int | None, optional(whole_number(1, 10_000))] = Key(
        "number of equal load steps to start with, 1 to 10 000; they are halved where needed", default=None
    )


class PathSettings(Definition):
    """How a path of equilibria is followed."""

    load_factor: OptionalNumber = Key(
        "multiple of the loads towards which the path begins and where it ends. 1 if neither "
        "displacement nor turns is given",
        default=None,
    )
    place: OptionalText = Key('the place whose displacement ends the path, such as "arch@0.5"', default=None)
    axis: Annotated[Literal["x", "y", "z"] | None, optional(one_of("x", "y", "z"))] = Key(
        'global axis of this displacement, "x", "y" or "z"', default=None
    )
    displacement: OptionalNumber = Key("from the reference shape at which the path ends", "m", default=None)
    turns: Annotated[int | None, optional(whole_number(1, 1000))] = Key(
        "number of limit points at the last of which the path ends, 1 to 1000", default=None
    )
    points: Annotated[int, whole_number(2, 100_000)] = Key(
        "number of points at most, 2 to 100 000", default=200
    )
    arc_length: Positive = Key(
        "largest distance between two points, in which a change of the load factor by its unit (load_factor, or 1), a "
        "displacement by the model's length and a rotation by 1 rad count alike",
        default=0.1,
    )

    @property
    def target(self) -> float | None:
        """The load factor at which the path ends, None if it may have any."""
        if self.load_factor is None and self.displacement is None and self.turns is None:
            return 1.0
        return self.load_factor

    @model_validator(mode="after")
    def _whole(self) -> Self:
        given = [name for name in ("place", "axis", "displacement") if getattr(self, name) is not None]
        if given and len(given) < 3:
            missing = next(name for name in ("place", "axis", "displacement") if name not in given)
            raise RefusedError(
                "place, axis and displacement belong together",
                f"add {missing}, or leave out {' and '.join(given)}",
                found="missing",
                at=(missing,),
            )
        return self


@accepts(quantity(TRIPLE, bounds=POSITIVE), "number > 0, or 3 numbers")
def _spin(value: Any) -> float | Triple:
    """An angular speed, or an angular velocity."""
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        given = vector(value)
        if not any(given):
            raise RefusedError("nothing turns", "give an angular velocity such as [0, 0, 4.0]")
        positive(math.hypot(*given))
        return given
    return positive(value)


class SteadySettings(Definition):
    """Which steady rotation is sought.

    Exactly one of `spin`, `energy` and `momentum` is given.
    """

    spin: Annotated[float | Triple | None, optional(_spin)] = Key(
        "{}. Three numbers: the angular velocity, global axes, with which the supports turn, or about which a rod on "
        "a ball joint or without supports does. One number: how fast such a rod turns, about an axis that is found",
        "rad/s",
        default=None,
    )
    energy: OptionalPositive = Key("kinetic and elastic energy of a rod that turns freely", "J", default=None)
    momentum: OptionalPositive = Key(
        "its angular momentum about the ball joint or the mass centre", "N m s", default=None
    )
    axis: OptionalDirection = Key(
        "of a rod that turns freely: the reference shape about this axis, global axes, is the first "
        "guess; without it a bent shape is sought",
        default=None,
    )
    about: Annotated[Triple | None, optional(vector)] = Key(
        "a point on the axis of a given angular velocity, {}. Unless given it is the origin, for a "
        "rod that turns freely the ball joint or the mass centre",
        "m",
        default=None,
    )
    formulation: Annotated[Literal["geometric", "intrinsic"], one_of("geometric", "intrinsic")] = Key(
        '"geometric" (positions and rotations) or "intrinsic" (body velocities and strains)',
        default="geometric",
    )
    damping: Annotated[Literal["full", "linearised"], one_of("full", "linearised")] = Key(
        '"full" Kelvin-Voigt damping or "linearised" (Artola, Wynn and Palacios), which lets rods '
        "turn about their own axis only; the latter with the intrinsic formulation",
        default="full",
    )
    modes: Annotated[int, whole_number(1, 1000)] = Key(
        "number of small motions about the rotation to report, 1 to 1000", default=6
    )

    @property
    def measure(self) -> Literal["spin", "energy", "momentum"]:
        """The one that is given."""
        return "spin" if self.spin is not None else "energy" if self.energy is not None else "momentum"

    @property
    def driven(self) -> bool:
        """Whether the angular velocity is given as a vector."""
        return isinstance(self.spin, tuple)

    @model_validator(mode="after")
    def _one_measure(self) -> Self:
        given = [name for name in ("spin", "energy", "momentum") if getattr(self, name) is not None]
        if len(given) != 1:
            raise RefusedError(
                "a steady rotation is picked by exactly one of spin, energy and momentum",
                "give one of them, such as spin = [0, 0, 4.0]",
                found=" and ".join(given),
                at=(given[1],) if given else ("spin",),
            )
        if self.driven and self.axis is not None:
            raise RefusedError(
                "the angular velocity tells the axis already",
                "leave axis out, or give spin as one number",
                found=show(self.axis),
                at=("axis",),
            )
        if self.about is not None and not self.driven:
            raise RefusedError(
                "a rod that turns freely turns about its ball joint or its mass centre",
                "leave about out, or give spin as an angular velocity, three numbers",
                found=show(self.about),
                at=("about",),
            )
        if self.formulation == "geometric" and self.damping == "linearised":
            raise RefusedError(
                "the geometric formulation has full damping only",
                "add formulation = 'intrinsic', or leave out damping",
                found=show(self.damping),
                at=("damping",),
            )
        return self


AnySettings: TypeAlias = SimulateSettings | EquilibriumSettings | PathSettings | SteadySettings
"""Settings of one of the analyses."""
