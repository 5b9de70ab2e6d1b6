"""Base class of cross sections: matrices per length, and the largest distance from the centre line."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, TypeAlias

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.materials.material import Material
from viscorod.model.sections.kept_meshes import KeptMesh
from viscorod.model.sections.polygons import Extent, Polygon
from viscorod.model.sections.stress_field import StressField
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

__all__ = ["SECTION", "AnySection", "Branches", "Matrices"]

SECTION = "name of a section in quotes, or a table with `shape`"
"""A section in a case file, in words."""

Matrices: TypeAlias = tuple[Floats, Floats, Floats]
Branches: TypeAlias = tuple[Floats, Floats]


class AnySection(Definition):
    """A cross section in the plane of d1 and d2.

    The order is (shear_1, shear_2, stretch, bend_1, bend_2, twist) in C and D, (v1, v2, v3, w1, w2, w3) in M.
    """

    tag: ClassVar[str | None] = "shape"

    #: Why the section takes no `Material` from its rod; None where it needs one.
    no_material: ClassVar[str | None] = None
    #: Whether a section between two such sections can be had by changing every dimension linearly.
    can_taper: ClassVar[bool] = True

    @property
    def needs_material(self) -> bool:
        """Whether stiffness, damping and inertia come from a `Material` given beside the section."""
        return self.no_material is None

    @property
    def has_inertia(self) -> bool:
        """Whether its inertia is known, but for the density of a material beside it; nothing moves without."""
        return True

    def refuse_material(self, material: Material | None) -> None:
        """Refuse a material beside a section that takes none.

        Raises:
            InputError: there is one.
        """
        if material is not None and self.no_material is not None:
            raise InputError(Fault("material", "", self.no_material, "leave material out"))

    @property
    def extent(self) -> Extent | None:
        """The ellipse or box that the section is; None for other shapes."""
        return None

    @property
    def outline(self) -> tuple[Polygon, ...]:
        """Outlines of its regions about the centre line, along d1 and d2, m; none where they are not known."""
        return () if self.extent is None else (self.extent.polygon,)

    @property
    def half_width(self) -> float | None:
        """Largest distance of a point of the section from the centre line, m; None where it is not known."""
        if self.extent is not None:
            return self.extent.reach
        corners = [corner for outer, _ in self.outline for corner in outer]
        return max((math.hypot(*corner) for corner in corners), default=None)

    def _drawing(self) -> str:
        drawing = Drawing()
        drawing.area(
            np.array(ring, dtype=float) for region in self.outline for ring in (region[0], *region[1])
        )
        return drawing.svg()

    def warping_length(self, material: Material | None = None) -> float | None:
        """Return over which length from an end that holds its warping a rod resists torsion by it, m.

        It is sqrt(E I_w/(G J)) (V. Z. Vlasov, Thin-walled elastic beams, 1961); None where it is not known.
        """
        del material
        return None

    def remarks(self) -> tuple[str, ...]:
        """Return remarks about the formulas used for this section."""
        return ()

    def mesh(self, material: Material | None = None) -> KeptMesh | None:
        """Return what its mesh is made of; None where it has none."""
        del material
        return None

    def stress_field(self, material: Material | None = None) -> StressField:
        """Return how the section carries its forces, from which stresses at its points follow.

        Raises:
            InputError: its points are not known, or have no material.
        """
        del material
        raise InputError(
            Fault(
                "section",
                type(self).__name__,
                "a section given by numbers has no points, so that no stress is known there",
                "describe it by its shape (circle, rectangle, ..., outline or composite) for stresses",
            )
        )

    def thermal_strain(self, rise: Floats, material: Material | None) -> Floats:
        """Return the strains (6,) of a free section that is warmer, here by one material's expansion.

        Args:
            rise: of the temperature as ``(0, 0, T, dT/dxi2, -dT/dxi1, 0)`` (6,), in K and K/m: a linear field.
            material: of the section, if it needs one.

        Raises:
            RefusedError: its thermal expansion is not known.
        """
        if material is None:
            raise RefusedError(
                f"{type(self).__name__} has no material, so that its thermal expansion is not known",
                "give value",
                found="",
                at=("temperature",),
            )
        return material.expansion * rise

    @property
    def materials(self) -> tuple[Material, ...]:
        """Materials of its own, beside that of its rod."""
        return ()

    def by_material(self, material: Material | None) -> list[tuple[Material, Floats, Floats]]:
        """Return every material with its C_E and C_G: the stiffness is the sum of ``E C_E + G C_G``, (6, 6) each.

        Nothing where the stiffness is given by numbers.
        """
        del material
        return []

    def heat_capacity(self, material: Material | None) -> float | None:
        """Return the heat capacity per length, J/(m K); None where a specific heat is not known."""
        if material is None or material.specific_heat is None or not material.has_density:
            return None
        return float(self.matrices(material)[2][0, 0]) * material.specific_heat

    @abstractmethod
    def matrices(self, material: Material | None = None) -> Matrices:
        """Return stiffness C (N, N m, N m^2), damping D (the same times s), inertia M (kg/m, kg, kg m), (6, 6) each."""

    @abstractmethod
    def branch_matrices(self, material: Material | None = None) -> Branches:
        """Return Maxwell branches: relaxation times (n,), s, and their stiffnesses (n, 6, 6)."""
