"""Surfaces of rods with their true sections, and the stresses on them, for ParaView."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.results.between_records import Instants
from viscorod.results.result_places import ResultPlace
from viscorod.results.stress import RodStress, section_at
from viscorod.solve.stress.section_stress import von_mises
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["Surfaces"]


@dataclass(frozen=True)
class _Ring:
    """A closed line on the surface of a rod: number of its place, points of the section ``(n, 2)`` [m], its first."""

    place: int
    points: Floats
    first: int


class Surfaces:
    """The surfaces of all rods whose sections have a shape.

    Args:
        result: that holds the rods; sites: places along them, rod by rod.

    Attributes:
        quads: corners of all faces ``(m, 4)``; rod: number of the rod of every point ``(n,)``.
    """

    def __init__(self, result: Result, sites: list[ResultPlace]) -> None:
        self._result, self._sites = result, sites
        self._rings: list[_Ring] = []
        self._stress: dict[str, RodStress] = {}
        quads: list[Integers] = []
        rods: list[int] = []
        names = list(result.sites.rods)
        before: dict[tuple[str, int], _Ring] = {}
        count = 0
        for number, site in enumerate(sites):
            try:
                stress = self._stress.setdefault(site.rod, RodStress(result, site.rod))
                stress.at(site.s, np.zeros(3))
            except InputError:
                continue
            for k, points in enumerate(stress.rings(site.s)):
                old = before.get((site.rod, k))
                if old is not None and len(old.points) == len(points):
                    quads.append(_between(old.first, count, len(points)))
                before[site.rod, k] = _Ring(number, points, count)
                self._rings.append(before[site.rod, k])
                rods += [names.index(site.rod)] * len(points)
                count += len(points)
        self.quads: Integers = np.concatenate(quads) if quads else np.zeros((0, 4), dtype=np.int64)
        self.rod = np.array(rods, dtype=np.int64)

    def fields(self, position: Floats, frame: Floats, instants: Instants | None) -> dict[str, Floats]:
        """Return positions ``(t, n, 3)`` [m], axial and von Mises stress [Pa] ``(t, n)`` of all points.

        Args:
            position, frame: of the sites ``(t, sites, 3)`` and ``(t, sites, 3, 3)``; instants: of a run, None for all
                stored states.
        """
        columns: list[tuple[Floats, Floats, Floats]] = []
        for number, rings in groupby(self._rings, key=lambda ring: ring.place):
            site = self._sites[number]
            section, parts = section_at(self._result, self._stress[site.rod], site, instants)
            for ring in rings:
                stress = section.fields(section.field.at(ring.points), parts).stress
                across = np.einsum("tij,nj->tni", frame[:, number, :, :2], ring.points)
                columns.append((position[:, number, None] + across, stress[..., 2], von_mises(stress)))
        names = ("position", "stress_33", "von_mises")
        return {
            name: np.concatenate(values, axis=1)
            for name, values in zip(names, zip(*columns, strict=True), strict=True)
        }


def _between(first: int, second: int, count: int) -> Integers:
    """Return the faces between two rings of ``count`` points that begin at ``first`` and ``second``."""
    here = np.arange(count)
    after = (here + 1) % count
    return np.stack([first + here, first + after, second + after, second + here], axis=-1)
