"""Centre lines of rods: straight, circular arc, helix, through points, any function; with their frames.

A frame is a rotation matrix whose columns are d1, d2 (the section's axes) and d3 (the unit tangent). Frames
are rotation-minimising along the rod (no twist: d1'.d2 = 0), then turned about d3 by the twist the user
gives.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from viscorod.model.described import Described, RefusedError, show
from viscorod.model.smooth_curve import SmoothCurve, chebyshev_curve
from viscorod.model.values import (
    Direction,
    NonNegative,
    Number,
    Positive,
    Triple,
    Vector,
    each,
    function,
    number,
    one_of,
    sequence,
    vector,
)
from viscorod.typing import Floats

__all__ = ["Arc", "Centreline", "Curve", "Helix", "Points", "Straight", "Twist"]

Twist: TypeAlias = float | Callable[[float], float]
"""Total angle from start to end, or the angle as a function of the arc length; rad."""

VERTICAL = 0.999999
"""Beyond this cosine to global z a tangent counts as vertical for the default section axes."""


class Centreline(Described):
    """A smooth curve of positive length, parametrised by its arc length s from 0 to `length`."""

    tag: ClassVar[str | None] = "shape"

    @property
    @abstractmethod
    def length(self) -> float:
        """Arc length, m."""

    @abstractmethod
    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """Positions (n, 3) and rotation-minimising frames (n, 3, 3) at `s` (n,), started from any normal."""

    @abstractmethod
    def curvature(self, s: Floats) -> Floats:
        """Curvature vector r'' (n, 3) at `s` (n,), global axes, 1/m."""

    def frames(
        self, s: Floats | Sequence[float], d1: Sequence[float] | None = None, twist: Twist = 0.0
    ) -> tuple[Floats, Floats]:
        """Positions and frames at stations of the rod.

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
        position, natural = self.bishop(stations)
        start = self.bishop(np.zeros(1))[1][0]
        wanted = start_axis(start[:, 2], d1)
        angle = math.atan2(float(wanted @ start[:, 1]), float(wanted @ start[:, 0])) + self.twisted(
            stations, twist
        )
        c, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
        first = c * natural[:, :, 0] + sine * natural[:, :, 1]
        second = c * natural[:, :, 1] - sine * natural[:, :, 0]
        return position, np.stack([first, second, natural[:, :, 2]], axis=2)

    def twisted(self, s: Floats, twist: Twist) -> Floats:
        """Angle (n,) of the section about d3 relative to the rotation-minimising frame at `s`, rad."""
        if callable(twist):
            return np.array([_angle(twist, float(station)) for station in s])
        return twist * s / self.length


def _angle(twist: Callable[[float], float], s: float) -> float:
    angle = twist(s)
    try:
        return number(angle)
    except RefusedError as error:
        raise RefusedError(
            f"the function of the twist gave this at s = {s:.6g}: {error.why}",
            "make it return an angle in rad everywhere",
            found=show(angle),
            at=("twist",),
        ) from None


def cross(a: Floats, b: Floats) -> Floats:
    """The cross product of two vectors (3,); ``np.cross`` takes ten times as long for one pair."""
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def start_axis(tangent: Floats, d1: Sequence[float] | None) -> Floats:
    """The section's first axis (3,) at the start, for the unit `tangent` (3,); see `Centreline.frames`."""
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


class Straight(Centreline):
    """A straight line.

    Args:
        start: m.
        end: m.
    """

    shape: Literal["straight"] = Field(default="straight", kw_only=True, repr=False)
    start: Vector = Field(description="three numbers, m")
    end: Vector = Field(description="three numbers, m")

    @model_validator(mode="after")
    def _positive_length(self) -> Self:
        if not 0.0 < self.length < math.inf:
            raise RefusedError(
                f"the rod would have the length {self.length:g}",
                "give two different points, start and end",
                found=f"start {show(self.start)} and end {show(self.end)}",
            )
        return self

    @property
    def length(self) -> float:
        """Distance of the ends, m."""
        return math.dist(self.start, self.end)

    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """See `Centreline`."""
        start = np.array(self.start)
        tangent = (np.array(self.end) - start) / self.length
        frame = _frame(tangent, start_axis(tangent, None))
        return start + s[:, None] * tangent, np.broadcast_to(frame, (len(s), 3, 3))

    def curvature(self, s: Floats) -> Floats:
        """Zero."""
        return np.zeros((len(s), 3))


