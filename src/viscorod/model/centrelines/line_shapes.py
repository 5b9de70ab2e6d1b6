"""Centre lines in closed form: straight, circular arc, helix."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.centrelines.centreline import VERTICAL, Centreline, cross, start_axis
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Direction, NonNegative, Number, Positive, Vector, one_of
from viscorod.typing import Floats

__all__ = ["Arc", "Helix", "Straight"]


class Straight(Centreline):
    """A straight line."""

    shape: Literal["straight"] = Field(default="straight", kw_only=True, repr=False)
    start: Vector = Key("", "m")
    end: Vector = Key("", "m")

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
        start, tangent, frame = self._line
        return start + s[:, None] * tangent, np.broadcast_to(frame, (len(s), 3, 3))

    @cached_property
    def _line(self) -> tuple[Floats, Floats, Floats]:
        """Start [m], tangent and frame of the line."""
        start = np.array(self.start)
        tangent = (np.array(self.end) - start) / self.length
        return start, tangent, _frame(tangent, start_axis(tangent, None))

    def curvature(self, s: Floats) -> Floats:
        """Return zero."""
        return np.zeros((len(s), 3))


class Arc(Centreline):
    """A circular arc."""

    shape: Literal["arc"] = Field(default="arc", kw_only=True, repr=False)
    start: Vector = Key("", "m")
    tangent: Direction = Key("direction at the start")
    normal: Direction = Key(
        "direction from the start to the centre of curvature, perpendicular to the tangent"
    )
    radius: Positive = Key("", "m")
    angle: Positive = Key("of the arc, > 0", "rad")

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
        """Return the vector towards the centre, of size 1/radius."""
        tangent, normal = self._axes()
        c, sine = np.cos(s / self.radius)[:, None], np.sin(s / self.radius)[:, None]
        return np.asarray((c * normal - sine * tangent) / self.radius)


class Helix(Centreline):
    """A circular helix r = centre + R (cos a e1 + sin a e2) + pitch (a - phase)/2pi axis.

    e1 is the part of global x normal to the axis (of global y when the axis is along x), and e1, e2, axis are
    right-handed; `a` grows from `phase`. In a left-handed helix `a` decreases while the height grows.
    """

    shape: Literal["helix"] = Field(default="helix", kw_only=True, repr=False)
    radius: Positive = Key("R", "m")
    pitch: NonNegative = Key("rise along the axis per turn, >= 0 (0: a ring)", "m")
    turns: Positive = Key("number of turns, > 0")
    centre: Vector = Key("of the circle in which the helix starts", "m", default=(0.0, 0.0, 0.0))
    axis: Direction = Key("direction in which it rises", default=(0.0, 0.0, 1.0))
    phase: Number = Key("angle a of the start", "rad", default=0.0)
    handedness: Annotated[Literal["right", "left"], one_of("right", "left")] = Key(
        '"right" or "left"', default="right"
    )

    @property
    def length(self) -> float:
        """Turns times the length of one, m."""
        return self.turns * math.hypot(2.0 * math.pi * self.radius, self.pitch)

    @property
    def apart(self) -> float:
        """Distance of a turn from the next one, across the line, m."""
        return self.pitch * 2.0 * math.pi * self.radius / math.hypot(2.0 * math.pi * self.radius, self.pitch)

    def _polar(self, s: Floats) -> tuple[Floats, Floats, Floats, float, float]:
        """Return outward and circumferential directions (n, 3), the axis (3,), and the slope's cosine and sine."""
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
        """Return the vector towards the axis, of size R/(R^2 + (pitch/2pi)^2)."""
        outward, _, _, flat, _ = self._polar(s)
        return np.asarray(-outward * flat**2 / self.radius)


def _frame(tangent: Floats, d1: Floats) -> Floats:
    return np.array([d1, cross(tangent, d1), tangent]).T
