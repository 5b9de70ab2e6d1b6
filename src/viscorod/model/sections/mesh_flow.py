"""Shear stresses of a meshed section: outlines, composites, and shapes without a closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.model.materials.material import Material
from viscorod.model.sections.meshed_section import SectionPoints
from viscorod.model.sections.polygons import Polygon
from viscorod.model.sections.saint_venant import POINTS, SectionAnalysis, ShearFields, meshed
from viscorod.model.sections.shape_flow import refuse_outside
from viscorod.model.sections.stress_field import SectionPatch, SectionSamples, StressField
from viscorod.typing import Floats, Integers

__all__ = ["mesh_field"]

INSIDE = -1e-7
"""Area coordinate below which a point is not in a triangle."""
CHUNK = 4_000_000
"""Pairs of points and triangles that are looked at at once."""
CORNERS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]], dtype=float
)
PARTS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
"""Nodes of a triangle in area coordinates, and the four triangles between them."""


def mesh_field(
    analysis: SectionAnalysis,
    polygons: tuple[Polygon, ...],
    materials: Sequence[Material],
    nu: float,
    centres: SectionPoints,
) -> StressField:
    """Return how a meshed section carries its forces.

    Args:
        analysis: of the section; its mesh is made again.
        polygons: of the regions, in given coordinates, m.
        materials: of the regions.
        nu: Poisson's ratio of the lateral contraction in flexure.
        centres: where the centre line goes through, and the angle of d1.
    """
    youngs, shear = (
        np.array([getattr(m, name) for m in materials]) for name in ("youngs_modulus", "shear_modulus")
    )
    mesh = meshed(polygons, analysis.side)
    fields = ShearFields(mesh, analysis.centre, youngs, shear, nu)
    origin, (c, s) = np.array(centres.origin), (np.cos(centres.angle), np.sin(centres.angle))
    turn = np.array([[c, -s], [s, c]])
    offset = origin - analysis.centre
    # a force along d1, d2 at the centre line is one at the tension centre with a torque about it
    forces = np.zeros((3, 3))
    forces[:2, :2] = turn
    forces[2] = [*(offset[0] * turn[1] - offset[1] * turn[0]), 1.0]

    def samples(points: Floats, triangles: Integers, strains: Floats) -> SectionSamples:
        region = mesh.region[triangles]
        flow = shear[region][:, None, None] * np.einsum("ad,nak,kj->ndj", turn, strains, forces)
        return SectionSamples((points - origin) @ turn, region, flow)

    def placed(triangles: Integers, places: Floats) -> SectionSamples:
        points = np.einsum("nc,ncd->nd", places, mesh.points[mesh.triangles[triangles, :3]])
        return samples(points, triangles, fields.at(triangles, places))

    def at(points: Floats) -> SectionSamples:
        triangles, places = _located(mesh.points[mesh.triangles[:, :3]], points @ turn.T + origin)
        refuse_outside(points, triangles >= 0)
        return placed(triangles, places)

    count = len(mesh.triangles)
    every = np.arange(count)
    rule = placed(np.repeat(every, len(POINTS)), np.tile(POINTS, (count, 1)))
    corners = placed(np.repeat(every, len(CORNERS)), np.tile(CORNERS, (count, 1)))
    triangles = (len(CORNERS) * every[:, None, None] + PARTS).reshape(-1, 3)
    weight = fields.rule.weight.ravel() * fields.length**2
    return StressField(tuple(materials), rule, weight, SectionPatch(corners, triangles), at)


def _located(corners: Floats, points: Floats) -> tuple[Integers, Floats]:
    """Return the triangle of each point (n,), -1 for none, and its area coordinates there (n, 3).

    Args:
        corners: of the triangles (m, 3, 2); points: (n, 2).
    """
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    found, places = np.empty(len(points), dtype=np.int64), np.empty((len(points), 3))
    step = max(1, CHUNK // len(corners))
    for first in range(0, len(points), step):
        part = slice(first, first + step)
        d = points[part, None] - corners[:, 0]
        b = (d[..., 0] * v[:, 1] - d[..., 1] * v[:, 0]) / double
        c = (u[:, 0] * d[..., 1] - u[:, 1] * d[..., 0]) / double
        least = np.minimum(np.minimum(b, c), 1.0 - b - c)
        best = np.argmax(least, axis=1)
        rows = np.arange(len(best))
        b, c = b[rows, best], c[rows, best]
        places[part] = np.stack([1.0 - b - c, b, c], axis=-1)
        found[part] = np.where(least[rows, best] >= INSIDE, best, -1)
    return found, places
