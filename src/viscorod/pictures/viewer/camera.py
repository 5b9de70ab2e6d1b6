"""From where the page looks first: what is up, where the eye is, how fine the grid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from viscorod.typing import Floats

__all__ = ["first_look"]

_FLAT = 1e-3  # extent across a plane, as a part of the largest, below which the plane is faced
_CELLS = 5.0  # of the grid, across the model
_ARROW = 0.18  # length of the longest arrow, as in the scripts
_AZIMUTH, _ELEVATION = math.radians(-55.0), math.radians(22.0)
_ASIDE, _ABOVE = 0.22, 0.28  # of the eye from the normal of a plane that is faced, rad


def first_look(positions: Floats, weight: Floats, loads: Floats) -> dict[str, Any]:
    """Return centre and size [m] of what is shown, the direction up, that of the eye, and the grid's cell [m].

    Args:
        positions: all points of all frames ``(..., 3)`` [m].
        loads: feet of arrows and where these point ``(2, ...)``, 1 for the largest.
        weight: sum of the gravity loads (3,) [m/s^2]; up is against it where it goes along an axis.
    """
    points = positions.reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    extent = high - low
    size = float(np.linalg.norm(extent)) or 1.0
    feet = loads[0].reshape(-1, 3)
    tips = feet + _ARROW * size * loads[1].reshape(-1, 3)
    low, high = (
        np.minimum(low, tips.min(axis=0, initial=np.inf)),
        np.maximum(high, tips.max(axis=0, initial=-np.inf)),
    )
    thin = int(np.argmin(extent))
    planar = bool(extent[thin] <= _FLAT * float(extent.max()))
    up = np.array([0.0, 0.0, 1.0])
    if np.count_nonzero(weight) == 1:
        up = -weight / np.linalg.norm(weight)
    elif planar and thin == 2:
        up = np.array([0.0, 1.0, 0.0])
    normal = np.eye(3)[thin] * (-1.0 if thin == 1 else 1.0)
    if planar and abs(float(normal @ up)) < 0.5:
        side = np.cross(up, normal)
        eye = math.cos(_ABOVE) * (math.cos(_ASIDE) * normal + math.sin(_ASIDE) * side) + math.sin(_ABOVE) * up
    else:
        first = np.array([0.0, 0.0, 1.0]) if abs(up[1]) > 0.5 else np.array([1.0, 0.0, 0.0])
        if abs(up[0]) > 0.5:
            first = np.array([0.0, 1.0, 0.0])
        second = np.cross(up, first)
        flat = math.cos(_AZIMUTH) * first + math.sin(_AZIMUTH) * second
        eye = math.cos(_ELEVATION) * flat + math.sin(_ELEVATION) * up
    return {
        "centre": (0.5 * (low + high)).tolist(),
        "low": low.tolist(),
        "high": high.tolist(),
        "size": size,
        "up": up.tolist(),
        "eye": eye.tolist(),
        "cell": _round(float(extent.max()) / _CELLS or 1.0),
    }


def _round(length: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above a length."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))
