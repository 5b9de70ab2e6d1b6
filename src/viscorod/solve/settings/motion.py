"""Settings of a motion: a table of a case file and keyword arguments of the API in one."""

from __future__ import annotations

from functools import partial
from typing import Annotated, ClassVar, Literal, Self

from pydantic import model_validator

from viscorod.model.actions.event import Events
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.metadata import Key, optional
from viscorod.model.fields.values import (
    OneOfRegistry,
    OptionalPositive,
    OptionalUnitInterval,
    Positive,
    one_number_of,
    one_of,
    whole_number,
)
from viscorod.solve.formulations.registry import damping_words, dampings, formulation_words
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import LARGEST_TOLERANCE, Meshed
from viscorod.solve.start import OptionalStart
from viscorod.solve.transient.integrators import INTEGRATORS, Method, integrators_that

__all__ = ["SimulateSettings"]


LEAST_TOLERANCE = 1e-10
MOST_MODES = 200
"""Vibration modes of a reduced motion at most: its arrays grow with their cube."""


def _has(parameter: str, method: Method) -> bool:
    return parameter in method.parameters


class SimulateSettings(Meshed):
    """How a motion is computed."""

    needs: ClassVar[str] = "a duration"

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
        '"radau" (order 5, or more with more stages; steps that follow the error), "generalized_alpha" or '
        '"midpoint" (order 2, which keeps energy exactly)',
        default="radau",
    )
    spectral_radius: OptionalUnitInterval = Key(
        'of "generalized_alpha" at infinite frequency, 0 (strong damping of what is not resolved) to '
        "1 (none); 0.6 unless given",
        default=None,
    )
    stages: Annotated[int | None, optional(one_number_of(3, 5, 7))] = Key(
        'of "radau", whose order is twice that less one; 3 unless given, 5 pay for a tolerance of 1e-7 or less',
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
    modes: Annotated[int | None, optional(whole_number(1, MOST_MODES))] = Key(
        "of the intrinsic formulation: the motion is sought in so many vibration modes, with rigid motions and the "
        "answers to products of modes beside them; left out: in the velocities of all nodes",
        default=None,
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

    @property
    def course(self) -> Course:
        """See :class:`Meshed`."""
        return Course("t", " s", 0.0, self.duration)

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
    def _fits_modes(self) -> Self:
        if self.modes is None:
            return self
        method = INTEGRATORS[self.integrator]
        if self.formulation != "intrinsic" or self.dynamics == "linear":
            raise RefusedError(
                "motions in modes are those of the nonlinear intrinsic equations",
                "add formulation = 'intrinsic' and leave out dynamics, or leave out modes; linear motions in modes: "
                "model.linear(...).reduced(...)",
                found=show(self.modes),
                at=("modes",),
            )
        if method.make_reduced is None:
            raise RefusedError(
                f"{method.title} does not integrate motions in modes",
                f"give integrator = {integrators_that(lambda other: other.make_reduced)}, or leave out modes",
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

    @property
    def mesh_accuracy(self) -> float:
        """The accuracy of the mesh: what was given, else no less than the tolerance that was given for the steps."""
        if "accuracy" in self.model_fields_set:
            return self.accuracy
        return max(self.accuracy, self.tolerance or 0.0)

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
