"""Outlines of sections that are polygons, as the surface of a rod shows them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from viscorod.model.sections.composite import Composite
from viscorod.model.sections.outline import PolygonSection
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.rod import Rod

__all__ = ["contours_of"]

MOST_CORNERS = 48
"""Corners of a drawn contour; of more, such as those of an ellipse, some are left out evenly."""


def contours_of(rod: Rod) -> list[list[Floats]] | None:
    """Return the contours of a rod's section about its centre line, of each region the outer one, then its holes.

    Each is ``(corners, 2)`` [m], the outer one anticlockwise, holes clockwise. None where the section is no polygon, or
    another one elsewhere on the rod.
    """
    section = rod.section
    if isinstance(section, PolygonSection):
        regions = [(section.points, section.holes)]
    elif isinstance(section, Composite):
        regions = [region.polygon for region in section.regions]
    else:
        return None
    points = section.centres
    cos, sin = math.cos(points.angle), math.sin(points.angle)

    def placed(ring: Sequence[Sequence[float]], turn: float) -> Floats:
        corners = np.array(ring, dtype=float)
        corners = corners[:: -(-len(corners) // MOST_CORNERS)]
        x, y = corners.T
        if turn * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0:
            corners = corners[::-1]
        about: Floats = (corners - np.array(points.origin)) @ np.array([[cos, -sin], [sin, cos]])
        return about

    return [[placed(outer, 1.0), *(placed(hole, -1.0) for hole in holes)] for outer, holes in regions]
