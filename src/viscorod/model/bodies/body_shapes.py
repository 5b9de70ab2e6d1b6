"""Homogeneous rigid bodies of simple shapes."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.bodies.body_base import AXES, Shaped
from viscorod.model.fields.directions import OptionalAxes, axes_from, columns
from viscorod.model.fields.forms import POSITIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import Direction, Positive, Triple, each, positive, vector
from viscorod.typing import Floats

__all__ = ["Box", "Cylinder", "Sphere"]


@accepts(listed(quantity(bounds=POSITIVE), 3, 3), "3 numbers > 0")
def _sides(value: Any) -> Triple:
    x, y, z = each(vector(value), positive)
    return x, y, z


class Box(Shaped):
    """A homogeneous box."""

    shape: Literal["box"] = Field(default="box", kw_only=True, repr=False)
    sides: Annotated[GivenAs[Triple, Amounts], _sides] = Key(
        "lengths of the edges along the body's axes", "m"
    )
    axes: OptionalAxes = Key(AXES, default=None, kw_only=True)

    def volume(self) -> float:
        """Return the product of the sides, m^3."""
        a, b, c = self.sides
        return a * b * c

    def gyration(self) -> Triple:
        """Return (b^2 + c^2)/12 and its permutations, m^2."""
        a, b, c = self.sides
        return (b * b + c * c) / 12.0, (c * c + a * a) / 12.0, (a * a + b * b) / 12.0

    def frame(self) -> Floats:
        """Return the given axes."""
        return columns(self.axes)


class Sphere(Shaped):
    """A homogeneous sphere."""

    shape: Literal["sphere"] = Field(default="sphere", kw_only=True, repr=False)
    radius: Positive = Key("", "m")
    axes: OptionalAxes = Key(AXES, default=None, kw_only=True)

    def volume(self) -> float:
        """Return 4/3 pi r^3, m^3."""
        return 4.0 / 3.0 * math.pi * self.radius**3

    def gyration(self) -> Triple:
        """Return 2/5 r^2 about every axis, m^2."""
        value = 0.4 * self.radius**2
        return value, value, value

    def frame(self) -> Floats:
        """Return the given axes."""
        return columns(self.axes)


class Cylinder(Shaped):
    """A homogeneous cylinder; its axis is the body's z."""

    shape: Literal["cylinder"] = Field(default="cylinder", kw_only=True, repr=False)
    radius: Positive = Key("", "m")
    length: Positive = Key("along the axis", "m")
    axis: Direction = Key("direction, global components", default=(0.0, 0.0, 1.0))

    def volume(self) -> float:
        """Return pi r^2 l, m^3."""
        return math.pi * self.radius**2 * self.length

    def gyration(self) -> Triple:
        """Return (3 r^2 + l^2)/12 across the axis, r^2/2 about it, m^2."""
        across = self.radius**2 / 4.0 + self.length**2 / 12.0
        return across, across, self.radius**2 / 2.0

    def frame(self) -> Floats:
        """Return axes with the axis as z."""
        return axes_from(self.axis)[:, [1, 2, 0]]