class Arc(Centreline):
    """A circular arc.

    Args:
        start: m.
        tangent: direction at the start.
        normal: direction from the start to the centre of curvature, perpendicular to the tangent.
        radius: m.
        angle: of the arc, > 0, rad.
    """

    shape: Literal["arc"] = Field(default="arc", kw_only=True, repr=False)
    start: Vector = Field(description="three numbers, m")
    tangent: Direction = Field(description="direction at the start, three numbers")
    normal: Direction = Field(description="direction from the start to the centre, three numbers")
    radius: Positive = Field(description="m")
    angle: Positive = Field(description="rad")

    @model_validator(mode="after")
    def _perpendicular(self) -> Self:
        cosine = sum(a * b for a, b in zip(self.tangent, self.normal, strict=True))
        if abs(cosine) > 1e-6:
            raise RefusedError(
                f"it must be perpendicular to the tangent; the cosine of their angle is {cosine:.6g}",
                "give the direction from the start to the centre of the arc",
                found=show(self.normal),
                at=("normal",),
            )
        return self

    @property
    def length(self) -> float:
        """Radius times angle, m."""
        return self.radius * self.angle

    def _axes(self) -> tuple[Floats, Floats]:
        tangent = np.array(self.tangent)
        normal = np.array(self.normal) - (np.array(self.normal) @ tangent) * tangent
        return tangent, normal / np.linalg.norm(normal)

    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """See `Centreline`; the frame turns with the arc about the axis of the circle."""
        tangent, normal = self._axes()
        c, sine = np.cos(s / self.radius)[:, None], np.sin(s / self.radius)[:, None]
        versine = 2.0 * np.sin(s / self.radius / 2.0)[:, None] ** 2
        position = np.array(self.start) + self.radius * (sine * tangent + versine * normal)
        inward = c * normal - sine * tangent
        along = c * tangent + sine * normal
        axis = np.broadcast_to(cross(tangent, normal), inward.shape)
        return position, np.stack([inward, axis, along], axis=2)

    def curvature(self, s: Floats) -> Floats:
        """Towards the centre, 1/radius."""
        tangent, normal = self._axes()
        c, sine = np.cos(s / self.radius)[:, None], np.sin(s / self.radius)[:, None]
        return np.asarray((c * normal - sine * tangent) / self.radius)


class Helix(Centreline):
    """A circular helix r = centre + R (cos a e1 + sin a e2) + pitch (a - phase)/2pi axis.

    e1 is the part of global x normal to the axis (of global y when the axis is along x), and e1, e2, axis are
    right-handed; `a` grows from `phase`. In a left-handed helix `a` decreases while the height grows.

    Args:
        radius: R, m.
        pitch: rise along the axis per turn, >= 0 (0: a ring), m.
        turns: number of turns, > 0.
        centre: of the circle in which the helix starts, m.
        axis: direction in which it rises.
        phase: angle a of the start, rad.
        handedness: "right" or "left".
    """

    shape: Literal["helix"] = Field(default="helix", kw_only=True, repr=False)
    radius: Positive = Field(description="m")
    pitch: NonNegative = Field(description="rise per turn, m")
    turns: Positive = Field(description="number of turns")
    centre: Vector = (0.0, 0.0, 0.0)
    axis: Direction = (0.0, 0.0, 1.0)
    phase: Number = 0.0
    handedness: Annotated[Literal["right", "left"], one_of("right", "left")] = "right"

    @property
    def length(self) -> float:
        """Turns times the length of one, m."""
        return self.turns * math.hypot(2.0 * math.pi * self.radius, self.pitch)

    def _polar(self, s: Floats) -> tuple[Floats, Floats, Floats, float, float]:
        """Outward and circumferential directions (n, 3), the axis (3,), and the slope's cosine and sine."""
        axis = np.array(self.axis)
        seed = np.array([1.0, 0.0, 0.0] if abs(axis[0]) <= VERTICAL else [0.0, 1.0, 0.0])
        e1 = seed - (seed @ axis) * axis
        e1 /= np.linalg.norm(e1)
        e2 = np.cross(axis, e1)
        sign = 1.0 if self.handedness == "right" else -1.0
        angle = self.phase + sign * 2.0 * math.pi * self.turns * s / self.length
        c, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
        per_turn = math.hypot(2.0 * math.pi * self.radius, self.pitch)
        flat, rise = 2.0 * math.pi * self.radius / per_turn, self.pitch / per_turn
        return c * e1 + sine * e2, sign * (c * e2 - sine * e1), axis, flat, rise

    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """See `Centreline`; the Frenet frame turned back by the torsion times s."""
        outward, around, axis, flat, rise = self._polar(s)
        position = np.array(self.centre) + self.radius * outward + (rise * s)[:, None] * axis
        tangent = flat * around + rise * axis
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        binormal = np.cross(tangent, -outward)
        torsion = (1.0 if self.handedness == "right" else -1.0) * flat * rise / self.radius
        c, sine = np.cos(torsion * s)[:, None], np.sin(torsion * s)[:, None]
        first, second = -c * outward - sine * binormal, c * binormal - sine * outward
        return position, np.stack([first, second, tangent], axis=2)

    def curvature(self, s: Floats) -> Floats:
        """Towards the axis, R/(R^2 + (pitch/2pi)^2)."""
        outward, _, _, flat, _ = self._polar(s)
        return np.asarray(-outward * flat**2 / self.radius)


