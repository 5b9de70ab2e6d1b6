"""Fields that rods can be coloured by: strains, section forces and losses at Gauss points, speed at stations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.largest_stress import peak_stresses
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.pictures.viewer.frames import Frames
    from viscorod.pictures.viewer.rod_lines import Line
    from viscorod.results.result import Result

__all__ = ["FieldPoints", "fields_of", "points_of", "speed_of"]

_STRAIN = ("shear 1", "shear 2", "stretch", "bend 1", "bend 2", "twist")
_ROUND_OFF = 1e-9
MOST_STRESSES = 200_000
"""Gauss points times frames up to which a page shows stresses, which take a second or two then."""
_FORCE = ("shear force 1", "shear force 2", "axial force", "moment 1", "moment 2", "torque")


@dataclass(frozen=True, eq=False)
class FieldPoints:
    """Gauss points of a page.

    Attributes:
        lower, upper: the stored points from which each is interpolated ``(points,)``; part: of the upper one.
        s: arc lengths [m].
        line: number of the rod of each.
    """

    lower: Integers
    upper: Integers
    part: Floats
    s: Floats
    line: Integers

    def of(self, values: Floats) -> Floats:
        """Return a field ``(n, stored points)`` at the points of the page."""
        if not self.part.any():
            alone: Floats = values[:, self.lower]
            return alone
        between: Floats = (1.0 - self.part) * values[:, self.lower] + self.part * values[:, self.upper]
        return between


def points_of(result: Result, lines: list[Line], most: int) -> FieldPoints | None:
    """Return Gauss points of all rods, at even arc lengths if there are more than `most`; None if none are stored."""
    if "point_rod" not in result.data.coords or not result.data.sizes.get("point", 0):
        return None
    rods = np.asarray(result.data["point_rod"].values, dtype=str)
    arc = np.asarray(result.data["point_s"].values, dtype=float)
    columns: list[tuple[Integers, Integers, Floats, Floats, Integers]] = []
    for number, line in enumerate(lines):
        mine = np.flatnonzero(rods == line.rod)
        mine = mine[np.argsort(arc[mine], kind="stable")]
        if not mine.size:
            continue
        known = arc[mine]
        count = known.size if rods.size <= most else min(known.size, max(2, most * known.size // rods.size))
        s = known if count == known.size else np.linspace(known[0], known[-1], count)
        k = np.clip(np.searchsorted(known, s, side="right") - 1, 0, max(known.size - 2, 0))
        after = np.minimum(k + 1, known.size - 1)
        gap = np.where(known[after] > known[k], known[after] - known[k], 1.0)
        part = np.clip((s - known[k]) / gap, 0.0, 1.0)
        if count == known.size:
            k, after, part = np.arange(count), np.arange(count), np.zeros(count)
        columns.append((mine[k], mine[after], part, s, np.full(count, number, dtype=np.int64)))
    if not columns:
        return None
    lower, upper, part, s, line_of = (np.concatenate(column) for column in zip(*columns, strict=True))
    return FieldPoints(lower, upper, part, s, line_of)


def fields_of(result: Result, frames: Frames, points: FieldPoints) -> list[tuple[dict[str, object], Floats]]:
    """Return what is stored at Gauss points: name, title, unit, scale and values ``(n, points)`` in SI."""
    found: list[tuple[dict[str, object], Floats]] = []

    def add(key: str, title: str, unit: str, values: Floats, prefix: bool = True) -> None:
        shown = points.of(values)
        factor, word = scaled(unit, shown) if prefix else (1.0, unit)
        found.append(({"key": key, "title": title, "unit": word, "scale": factor}, shown))

    data = result.data
    if "strain" in data:
        strain = _without_round_off(frames.linear("strain"))
        for k, title in enumerate(_STRAIN):
            add(f"strain{k}", title, "1" if k < 3 else "1/m", strain[..., k], prefix=False)
    if "section_force" in data:
        force = _without_round_off(frames.linear("section_force"))
        for k, title in enumerate(_FORCE):
            add(f"force{k}", title, "N" if k < 3 else "N m", force[..., k])
    if "section_force" in data and data.sizes["point"] * frames.count <= MOST_STRESSES:
        springs = frames.linear("branch_strain") if "branch_strain" in data else None
        peaks = peak_stresses(result, strain, force, springs)
        if peaks is not None:
            add("mises", "von Mises stress, largest in the section", "Pa", peaks)
    if "dissipation" in data:
        add("dissipation", "dissipation density", "W/m", frames.linear("dissipation"))
    return found


def _without_round_off(values: Floats) -> Floats:
    """Return strains or forces ``(n, points, 6)``; components that stay far below the others of their unit are zero."""
    largest = np.abs(values).max(axis=(0, 1), initial=0.0)
    size = np.repeat([largest[:3].max(), largest[3:].max()], 3)
    shown: Floats = np.where(largest < _ROUND_OFF * size, 0.0, values)
    return shown


def speed_of(result: Result, frames: Frames, lines: list[Line]) -> Floats | None:
    """Return the speed at the nodes of the page ``(n, nodes)`` [m/s]."""
    if "velocity" not in result.data or result.dimension != "time":
        return None
    velocity = frames.linear("velocity")
    nodes = np.concatenate([line.nodes(velocity) for line in lines], axis=1)
    speed: Floats = np.linalg.norm(nodes, axis=-1)
    return speed
