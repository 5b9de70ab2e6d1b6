"""Centre lines of rods and their frames; the shapes are in ``line_shapes`` and ``parametric_lines``.

A frame is a rotation matrix whose columns are d1, d2 (the section's axes) and d3 (the unit tangent). Frames
are rotation-minimising along the rod (no twist: d1'.d2 = 0), then turned about d3 by the twist the user
gives.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np

from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import number
from viscorod.typing import Floats

__all__ = ["VERTICAL", "Centreline", "Twist", "cross", "start_axis"]

Twist: TypeAlias = float | Callable[[float], float]
"""Total angle from start to end, or the angle as a function of the arc length; rad."""

FEW, MOST_KNOWN = 80, 32
"""Stations whose frames are kept, and how often."""
VERTICAL = 0.999999
"""Beyond this cosine to global z a tangent counts as vertical for the default section axes."""


class Centreline(Definition):
    """A smooth curve of positive length, parametrised by its arc length s from 0 to `length`."""

    tag: ClassVar[str | None] = "shape"

    @property
    @abstractmethod
    def length(self) -> float:
        """Arc length, m."""

    @abstractmethod
    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """Return positions (n, 3) and rotation-minimising frames (n, 3, 3) at `s` (n,), started from any normal."""

    @abstractmethod
    def curvature(self, s: Floats) -> Floats:
        """Return the curvature vector r'' (n, 3) at `s` (n,), global axes, 1/m."""

    def frames(
        self, s: Floats | Sequence[float], d1: Sequence[float] | None = None, twist: Twist = 0.0
    ) -> tuple[Floats, Floats]:
        """Return positions and frames at stations of the rod.

        Args:
            s: arc lengths (n,), m.
            d1: direction of the section's first axis at s = 0 (its part normal to the tangent is used),
                global axes; by default d2 is the part of global z normal to the tangent (of global y for a
                vertical rod) and d1 = d2 x d3.
            twist: angle by which the frame is turned about d3: the total, growing evenly, or a function of
                s; rad.

        Returns:
            positions (n, 3) in m and frames (n, 3, 3), columns d1, d2, d3, in global axes.

        Raises:
            RefusedError: d1 is parallel to the tangent at the start.
        """
        stations = np.atleast_1d(np.asarray(s, dtype=np.float64))
        if callable(twist) or stations.size > FEW:
            return self._frames(stations, d1, twist)
        key = stations.tobytes(), None if d1 is None else tuple(map(float, d1)), float(twist)
        found = self._known_frames.get(key)
        if found is None:
            if len(self._known_frames) >= MOST_KNOWN:
                self._known_frames.clear()
            found = self._known_frames[key] = self._frames(stations, d1, twist)
        return found[0].copy(), found[1].copy()

    @cached_property
    def _known_frames(self) -> dict[Any, tuple[Floats, Floats]]:
        """Positions and frames that were asked for: those of ends, supports and nodes are asked for many times."""
        return {}

    def _frames(self, stations: Floats, d1: Sequence[float] | None, twist: Twist) -> tuple[Floats, Floats]:
        position, natural = self.bishop(stations)
        angle = self._start_angle(d1) + self.twisted(stations, twist)
        c, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
        first = c * natural[:, :, 0] + sine * natural[:, :, 1]
        second = c * natural[:, :, 1] - sine * natural[:, :, 0]
        return position, np.stack([first, second, natural[:, :, 2]], axis=2)

    def _start_angle(self, d1: Sequence[float] | None) -> float:
        """Return the angle [rad] of the section at s = 0 from the rotation-minimising frame there."""
        axis = None if d1 is None else tuple(map(float, d1))
        known = self._start_angles
        if axis not in known:
            start = self.bishop(np.zeros(1))[1][0]
            wanted = start_axis(start[:, 2], d1)
            known[axis] = math.atan2(float(wanted @ start[:, 1]), float(wanted @ start[:, 0]))
        return known[axis]

    @cached_property
    def _start_angles(self) -> dict[tuple[float, ...] | None, float]:
        """Angles that are known, by the axis d1 that was given."""
        return {}

    def twisted(self, s: Floats, twist: Twist) -> Floats:
        """Return the angle (n,) of the section about d3 relative to the rotation-minimising frame at `s`, rad."""
        if callable(twist):
            return np.array([_angle(twist, float(station)) for station in s])
        return twist * s / self.length


def _angle(twist: Callable[[float], float], s: float) -> float:
    return returned(
        twist,
        s,
        check=number,
        name="the function of the twist",
        where=f"at s = {s:.6g} m",
        instead="make it return an angle in rad everywhere",
        at=("twist",),
    )


def cross(a: Floats, b: Floats) -> Floats:
    """Return the cross product of two vectors (3,); ``np.cross`` takes ten times as long for one pair."""
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def start_axis(tangent: Floats, d1: Sequence[float] | None) -> Floats:
    """Return the section's first axis (3,) at the start, for the unit `tangent` (3,); see `Centreline.frames`."""
    if d1 is None:
        upward = np.array([0.0, 0.0, 1.0] if abs(tangent[2]) <= VERTICAL else [0.0, 1.0, 0.0])
        second = upward - (upward @ tangent) * tangent
        return cross(second / np.linalg.norm(second), tangent)
    given = np.asarray(d1, dtype=np.float64) / math.hypot(*d1)
    normal = given - (given @ tangent) * tangent
    size = float(np.linalg.norm(normal))
    if size < 1e-6:
        raise RefusedError(
            "the section's axis d1 must not point along the rod",
            "give a direction across the tangent at the rod's start, or leave d1 out",
            found=show(tuple(d1)),
            at=("d1",),
        )
    return np.asarray(normal / size)
