"""Outlines of sections that are polygons, as the surface of a rod shows them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from viscorod.model.composite import Composite
from viscorod.model.outline import Outline
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.rod import Rod

__all__ = ["contours_of"]

MOST_CORNERS = 48
"""Corners of a drawn contour; of more, such as those of an ellipse, some are left out evenly."""


def contours_of(rod: Rod) -> list[Floats] | None:
    """Return the outer contours of a rod's section about its centre line, anticlockwise ``(corners, 2)`` [m].

    Holes are seen at the ends of a rod only and are not drawn. None where the section is no polygon, or another
    one elsewhere on the rod.
    """
    section = rod.section
    if isinstance(section, Outline):
        rings = [section.points]
    elif isinstance(section, Composite):
        rings = [region.polygon[0] for region in section.regions]
    else:
        return None
    points = section.centres
    cos, sin = math.cos(points.angle), math.sin(points.angle)
    found = []
    for ring in rings:
        corners = np.array(ring, dtype=float)
        if np.array_equal(corners[0], corners[-1]):
            corners = corners[:-1]
        corners = corners[:: -(-len(corners) // MOST_CORNERS)]
        x, y = corners.T
        if np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0:
            corners = corners[::-1]
        found.append((corners - np.array(points.origin)) @ np.array([[cos, -sin], [sin, cos]]))
    return found
