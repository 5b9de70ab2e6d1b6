"""From where a view in space looks: so that motions are seen, and rods do not hide behind each other."""

from __future__ import annotations

import math

import numpy as np

from viscorod.typing import Floats

__all__ = ["projection"]

_AZIMUTH, _ELEVATION = math.radians(-60.0), math.radians(25.0)  # of the usual eye, z upwards
_OTHERS = (0.0, 20.0, -20.0, 45.0, -45.0, 90.0)  # degrees from it, around z, the nearest first
_SEEN = 0.15  # of the squares of what is swept over, below which another eye is sought
_HIDDEN = 0.05  # part of the lines that may be hidden more than by another eye
_BEHIND, _COVERED = 0.08, 0.012  # distances in space and on paper, over the extent, of what hides each other
_POINTS = 250  # of the lines that are compared in pairs


def projection(points: Floats, swept: Floats | None = None, lines: Floats | None = None) -> Floats:
    """Return the projection ``(2, 3)`` of a view in space: the usual one, or one that shows more.

    Args:
        points: ``(n, 3)`` [m] of all that is drawn, which another eye should not see on one spot either.
        swept: normals ``(..., 3)`` of what moving lines sweep over; None where nothing is shown to move.
        lines: points ``(k, 3)`` [m] along the lines of one state, which may hide each other; None if they cannot.
    """
    around = _AZIMUTH + np.radians(_OTHERS)
    e, zero = _ELEVATION, np.zeros_like(around)
    right = np.stack([-np.sin(around), np.cos(around), zero], axis=-1)
    up = np.stack(
        [-np.sin(e) * np.cos(around), -np.sin(e) * np.sin(around), np.full_like(around, np.cos(e))], axis=-1
    )
    views: Floats = np.stack([right, up], axis=1)
    total = 0.0 if swept is None else float(np.sum(swept**2))
    area = np.ones(len(views))
    if swept is not None and total > 0.0:
        area = np.sum((swept.reshape(-1, 3) @ np.cross(right, up).T) ** 2, axis=0) / total
    hidden = np.zeros(len(views)) if lines is None or not lines.size else _hidden(lines, views)
    if area[0] >= _SEEN and hidden[0] <= hidden.min() + _HIDDEN:
        usual: Floats = views[0]
        return usual
    clear = hidden <= hidden.min() + _HIDDEN
    score = np.ones(len(views))
    if area[0] < _SEEN:
        score = area * np.sum(((points - points.mean(axis=0)) @ views.transpose(0, 2, 1)) ** 2, axis=(1, 2))
    best: Floats = views[int(np.argmax(np.where(clear, score, 0.0)))]  # the nearest one of those alike
    return best


def _hidden(lines: Floats, views: Floats) -> Floats:
    """Return which part of the points of lines is on paper where others are that are far from them in space."""
    chosen = lines[np.unique(np.linspace(0, len(lines) - 1, min(_POINTS, len(lines))).round().astype(int))]
    extent = float(np.ptp(chosen, axis=0).max())
    apart = _distances(chosen) > _BEHIND * extent
    found: Floats = np.array(
        [np.mean(np.any(apart & (_distances(chosen @ view.T) < _COVERED * extent), axis=1)) for view in views]
    )
    return found


def _distances(points: Floats) -> Floats:
    """Return the distances of all pairs of points ``(n, d)``."""
    found: Floats = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return found
