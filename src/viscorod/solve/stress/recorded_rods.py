"""Sections of the rods of a result, from what it keeps of its model."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.materials.material import Material
from viscorod.model.sections.kept_meshes import KeptMesh, kept_meshes
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_profile import Piecewise, SectionProfile, section_profile
from viscorod.model.sections.section_stations import Stations
from viscorod.model.sections.taper import Taper
from viscorod.model.strain_constraints import constrained_strains
from viscorod.typing import Floats

__all__ = ["RecordedRod", "RecordedRods", "SectionHere"]

_KEYS = (
    *("section", "sections", "taper", "stations", "sampled", "bent"),
    *("material", "constraints", "law", "tilt", "curvature_correction"),
)
"""What a table of a rod says of its sections."""


class SectionHere(NamedTuple):
    """A section with the material that it takes, and which of the six strains its rod holds.

    ``corrected`` tells whether the curvature of the reference shape is counted in its matrices.
    """

    section: AnySection
    material: Material | None
    held: tuple[bool, ...]
    corrected: bool = False


class RecordedRods:
    """The rods of a result.

    Args:
        attrs: of the result; lengths: of the rods by name [m].

    Attributes:
        known: sections that have been looked at, for those who do.
    """

    def __init__(self, attrs: Mapping[str, Any], lengths: Mapping[str, float]) -> None:
        case = json.loads(str(attrs.get("case") or "{}"))
        self._rods = case.get("rods", {})
        self._warmed = {
            s["rod"] for s in case.get("rest_strains", ()) if {"temperature", "gradient"} & s.keys()
        }
        self._more = json.loads(str(attrs.get("sections") or "{}"))
        self._meshes = [KeptMesh.of_list(one) for one in json.loads(str(attrs.get("section_meshes") or "[]"))]
        self._lengths = lengths
        self._alike: dict[str, RecordedRod] = {}
        self.known: dict[Any, Any] = {}

    def meshes(self) -> AbstractContextManager[None]:
        """Let sections take the meshes that the result was computed with, where it was by a neighbour of a model."""
        return kept_meshes(self._meshes)

    def rod(self, name: str) -> RecordedRod:
        """Return the sections of a rod.

        Raises:
            InputError: the result does not hold them, or no stress follows from them.
        """
        if name not in self._rods:
            raise InputError(
                Fault(
                    "place",
                    name,
                    "this result does not hold its model, and thus no section",
                    "compute it again",
                )
            )
        rod = self._rods[name] | self._more.get(name, {})
        described = {key: rod[key] for key in _KEYS if key in rod}
        key = json.dumps([described, self._lengths[name] if "taper" in rod else 0.0])
        if name in self._warmed and '"composite"' in key:
            raise InputError(
                Fault(
                    "place",
                    name,
                    "its temperature leaves stresses in its composite section that balance each other, not known here",
                    "give value in place of temperature to leave them out; section forces are in probe",
                )
            )
        if key not in self._alike:
            with self.meshes():
                self._alike[key] = RecordedRod.of(name, described, self._lengths[name])
        return self._alike[key]


@dataclass(frozen=True)
class RecordedRod:
    """Sections along a rod.

    Attributes:
        profile: the sections; material: of those that take one; held: strains that the rod holds.
        length: of the rod [m].
        corrected: whether its matrices count the reference curvature, which then is known at ``stations`` [m].
        bent: these curvatures [1/m].
    """

    profile: SectionProfile
    material: Material | None
    held: tuple[bool, ...]
    length: float
    corrected: bool = False
    stations: tuple[float, ...] = ()
    bent: tuple[tuple[float, float], ...] = ()

    @classmethod
    def of(cls, name: str, rod: Mapping[str, Any], length: float) -> RecordedRod:
        """Return the sections of a rod from its table in a case.

        Raises:
            InputError: no stress follows from them.
        """
        if rod.get("law"):
            raise InputError(
                Fault(
                    "place",
                    name,
                    "its sections have a law beside their stiffness, and how it is spread over them is not known",
                    "leave the law out for stresses; strains and section forces are in probe",
                )
            )
        if rod.get("tilt"):
            raise InputError(
                Fault(
                    "place",
                    name,
                    "its sections are oblique (tilt), and stresses are known in normal ones only",
                    "leave tilt out for stresses; strains and section forces are in probe",
                )
            )
        material = None if rod.get("material") is None else Material.model_validate(rod["material"])
        held = constrained_strains(tuple(rod.get("constraints") or ()))
        bent = tuple((float(first), float(second)) for first, second in rod.get("bent") or ())
        corrected = bool(rod.get("curvature_correction"))
        stations = tuple(rod.get("stations") or ())
        return cls(_profile(rod), material, held, length, corrected, stations, bent)

    def curvature(self, s: float, seen: Floats) -> Floats:
        """Return the reference curvatures ``(2,)`` [1/m] at an arc length: at Gauss points those that are kept.

        Args:
            s: arc length [m].
            seen: curvatures of the interpolated reference shape there ``(2,)``.
        """
        if self.bent:
            near = int(np.argmin(np.abs(np.array(self.stations) - s)))
            if abs(self.stations[near] - s) <= 1e-9 * self.length:
                return np.array(self.bent[near])
        return seen

    def at(self, s: float) -> SectionHere:
        """Return the section at an arc length [m]."""
        if isinstance(self.profile, Piecewise | Stations):
            section = self.profile.at(s)
        elif isinstance(self.profile, Taper):
            section = self.profile.at(min(max(s / self.length, 0.0), 1.0))
        elif isinstance(self.profile, AnySection):
            section = self.profile
        else:
            section = self.profile(s)
        material = self.material if section.needs_material else None
        return SectionHere(section, material, self.held, self.corrected)


def _profile(rod: Mapping[str, Any]) -> SectionProfile:
    if "sampled" in rod:  # a function of the arc length, at the Gauss points
        stations = np.asarray(rod["stations"], dtype=float)
        sections = [section_profile(one) for one in rod["sampled"]]

        def nearest(s: float) -> AnySection:
            section = sections[int(np.argmin(np.abs(stations - s)))]
            assert isinstance(section, AnySection)
            return section

        return nearest
    if isinstance(rod.get("sections"), Mapping):
        return Stations.model_validate(rod["sections"])
    if "sections" in rod:
        return Piecewise([(piece["until"], piece["section"]) for piece in rod["sections"]])
    if "taper" in rod:
        return Taper(rod["taper"]["start"], rod["taper"]["end"])
    return section_profile(rod["section"])
