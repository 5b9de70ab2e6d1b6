"""Stress, strain and loss at any point of a section, any place of a rod and any time; see ``Result.stress``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.between_records import Instants
from viscorod.results.element_points import Stencil
from viscorod.results.probe import PartsRead
from viscorod.results.reference_shape import reference_curvature
from viscorod.results.result_places import ResultPlace
from viscorod.solve.stress.section_rings import section_rings
from viscorod.solve.stress.section_stress import ForceParts, SectionStress, von_mises
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.result import Result

__all__ = ["STRESSES", "RodStress", "StressPatch", "section_at", "section_patch", "stress_at"]

STRESSES = ("11", "22", "33", "23", "13", "12")
"""Components of stress and strain along d1, d2 and d3."""
MOST_SECTIONS = 256
"""Sections that are kept at most: each has the stresses of unit forces at some thousand points."""
STRAIGHT = 1e-7
"""Half width times curvature of the reference shape below which a rod counts as straight."""


class RodStress:
    """The sections of one rod of a result.

    Args:
        result: that holds the rod; rod: its name.

    Raises:
        InputError: no stress follows from its sections.
    """

    def __init__(self, result: Result, rod: str) -> None:
        self._result, self.rod = result, rod
        self._sections = result.recorded_rods.rod(rod)
        self._known = result.recorded_rods.known
        self.moving = result.kind == "simulate" or result.stored.attrs.get("damping") == "linearised"

    def at(self, s: float, curvature: Floats) -> SectionStress:
        """Return the section at an arc length [m] where the reference shape has this curvature ``(3,)`` [1/m]."""
        here, curvature = self._sections.at(s), self._sections.curvature(s, curvature[:2])
        half = here.section.half_width
        if half is not None and half * np.linalg.norm(curvature) < STRAIGHT:
            curvature = np.zeros(2)
        digits = 0 if not curvature.any() else 9 - int(np.floor(np.log10(np.linalg.norm(curvature))))
        key = here, tuple(np.round(curvature, digits).tolist())
        if key not in self._known:
            if len(self._known) >= MOST_SECTIONS:  # sections that vary along the rod
                self._known.clear()
            try:
                with self._result.recorded_rods.meshes():
                    self._known[key] = SectionStress(here, curvature)
            except InputError as error:
                raise InputError(problem.within(self.rod) for problem in error.problems) from None
        section: SectionStress = self._known[key]
        return section

    def rings(self, s: float) -> list[Floats]:
        """Return points ``(n, 2)`` [m] on the outline and the holes of the section at an arc length [m]."""
        return section_rings(self._sections.at(s).section)

    def parts(
        self, sections: Sequence[SectionStress], strain: Floats, force: Floats, springs: Floats | None
    ) -> ForceParts:
        """Return the parts of section forces ``(t, k, ...)`` at ``k`` Gauss points.

        Args:
            sections: of the Gauss points; strain, force: ``(t, k, 6)``.
            springs: strains of the springs of all branches of the result ``(t, k, n, 6)``; None without any.
        """
        found = []
        for k, section in enumerate(sections):
            own = None if springs is None else springs[:, k, self.branches_of(section)]
            found.append(section.parts(strain[:, k], force[:, k], own, moving=self.moving))
        names = vars(found[0])
        return ForceParts(*(np.stack([getattr(part, name) for part in found], axis=1) for name in names))

    def branches_of(self, section: SectionStress) -> Integers:
        """Return which of the branches of the result are those of a section."""
        if not len(section.times):
            return np.zeros(0, dtype=np.int64)
        known = np.asarray(self._result.stored["relaxation_time"].values, dtype=float)
        return np.array([int(np.argmin(np.abs(known - time))) for time in section.times])


def stress_at(
    result: Result, place: str | int, points: Any = None, instants: Instants | None = None
) -> xr.Dataset:
    """Return stress, strain and loss at points of the section at a place; see ``Result.stress``."""
    import xarray as xr

    site = _site(result, place)
    section, parts = section_at(result, RodStress(result, site.rod), site, instants)
    field = section.field
    samples = field.rule if points is None else field.at(_points(points))
    found = section.fields(samples, parts)
    ratio = np.array([m.poissons_ratio for m in field.materials])[samples.region]
    along = result.dimension
    level = np.asarray(result.stored[along].values, dtype=float) if instants is None else instants.time
    strain = _tensor(0.5 * found.strain[..., :2], found.strain[..., 2])
    strain[..., :2] = -(ratio * found.strain[..., 2])[..., None]
    dims = (along, "point")
    about = {
        "stress": ("Pa", "stress, elastic and viscous together, along d1, d2, d3", _full(found.stress)),
        "viscous_stress": ("Pa", "viscous part of the stress", _full(found.viscous)),
        "strain": ("1", "strain of the elastic part, components of the tensor", strain),
        "von_mises": ("Pa", "von Mises stress", von_mises(found.stress)),
    }
    if result.kind == "simulate" and not parts.unknown.any():
        about["loss_density"] = ("W/m^3", "power lost to viscosity per volume", found.loss)
    variables: dict[str, Any] = {
        name: ((*dims, *(("stress_component",) if values.ndim == 3 else ())), values, _units(unit, text))
        for name, (unit, text, values) in about.items()
    }
    weight = (
        {} if points is not None else {"area": ("point", field.weight, _units("m^2", "area of the point"))}
    )
    curved = samples.curved(section.curvature)
    return xr.Dataset(
        variables,
        {
            along: (along, level, dict(result.data[along].attrs)),
            "stress_component": list(STRESSES),
            "x1": ("point", samples.points[:, 0], _units("m", "along d1 from the centre line")),
            "x2": ("point", samples.points[:, 1], _units("m", "along d2 from the centre line")),
            "region": ("point", samples.region, _units("1", "number of the region of a composite")),
            "volume_factor": ("point", curved, _units("1", "J0: volume over area and arc length")),
            **weight,
        },
        {"place": site.label, "rod": site.rod, "s": site.s},
    )


@dataclass(frozen=True)
class StressPatch:
    """Stresses over a section in triangles.

    Attributes:
        place: in words; level: time [s], load factor or spin.
        points: corners ``(n, 2)`` [m]; triangles: their numbers ``(m, 3)``.
        stress: s31, s32, s33 ``(n, 3)`` [Pa].
    """

    place: str
    level: float
    points: Floats
    triangles: Integers
    stress: Floats

    @property
    def von_mises(self) -> Floats:
        """Von Mises stress ``(n,)`` [Pa]."""
        return von_mises(self.stress)


def section_patch(result: Result, place: str | int, time: float | None = None) -> StressPatch:
    """Return the stresses over the section at a place, at a time of a run or in its worst or the last state.

    Raises:
        InputError: as of :func:`stress_at`, or a time of what is no run.
    """
    site = _site(result, place)
    instants = None
    if time is not None:
        if result.kind != "simulate":
            raise InputError(f"time = {time!r}: only a run has times; leave it out for the last state")
        known = np.asarray(result.data["time"].values, dtype=float)
        instants = Instants.of(known, np.array([time]), getattr(result, "step_ends", None))
    section, parts = section_at(result, RodStress(result, site.rod), site, instants)
    patch = section.field.patch
    state = 0 if instants is not None else -1
    if result.kind == "simulate" and instants is None:
        largest, state = -1.0, 0
        for k in np.argsort(-(bound := section.bound(parts))):
            if bound[k] <= largest:
                break
            size = float(von_mises(section.fields(patch.samples, parts.at(np.array([k]))).stress).max())
            largest, state = (size, int(k)) if size > largest else (largest, state)
    level = result.data[result.dimension].values[state] if time is None else time
    chosen = parts.at(np.array([state]))
    stress = section.fields(patch.samples, chosen).stress[0]
    return StressPatch(site.label, float(level), patch.samples.points, patch.triangles, stress)


def section_at(
    result: Result, rod: RodStress, site: ResultPlace, instants: Instants | None
) -> tuple[SectionStress, ForceParts]:
    """Return the section at a place, and the parts of its forces in all states or at the instants."""
    data, read = result.data, PartsRead(result, instants)
    stencil = Stencil.of(data, result.sites, [site])
    group = stencil.groups[0]
    if not group.gauss.size or not read.has("section_force"):
        raise InputError("this result holds no section forces, from which stresses follow")
    nodes = stencil.stations[group.nodes[0]]
    s = np.asarray(data["station_s"].values, dtype=float)[nodes]
    rotation = np.asarray(data["reference_rotation"].values, dtype=float)[nodes]
    points = stencil.points[group.gauss[0]]
    places = np.asarray(data["point_s"].values, dtype=float)[points]
    curvature = reference_curvature(s, rotation, np.append(places, site.s))
    sections = [rod.at(float(x), bent) for x, bent in zip(places, curvature, strict=False)]
    strain, force = (read.at(name, "point", points) for name in ("strain", "section_force"))
    springs = read.at("branch_strain", "point", points) if read.has("branch_strain") else None
    mixed = rod.parts(sections, strain, force, springs).mixed(group.weights[0])
    if instants is not None:
        mixed = ForceParts(*(instants.fields(part) for part in vars(mixed).values()))
    return rod.at(site.s, curvature[-1]), mixed


def _site(result: Result, place: str | int) -> ResultPlace:
    site = result.sites.at(place)
    if site.rod in result.sites.bodies:
        raise InputError(
            f"{site.label!r} is a place on a rigid body, which has no stresses; give a place on a rod"
        )
    return site


def _points(points: Any) -> Floats:
    try:
        found = np.asarray(points, dtype=float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape == (2,):
        found = found[None]
    if found.ndim != 2 or found.shape[1] != 2 or not found.size or not np.isfinite(found).all():
        raise InputError(
            "points: give one point [along d1, along d2] of the section about the centre line in m, or a list of them"
        )
    return found


def _tensor(across: Floats, along: Floats) -> Floats:
    """Return components 11, 22, 33, 23, 13, 12 ``(..., 6)`` of 31, 32 ``(..., 2)`` and 33."""
    zero = np.zeros_like(along)
    return np.stack([zero, zero, along, across[..., 1], across[..., 0], zero], axis=-1)


def _full(stress: Floats) -> Floats:
    return _tensor(stress[..., :2], stress[..., 2])


def _units(unit: str, text: str) -> dict[str, str]:
    return {"units": unit, "long_name": text}
