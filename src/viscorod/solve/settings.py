"""Settings of the analyses: tables of a case file and keyword arguments of the API in one."""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from viscorod.model.actions.event import Events
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import POSITIVE, TEXT, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import (
    TRIPLE,
    Flag,
    Number,
    OneOfRegistry,
    OptionalDirection,
    OptionalNumber,
    OptionalPositive,
    OptionalText,
    OptionalUnitInterval,
    Positive,
    Triple,
    each,
    numbers,
    one_of,
    positive,
    vector,
    whole_number,
    word,
)
from viscorod.solve.formulations.registry import FORMULATIONS, damping_words, dampings, formulation_words
from viscorod.solve.stage_settings import Stages
from viscorod.solve.start import OptionalStart, Start, as_start
from viscorod.solve.transient.integrators import INTEGRATORS, Method, integrators_that

LEAST_TOLERANCE, LARGEST_TOLERANCE, LEAST_ACCURACY = 1e-10, 0.1, 1e-8

__all__ = [
    "AnySettings",
    "CoSimulationSettings",
    "EquilibriumSettings",
    "Meshed",
    "ModesSettings",
    "PathSettings",
    "SimulateSettings",
    "SteadySettings",
]


def _has(parameter: str, method: Method) -> bool:
    return parameter in method.parameters


@accepts(quantity(bounds=POSITIVE), "number from 1e-8 to 0.1")
def _accuracy(value: Any) -> float:
    wanted = positive(value)
    if not LEAST_ACCURACY <= wanted <= LARGEST_TOLERANCE:
        raise RefusedError("out of reach", f"give {LEAST_ACCURACY:g} to {LARGEST_TOLERANCE:g}")
    return wanted


class Meshed(Definition):
    """What is wanted of a mesh."""

    accuracy: Annotated[float, _accuracy] = Key(
        "wanted accuracy of the mesh where a rod leaves out elements: estimated error of positions over the largest "
        "displacement, of section forces over the largest one, of each listed frequency over itself. The mesh is "
        "refined until it is reached",
        default=1e-4,
        kw_only=True,
    )


