"""Triangles over a cross section, by the mesher of the library sectionproperties (J. R. Shewchuk's Triangle)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.sections.polygons import Polygon, library
from viscorod.quantity_text import per_cent
from viscorod.typing import Floats, Integers

__all__ = ["Joined", "SectionMesh", "first_size", "joined", "refuse_misfits", "triangulate"]

SNAP = 1e-7
"""Corners and edges closer than this fraction of the section's size are one: regions meet in spite of round-off."""
MOST_TRIANGLES = 50_000
SMALLEST_ANGLE = 30.0


@dataclass(frozen=True)
class SectionMesh:
    """Six-noded triangles with straight sides.

    Attributes:
        points: nodes (n, 2), m.
        triangles: nodes (m, 6) of every triangle: corners 1, 2, 3, then the middles of 12, 23, 31.
        region: index (m,) of the region of every triangle.
    """

    points: Floats
    triangles: Integers
    region: Integers


@lru_cache(maxsize=64)
def refuse_misfits(polygons: tuple[Polygon, ...]) -> None:
    """Refuse regions that overlap, that do not make one connected section, or that are too thin to mesh.

    Raises:
        RefusedError: which regions are wrong.
    """
    shapely, _ = library()
    met = joined(polygons)
    shapes = [_shape(shapely, rings, met.corners) for rings in met.rings]
    for index, shape in enumerate(shapes):
        if shape is None or not shape.is_valid or shape.area < SNAP**2:
            raise RefusedError(
                f"the region is thinner somewhere than {SNAP:g} of the section's size",
                "make it thicker there, or leave it out",
                found="",
                at=(index,),
            )
        for other in range(index):
            common = shape.intersection(shapes[other]).area
            if common > 1e-9 * min(shape.area, shapes[other].area):
                share = common / shape.area
                raise RefusedError(
                    f"the region overlaps region {other + 1} with {per_cent(100.0 * share, 3)} of its area",
                    "give every place to one region: give the outer one a hole, or move one of them",
                    found="",
                    at=(index,),
                )
    whole = shapely.unary_union(shapes)
    if whole.geom_type != "Polygon":
        raise RefusedError(
            f"the regions are {len(whole.geoms)} separate parts: they do not all join along edges",
            "move them together until they share edges",
            found=f"{len(shapes)} regions",
        )
    expected = sum(_expected_triangles(shape) for shape in shapes)
    if expected > MOST_TRIANGLES:
        raise RefusedError(
            f"the section is too thin somewhere: it would take about {expected:.0e} triangles",
            "make the thin places thicker, or give the section's numbers with shape = 'given' or 'stiffness'",
            found="",
        )


def _expected_triangles(shape: Any) -> float:
    """Return the number of well-shaped triangles that the thin places of a region of size 1 need.

    Places thinner than 2 d are those that an opening by d (shrink, then grow) leaves out; their triangles have an
    area of about d^2. Their number is summed over halved d until nothing is left out.
    """
    expected, d, style = 0.0, 0.25, {"join_style": "mitre", "mitre_limit": 20.0}
    while d > SNAP / 4.0:
        thin = shape.area - shape.buffer(-d, **style).buffer(d, **style).intersection(shape).area
        if thin < 1e-13 * shape.area:
            break
        expected += thin / d**2
        d /= 2.0
    return expected


def first_size(polygons: tuple[Polygon, ...]) -> float:
    """Return the triangle side of a first mesh, m: half of 2 A/perimeter, at most a tenth of the root of A."""
    shapely, _ = library()
    met = joined(polygons)
    shapes, size = [_shape(shapely, rings, met.corners) for rings in met.rings], met.size
    area = sum(shape.area for shape in shapes)
    thickness = min(2.0 * shape.area / shape.length for shape in shapes)
    return float(size * max(min(0.5 * thickness, 0.1 * math.sqrt(area)), math.sqrt(2.0 * area / 20_000)))


