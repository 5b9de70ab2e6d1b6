"""Checks that settings suit the model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from viscorod.errors import Fault, InputError
from viscorod.model.actions.event import Crossing
from viscorod.model.actions.time_function import Constant
from viscorod.model.connections.place import GROUND
from viscorod.model.connections.resolved_places import find
from viscorod.model.connections.velocity_support import VelocitySupport
from viscorod.model.fields.definition import RefusedError, show
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.reduced_checks import unfit_for_modes
from viscorod.solve.transient.integrators import INTEGRATORS, integrators_that

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["require_fit", "unfit_for_steady"]


_MATRICES_ONLY = "linearised damping is that of section matrices, and this rod has a law beside them"
_KELVIN_VOIGT = "take Kelvin-Voigt damping instead of the branches, or {}"


def require_fit(model: ModelDescription, settings: SimulateSettings) -> None:
    """Refuse settings that do not go with the model.

    Raises:
        InputError: with everything that does not fit, by name, and what to take instead.
    """
    problems = list(_unfit(model, settings))
    if problems:
        raise InputError(problems)


def unfit_for_steady(model: ModelDescription, formulation: str, damping: str) -> Iterator[Fault]:
    """Yield what a steady rotation in a formulation with a kind of damping cannot be computed with."""
    if formulation == "intrinsic":
        why, instead = "steady rotations of the intrinsic formulation have no {}", "leave out formulation"
        yield from _joints(model, why.format("joints, which hold positions"), instead)
        yield from _springs(model, why.format("springs, which pull by positions"), instead)
    if damping == "linearised":
        why = "linearised damping is that of Kelvin-Voigt rods, this one has Maxwell branches"
        yield from _branches(model, why, _KELVIN_VOIGT.format("damping = 'full'"))
        yield from _laws(model, _MATRICES_ONLY, "take damping = 'full'")
    yield from _moving_joints(model, "a steady rotation needs joints that stay as they are")
    for index, joint in enumerate(model.joints):
        where = f"joints[{index}]"
        if joint.damping and GROUND in joint.ends:
            why = "the ground of a joint turns with the model, while its damper would stand still"
            instead = "join the place to a body that is clamped, or leave out damping"
            yield Fault(where, joint.label, why, instead)
    why = "it changes with time, and a steady rotation does not"
    yield from _changing_rest(model, why, "leave out time, or compute the motion with simulate")


def _unfit(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    yield from _moving_supports(model, settings)
    if settings.dynamics == "linear":
        yield from _unfit_for_linear_dynamics(model)
    else:
        yield from _unfit_for_damping(model, settings)
    if settings.modes is not None:
        yield from unfit_for_modes(model)
    yield from _struck_dashpots(model, settings)
    yield from _driven_held_strains(model, settings)
    yield from _unknown_places(model, settings)
    yield from _two_starts(model, settings)


def _moving_supports(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    """Say which motions of supports an integrator cannot follow, or linear dynamics do not have."""
    method = INTEGRATORS[settings.integrator]
    for index, support in enumerate(model.supports):
        if isinstance(support, VelocitySupport) and not method.velocity_supports:
            others = integrators_that(lambda other: other.velocity_supports)
            yield Fault(
                f"supports[{index}].kind",
                support.label,
                f"{method.title} cannot hold velocities along moving axes",
                f"give integrator = {others}, or hold positions by another support",
            )
        if settings.dynamics == "linear" and (
            support.motion or (isinstance(support, VelocitySupport) and support.velocity)
        ):
            yield Fault(
                f"supports[{index}].{'motion' if support.motion else 'velocity'}",
                support.label,
                "linear dynamics need supports that stay where they are",
                "leave it out, or take dynamics = 'nonlinear'",
            )


def _unfit_for_linear_dynamics(model: ModelDescription) -> Iterator[Fault]:
    why = "linear dynamics have no {}"
    yield from _moving_joints(model, "linear dynamics need joints that stay where they are")
    yield from _laws(model, why.format("laws of sections"), "leave it out, or take dynamics = 'nonlinear'")
    yield from _changing_drag(model)
    yield from _changing_rest(
        model, why.format("rest strains that change with time"), "take dynamics = 'nonlinear'"
    )


def _unfit_for_damping(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    """Say which sections the damping, or the integrator, of a nonlinear motion does not have."""
    formulation = FORMULATIONS[settings.formulation, settings.damping]
    if not formulation.branches:
        why = f"{settings.damping} damping is that of Kelvin-Voigt rods, this one has Maxwell branches"
        yield from _branches(model, why, "take damping = 'full'")
    if not formulation.laws:
        yield from _laws(model, _MATRICES_ONLY, "take damping = 'full'")
    if settings.damping == "linearised":
        why = "linearised damping is that of one unstressed shape, and this rest strain changes with time"
        yield from _changing_rest(model, why, "take damping = 'full'")
    if settings.integrator == "generalized_alpha" and any(rod.law is not None for rod in model.rods.values()):
        why = "generalised alpha has no laws of sections with rest strains that change with time"
        yield from _changing_rest(model, why, "take integrator = 'radau'")


def _unknown_places(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    """Say which events watch places that the model does not have."""
    for index, event in enumerate(settings.events):
        if isinstance(event, Crossing):
            try:
                find(model, event.at)
            except RefusedError as error:
                yield Fault(f"events[{index}].at", show(event.at), error.why, error.instead)


def _two_starts(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    """Say where initial strains and settings start a motion in two ways."""
    if model.strains and settings.start is None and settings.initial == "equilibrium":
        yield Fault(
            "initial",
            "'equilibrium'",
            "the model has initial strains, which are not an equilibrium",
            "give initial = 'reference' to start from the shape that they make, or remove the strains",
        )
    if model.strains and settings.start is not None:
        yield Fault(
            "start", "", "the model has initial strains, which are another start", "leave one of them out"
        )


def _joints(model: ModelDescription, why: str, instead: str) -> Iterator[Fault]:
    for index, joint in enumerate(model.joints):
        yield Fault(f"joints[{index}]", joint.label, why, instead)


def _moving_joints(model: ModelDescription, why: str) -> Iterator[Fault]:
    for index, joint in enumerate(model.joints):
        for word, motion in joint.motion.items():
            if not isinstance(motion, Constant):
                yield Fault(
                    f"joints[{index}].motion.{word}",
                    joint.label,
                    f"{why}, and this motion is a function of time",
                    "give a number, or compute the nonlinear motion with simulate",
                )


def _changing_drag(model: ModelDescription) -> Iterator[Fault]:
    for index, load in enumerate(model.loads):
        if load.sees_motion and not (
            load.until is None and (load.time is None or isinstance(load.time, Constant))
        ):
            why = "linear dynamics have constant matrices, and its part in them would change with time"
            yield Fault(
                f"loads[{index}]", load.word, why, "leave out time and until, or take dynamics = 'nonlinear'"
            )


def _changing_rest(model: ModelDescription, why: str, instead: str) -> Iterator[Fault]:
    for index, strain in enumerate(model.rest_strains):
        if strain.changes:
            yield Fault(f"rest_strains[{index}].time", strain.rod, why, instead)


def _struck_dashpots(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    """Refuse rest strains that jump where dashpots would answer with infinite forces."""
    for index, strain in enumerate(model.rest_strains):
        jumps = [t for t in strain.jumps if 0.0 < t < settings.duration]
        if jumps and model.rods[strain.rod].viscous:
            yield Fault(
                f"rest_strains[{index}].time",
                f"a jump at {jumps[0]:g} s",
                "the dashpots of the rod answer a jump of its rest strain with an infinite force",
                "give a ramp, or a material with Maxwell branches alone",
            )


def _driven_held_strains(model: ModelDescription, settings: SimulateSettings) -> Iterator[Fault]:
    """Refuse rest strains that change where constraints keep strains at what they are, as some instants show."""
    for index, strain in enumerate(model.rest_strains):
        rod = model.rods[strain.rod]
        if not strain.changes or not any(rod.constrained_strains):
            continue
        given = strain.on(rod)
        times = [settings.duration * k / 4.0 for k in range(5)] if strain.sees_time else [0.0]
        places = [rod.length * k / 4.0 for k in range(5)]
        values = [given.at(s, t) for s in places for t in times]
        if any(held and value[k] for value in values for k, held in enumerate(rod.constrained_strains)):
            yield Fault(
                f"rest_strains[{index}].rod",
                strain.rod,
                f"its constraints {', '.join(rod.constraints)} hold a strain whose rest strain changes with time",
                "leave the constraint out, or that strain zero",
            )


def _springs(model: ModelDescription, why: str, instead: str) -> Iterator[Fault]:
    for index, spring in enumerate(model.springs):
        yield Fault(f"springs[{index}]", spring.label, why, instead)


def _laws(model: ModelDescription, why: str, instead: str) -> Iterator[Fault]:
    for name, rod in model.rods.items():
        if rod.law is not None:
            yield Fault(f"rods.{name}.law", type(rod.law).__name__, why, instead)


def _branches(model: ModelDescription, why: str, instead: str) -> Iterator[Fault]:
    for name, rod in model.rods.items():
        if rod.relaxing:
            yield Fault(f"rods.{name}", "Maxwell branches", why, instead)
