"""Laws of damping by words, as variants of a case with the numbers that are then sought.

"elastic", "kelvin_voigt", "flat_loss" and "branches 2" are of the material; "air_drag" and "clamp_loss" are not;
joined by "+" they act together: "elastic + air_drag".
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from viscorod.analyses.identification.sought import Range
from viscorod.casefile.case import Case, case_from_dict
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show

__all__ = ["Frequencies", "variant"]

START = 0.05
"""Loss factor at which the search for one begins."""
DECADE = 10.0
"""Ratio of the relaxation times of neighbouring branches."""
MOST_BRANCHES = 8
AIR = 1.2
"""Density of air, kg/m^3, and a usual drag coefficient."""
STIFF = 100.0
"""Stiffness of a clamp at the start over that of the rod, EI/L."""

Content = dict[str, Any]
Sought = dict[str, Range]


@dataclass(frozen=True)
class Frequencies:
    """Of records: at which they vibrate, in the mean, and the lowest and highest that they hold, Hz.

    A flat loss is flat in that `band`, which may have units as in a case. Its moduli are those `moduli_at`, Hz; left
    out, those in the middle of the band.
    """

    middle: float
    band: Sequence[Any]
    moduli_at: Any = None

    def of_case(self, case: Case) -> Frequencies:
        """Return them with the band of a flat loss that the case has; else its moduli are those of the records."""
        for material in case.content.get("materials", {}).values():
            own = material.get("damping") if isinstance(material, Mapping) else None
            if isinstance(own, Mapping) and own.get("kind") == "loss_factor" and "band" in own:
                return replace(self, band=list(own["band"]), moduli_at=own.get("moduli_at"))
        return replace(self, moduli_at=self.middle)


def variant(case: Case, words: str, hertz: Frequencies) -> tuple[Case, Sought]:
    """Return a case with another law of damping, and the numbers of that with their starts.

    Args:
        case: with one material.
        words: of the law.
        hertz: frequencies of the records.

    Raises:
        InputError: a word is not known, or the case has not what it needs.
    """
    content = copy.deepcopy(dict(case.content))
    materials = list(content.get("materials", {}))
    if len(materials) != 1:
        found = f"{len(materials)} materials"
        raise InputError(
            Fault("laws", found, "laws by words are of one material", "give cases with parameters instead")
        )
    sought: Sought = {}
    parts = [part.strip() for part in words.split("+")]
    of_material = [part for part in parts if part not in _OUTSIDE]
    if len(of_material) > 1:
        raise InputError(
            Fault("laws", show(words), "two laws of one material", "join a law with air_drag or clamp_loss")
        )
    for part in parts:
        branches = re.fullmatch(r"branch(?:es)? (\d+)", part)
        if branches and 1 <= int(branches[1]) <= MOST_BRANCHES:
            sought |= _branches(content, materials[0], hertz, int(branches[1]))
        elif part in _OF_MATERIAL:
            sought |= _OF_MATERIAL[part](content, materials[0], hertz)
        elif part in _OUTSIDE:
            sought |= _OUTSIDE[part](case, content, hertz)
        else:
            known = ", ".join([*_OF_MATERIAL, f"branches 1 to {MOST_BRANCHES}", *_OUTSIDE])
            raise InputError(Fault("laws", show(part), "no such law", f"use {known}, joined by +"))
    return case_from_dict({"title": case.title, **content}, case.source), sought


def _elastic(content: Content, material: str, _hertz: Frequencies) -> Sought:
    content["materials"][material].pop("damping", None)
    return {}


def _kelvin_voigt(content: Content, material: str, hertz: Frequencies) -> Sought:
    tau = START / (2.0 * math.pi * hertz.middle)
    content["materials"][material]["damping"] = {"shear_time": tau, "bulk_time": tau}
    path = f"materials.{material}.damping"
    return {f"{path}.shear_time, {path}.bulk_time": tau}


def _flat_loss(content: Content, material: str, hertz: Frequencies) -> Sought:
    flat = {"kind": "loss_factor", "extension": START, "band": list(hertz.band)}
    if hertz.moduli_at is not None:
        flat["moduli_at"] = hertz.moduli_at
    content["materials"][material]["damping"] = flat
    return {f"materials.{material}.damping.extension": (1e-5, START, 0.9)}


def _branches(content: Content, material: str, hertz: Frequencies, count: int) -> Sought:
    middle = 1.0 / (2.0 * math.pi * hertz.middle)
    times = [middle * DECADE ** (k - 0.5 * (count - 1)) for k in range(count)]
    ratios = [2.0 * START / count] * count
    path = f"materials.{material}.damping"
    content["materials"][material]["damping"] = {
        "kind": "prony",
        "extension_ratios": ratios,
        "extension_times": times,
    }
    sought: Sought = {f"{path}.extension_ratios[{k}]": ratios[k] for k in range(count)}
    if count == 1:
        sought[f"{path}.extension_times[0]"] = times[0]
    return sought


def _air_drag(case: Case, content: Content, _hertz: Frequencies) -> Sought:
    loads = content.setdefault("loads", [])
    keys = []
    for name, rod in case.description.rods.items():
        _, _, inertia = rod.matrices_at(0.0)
        density = getattr(rod.material, "density", None)
        width = math.sqrt(float(inertia[0, 0]) / density) if density else 0.0
        if not width:
            raise InputError(
                Fault("laws", "air_drag", f"the width of rod {name} is not known", "give the load as a case")
            )
        keys.append(f"loads[{len(loads)}].coefficient_across")
        loads.append({"kind": "drag", "rod": name, "coefficient_across": 1.2, "density": AIR, "width": width})
    return {", ".join(keys): 1.2}


def _clamp_loss(case: Case, content: Content, hertz: Frequencies) -> Sought:
    clamps = [one for one in content.get("supports", []) if one.get("kind") == "clamp"]
    if len(clamps) != 1:
        raise InputError(
            Fault("laws", "clamp_loss", f"{len(clamps)} clamps", "give cases with springs instead")
        )
    place = clamps[0]["at"]
    rod = case.description.rods[str(place).split(".")[0].split("@")[0]]
    stiffness = STIFF * float(rod.matrices_at(0.0)[0][3:5, 3:5].diagonal().max()) / rod.length
    damping = START * stiffness / (2.0 * math.pi * hertz.middle)
    content["supports"] = [
        {"kind": "pin", "at": place} if one is clamps[0] else one for one in content["supports"]
    ]
    springs = content.setdefault("springs", [])
    number = len(springs)
    turns = ("rx", "ry", "rz")
    springs.append(
        {
            "at": place,
            "stiffness": dict.fromkeys(turns, stiffness),
            "damping": dict.fromkeys(turns, damping),
        }
    )
    return {
        ", ".join(f"springs[{number}].{word}.{turn}" for turn in turns): start
        for word, start in (("stiffness", stiffness), ("damping", damping))
    }


_OF_MATERIAL: dict[str, Callable[[Content, str, Frequencies], Sought]] = {
    "elastic": _elastic,
    "kelvin_voigt": _kelvin_voigt,
    "flat_loss": _flat_loss,
}
_OUTSIDE: dict[str, Callable[[Case, Content, Frequencies], Sought]] = {
    "air_drag": _air_drag,
    "clamp_loss": _clamp_loss,
}
