"""Sections of several viscoelastic materials."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from viscorod.model.fields.definition import Definition, RefusedError, at_key, show
from viscorod.model.fields.forms import listed, named_or, of_kind
from viscorod.model.fields.metadata import TABLES, Accepts, Key, accepts, optional
from viscorod.model.fields.values import Number, choose, items, pair
from viscorod.model.materials.material import Material
from viscorod.model.sections.kept_meshes import KeptMesh
from viscorod.model.sections.mesh_flow import mesh_field
from viscorod.model.sections.meshed_section import (
    AXES,
    MESH_SIZE,
    Axes,
    MeshSize,
    Origin,
    Parts,
    SectionPoints,
    meshed_remark,
    parts,
)
from viscorod.model.sections.polygons import (
    Holes,
    Polygon,
    corners,
    placed,
    polygon,
    polygon_area,
    refuse_improper,
)
from viscorod.model.sections.saint_venant import SectionAnalysis, analysed
from viscorod.model.sections.section_base import SECTION, AnySection, Branches, Matrices
from viscorod.model.sections.section_mesh import refuse_misfits
from viscorod.model.sections.section_shapes import SHAPES, Shape
from viscorod.model.sections.stress_field import StressField
from viscorod.typing import Floats

__all__ = ["Composite", "CompositeRegion"]


@accepts(named_or("material"), "name of a material in quotes, or a table")
def _material(value: Any) -> Material:
    material = value if isinstance(value, Material) else Material.model_validate(value)
    if material.pending:
        raise RefusedError(
            "the damping of a region cannot follow from a mode: the other regions take part in it",
            "give times, a loss factor or another measure of the material itself",
            found=show(material.damping),
            at=("damping",),
        )
    return material


_shape = choose("shape", SHAPES, form=named_or("section"), words=SECTION)


class CompositeRegion(Definition):
    """A part of a composite section, of one material: a polygon or a simple shape, at its place."""

    material: Annotated[Material, _material] = Key("of the region")
    section: Annotated[Shape | None, optional(_shape)] = Key(
        "a circle, annulus, rectangle, ellipse or square tube; or `points`", default=None
    )
    points: Annotated[Sequence[Sequence[float]] | None, optional(corners)] = Key(
        "corners of a polygon in order, once around, [along d1, along d2]; {}; or `section`",
        "m",
        default=None,
    )
    holes: Holes = Key("of the polygon, each a list of corners; {}", "m", default=())
    at: Annotated[Sequence[float], pair] = Key(
        "where the centre of the section, or the origin of the points, lies in the whole section; {}",
        "m",
        default=(0.0, 0.0),
    )
    angle: Number = Key(
        "by which the region is turned about that point, from d1 towards d2; {}", "rad", default=0.0
    )

    @model_validator(mode="after")
    def _one_outline(self) -> Self:
        if (self.section is None) == (self.points is None):
            given = "neither" if self.section is None else "both"
            raise RefusedError(
                "a region has one outline, by section or by points", "give one of the two", found=given
            )
        if self.section is not None and self.holes:
            raise RefusedError(
                "holes belong to an outline given by points",
                "leave holes out, or give points instead of section",
                found=type(self.section).__name__,
                at=("holes",),
            )
        if self.section is not None:
            with at_key("section", self.section):
                _refuse_numbers(self.section)
        else:
            refuse_improper(self._own)
        return self

    @property
    def _own(self) -> Polygon:
        if self.section is not None:
            return self.section.outline[0]
        return polygon(self.points or (), self.holes)

    @property
    def polygon(self) -> Polygon:
        """Outline and holes in the coordinates of the whole section, m."""
        return placed(self._own, self.at, self.angle)


def _refuse_numbers(shape: Shape) -> None:
    """Refuse numbers that replace the formulas of a shape."""
    numbers = (shape.torsion_constant, shape.shear_factor_1, shape.shear_factor_2)
    if any(number is not None for number in numbers):
        raise RefusedError(
            "torsion_constant and shear factors of a part of a section mean nothing for the whole",
            "leave them out",
            found=type(shape).__name__,
        )


def _some_regions(value: Any) -> tuple[Any, ...]:
    regions = items(value)
    if not regions:
        raise RefusedError("a composite section needs at least one region", "give regions")
    return regions


class Composite(AnySection):
    """A section of several bonded materials, each with its own elasticity, viscosity and density.

    It needs the package sectionproperties: ``pip install 'viscorod[sections]'``. The stiffness comes from finite
    elements of Saint-Venant's torsion and flexure with the moduli of every region. The damping is the power that the
    strains of the elastic section dissipate: eta_E times a region's share in extension and bending, eta times its
    share in shear and torsion. In extension, bending and torsion this is the first order of the section's complex
    stiffness in the frequency, since the elastic energy is stationary in the warping; the shear of flexure keeps the
    distribution of the elastic section. Maxwell branches are treated in the same way.
    """

    no_material: ClassVar[str | None] = "the regions of a composite section have their own materials"
    can_taper: ClassVar[bool] = False
    shape: Literal["composite"] = Field(default="composite", kw_only=True, repr=False)
    regions: Annotated[
        Sequence[CompositeRegion],
        BeforeValidator(_some_regions),
        Accepts(listed(of_kind("sections.region"), 1), TABLES),
    ] = Key("the parts, which share edges and do not overlap")
    origin: Origin = Key(
        'where the centre line goes through: "centroid" (the tension centre, weighted by Young\'s '
        'modulus), "shear_centre", or "given" (the point [0, 0])',
        default="centroid",
    )
    axes: Axes = Key(AXES, default="given")
    mesh_size: MeshSize = Key(MESH_SIZE, "m", default=None)

    @model_validator(mode="after")
    def _usable(self) -> Self:
        try:
            refuse_misfits(self._polygons)
            self.matrices()
        except RefusedError as error:
            at = error.at if error.at == ("mesh_size",) else ("regions", *error.at)
            found = f"{len(self.regions)} regions" if error.found == "" else error.found
            raise RefusedError(error.why, error.instead, found=found, at=at) from None
        return self

    @property
    def _polygons(self) -> tuple[Polygon, ...]:
        return tuple(region.polygon for region in self.regions)

    @property
    def _materials(self) -> list[Material]:
        return [region.material for region in self.regions]

    @property
    def _moduli(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        materials = self._materials
        return tuple(m.youngs_modulus for m in materials), tuple(m.shear_modulus for m in materials)

    @property
    def _analysis(self) -> SectionAnalysis:
        """The analysis with Poisson's ratio of the regions, or the mean EA/2GA - 1 where they differ."""
        youngs, shear = self._moduli
        return analysed(self._polygons, youngs, shear, self._flexure_ratio, self.mesh_size)

    @property
    def _flexure_ratio(self) -> float:
        return self._materials[0].poissons_ratio if self._one_ratio else self._mean_ratio

    @property
    def _one_ratio(self) -> bool:
        return len({m.poissons_ratio for m in self._materials}) == 1

    @property
    def _mean_ratio(self) -> float:
        youngs, shear = (np.array(moduli) for moduli in self._moduli)
        areas = np.array([polygon_area(shape) for shape in self._polygons])
        return float(youngs @ areas / (2.0 * (shear @ areas)) - 1.0)

    @cached_property
    def _parts(self) -> Parts:
        densities = [m.inertial_density for m in self._materials]
        return parts(self._analysis, *self._moduli, densities, origin=self.origin, axes=self.axes)

    @property
    def centres(self) -> SectionPoints:
        """Tension centre, shear centre, mass centre and the origin of the centre line, in given coordinates, m."""
        return self._parts.points

    @property
    def outline(self) -> tuple[Polygon, ...]:
        """The polygons about the centre line, along d1 and d2, m."""
        return self.centres.about_line(self._polygons)

    def warping_length(self, material: Material | None = None) -> float | None:
        """See `AnySection.warping_length`."""
        del material
        _, shear = self._moduli
        return math.sqrt(self._analysis.warping * float(shear @ self._analysis.strains[:, 2, 2]))

    def remarks(self) -> tuple[str, ...]:
        """Describe the mesh and its error, and the neglected effects where Poisson's ratios differ."""
        mesh = meshed_remark(self._analysis)
        if self._one_ratio:
            return (mesh,)
        return (
            mesh,
            "its materials differ in Poisson's ratio: the stresses by which they hinder each other's lateral "
            "contraction are neglected",
        )

    def matrices(self, material: Material | None = None) -> Matrices:
        """Return stiffness C, damping D and inertia M per length, (6, 6) each.

        C = sum E_m C_E,m + G_m C_G,m, D = sum eta_E,m C_E,m + eta_m C_G,m over the regions. A material with Maxwell
        branches adds nothing to D; its viscosity is in the :meth:`branch_matrices`.

        Raises:
            InputError: there is a material.
        """
        self.refuse_material(material)
        found = self._parts
        youngs, shear = self._moduli
        viscous = [
            (0.0, 0.0) if m.branches else (m.extensional_viscosity, m.shear_viscosity)
            for m in self._materials
        ]
        stiffness = np.tensordot(youngs, found.extensional, 1) + np.tensordot(shear, found.shearing, 1)
        extension, shearing = np.array(viscous).T
        damping = np.tensordot(extension, found.extensional, 1) + np.tensordot(shearing, found.shearing, 1)
        density = [m.inertial_density for m in self._materials]
        return stiffness, damping, np.tensordot(density, found.inertia, 1)

    def by_material(self, material: Material | None = None) -> list[tuple[Material, Floats, Floats]]:
        """See `AnySection.by_material`: those of the regions, with the warping of the section at rest."""
        del material
        found = self._parts
        return list(zip(self._materials, found.extensional, found.shearing, strict=True))

    def thermal_strain(self, rise: Floats, material: Material | None) -> Floats:
        """See `AnySection.thermal_strain`: its regions hinder each other's expansion along the rod.

        ``C eps = sum E_m alpha_m C_E,m rise``; across it they expand freely, as in all of this theory.
        """
        del material
        stress = sum(
            m.youngs_modulus * m.expansion * part
            for m, part in zip(self._materials, self._parts.extensional, strict=True)
        )
        return np.asarray(np.linalg.solve(self.matrices()[0], stress @ rise))

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials of its regions."""
        return tuple(self._materials)

    @property
    def has_inertia(self) -> bool:
        """Whether the densities of all regions are known."""
        return all(m.has_density for m in self._materials)

    def heat_capacity(self, material: Material | None) -> float | None:
        """Return the heat capacity per length, J/(m K); None where a region's specific heat is not known."""
        del material
        heats = [(m.density, m.specific_heat) for m in self._materials]
        known = [density * heat for density, heat in heats if heat is not None and not math.isnan(density)]
        if len(known) < len(heats):
            return None
        return float(np.tensordot(known, self._parts.inertia, 1)[0, 0])

    def branch_matrices(self, material: Material | None = None) -> Branches:
        """Return Maxwell branches: times (n,), s, and E_j C_E,m + G_j C_G,m (n, 6, 6) of every material's branches.

        Branches of the same time become one. The strains are those of the section at its equilibrium moduli.
        """
        del material
        found = self._parts
        sums: dict[float, Any] = {}
        for index, m in enumerate(self._materials):
            for b in m.branches:
                share = b.youngs_modulus * found.extensional[index] + b.shear_modulus * found.shearing[index]
                sums[b.time] = sums.get(b.time, 0.0) + share
        times = sorted(sums)
        return np.array(times), np.array([sums[time] for time in times]).reshape(-1, 6, 6)

    def mesh(self, material: Material | None = None) -> KeptMesh:
        """See `AnySection.mesh`."""
        del material
        return KeptMesh(self._polygons, self._analysis.side)

    def stress_field(self, material: Material | None = None) -> StressField:
        """Return how the regions carry the forces, by finite elements.

        Raises:
            InputError: there is a material.
        """
        self.refuse_material(material)
        nu = self._flexure_ratio
        return mesh_field(self._analysis, self._polygons, self._materials, nu, self.centres)
