"""Outlines of cross sections: polygons and what is accepted as one, ellipses and boxes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, cast

import numpy as np

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import listed, quantity
from viscorod.model.fields.metadata import accepts
from viscorod.model.fields.values import each, pair
from viscorod.typing import Floats

__all__ = [
    "Corners",
    "Extent",
    "Holes",
    "Polygon",
    "corners",
    "library",
    "placed",
    "polygon",
    "polygon_area",
    "refuse_improper",
]

Ring: TypeAlias = tuple[tuple[float, float], ...]
"""Corners of a closed polygon, in order; the last is joined to the first."""
Polygon: TypeAlias = tuple[Ring, tuple[Ring, ...]]
"""An outline and its holes."""

Points: TypeAlias = Sequence[Sequence[float]]

CORNERS = listed(listed(quantity(), 2, 2), 3)
CLOSED = 1e-9
"""Distance of the last corner from the first, over the size of the outline, up to which it is the same."""
SIDES = 96
"""Sides of the polygon that approximates an ellipse: same area, second moments within (2 pi/96)^4/180 < 1e-7."""


def library() -> tuple[Any, Any]:
    """Return the modules shapely and sectionproperties.pre.pre, imported when a section first needs them.

    Raises:
        RefusedError: they are not installed.
    """
    try:
        import shapely
        from sectionproperties.pre import pre
    except ImportError as error:
        raise RefusedError(
            f"outlines and composite sections need the package sectionproperties ({error})",
            "install it with: pip install 'viscorod[sections]'",
            found="",
        ) from None
    return shapely, pre


@accepts(CORNERS, "list of 3 points or more, 2 numbers each")
def corners(value: Any) -> Ring:
    """Return `value` as the corners of a closed polygon; a last corner that repeats the first is left out."""
    ring = each(value, pair)
    if len(ring) > 1 and math.dist(ring[0], ring[-1]) <= CLOSED * max(
        math.dist(ring[0], one) for one in ring
    ):
        ring = ring[:-1]
    if len(ring) < 3:
        raise RefusedError(
            f"a closed outline needs at least 3 different corners, {len(ring)} were given",
            "give the corners in order, such as [[0, 0], [0.02, 0], [0, 0.01]]",
        )
    for index, (before, after) in enumerate(zip(ring, (*ring[1:], ring[0]), strict=True)):
        if before == after:
            raise RefusedError(
                "the same corner twice in a row", "leave one of them out", found=show(after), at=(index + 1,)
            )
    return ring


@accepts(listed(CORNERS), "list of such lists")
def rings(value: Any) -> tuple[Ring, ...]:
    """Return `value` as a list of closed polygons."""
    return each(value, corners)


Corners = Annotated[Points, corners]
Holes = Annotated[Sequence[Points], rings]


def polygon(points: Points, holes: Sequence[Points]) -> Polygon:
    """Return checked corners and holes (fields of the types above hold tuples) as a polygon."""
    return cast(Ring, points), cast(tuple[Ring, ...], holes)


def refuse_improper(shape: Polygon) -> None:
    """Refuse outlines and holes that cross themselves, and holes outside the outline or in one another.

    Raises:
        RefusedError: with the fault and its position.
    """
    shapely, _ = library()
    outline, holes = shape
    outer = _area(shapely, outline, "the outline", ("points",))
    inner = [_area(shapely, hole, f"hole {index + 1}", ("holes", index)) for index, hole in enumerate(holes)]
    for index, hole in enumerate(inner):
        if not outer.contains_properly(hole):
            raise RefusedError(
                "the hole does not lie inside the outline, or touches it",
                "move its corners inside, or make the notch part of the outline",
                found=show(list(holes[index])),
                at=("holes", index),
            )
        for other in range(index):
            if hole.intersects(inner[other]):
                raise RefusedError(
                    f"the hole overlaps or touches hole {other + 1}",
                    "make one hole of the two",
                    found=show(list(holes[index])),
                    at=("holes", index),
                )


def _area(shapely: Any, ring: Ring, name: str, at: tuple[str | int, ...]) -> Any:
    """Return the area inside a ring, as the library's polygon, scaled to a size of 1."""
    points = np.array(ring)
    size = float(np.ptp(points, axis=0).max())
    shape = shapely.Polygon((points - points.mean(axis=0)) / size)
    if not shape.is_valid or shape.area < 1e-12:
        flat = shape.convex_hull.area < 1e-12
        reason = shapely.is_valid_reason(shape)
        where = ""
        if "[" in reason and not flat:
            x, y = np.array(reason.partition("[")[2].rstrip("]").split(), dtype=float) * size + points.mean(
                axis=0
            )
            where = f" near ({x:.6g}, {y:.6g})"
        raise RefusedError(
            f"{name} crosses or touches itself{where}" if where else f"{name} encloses no area",
            "give its corners in order, once around",
            found=show(list(ring)),
            at=at,
        )
    return shapely.Polygon(ring)


@dataclass(frozen=True)
class Extent:
    """An ellipse or a box about the centre of a section, with or without a hole of the same kind.

    Attributes:
        round: whether it is an ellipse.
        halves: half width along d1 and half height along d2, m.
        hole: those of the hole, m; None where there is none.
    """

    round: bool
    halves: tuple[float, float]
    hole: tuple[float, float] | None = None

    @property
    def reach(self) -> float:
        """Largest distance of a point from the centre, m."""
        return max(self.halves) if self.round else math.hypot(*self.halves)

    @property
    def polygon(self) -> Polygon:
        """Outline and hole as polygons.

        An ellipse becomes a polygon of 96 sides of the same area. For a regular polygon of n sides and the area of
        the circle the second moment is too large by the fraction (2 pi/n)^4/180 only.
        """
        ring = _ellipse if self.round else _box
        return ring(*self.halves), () if self.hole is None else (ring(*self.hole),)


def _box(x: float, y: float) -> Ring:
    return (-x, -y), (x, -y), (x, y), (-x, y)


def _ellipse(a: float, b: float) -> Ring:
    step = 2.0 * math.pi / SIDES
    larger = math.sqrt(step / math.sin(step))  # the same area as the ellipse
    angles = step * (np.arange(SIDES) + 0.5)
    points = larger * np.column_stack([a * np.cos(angles), b * np.sin(angles)])
    return tuple((float(x), float(y)) for x, y in points)


def placed(shape: Polygon, at: Sequence[float], angle: float) -> Polygon:
    """Return the polygon turned by `angle` (rad, from d1 towards d2) about the origin, then moved by `at` (m)."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])

    def moved(ring: Ring) -> Ring:
        points: Floats = np.array(ring) @ turn.T + np.array(at)
        return tuple((float(x), float(y)) for x, y in points)

    outline, holes = shape
    return moved(outline), tuple(moved(hole) for hole in holes)


def polygon_area(shape: Polygon) -> float:
    """Return the area without the holes, m^2 (the trapezoids under the edges)."""

    def inside(ring: Ring) -> float:
        x, y = np.array(ring).T
        x, y = x - x.mean(), y - y.mean()
        return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0

    outline, holes = shape
    return inside(outline) - sum(inside(hole) for hole in holes)
