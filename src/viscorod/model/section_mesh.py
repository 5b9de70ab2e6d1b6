"""Triangles over a cross section, by the mesher of the library sectionproperties (J. R. Shewchuk's Triangle)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from viscorod.model.described import RefusedError, show
from viscorod.model.polygons import Polygon, library
from viscorod.typing import Floats, Integers

__all__ = ["SectionMesh", "first_size", "refuse_misfits", "triangulate"]

SNAP = 1e-9
"""Corners closer than this fraction of the section's size are one: regions share edges in spite of round-off."""
MOST_TRIANGLES = 100_000
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
    shapes, _, _ = _scaled(shapely, polygons)
    for index, shape in enumerate(shapes):
        if shape.geom_type != "Polygon" or shape.is_empty or not shape.is_valid:
            raise RefusedError(
                "the region is thinner than a billionth of the section somewhere",
                "make it thicker, or leave it out",
                found="",
                at=(index,),
            )
        for other in range(index):
            common = shape.intersection(shapes[other]).area
            if common > 1e-8 * min(shape.area, shapes[other].area):
                share = common / shape.area
                raise RefusedError(
                    f"the region overlaps region {other + 1} with {100.0 * share:.3g} % of its area",
                    "give every place to one region: give the outer one a hole, or move one of them",
                    found="",
                    at=(index,),
                )
    whole = shapely.unary_union(shapes, grid_size=SNAP)
    if whole.geom_type != "Polygon":
        raise RefusedError(
            f"the regions are {len(whole.geoms)} separate parts: they do not all join along edges",
            "move them together until they share edges",
            found=f"{len(shapes)} regions",
        )
    expected = sum(shape.length**2 / shape.area for shape in shapes)
    if expected > MOST_TRIANGLES:
        raise RefusedError(
            "the section is too thin for its length to be covered with triangles",
            "give its numbers instead, with shape = 'given' or 'stiffness'",
            found=f"about {expected:.2g} triangles",
        )


def first_size(polygons: tuple[Polygon, ...]) -> float:
    """Side of the triangles of a first mesh, m: half the thickness 2 A/perimeter, at most a tenth of the root of A."""
    shapely, _ = library()
    shapes, size, _ = _scaled(shapely, polygons)
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
    shapes, size, middle = _scaled(shapely, polygons)
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
    # snap rounding: a corner on another region's edge becomes a corner of that edge, no sliver is left between
    lines = shapely.unary_union([shape.boundary for shape in shapes], grid_size=SNAP)
    pieces = [np.array(line.coords) for line in getattr(lines, "geoms", [lines])]
    segments = np.vstack([np.hstack([piece[:-1], piece[1:]]) for piece in pieces])
    corners, index = np.unique(segments.reshape(-1, 2), axis=0, return_inverse=True)
    facets = np.unique(np.sort(index.reshape(-1, 2), axis=1), axis=0)
    faces = shapely.polygonize(list(getattr(lines, "geoms", [lines]))).geoms
    seeds = [face.representative_point() for face in faces]
    owners = [next((k for k, shape in enumerate(shapes) if shape.contains(p)), None) for p in seeds]
    inside = [point.coords[0] for point, owner in zip(seeds, owners, strict=True) if owner is not None]
    found = pre.create_mesh(
        points=corners.tolist(),
        facets=facets.tolist(),
        holes=[point.coords[0] for point, owner in zip(seeds, owners, strict=True) if owner is None],
        control_points=inside,
        mesh_sizes=[largest] * len(inside),
        min_angle=SMALLEST_ANGLE,
        coarse=False,
    )
    triangles = np.array(found["triangles"], dtype=np.int64)[:, [0, 1, 2, 5, 3, 4]]
    face = np.array(found["triangle_attributes"], dtype=float).reshape(len(triangles), -1)[:, 0]
    region = np.array([owner for owner in owners if owner is not None])[face.astype(np.int64)]
    points = np.array(found["vertices"], dtype=float) * size + middle
    return SectionMesh(points, triangles, region)


def _scaled(shapely: Any, polygons: tuple[Polygon, ...]) -> tuple[list[Any], float, Floats]:
    """The polygons moved to the origin, scaled to a size of 1 and snapped; the size and the middle, m."""
    every = np.array([corner for outline, _ in polygons for corner in outline])
    low, high = every.min(axis=0), every.max(axis=0)
    middle, size = (low + high) / 2.0, float((high - low).max())
    shapes = []
    for outline, holes in polygons:
        rings = [(np.array(ring) - middle) / size for ring in (outline, *holes)]
        shapes.append(shapely.set_precision(shapely.Polygon(rings[0], rings[1:]), SNAP))
    return shapes, size, middle
