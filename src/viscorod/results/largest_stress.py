"""The largest von Mises stress of a result, over all states, at the Gauss points and the ends of the rods.

In every section a bound of the stress follows from the section force alone. Sections are looked at in the order of
their bounds until no bound is above what was found.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.array_pieces import blocks
from viscorod.results.reference_shape import reference_curvatures
from viscorod.results.result_places import by_name, lagrange_weights
from viscorod.results.stress import RodStress
from viscorod.solve.stress.section_stress import SectionStress, von_mises
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["LargestStress", "largest_stress", "peak_stresses"]

AT_ONCE = 32
"""States of a section whose stresses are computed together."""
ALIKE = 1e-9
"""Part by which stresses on both sides of a symmetric section differ by round-off."""


@dataclass(frozen=True)
class LargestStress:
    """The largest von Mises stress.

    Attributes:
        value: [Pa]; rod: in which; s: where [m]; point: of its section ``(2,)`` [m].
        state: number of the stored state; level: its time [s], load factor or spin.
        missing: rods that are not known in three dimensions: sections given by numbers, or with a law.
    """

    value: float
    rod: str
    s: float
    point: tuple[float, float]
    state: int
    level: float
    missing: tuple[str, ...]


def peak_stresses(result: Result, strain: Floats, force: Floats, springs: Floats | None) -> Floats | None:
    """Return the largest von Mises stress in the section at all Gauss points ``(n, m)`` [Pa], to about a percent.

    Args:
        result: whose sections these are.
        strain, force: at the Gauss points ``(n, m, 6)``.
        springs: strains of the branches' springs ``(n, m, branches, 6)``, None where there are none.

    Returns:
        None where the section of a rod is not known in three dimensions.
    """
    missing: list[str] = []
    places = [some for some in _places(result, missing) if some.points.shape[1] == 1]
    if missing:
        return None
    found = np.zeros(strain.shape[:2])
    for some in places:
        section = some.section
        own = None
        if springs is not None and len(section.times):
            own = some.read(springs)[:, some.stress.branches_of(section)]
        parts = section.parts(some.read(strain), some.read(force), own, moving=some.stress.moving)
        found[:, some.points[:, 0]] = section.peaks(parts).reshape(len(strain), -1)
    return found


@dataclass(frozen=True)
class _Places:
    """Places with one section: on which rods, arc lengths ``(k,)`` [m], and Gauss points with weights ``(k, p)``."""

    section: SectionStress
    stress: RodStress
    rods: tuple[str, ...]
    s: Floats
    points: Integers
    weights: Floats

    def read(self, field: Floats) -> Floats:
        """Return a field of the Gauss points ``(t, m, ...)`` at the places ``(t k, ...)``."""
        found: Floats = np.einsum("kp,tkp...->tk...", self.weights, field[:, self.points])
        return found.reshape(-1, *found.shape[2:])


def largest_stress(result: Result) -> LargestStress | None:
    """Return the largest von Mises stress of all rods whose sections have a shape; None where none has."""
    if "section_force" not in result.stored:
        return None
    missing: list[str] = []
    places = list(_places(result, missing))
    best: LargestStress | None = None
    first = 0
    for strain, force in zip(blocks(result, "strain"), blocks(result, "section_force"), strict=True):
        for some in places:
            best = _larger(best, some, strain, force, result, first)
        first += len(strain)
    return None if best is None else replace(best, missing=tuple(missing))


def _larger(
    best: LargestStress | None, places: _Places, strain: Floats, force: Floats, result: Result, first: int
) -> LargestStress | None:
    """Return the largest stress at some places in states from number ``first`` on, or the ``best`` so far."""
    section, along = places.section, result.dimension
    springs = None
    if len(section.times) and "branch_strain" in result.stored:
        kept = result.stored["branch_strain"].isel({along: slice(first, first + len(strain))}).values
        springs = places.read(np.asarray(kept, dtype=float))[:, places.stress.branches_of(section)]
    parts = section.parts(places.read(strain), places.read(force), springs, moving=places.stress.moving)
    bound = section.bound(parts)
    order = np.argsort(-bound)
    samples = section.field.patch.samples
    for begin in range(0, len(order), AT_ONCE):
        chosen = order[begin : begin + AT_ONCE]
        if best is not None and bound[chosen[0]] <= best.value:
            break
        size = von_mises(section.fields(samples, parts.at(chosen)).stress)
        row = int(np.argmax(size.max(axis=1)))
        n = _uppermost(samples.points, size[row])
        if best is None or size[row, n] > best.value:
            state, k = divmod(int(chosen[row]), len(places.s))
            x, y = samples.points[n].tolist()
            level = float(result.stored[along].values[first + state])
            value, s = float(size[row, n]), float(places.s[k])
            best = LargestStress(value, places.rods[k], s, (x, y), first + state, level, ())
    return best


def _uppermost(points: Floats, size: Floats) -> int:
    """Return the number of the point of the largest stress; of points that mirror each other, that farthest along d2.

    Otherwise round-off, and so the processor, would choose.
    """
    alike = np.flatnonzero(size >= (1.0 - ALIKE) * size.max())
    return int(alike[np.lexsort(points[alike].T)[-1]])


def _places(result: Result, missing: list[str]) -> Iterator[_Places]:
    """Yield all Gauss points and ends of rods, by section; rods whose sections have none go to ``missing``."""
    data = result.stored
    points_of = by_name(np.asarray(data["point_rod"].values, dtype=str))
    s = np.asarray(data["point_s"].values, dtype=float)
    curvature = reference_curvatures(result)
    order = np.asarray(data["station_order"].values)
    found: dict[tuple[int, int], list[tuple[SectionStress, RodStress, str, float, Integers, Floats]]] = {}
    for rod in result.sites.rods:
        try:
            stress = RodStress(result, rod)
            mine = points_of[rod]
            sections = [stress.at(float(s[k]), curvature[k]) for k in mine]
        except InputError:
            missing.append(rod)
            continue
        p = int(order[result.sites.stations(rod)[0]])
        ends = [
            (site.s, inside)
            for site, inside in zip(result.sites.ends(rod), (mine[:p], mine[-p:]), strict=True)
        ]
        rows: list[tuple[SectionStress, float, Integers, Floats]] = [
            (section, float(s[k]), np.array([k]), np.ones(1))
            for section, k in zip(sections, mine, strict=True)
        ]
        rows += [
            (
                stress.at(at, curvature[inside[0 if at == ends[0][0] else -1]]),
                at,
                inside,
                lagrange_weights(s[inside], at),
            )
            for at, inside in ends
        ]
        for section, at, inside, weights in rows:
            key = id(section), len(inside)
            found.setdefault(key, []).append((section, stress, rod, at, inside, weights))
    for group in found.values():
        section, stress = group[0][:2]
        columns: Any = list(zip(*(row[2:] for row in group), strict=True))
        yield _Places(section, stress, columns[0], *(np.array(column) for column in columns[1:]))
