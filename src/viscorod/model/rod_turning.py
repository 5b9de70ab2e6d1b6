"""How far the reference shape of a rod turns along it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.model.centrelines.line_shapes import Straight
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.rod import Rod

__all__ = ["turning_along"]

SAMPLES, MOST_SAMPLES = 64, 4096
"""Pieces of a rod in which it is measured how far the reference shape turns."""
FINE = 0.5
"""Turning of a piece that needs no smaller ones, rad."""


def turning_along(rod: Rod) -> tuple[Floats, Floats]:
    """Return stations, and the angles of the frame there: by the frames, or by the curvature if that is more.

    Frames show the rotation between two stations, but not whole turns. A straight rod is only turned about itself.
    """
    if isinstance(rod.centreline, Straight) and not callable(rod.turn) and not rod.tilted:
        return np.array([0.0, rod.length]), np.array([0.0, abs(rod.turn)])
    count = SAMPLES
    while True:
        s = np.linspace(0.0, rod.length, count + 1)
        frames = rod.frames(s)[1]
        trace = np.einsum("nij,nij->n", frames[:-1], frames[1:])
        seen = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
        bent = np.linalg.norm(rod.centreline.curvature(0.5 * (s[:-1] + s[1:])), axis=1) * np.diff(s)
        step = np.maximum(seen, np.hypot(bent, np.diff(rod.centreline.twisted(s, rod.turn))))
        if step.max() < FINE or count >= MOST_SAMPLES:
            return s, np.concatenate([[0.0], np.cumsum(step)])
        count *= 8
