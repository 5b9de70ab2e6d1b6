"""The meshes of the sections of a model, which neighbours of it keep."""

from __future__ import annotations

from collections.abc import Iterator

from viscorod.analyses.discrete import DiscreteModel
from viscorod.model.rod import Rod
from viscorod.model.sections.kept_meshes import KeptMesh
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_profile import Piecewise
from viscorod.model.sections.section_stations import Stations

__all__ = ["section_meshes"]


def section_meshes(discrete: DiscreteModel) -> tuple[KeptMesh, ...]:
    """Return what the meshes of all sections of a model are made of, each once; of functions those at Gauss points."""
    found: dict[KeptMesh, None] = {}
    for number, rod in enumerate(discrete.model.rods.values()):
        for section in _sections(rod, number, discrete):
            mesh = section.mesh(rod.material if section.needs_material else None)
            if mesh is not None:
                found[mesh] = None
    return tuple(found)


def _sections(rod: Rod, number: int, discrete: DiscreteModel) -> Iterator[AnySection]:
    """Yield the sections of a rod of which others may have been made."""
    section = rod.section
    if isinstance(section, AnySection):
        yield section
    elif isinstance(section, Piecewise):
        yield from (piece.section for piece in section.pieces)
    elif isinstance(section, Stations):
        yield from (station.section for station in section.given)
    elif callable(section) and not rod.section_at(0.0).can_taper:
        gauss = discrete.system.gauss_positions()
        yield from (rod.section_at(float(s)) for s in gauss.s[gauss.rod == number])