class SimulateSettings(Meshed):
    """How a motion is computed."""

    duration: Positive = Key("simulated time", "s")
    time_step: OptionalPositive = Key(
        "{}; the step of integrators with equal steps (left out: chosen from the lowest modes), the "
        "largest step of the others",
        "s",
        default=None,
    )
    tolerance: OptionalPositive = Key(
        "what steps may err by: displacements over the size of the model and rotations in rad; the steps "
        'follow from it. Unless given, for "radau" 0.03 % of the amplitude of the motion that there is, and 1e-4 at '
        'most; "generalized_alpha" has equal steps without it',
        default=None,
    )
    initial: Annotated[Literal["equilibrium", "reference"], one_of("equilibrium", "reference")] = Key(
        'what the motion starts from: "equilibrium" under the loads at t = 0-, or the "reference" shape',
        default="equilibrium",
    )
    integrator: Annotated[str, OneOfRegistry(INTEGRATORS.keys)] = Key(
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
    formulation: Annotated[str, OneOfRegistry(formulation_words)] = Key(
        '"geometric" (strains follow from positions and rotations) or "intrinsic" (strains and body velocities; '
        'positions follow by integration in time), which goes with "radau" and "midpoint"',
        default="geometric",
    )
    damping: Annotated[str, OneOfRegistry(damping_words)] = Key(
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
    start: OptionalStart = Key(
        "state of an earlier result that the motion starts from instead of `initial`, with its velocities; its own "
        "time begins at 0",
        default=None,
    )

    @model_validator(mode="after")
    def _one_start(self) -> Self:
        if self.start is not None and "initial" in self.model_fields_set:
            raise RefusedError(
                "the motion starts from an earlier result",
                "leave initial out, or start",
                found=show(self.initial),
                at=("initial",),
            )
        return self

    @model_validator(mode="after")
    def _fits_formulation(self) -> Self:
        own, method = dampings(self.formulation), INTEGRATORS[self.integrator]
        linear = {word: kind for word, kind in own.items() if kind.linear}
        if self.damping not in own or (self.dynamics == "linear" and not linear):
            name = "dynamics" if self.damping in own else "damping"
            raise RefusedError(
                f"the {self.formulation} formulation has {' or '.join(own)} damping"
                f"{'' if linear else ' and nonlinear dynamics'} only",
                f"add formulation = 'intrinsic', or leave out {name}",
                found=show(getattr(self, name)),
                at=(name,),
            )
        if self.formulation not in method.formulations:
            others = integrators_that(lambda other: self.formulation in other.formulations)
            raise RefusedError(
                f"{method.title} integrates the {' and '.join(method.formulations)} formulation only",
                f"give integrator = {others}, or formulation = {method.formulations[0]!r}",
                found=show(self.integrator),
                at=("integrator",),
            )
        if self.dynamics == "linear" and self.damping not in linear:
            raise RefusedError(
                f"linear dynamics have {' or '.join(linear)} damping",
                f"add damping = {' or '.join(map(repr, linear))}, or leave out dynamics",
                found=show(self.dynamics),
                at=("dynamics",),
            )
        if self.dynamics == "linear" and method.make_linear is None:
            raise RefusedError(
                f"{method.title} integrates nonlinear dynamics only",
                f"give integrator = {integrators_that(lambda other: other.make_linear)}, or leave out dynamics",
                found=show(self.integrator),
                at=("integrator",),
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
        method = INTEGRATORS[self.integrator]
        if self.tolerance is not None:
            if not method.adaptive:
                others = integrators_that(lambda other: other.adaptive)
                raise RefusedError(
                    f"{method.title} has equal steps and no error estimate",
                    f"leave it out and give time_step, or take the integrator {others}",
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
        for name in sorted({name for other in INTEGRATORS.values() for name in other.parameters}):
            value = getattr(self, name)
            if value is not None and name not in method.parameters:
                others = integrators_that(partial(_has, name))
                raise RefusedError(
                    f"the integrator '{self.integrator}' has no such parameter",
                    f"leave it out, or add integrator = {others}",
                    found=show(value),
                    at=(name,),
                )
        return self


@accepts(listed(quantity()), "list of numbers")
def _factors(value: Any) -> tuple[float, ...]:
    return numbers(value, at_least=0)


class EquilibriumSettings(Meshed):
    """How a static equilibrium is computed."""

    load_steps: Annotated[int | None, optional(whole_number(1, 10_000))] = Key(
        "number of equal load steps, 1 to 10 000, each of which is stored, and nothing between; smaller steps are "
        "taken where needed. Left out, all steps are stored; the first is the whole load, or a third of a turn of a "
        "prescribed rotation",
        default=None,
    )
    load_factor: Number = Key("multiple of all loads and prescribed motions", default=1.0)
    search: Flag = Key(
        "whether the search goes on to a stable equilibrium where load steps fail or end at an unstable one; false "
        "keeps to the equilibrium that load steps lead to, such as that of a straight strut. Left out, it does so "
        "unless rotations of more than a full turn are prescribed, which rods without contact might undo",
        default=True,
    )
    start: OptionalStart = Key(
        "state of an earlier result from which the search begins instead of the reference shape; loads act in full "
        "from there on, prescribed motions grow from what they are in it",
        default=None,
    )
    stages: Stages = Key(
        "stages, each from the equilibrium at the end of the one before: which loads and motions grow in it",
        default=(),
    )
    load_factors: Annotated[tuple[float, ...], _factors] = Key(
        "multiples of all loads and prescribed motions that are wanted, in this order, in place of load_factor and "
        "load_steps; exactly these are stored",
        default=(),
    )

    @property
    def stops(self) -> tuple[float, ...]:
        """The load factors that are wanted, in their order; the last one is the end."""
        if self.load_factors:
            return self.load_factors
        steps = self.load_steps or 1
        return (*(self.load_factor * (k / steps) for k in range(1, steps)), self.load_factor)

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.load_factors and (self.stages or self.start is not None):
            raise RefusedError(
                f"loads of {'stages' if self.stages else 'a start'} go from what they are to their full size",
                "leave it out, or give load_steps",
                found=show(list(self.load_factors)),
                at=("load_factors",),
            )
        if self.load_factors and (self.load_steps is not None or self.load_factor != 1.0):
            other = "load_steps" if self.load_steps is not None else "load_factor"
            raise RefusedError(
                f"load_factors says which states are wanted, so does {other}",
                f"leave {other} or load_factors out",
                found=show(list(self.load_factors)),
                at=("load_factors",),
            )
        return self


@accepts({"type": "integer", "minimum": -1000, "maximum": 1000}, "whole number from -1000 to 1000, not 0")
def _branch(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value == 0 or abs(value) > 1000:
        raise RefusedError(
            "the number of a bifurcation is needed here", "give 1 for the first, -1 for its other side"
        )
    return value


class PathSettings(Meshed):
    """How a path of equilibria is followed."""

    renamed: ClassVar[dict[str, str]] = {"turns": "limit_point"}

    load_factor: OptionalNumber = Key(
        "multiple of the loads towards which the path begins and where it ends. 1 if neither "
        "displacement nor limit_point is given",
        default=None,
    )
    place: OptionalText = Key('the place whose displacement ends the path, such as "arch@0.5"', default=None)
    axis: Annotated[Literal["x", "y", "z"] | None, optional(one_of("x", "y", "z"))] = Key(
        'global axis of this displacement, "x", "y" or "z"', default=None
    )
    displacement: OptionalNumber = Key("from the reference shape at which the path ends", "m", default=None)
    limit_point: Annotated[int | None, optional(whole_number(1, 1000))] = Key(
        "number of limit points at the last of which the path ends, 1 to 1000", default=None
    )
    load_factors: Annotated[tuple[float, ...], _factors] = Key(
        "load factors at which a point is wanted, each time the path passes one", default=()
    )
    branch: Annotated[int | None, optional(_branch)] = Key(
        "number of the bifurcation at which the path goes over to the branch that crosses it there, 1 for the first; "
        "-1 goes to its other side",
        default=None,
    )
    points: Annotated[int, whole_number(2, 100_000)] = Key(
        "number of points at most, 2 to 100 000", default=200
    )
    arc_length: OptionalPositive = Key(
        "largest distance between two points, in which a displacement by the model's length, a rotation by 1 rad and a "
        "change of the load factor by its unit count alike. The unit is load_factor, or what moves the reference shape "
        "by its length if that is less. Left out, 0.1, or a hundredth of prescribed motions if that is more",
        default=None,
    )
    start: OptionalStart = Key(
        "state of an earlier result near which the path begins, at its load factor (1 for a motion), instead of the "
        "reference shape without loads",
        default=None,
    )

    @property
    def target(self) -> float | None:
        """The load factor at which the path ends, None if it may have any."""
        if self.load_factor is None and self.displacement is None and self.limit_point is None:
            return self.load_factors[-1] if self.load_factors else 1.0
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


@accepts(listed(TEXT), "list of places, in quotes")
def _ports(value: Any) -> tuple[str, ...]:
    return each(value, word)


@accepts(quantity(TRIPLE, bounds=POSITIVE), "number > 0, or 3 numbers")
def _spin(value: Any) -> float | Triple:
    """Return an angular speed, or an angular velocity."""
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        given = vector(value)
        if not any(given):
            raise RefusedError("nothing turns", "give an angular velocity such as [0, 0, 4.0]")
        positive(math.hypot(*given))
        return given
    return positive(value)


class SteadySettings(Meshed):
    """Which steady rotation is sought.

    Exactly one of `spin`, `energy` and `momentum` is given.
    """

    renamed: ClassVar[dict[str, str]] = {"about": "centre"}

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
    centre: Annotated[Triple | None, optional(vector)] = Key(
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
    start: OptionalStart = Key(
        "state of an earlier result, a motion that turns, as first guess", default=None
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
                "the angular velocity has an axis already",
                "leave axis out, or give spin as one number",
                found=show(self.axis),
                at=("axis",),
            )
        if self.centre is not None and not self.driven:
            raise RefusedError(
                "a rod that turns freely turns about its ball joint or its mass centre",
                "leave centre out, or give spin as an angular velocity, three numbers",
                found=show(self.centre),
                at=("centre",),
            )
        if (self.formulation, self.damping) not in FORMULATIONS:
            raise RefusedError(
                f"the {self.formulation} formulation has {' or '.join(dampings(self.formulation))} damping only",
                "add formulation = 'intrinsic', or leave out damping",
                found=show(self.damping),
                at=("damping",),
            )
        return self


ABOUT = ("equilibrium", "released", "reference")


@accepts(None, '"equilibrium", "released" or "reference"', "a result, or one with a time: `(run, 1.5)`")
def _about(value: Any) -> str | Start:
    if isinstance(value, str) and (value in ABOUT or not value.endswith(".nc")):
        return one_of(*ABOUT)(value)
    found = as_start(value)
    assert found is not None
    return found


class ModesSettings(Meshed):
    """Which small vibrations are sought."""

    count: Annotated[int, whole_number(1, 100_000)] = Key("number of modes, 1 to 100 000", default=6)
    about: Annotated[str | Start, _about] = Key(
        '"equilibrium" under the loads at t = 0- (just before t = 0), the equilibrium once "released", under those '
        'just after t = 0, or the "reference" shape (as if free of load); a state of an earlier result: about the '
        "equilibrium under the loads at t = 0- that is found from there",
        default="equilibrium",
    )
    near: OptionalPositive = Key(
        "those whose natural frequencies are nearest to this one, in place of the slowest", "Hz", default=None
    )
    oscillating: Flag = Key("leave out rigid motions and overdamped modes", default=False)


LONGEST_COUPLING = 1e6
"""Simulated time [s] for which the settings of a co-simulation are chosen; it has no end of its own."""


class _Ports(Definition):
    ports: Annotated[tuple[str, ...], _ports] = Key(
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


AnySettings: TypeAlias = SimulateSettings | EquilibriumSettings | PathSettings | SteadySettings
"""Settings of one of the analyses."""
