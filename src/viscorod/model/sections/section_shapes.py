"""Cross sections with a known outline.

Shear factors: G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966).
Torsion: S. Timoshenko and J. N. Goodier, Theory of elasticity, chapter 10; Bredt's formula for thin walls.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import OptionalPositive, Positive
from viscorod.model.materials.material import Material
from viscorod.model.sections.isotropic_section import MaterialSection, required
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.polygons import Extent
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.shape_flow import (
    Flow,
    ShapeGrid,
    box_grid,
    elliptic_flow,
    rectangular_flow,
    ring_grid,
    tube_flow,
)
from viscorod.model.sections.stress_field import StressField

__all__ = ["SHAPES", "Annulus", "Circle", "Ellipse", "Rectangle", "Shape", "SquareTube"]

ZETA_5 = 1.0369277551433699263
"""Riemann's zeta(5), for the torsion of the rectangle."""


COWPER = "instead of Cowper's"


class Shape(MaterialSection):
    """A section with a known outline; formulas for torsion and shear may be replaced by given numbers.

    Every shape says its `extent` or, if it is neither ellipse nor box, its `outline`.
    """

    torsion_constant: OptionalPositive = Key("", "m^4", default=None, kw_only=True, repr=False)
    shear_factor_1: OptionalPositive = Key(COWPER, default=None, kw_only=True, repr=False)
    shear_factor_2: OptionalPositive = Key(COWPER, default=None, kw_only=True, repr=False)

    @property
    def area(self) -> float:
        """A, m^2."""
        return self.moments()[0]

    @property
    def second_moment_1(self) -> float:
        """I1 = <xi2^2>, m^4, resists bend_1 (about d1)."""
        return self.moments()[1]

    @property
    def second_moment_2(self) -> float:
        """I2 = <xi1^2>, m^4, resists bend_2 (about d2)."""
        return self.moments()[2]

    def torsion(self) -> float:
        """Return Saint-Venant's torsion constant J, m^4: the given one or the formula's."""
        return self._torsion() if self.torsion_constant is None else self.torsion_constant

    def shear_factors(self, poissons_ratio: float) -> tuple[float, float]:
        """Return the given shear factors, or Cowper's (1966)."""
        if self.shear_factor_1 is not None and self.shear_factor_2 is not None:
            return self.shear_factor_1, self.shear_factor_2
        k1, k2 = self._cowper(poissons_ratio)
        return (
            k1 if self.shear_factor_1 is None else self.shear_factor_1,
            k2 if self.shear_factor_2 is None else self.shear_factor_2,
        )

    def stress_field(self, material: Material | None = None) -> StressField:
        """Return how the section carries its forces: in closed form, or by finite elements over its outline.

        Raises:
            InputError: there is no material, or sectionproperties is missing where the shape has no closed form.
        """
        material = required(material)
        closed = self._flow(material.poissons_ratio)
        if closed is None:
            whole = PolygonSection(*self.outline[0])
            return whole.stress_field(material)
        grid, flow = closed
        rule = grid.samples(grid.points, flow)
        return StressField(
            (material,), rule, grid.weight, grid.patch(flow), lambda points: grid.samples(points, flow)
        )

    def _flow(self, nu: float) -> tuple[ShapeGrid, Flow] | None:
        """Return a grid over the section and its shear stresses under unit forces; None for no closed form."""
        del nu
        return None

    @abstractmethod
    def _torsion(self) -> float: ...

    @abstractmethod
    def _cowper(self, nu: float) -> tuple[float, float]: ...


class Circle(Shape):
    """Solid circle."""

    shape: Literal["circle"] = Field(default="circle", kw_only=True, repr=False)
    radius: Positive = Key("", "m")
    torsion_constant: OptionalPositive = Key(
        "{}, instead of pi r^4/2", "m^4", default=None, kw_only=True, repr=False
    )

    def moments(self) -> tuple[float, float, float]:
        """Return A = pi r^2; I1 = I2 = pi r^4/4."""
        area = math.pi * self.radius**2
        second_moment = math.pi * self.radius**4 / 4.0
        return area, second_moment, second_moment

    @property
    def extent(self) -> Extent:
        """The circle."""
        return Extent(True, (self.radius, self.radius))

    def _flow(self, nu: float) -> tuple[ShapeGrid, Flow] | None:
        return ring_grid((self.radius, self.radius), 0.0), lambda p: tube_flow(p, self.radius, 0.0, nu)

    def _torsion(self) -> float:
        return 2.0 * self.second_moment_1

    def _cowper(self, nu: float) -> tuple[float, float]:
        k = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
        return k, k


