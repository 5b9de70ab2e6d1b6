"""Rods for the picture: stations that go into the page, rings of the drawn surface, outlines of sections."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from viscorod.pictures.viewer.contours import contours_of
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.model.description.model_description import ModelDescription
    from viscorod.model.rod import Rod
    from viscorod.results.result import Result

__all__ = ["MOST_NODES", "Line", "Outline", "lines_of"]

Outline: TypeAlias = Literal["round", "box"]

MOST_NODES = 400
"""Stations of all rods in a page; with more, rods are taken at even arc lengths, by the elements' polynomials."""
MOST_RINGS = 900
"""Rings of the drawn surfaces of all rods."""
_FINE = 12  # rings from one station to the next at most
_FEWEST = 3  # stations of a rod that is taken at even arc lengths


@dataclass(frozen=True, eq=False)
class Line:
    """A rod in the page.

    Attributes:
        rod: its name.
        weights: of the result's stations in each node of the page ``(nodes, k)``; stations: which they are; None: the
            nodes are these stations.
        s: arc lengths of the nodes [m].
        ring_s: arc lengths of the rings ``(rings,)`` [m].
        ring_first: first of the neighbouring nodes that make a ring ``(rings,)``; ring_weights: theirs ``(rings, w)``.
        outline: of the section, "round" (an ellipse) or "box".
        halves: half width along d1 and half height along d2 at each ring ``(rings, 2)`` [m], 0 if unknown.
        holes: size of the hole at each ring as a part of the halves ``(rings,)``, 0 where there is none.
        contours: of polygons, drawn instead of the outline: of each region the outer one, then its holes, each
            ``(corners, 2)``, as parts of the halves; or none.
    """

    rod: str
    stations: Integers
    weights: Floats | None
    s: Floats
    ring_s: Floats
    ring_first: Integers
    ring_weights: Floats
    outline: Outline
    halves: Floats
    holes: Floats
    contours: list[list[Floats]]

    def nodes(self, values: Floats) -> Floats:
        """Return a field of the result's stations ``(n, stations, c)`` at the nodes ``(n, nodes, c)``."""
        mine = values[:, self.stations]
        if self.weights is None:
            return mine
        taken: Floats = np.einsum("ns,tsc->tnc", self.weights, mine)
        return taken


def lines_of(result: Result, model: ModelDescription | None) -> list[Line]:
    """Return all rods of a result; sections are those of the model, where it is known."""
    sites, data = result.sites, result.data
    arc = np.asarray(data["station_s"].values, dtype=float)
    order = np.asarray(data["station_order"].values, dtype=int)
    count = {rod: sites.stations(rod).size for rod in sites.rods}
    total = sum(count.values())
    lines = []
    for rod in sites.rods:
        stations = sites.stations(rod)
        known = arc[stations]
        mine = stations.size
        rings = max(mine, MOST_RINGS * mine // max(total, MOST_RINGS // 3))
        if total > MOST_NODES:
            mine = min(mine, max(_FEWEST, MOST_NODES * mine // total))
        if mine < stations.size:
            s = np.linspace(known[0], known[-1], mine)
            stations = np.unique(sites.weights(rod, s)[0])
            weights = _weights(result, rod, s, stations)
            ring_s, first, ring_weights = s, np.arange(mine), np.ones((mine, 1))
        else:
            s, weights = known, None
            parts = int(np.clip(rings // max(mine - 1, 1), 1, _FINE))
            u = np.linspace(0.0, mine - 1.0, parts * (mine - 1) + 1)
            ring_s = np.interp(u, np.arange(mine), known)
            first, ring_weights = _stencils(_weights(result, rod, ring_s, stations), int(order[stations[0]]))
        given = model.rods.get(rod) if model else None
        outline, halves, holes = _section(given, ring_s)
        contours = contours_of(given) if given else None
        if contours:
            reach = float(max(np.max(np.linalg.norm(outer, axis=1)) for outer, *_ in contours))
            halves = np.full((ring_s.size, 2), reach)
            contours = [[contour / reach for contour in region] for region in contours]
        if not halves.any():
            outline, halves = "round", _half_widths(data, rod, ring_s)
        lines.append(
            Line(
                rod, stations, weights, s, ring_s, first, ring_weights, outline, halves, holes, contours or []
            )
        )
    return lines


def _weights(result: Result, rod: str, s: Floats, stations: Integers) -> Floats:
    """Return weights of a rod's ``stations`` at arc lengths, by the elements' own polynomials ``(s, stations)``."""
    chosen, values = result.sites.weights(rod, s)
    by_number = np.argsort(stations)
    weights = np.zeros((s.size, stations.size))
    columns = by_number[np.searchsorted(stations, chosen, sorter=by_number)]
    weights[np.arange(s.size)[:, None], columns] = values
    return weights


def _stencils(weights: Floats, order: int) -> tuple[Integers, Floats]:
    """Return rows with at most ``order + 1`` neighbouring weights as first column and weights."""
    width = min(order + 1, weights.shape[1])
    first = np.minimum(np.argmax(weights != 0.0, axis=1), weights.shape[1] - width)
    return first, np.take_along_axis(weights, first[:, None] + np.arange(width), axis=1)


def _half_widths(data: xr.Dataset, rod: str, s: Floats) -> Floats:
    """Return half widths of a rod as stored with the Gauss points, (rings, 2) [m]."""
    if "half_width" not in data:
        return np.zeros((s.size, 2))
    mine = np.asarray(data["point_rod"].values, dtype=str) == rod
    widths = np.asarray(data["half_width"].values, dtype=float)[mine]
    at = np.asarray(data["point_s"].values, dtype=float)[mine]
    if not widths.size:
        return np.zeros((s.size, 2))
    sorted_ = np.argsort(at)
    return np.repeat(np.interp(s, at[sorted_], widths[sorted_])[:, None], 2, axis=1)


def _section(rod: Rod | None, s: Floats) -> tuple[Outline, Floats, Floats]:
    """Return outline, half widths and holes of the sections at arc lengths; zeros if neither ellipse nor box."""
    halves, holes = np.zeros((s.size, 2)), np.zeros(s.size)
    if rod is None:
        return "round", halves, holes
    round_ = False
    for k, x in enumerate(s):
        extent = rod.section_at(float(np.clip(x, 0.0, rod.length))).extent
        if extent is None:
            return "round", np.zeros((s.size, 2)), np.zeros(s.size)
        halves[k], holes[k] = extent.halves, extent.hole[0] / extent.halves[0] if extent.hole else 0.0
        round_ |= extent.round
    return ("round" if round_ else "box"), halves, holes
