"""Outlines of sections that are polygons, as the surface of a rod shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from viscorod.model.sections.section_base import AnySection
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.rod import Rod

__all__ = ["contours_of"]

MOST_CORNERS = 48
"""Corners of a drawn contour; of more, such as those of an ellipse, some are left out evenly."""


def contours_of(rod: Rod) -> list[list[Floats]] | None:
    """Return the contours of a rod's section about its centre line, of each region the outer one, then its holes.

    Each is ``(corners, 2)`` [m], the outer one anticlockwise, holes clockwise. None where the section is an ellipse or
    a box, where it has no known outline, or where it changes along the rod.
    """
    section = rod.section
    if not isinstance(section, AnySection) or section.extent is not None or not section.outline:
        return None

    def drawn(ring: Sequence[Sequence[float]], turn: float) -> Floats:
        corners = np.array(ring, dtype=float)
        corners = corners[:: -(-len(corners) // MOST_CORNERS)]
        x, y = corners.T
        if turn * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0:
            corners = corners[::-1]
        return corners

    return [[drawn(outer, 1.0), *(drawn(hole, -1.0) for hole in holes)] for outer, holes in section.outline]
