"""Checks that a motion in modes suits the model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from viscorod.errors import Fault
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.velocity_support import VelocitySupport

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["unfit_for_modes"]

_WHOLE = "leave out modes, and compute the motion of all nodes"
_TRANSLATIONS, _ROTATIONS = MOTIONS[:3], MOTIONS[3:]


def unfit_for_modes(model: ModelDescription) -> Iterator[Fault]:
    """Yield what a motion in modes cannot be computed with."""
    why = "motions in modes have no {}: modes fulfil no conditions on positions"
    for index, joint in enumerate(model.joints):
        yield Fault(f"joints[{index}]", joint.label, why.format("joints"), _WHOLE)
    for index, spring in enumerate(model.springs):
        yield Fault(f"springs[{index}]", spring.label, "motions in modes have no springs", _WHOLE)
    for name, rod in model.rods.items():
        if rod.relaxing:
            why = "motions in modes have Kelvin-Voigt damping, and this rod has Maxwell branches"
            yield Fault(f"rods.{name}", "Maxwell branches", why, _WHOLE)
        if rod.law is not None:
            why = "motions in modes have the quadratic energy of section matrices, and this rod has a law beside them"
            yield Fault(f"rods.{name}.law", type(rod.law).__name__, why, _WHOLE)
        if any(rod.constrained_strains):
            why = "motions in modes hold no strains"
            yield Fault(f"rods.{name}.constraints", ", ".join(rod.constraints), why, _WHOLE)
    for index, strain in enumerate(model.rest_strains):
        if strain.changes:
            why = "modes are those of one unstressed shape, and this rest strain changes with time"
            yield Fault(f"rest_strains[{index}].time", strain.rod, why, _WHOLE)
    yield from _supports(model)


def _supports(model: ModelDescription) -> Iterator[Fault]:
    for index, support in enumerate(model.supports):
        moving = "motion" if support.motion else "velocity"
        if support.motion or (isinstance(support, VelocitySupport) and support.velocity):
            why = "motions in modes need supports that stand still"
            yield Fault(f"supports[{index}].{moving}", support.label, why, _WHOLE)
        elif not isinstance(support, VelocitySupport) and not _turns_with_section(support.held()):
            why = (
                "it holds directions in space while its section turns, and velocities in modes are those along the "
                "axes of the section"
            )
            instead = (
                f"hold all displacements, with no, two or three rotations, or all rotations; or {_WHOLE}"
            )
            yield Fault(f"supports[{index}]", support.label, why, instead)


def _turns_with_section(held: tuple[str, ...]) -> bool:
    """Return whether what is held is the same in the axes of the section however far it turns."""
    turning = sum(word in held for word in _ROTATIONS)
    return turning == len(_ROTATIONS) or (all(word in held for word in _TRANSLATIONS) and turning != 1)
