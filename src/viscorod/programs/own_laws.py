"""Refuse rods that other programs cannot represent."""

from __future__ import annotations

from collections.abc import Sequence

from viscorod.errors import Fault, InputError
from viscorod.model.rod import Rod
from viscorod.typing import Floats

__all__ = ["refuse_own_laws", "refuse_tilt"]


def refuse_tilt(rod: Rod) -> None:
    """Refuse a rod whose sections are oblique.

    Raises:
        InputError: they are.
    """
    if rod.tilted:
        why = "the sections of other programs are normal to the reference line"
        raise InputError(Fault("rod.tilt", "", why, "leave it out"))


def refuse_own_laws(rod: Rod, stations: Floats | Sequence[float]) -> None:
    """Refuse a rod with a law of its section beside stiffness and damping, or Maxwell branches at `stations`, m.

    So are rods whose sections are oblique.

    Raises:
        InputError: the rod has a law or tilted sections, or a section has branches.
    """
    refuse_tilt(rod)
    if not rod.has_inertia:
        raise InputError(
            Fault(
                "rod",
                "",
                "other programs need its inertia, which is not known",
                "give the density of its material, or the inertia of its section",
            )
        )
    if rod.law is not None:
        raise InputError(
            Fault(
                "rod.law",
                type(rod.law).__name__,
                "the other programs have sections with stiffness and damping matrices only",
                "leave it out",
            )
        )
    for s in stations:
        if rod.branches_at(float(s))[0].size:
            raise InputError(
                Fault(
                    "rod",
                    "",
                    f"its section at {s:.4g} m has Maxwell branches, and the other programs have Kelvin-Voigt "
                    "damping only",
                    'a Prony series with law = "kelvin_voigt" has the viscosity of slow motion instead, a LossFactor '
                    "with frequency in place of band that at one frequency",
                )
            )