def triangulate(polygons: tuple[Polygon, ...], side: float) -> SectionMesh:
    """Mesh regions that passed `refuse_misfits`.

    Args:
        polygons: of the regions, m.
        side: longest side of an equilateral triangle as large as the largest one, m.

    Raises:
        RefusedError: it would take too many triangles.
    """
    shapely, pre = library()
    met = joined(polygons)
    shapes, size = [_shape(shapely, rings, met.corners) for rings in met.rings], met.size
    largest = math.sqrt(3.0) / 4.0 * (side / size) ** 2
    area = sum(shape.area for shape in shapes)
    if not largest > 0.0 or area / largest > MOST_TRIANGLES:
        least = size * math.sqrt(4.0 / math.sqrt(3.0) * area / MOST_TRIANGLES)
        raise RefusedError(
            f"triangles of this size would be more than {MOST_TRIANGLES}",
            f"give a number above {least:.3g}, or leave mesh_size out",
            found=show(side),
            at=("mesh_size",),
        )
    facets = sorted(met.edges)
    holes = [shapely.Polygon(ring) for ring in shapely.unary_union(shapes).interiors]
    found = pre.create_mesh(
        points=met.corners.tolist(),
        facets=facets,
        holes=[hole.representative_point().coords[0] for hole in holes],
        control_points=[shape.representative_point().coords[0] for shape in shapes],
        mesh_sizes=[largest] * len(shapes),
        min_angle=SMALLEST_ANGLE,
        coarse=False,
    )
    triangles = np.array(found["triangles"], dtype=np.int64)[:, [0, 1, 2, 5, 3, 4]]
    region = np.array(found["triangle_attributes"], dtype=float).reshape(len(triangles), -1)[:, 0]
    points = np.array(found["vertices"], dtype=float) * size + met.middle
    return SectionMesh(points, triangles, region.astype(np.int64))


@dataclass(frozen=True)
class Joined:
    """Regions whose common corners and edges are the same: corners (n, 2), scaled by size about the middle.

    Attributes:
        rings: for every region its outline and holes as indices of corners.
        edges: pairs of corners, each once.
    """

    corners: Floats
    rings: list[list[list[int]]]
    edges: set[tuple[int, int]]
    size: float
    middle: Floats


def joined(polygons: tuple[Polygon, ...]) -> Joined:
    """Merge corners that are closer than `SNAP`, and insert corners that lie on an edge of a region into it."""
    every = np.array([corner for outline, _ in polygons for corner in outline])
    low, high = every.min(axis=0), every.max(axis=0)
    middle, size = (low + high) / 2.0, float((high - low).max())
    found: list[Floats] = []
    rings: list[list[list[int]]] = []
    for outline, holes in polygons:
        rings.append([])
        for ring in (outline, *holes):
            indices = [_index((np.array(corner) - middle) / size, found) for corner in ring]
            rings[-1].append(
                [i for i, before in zip(indices, np.roll(indices, 1), strict=True) if i != before]
            )
    corners = np.array(found)
    full = [[_with_corners_between(ring, corners) for ring in region] for region in rings]
    edges = {
        (min(i, j), max(i, j))
        for region in full
        for ring in region
        for i, j in zip(ring, [*ring[1:], *ring[:1]], strict=True)
    }
    return Joined(corners, full, edges, size, middle)


def _index(corner: Floats, found: list[Floats]) -> int:
    """Return the index of the corner among those found so far; a new one is added."""
    if found:
        distance = np.abs(np.array(found) - corner).max(axis=1)
        nearest = int(distance.argmin())
        if distance[nearest] < SNAP:
            return nearest
    found.append(corner)
    return len(found) - 1


def _with_corners_between(ring: list[int], corners: Floats) -> list[int]:
    full = []
    for i, j in zip(ring, [*ring[1:], *ring[:1]], strict=True):
        full.append(i)
        edge = corners[j] - corners[i]
        length = math.hypot(*edge)
        offset = corners - corners[i]
        along = offset @ edge / length
        beside = np.abs(offset @ [-edge[1], edge[0]]) / length
        between = np.flatnonzero((beside < SNAP) & (along > SNAP) & (along < length - SNAP))
        full += between[np.argsort(along[between])].tolist()
    return full


def _shape(shapely: Any, rings: list[list[int]], corners: Floats) -> Any:
    """Return the library's polygon of a region; None where less than a triangle is left of a ring."""
    if any(len(ring) < 3 for ring in rings):
        return None
    return shapely.Polygon(corners[rings[0]], [corners[ring] for ring in rings[1:]])
