"""The outlines of a section as points for pictures."""

from __future__ import annotations

import numpy as np

from viscorod.model.sections.section_base import AnySection
from viscorod.typing import Floats

__all__ = ["section_rings"]

AROUND = 48
"""Points of an ellipse."""
ALONG = 8
"""Points of a straight side."""


def section_rings(section: AnySection) -> list[Floats]:
    """Return points ``(n, 2)`` [m] on the outlines of a section and of its holes, each once around, on the section."""
    extent = section.extent
    if extent is not None and extent.round:
        turn = 2.0 * np.pi * np.arange(AROUND) / AROUND
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        return [circle * halves for halves in (extent.halves, extent.hole) if halves is not None]
    rings = [ring for outer, holes in section.outline for ring in (outer, *holes)]
    return [_divided(np.array(ring)) for ring in rings]


def _divided(corners: Floats) -> Floats:
    part = np.arange(ALONG)[:, None] / ALONG
    return np.concatenate(
        [a + part * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    )
