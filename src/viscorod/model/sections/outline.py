"""A section of one material with any outline: a polygon with holes."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.materials.material import Material
from viscorod.model.sections.isotropic_section import MaterialSection, required
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
from viscorod.model.sections.polygons import Corners, Holes, Polygon, polygon, refuse_improper
from viscorod.model.sections.saint_venant import SectionAnalysis, analysed
from viscorod.model.sections.section_base import Matrices
from viscorod.model.sections.section_mesh import refuse_misfits
from viscorod.model.sections.stress_field import StressField

__all__ = ["PolygonSection"]


class PolygonSection(MaterialSection):
    """A section with any outline, of one material; torsion and shear by finite elements.

    It needs the package sectionproperties: ``pip install 'viscorod[sections]'``. The shear stiffness is that of the
    strain energy of Saint-Venant's flexure, which depends on Poisson's ratio and on the proportions (for nu = 0 it
    agrees with Cowper's factors).
    """

    can_taper: ClassVar[bool] = False
    shape: Literal["outline"] = Field(default="outline", kw_only=True, repr=False)
    points: Corners = Key("corners in order, once around, [along d1, along d2]; {}", "m")
    holes: Holes = Key("each a list of corners like those of the outline; {}", "m", default=())
    origin: Origin = Key(
        'where the centre line goes through: "centroid", "shear_centre", or "given" (the point [0, 0])',
        default="centroid",
    )
    axes: Axes = Key(AXES, default="given")
    mesh_size: MeshSize = Key(MESH_SIZE, "m", default=None)

    @classmethod
    def from_geometry(
        cls, geometry: Any, *, origin: str = "centroid", axes: str = "given", mesh_size: float | None = None
    ) -> Self:
        """Take the outline of a geometry of the library sectionproperties, such as a steel section; lengths in m.

        Args:
            geometry: a `sectionproperties.pre.Geometry` of one region.
            origin: see the class.
            axes: see the class.
            mesh_size: see the class.

        Raises:
            InputError: the geometry has several regions.
        """
        shape = getattr(geometry, "geom", geometry)
        if getattr(shape, "geom_type", "") != "Polygon":
            raise RefusedError(
                "a geometry with one connected region is needed here",
                "give the regions of a compound geometry to Composite, each with its material",
                found=show(getattr(shape, "geom_type", type(geometry).__name__)),
            )
        return cls(
            list(shape.exterior.coords),
            [list(ring.coords) for ring in shape.interiors],
            origin=origin,
            axes=axes,
            mesh_size=mesh_size,
        )

    @model_validator(mode="after")
    def _usable(self) -> Self:
        refuse_improper(polygon(self.points, self.holes))
        try:
            refuse_misfits(self._polygons)
            self._analysis(0.0)
        except RefusedError as error:
            at = error.at if error.at == ("mesh_size",) else ("points",)
            found = show(list(self.points)) if error.found == "" else error.found
            raise RefusedError(error.why, error.instead, found=found, at=at) from None
        return self

    @property
    def _polygons(self) -> tuple[Polygon, ...]:
        return (polygon(self.points, self.holes),)

    def _analysis(self, nu: float) -> SectionAnalysis:
        """Analyse the section with G = 1 and E = 2 (1 + nu): only their ratio to other regions would matter."""
        return analysed(self._polygons, (2.0 * (1.0 + nu),), (1.0,), nu, self.mesh_size)

    def _parts(self, nu: float) -> Parts:
        youngs = (2.0 * (1.0 + nu),)
        return parts(self._analysis(nu), youngs, (1.0,), (1.0,), origin=self.origin, axes=self.axes)

    @property
    def centres(self) -> SectionPoints:
        """Centroid, shear centre and the origin of the centre line, in the coordinates of `points`, m."""
        return self._parts(0.0).points

    @property
    def outline(self) -> tuple[Polygon, ...]:
        """The polygons about the centre line, along d1 and d2, m."""
        return self.centres.about_line(self._polygons)

    def warping_length(self, material: Material | None = None) -> float | None:
        """See `AnySection.warping_length`."""
        found = self._analysis(0.0 if material is None else material.poissons_ratio)
        return math.sqrt(found.warping * float(found.strains[0, 2, 2]))

    def remarks(self) -> tuple[str, ...]:
        """Describe the mesh and its error."""
        return (meshed_remark(self._analysis(0.0)),)

    def moments(self) -> tuple[float, float, float]:
        """Return the area (m^2) and second moments I1 = <xi2^2>, I2 = <xi1^2> (m^4) about the centre line."""
        extensional, _, _ = self.geometry(0.0)
        return float(extensional[2, 2]), float(extensional[3, 3]), float(extensional[4, 4])

    def torsion(self) -> float:
        """Return Saint-Venant's torsion constant J, m^4."""
        analysis = self._analysis(0.0)
        return float(1.0 / analysis.strains[0, 2, 2])

    def shear_factors(self, poissons_ratio: float) -> tuple[float, float]:
        """Return k1, k2 of the shear stiffnesses without twist about the centre line, k1 G A and k2 G A."""
        extensional, shearing, _ = self.geometry(poissons_ratio)
        area = extensional[2, 2]
        return float(shearing[0, 0] / area), float(shearing[1, 1] / area)

    def geometry(self, poissons_ratio: float) -> Matrices:
        """Return C_E (m^2 to m^4), C_G (likewise) and inertia per density, which follow from the shape, (6, 6) each.

        About the centre line, with the couplings of a tension centre and a shear centre beside it.
        """
        found = self._parts(poissons_ratio)
        return found.extensional[0], found.shearing[0], found.inertia[0]

    def mesh(self, material: Material | None = None) -> KeptMesh:
        """See `AnySection.mesh`."""
        nu = 0.0 if material is None else material.poissons_ratio
        return KeptMesh(self._polygons, self._analysis(nu).side)

    def stress_field(self, material: Material | None = None) -> StressField:
        """Return how the section carries its forces, by finite elements.

        Raises:
            InputError: there is no material.
        """
        material = required(material)
        nu = material.poissons_ratio
        return mesh_field(self._analysis(nu), self._polygons, [material], nu, self._parts(nu).points)