class Annulus(Shape):
    """Circular tube."""

    shape: Literal["annulus"] = Field(default="annulus", kw_only=True, repr=False)
    outer_radius: Positive = Key("", "m")
    inner_radius: Positive = Key("{}, less than the outer one", "m")
    torsion_constant: OptionalPositive = Key(
        "{}, instead of the polar moment", "m^4", default=None, kw_only=True, repr=False
    )

    @model_validator(mode="after")
    def _hollow(self) -> Self:
        if self.inner_radius >= self.outer_radius:
            raise RefusedError(
                "the inner radius must be less than the outer one",
                f"give a number below {show(self.outer_radius)}",
                found=show(self.inner_radius),
                at=("inner_radius",),
            )
        return self

    def moments(self) -> tuple[float, float, float]:
        """Return A = pi (R^2 - r^2); I1 = I2 = pi (R^4 - r^4)/4."""
        area = math.pi * (self.outer_radius - self.inner_radius) * (self.outer_radius + self.inner_radius)
        second_moment = area * (self.outer_radius**2 + self.inner_radius**2) / 4.0
        return area, second_moment, second_moment

    @property
    def extent(self) -> Extent:
        """Both circles."""
        return Extent(True, (self.outer_radius,) * 2, (self.inner_radius,) * 2)

    def _flow(self, nu: float) -> tuple[ShapeGrid, Flow] | None:
        outer, inner = self.outer_radius, self.inner_radius
        return ring_grid((outer, outer), inner / outer), lambda p: tube_flow(p, outer, inner, nu)

    def _torsion(self) -> float:
        return 2.0 * self.second_moment_1

    def _cowper(self, nu: float) -> tuple[float, float]:
        m = (self.inner_radius / self.outer_radius) ** 2
        n = (1.0 + m) ** 2
        k = 6.0 * (1.0 + nu) * n / ((7.0 + 6.0 * nu) * n + (20.0 + 12.0 * nu) * m)
        return k, k


class Rectangle(Shape):
    """Solid rectangle."""

    shape: Literal["rectangle"] = Field(default="rectangle", kw_only=True, repr=False)
    width: Positive = Key("along d1", "m")
    height: Positive = Key("along d2", "m")
    torsion_constant: OptionalPositive = Key(
        "{}, instead of the exact series", "m^4", default=None, kw_only=True, repr=False
    )

    def moments(self) -> tuple[float, float, float]:
        """Return A = width height; I1 = width height^3/12; I2 = height width^3/12."""
        area = self.width * self.height
        return area, self.width * self.height**3 / 12.0, self.height * self.width**3 / 12.0

    @property
    def extent(self) -> Extent:
        """The rectangle."""
        return Extent(False, (self.width / 2.0, self.height / 2.0))

    def _flow(self, nu: float) -> tuple[ShapeGrid, Flow] | None:
        a, b = self.width / 2.0, self.height / 2.0
        units = np.array([1.0, 1.0, self._torsion()])
        return box_grid(a, b), lambda p: rectangular_flow(p, a, b, nu) / units

    def _torsion(self) -> float:
        """Return J = a b^3 [1/3 - 64/pi^5 b/a sum tanh(n pi a/2b)/n^5], a >= b, odd n (Timoshenko-Goodier).

        With tanh(x/2) = 1 - 2 exp(-x)/(1 + exp(-x)) and sum 1/n^5 = 31/32 zeta(5) the remaining sum converges
        like exp(-n pi a/b).
        """
        a, b = max(self.width, self.height), min(self.width, self.height)
        decaying = [math.exp(-n * math.pi * a / b) for n in range(1, 15, 2)]
        rest = sum(2.0 * e / (1.0 + e) / n**5 for n, e in zip(range(1, 15, 2), decaying, strict=True))
        return a * b**3 * (1.0 / 3.0 - 64.0 / math.pi**5 * b / a * (31.0 / 32.0 * ZETA_5 - rest))

    def _cowper(self, nu: float) -> tuple[float, float]:
        k = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
        return k, k


