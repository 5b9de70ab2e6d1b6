"""What follows from the sections along a rod: its mass, where they have kinks, what is assumed of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from viscorod.model.cable import GYRATION, SLACK
from viscorod.model.sections.section_kinks import SAMPLES as MANY_SAMPLES
from viscorod.model.sections.section_kinks import kinks
from viscorod.model.sections.section_profile import Piecewise
from viscorod.model.sections.section_stations import Stations
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.materials.material import Material
    from viscorod.model.rod import Rod

__all__ = ["assumptions_of", "doubts_of", "kinks_of", "mass_of"]

END = 1e-9
"""How far from the end of a rod, as a part of its length, what is there counts as the end."""
FEW_SAMPLES = 32
"""Intervals in which kinks of sections are sought that need a mesh of their own at every station."""


def mass_of(rod: Rod) -> float:
    """Return the mass of a rod whose sections have inertia [kg]."""
    if rod.uniform:
        return rod.length * float(rod.matrices_at(0.0)[2][0, 0])
    points, weights = np.polynomial.legendre.leggauss(1 if isinstance(rod.section, Piecewise) else 16)
    ends = np.array([0.0, *sorted({*rod.section_breaks, *rod.kinks}), rod.length])
    middles, halves = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    return float(
        sum(
            half * weight * rod.matrices_at(middle + half * point)[2][0, 0]
            for middle, half in zip(middles, halves, strict=True)
            for point, weight in zip(points, weights, strict=True)
        )
    )


def kinks_of(rod: Rod) -> tuple[float, ...]:
    """Return the interior stations where section or twist of a rod have a kink or jump, see ``Rod.kinks`` [m]."""
    found: list[float] = []
    if isinstance(rod.section, Stations):
        found += [station.at for station in rod.section.given]
    elif callable(rod.section):
        known = getattr(rod.section, "stations", None)
        costly = not rod.section_at(0.0).can_taper
        samples = FEW_SAMPLES if costly else MANY_SAMPLES
        found += (
            kinks(lambda s: _section_values(rod, s), rod.length, samples) if known is None else list(known)
        )
    twist = rod.turn
    if callable(twist):
        known = getattr(twist, "stations", None)
        found += kinks(lambda s: np.array([twist(s)]), rod.length) if known is None else list(known)
    inner = {s for s in found if 0.0 < s < rod.length * (1.0 - END)} - {*rod.section_breaks}
    return tuple(sorted(inner))


def _section_values(rod: Rod, s: float) -> Floats:
    """Return stiffness and inertia of the section at the arc length `s` as one array (72,)."""
    section = rod.section_at(s)
    material = rod.material if section.needs_material else None
    if material is not None and material.pending:
        material = material.with_damping(None)
    stiffness, _, inertia = section.matrices(material)
    return np.concatenate([stiffness.ravel(), inertia.ravel()])


def assumptions_of(rod: Rod) -> list[str]:
    """Return what is assumed of sections and material of a rod, one sentence each."""
    found = list(dict.fromkeys(text for material in _materials(rod) for text in material.assumptions))
    if rod.law is not None:
        found.append(
            f"its sections have the law {type(rod.law).__name__}, which times and moduli of the damping leave out"
        )
    if rod.is_cable:
        found.append(
            f"a cable, which bends and twists at no cost: {SLACK:g} of its axial stiffness times length squared "
            f"gives its sections a direction, {GYRATION**2:g} one about its axis, and their radius of gyration is "
            f"{GYRATION:g} of its length"
        )
    return found


def doubts_of(rod: Rod) -> list[str]:
    """Return how the damping of a rod differs from the data that it stands for, if by much."""
    return list(dict.fromkeys(text for material in _materials(rod) for text in material.doubts))


def _materials(rod: Rod) -> Iterator[Material]:
    if rod.material is not None:
        yield rod.material
    for s in (0.0, *rod.section_breaks):
        yield from rod.section_at(s).materials