class _Parametric(Centreline):
    """A centre line that needs a quadrature for its arc length."""

    @cached_property
    @abstractmethod
    def _smooth(self) -> SmoothCurve:
        """Arc length as a function of the parameter, with frames."""

    @property
    def length(self) -> float:
        """Arc length by Gauss quadrature, m."""
        return self._smooth.length

    def bishop(self, s: Floats) -> tuple[Floats, Floats]:
        """See `Centreline`."""
        return self._smooth.bishop(s)

    def curvature(self, s: Floats) -> Floats:
        """See `Centreline`."""
        return self._smooth.curvature(s)

    @model_validator(mode="after")
    def _resolved(self) -> Self:
        if not 0.0 < self._smooth.length < math.inf:
            raise RefusedError(
                f"the rod would have the length {self._smooth.length:g}", "give a longer curve"
            )
        return self


def _points(value: Any) -> tuple[Triple, ...]:
    items = sequence(value)
    if len(items) < 2:
        raise RefusedError(
            "a curve needs at least two points", "give a list of points, [[x, y, z], [x, y, z], ...]"
        )
    points = each(items, vector)
    for index, (before, point) in enumerate(pairwise(points), start=1):
        if math.dist(before, point) == 0.0:
            raise RefusedError(
                "the same point twice in a row", "leave one out", found=show(items[index]), at=(index,)
            )
    return points


class Points(_Parametric):
    """A smooth curve through points: a cubic spline over the chord lengths (continuous curvature).

    Args:
        points: at least two, m.
    """

    shape: Literal["points"] = Field(default="points", kw_only=True, repr=False)
    points: Annotated[Sequence[Sequence[float]], PlainValidator(_points)] = Field(
        description="list of points, m"
    )

    @cached_property
    def _smooth(self) -> SmoothCurve:
        from scipy.interpolate import CubicSpline

        points = np.array(self.points)
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if chords.min() < 1e-6 * chords.max():
            index = int(chords.argmin()) + 1
            raise RefusedError(
                "this point is closer to the one before than a millionth of the longest distance",
                "leave one of the two out",
                found=show(self.points[index]),
                at=("points", index),
            )
        knots = np.concatenate([[0.0], np.cumsum(chords / chords.mean())])
        spline = CubicSpline(knots, points)
        first, second = spline.derivative(), spline.derivative(2)
        return SmoothCurve(lambda u: (spline(u), first(u), second(u)), knots)


class Curve(_Parametric):
    """A curve given by a Python function (not in case files).

    Args:
        function: u in [0, 1] -> position (3 numbers, m); any parametrisation whose speed is never zero. It
            must be smooth; it is resolved to 12 digits by piecewise Chebyshev series.
    """

    shape: Literal["curve"] = Field(default="curve", kw_only=True, repr=False)
    function: Annotated[Callable[[float], Sequence[float] | Floats], PlainValidator(function)]

    @cached_property
    def _smooth(self) -> SmoothCurve:
        return SmoothCurve(*chebyshev_curve(self._point))

    def _point(self, u: float) -> Floats:
        try:
            return np.array(vector(self.function(u)))
        except RefusedError as error:
            raise RefusedError(
                f"it does not return a point: {error.why}", error.instead, at=("function",)
            ) from None


def _frame(tangent: Floats, d1: Floats) -> Floats:
    return np.array([d1, cross(tangent, d1), tangent]).T
