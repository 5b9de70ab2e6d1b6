"""Checks of how the parts of a model fit together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from viscorod.errors import Fault, InputError
from viscorod.model.actions.initial_strain import InitialStrain
from viscorod.model.actions.rest_strain import RestStrain
from viscorod.model.connections import joint_checks, support_checks
from viscorod.model.connections.place import GROUND, Place, find_rod, no_part
from viscorod.model.connections.resolved_places import find
from viscorod.model.description.given_places import misplaced
from viscorod.model.fields.definition import RefusedError, path_text, show

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["problems", "require_inertia"]


def problems(model: ModelDescription) -> Iterator[Fault]:
    """Find everything that is wrong with the model as a whole, with key paths."""
    if not model.rods and not model.bodies:
        yield Fault(
            "rods",
            "",
            "the model has no rod and no body",
            "add one with add(name, part), or a table [rods.NAME]",
        )
        return
    found = list(_unknown_places(model))
    if not found:
        found += joint_checks.wrong_attachments(model)
    yield from found
    if not found:
        yield from support_checks.off_centre(model)
        yield from support_checks.clashes(model)
        yield from joint_checks.wrong_joints(model)
        yield from joint_checks.loose_bodies(model)
    yield from joint_checks.names_twice(model)
    yield from _wrong_velocities(model)
    strains = list(_wrong_strains(model))
    yield from strains
    if not found and not strains:
        yield from _unfit_strains(model)


def require_inertia(model: ModelDescription) -> None:
    """Refuse rods whose inertia is not known, for what moves.

    Raises:
        InputError: with each of them.
    """
    faults = [
        Fault(
            f"rods.{name}.section.inertia",
            "",
            "it was left out, and something moves here",
            "give mass and moments of inertia per length, such as { mass = 0.5, J1 = 1e-6, J2 = 1e-6 }",
        )
        if all(
            section.needs_material is False and not section.materials for _, section in rod.typical_sections()
        )
        else Fault(
            f"rods.{name}.material.density",
            "",
            "it was left out, and something moves here",
            "give the mass per volume, kg/m^3",
        )
        for name, rod in model.rods.items()
        if not rod.has_inertia
    ]
    if faults:
        raise InputError(faults)


def _unknown_places(model: ModelDescription) -> Iterator[Fault]:
    for key in ("supports", "loads", "attachments", "joints", "springs"):
        for index, part in enumerate(getattr(model, key)):
            for error in misplaced(model, part):
                where = path_text((key, index, *error.at))
                yield Fault(where, error.found or "", error.why, error.instead)


def _wrong_velocities(model: ModelDescription) -> Iterator[Fault]:
    """Find initial velocities of unknown parts, or given twice, or of bodies by a function."""
    first: dict[str, int] = {}
    for index, given in enumerate(model.velocities):
        where = f"velocities[{index}]"
        if given.rod in model.bodies:
            if given.field is not None:
                yield Fault(
                    f"{where}.field",
                    show(given.rod),
                    "a rigid body has no velocities that differ from point to point",
                    "give linear, angular and about",
                )
        else:
            try:
                find_rod(given.rod, model.rods)
            except RefusedError as error:
                refused = no_part(given.rod, model.rods, model.bodies) if model.bodies else error
                yield Fault(f"{where}.rod", refused.found or "", refused.why, refused.instead)
                continue
        yield from _twice(first, given.rod, index, model, "velocities", "initial velocity")


def _wrong_strains(model: ModelDescription) -> Iterator[Fault]:
    """Find initial and rest strains of unknown rods, initial ones given twice, and tables that leave their rods."""
    both: dict[str, Sequence[InitialStrain | RestStrain]] = {
        "strains": model.strains,
        "rest_strains": model.rest_strains,
    }
    for key, strains in both.items():
        first: dict[str, int] = {}
        for index, given in enumerate(strains):
            try:
                find_rod(given.rod, model.rods, model.bodies)
            except RefusedError as error:
                yield Fault(f"{key}[{index}].rod", error.found or "", error.why, error.instead)
                continue
            if isinstance(given, RestStrain):  # several add up
                for misfit in given.misfits(model.rods[given.rod]):
                    where = path_text((key, index, *misfit.at))
                    yield Fault(where, misfit.found or "", misfit.why, misfit.instead)
            else:
                yield from _twice(first, given.rod, index, model, key, "initial strain")


def _twice(
    first: dict[str, int], name: str, index: int, model: ModelDescription, key: str, noun: str
) -> Iterator[Fault]:
    if name in first:
        part = "body" if name in model.bodies else "rod"
        yield Fault(
            f"{key}[{index}].rod",
            show(name),
            f"the {part} has its {noun} already from {key}[{first[name]}]",
            f"give each {part} one at most",
        )
    first.setdefault(name, index)


def _unfit_strains(model: ModelDescription) -> Iterator[Fault]:
    """Find initial strains of rods that are held elsewhere than at their starts."""
    places = [(f"attachments[{k}]", text) for k, a in enumerate(model.attachments) for text in (a.a, a.b)]
    places += [(f"joints[{k}]", text) for k, j in enumerate(model.joints) for text in j.ends]
    places += [(f"supports[{k}]", support.at) for k, support in enumerate(model.supports)]
    held = [(path, text, find(model, text)) for path, text in places if text != GROUND]
    for index, strain in enumerate(model.strains):
        for path, text, place in held:
            if not isinstance(place, Place) or place.rod != strain.rod:
                continue
            if path.startswith("attachments") or place.s > 0.0:
                yield Fault(
                    f"strains[{index}].rod",
                    show(strain.rod),
                    f"initial strains move all of the rod but its start, and {path} holds {text}",
                    "give it as a rest strain (rest_strain, [[rest_strains]]) if the rod is to be free of stress at it,"
                    " or hold the rod at its start only",
                )
                break
        constrained = model.rods[strain.rod].constraints
        if constrained and any(_strained(model, index)):
            yield Fault(
                f"strains[{index}].value",
                show(list(constrained)),
                "the initial strain is not zero where the rod's constraints hold it",
                "leave the strain or the constraint out",
            )


def _strained(model: ModelDescription, index: int) -> Iterator[bool]:
    """Return for the constrained strains of a rod whether its initial strain is not zero at its start or middle."""
    strain = model.strains[index]
    rod = model.rods[strain.rod]
    for s in (0.0, rod.length / 2.0):
        for value, held in zip(strain.at(s).tolist(), rod.constrained_strains, strict=True):
            yield held and value != 0.0