class Ellipse(Shape):
    """Solid ellipse."""

    shape: Literal["ellipse"] = Field(default="ellipse", kw_only=True, repr=False)
    semi_axis_1: Positive = Key("half the width along d1", "m")
    semi_axis_2: Positive = Key("half the height along d2", "m")
    torsion_constant: OptionalPositive = Key(
        "{}, instead of pi a^3 b^3/(a^2 + b^2)", "m^4", default=None, kw_only=True, repr=False
    )

    def moments(self) -> tuple[float, float, float]:
        """Return A = pi a b; I1 = pi a b^3/4 with b along d2; I2 = pi a^3 b/4 with a along d1."""
        area = math.pi * self.semi_axis_1 * self.semi_axis_2
        return area, area * self.semi_axis_2**2 / 4.0, area * self.semi_axis_1**2 / 4.0

    @property
    def extent(self) -> Extent:
        """The ellipse."""
        return Extent(True, (self.semi_axis_1, self.semi_axis_2))

    def _flow(self, nu: float) -> tuple[ShapeGrid, Flow] | None:
        a, b = self.semi_axis_1, self.semi_axis_2
        return ring_grid((a, b), 0.0), lambda p: elliptic_flow(p, a, b, nu)

    def _torsion(self) -> float:
        a, b = self.semi_axis_1, self.semi_axis_2
        return math.pi * a**3 * b**3 / (a**2 + b**2)

    def _cowper(self, nu: float) -> tuple[float, float]:
        return (
            _cowper_ellipse((self.semi_axis_1 / self.semi_axis_2) ** 2, nu),
            _cowper_ellipse((self.semi_axis_2 / self.semi_axis_1) ** 2, nu),
        )


class SquareTube(Shape):
    """Square tube with a thin wall.

    Torsion constant (Bredt) and shear factor (Cowper) hold for thin walls; area and second moments are exact.
    """

    shape: Literal["square_tube"] = Field(default="square_tube", kw_only=True, repr=False)
    width: Positive = Key("outer width", "m")
    thickness: Positive = Key("of the wall, {}, less than half the width", "m")
    torsion_constant: OptionalPositive = Key(
        "{}, instead of (width - thickness)^3 thickness", "m^4", default=None, kw_only=True, repr=False
    )

    @model_validator(mode="after")
    def _hollow(self) -> Self:
        if self.thickness >= self.width / 2.0:
            raise RefusedError(
                "the wall must be thinner than half the width, or nothing is left of the hole",
                f"give a number below {show(self.width / 2.0)}, or use shape = 'rectangle'",
                found=show(self.thickness),
                at=("thickness",),
            )
        return self

    def moments(self) -> tuple[float, float, float]:
        """Return A = 4 t (w - t); I1 = I2 = (w^4 - h^4)/12 with the hole's width h."""
        area = 4.0 * self.thickness * (self.width - self.thickness)
        hole = self.width - 2.0 * self.thickness
        second_moment = area * (self.width**2 + hole**2) / 12.0
        return area, second_moment, second_moment

    @property
    def extent(self) -> Extent:
        """Both squares."""
        hole = (self.width - 2.0 * self.thickness) / 2.0
        return Extent(False, (self.width / 2.0,) * 2, (hole, hole))

    def remarks(self) -> tuple[str, ...]:
        """Warn of thick walls."""
        if self.thickness <= 0.1 * self.width or self.torsion_constant is not None:
            return ()
        return (
            "the wall of the square tube is thicker than a tenth of its width: the thin-wall formulas are "
            "rough; give torsion_constant, shear_factor_1 and shear_factor_2",
        )

    def _torsion(self) -> float:
        return (self.width - self.thickness) ** 3 * self.thickness

    def _cowper(self, nu: float) -> tuple[float, float]:
        k = 20.0 * (1.0 + nu) / (48.0 + 39.0 * nu)
        return k, k


def _cowper_ellipse(n: float, nu: float) -> float:
    """Return Cowper's factor for shear along the semi-axis a, n = (a/b)^2."""
    return 12.0 * (1.0 + nu) * n * (3.0 * n + 1.0) / ((40.0 + 37.0 * nu) * n**2 + (16.0 + 10.0 * nu) * n + nu)


SHAPES: dict[str, type[AnySection]] = {
    "circle": Circle,
    "annulus": Annulus,
    "rectangle": Rectangle,
    "ellipse": Ellipse,
    "square_tube": SquareTube,
}
"""The shapes by their word in a case file; a new one is one class and one line here, or ``SHAPES["word"] = Kind``."""
