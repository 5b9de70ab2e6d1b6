"""6x6 matrices of an analysed section about the centre line and along the axes that the user wants.

A strain eps' = (Gamma', kappa') taken about the point p of the section and along axes turned by the angle a is the
same deformation as eps about the origin along the first axes. With R = [d1' d2' d3'] in components of d1, d2, d3,

    Gamma' + kappa' x (xi - p) is the strain of the point xi, so    Gamma = R Gamma' + p x R kappa',  kappa = R kappa',

    eps = X eps',    X = [[R, p~ R], [0, R]],    and    C' = X^T C X

since the energy 1/2 eps.C eps does not change. Velocities go as strains do, so D, M and branches are moved likewise.
About the tension centre extension and bending are uncoupled; a shear centre elsewhere couples shear and twist.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from viscorod.model.fields.definition import show
from viscorod.model.fields.metadata import optional
from viscorod.model.fields.values import one_of, positive
from viscorod.model.sections.polygons import Polygon, placed
from viscorod.model.sections.saint_venant import SectionAnalysis
from viscorod.quantity_text import per_cent
from viscorod.typing import Floats

__all__ = [
    "AXES",
    "MESH_SIZE",
    "Axes",
    "MeshSize",
    "Origin",
    "Parts",
    "SectionPoints",
    "meshed_remark",
    "moved",
    "parts",
]

Origin = Annotated[str, one_of("centroid", "shear_centre", "given")]
Axes = Annotated[str, one_of("given", "principal")]
MeshSize = Annotated[float | None, optional(positive)]

AXES = (
    '"given", or "principal": d1 and d2 turned into the principal axes of bending, d1 the nearer to the first'
)
MESH_SIZE = (
    "side of the largest triangles, {}; left out, they are refined until the stiffnesses stay within 0.2 %"
)
"""What these two mean, for all sections with a mesh."""


@dataclass(frozen=True)
class SectionPoints:
    """Points of a section in the coordinates in which its outline was given, m.

    Attributes:
        origin: point where the rod's centre line passes through the section.
        tension_centre: where an axial force stretches without bending; the centroid, weighted by E.
        shear_centre: where a shear force bends without twist (Trefftz).
        mass_centre: weighted by density.
        angle: of the section's d1 against the first given axis, rad.
    """

    origin: tuple[float, float]
    tension_centre: tuple[float, float]
    shear_centre: tuple[float, float]
    mass_centre: tuple[float, float]
    angle: float

    def about_line(self, polygons: Sequence[Polygon]) -> tuple[Polygon, ...]:
        """Return polygons in given coordinates about the centre line, along d1 and d2, m."""
        x, y = self.origin
        centred = (placed(polygon, (-x, -y), 0.0) for polygon in polygons)
        return tuple(placed(polygon, (0.0, 0.0), -self.angle) for polygon in centred)


@dataclass(frozen=True)
class Parts:
    """The matrices of every region of a section per modulus or density, (r, 6, 6) each.

    C = sum (E_m extensional_m + G_m shearing_m), M = sum rho_m inertia_m.
    """

    extensional: Floats
    shearing: Floats
    inertia: Floats
    points: SectionPoints


def parts(
    analysis: SectionAnalysis,
    youngs: Sequence[float],
    shear: Sequence[float],
    density: Sequence[float],
    *,
    origin: str,
    axes: str,
) -> Parts:
    """Return the matrices of every region about the wanted origin and axes.

    Args:
        analysis: of regions with these moduli.
        youngs: Young's modulus of every region, Pa.
        shear: shear modulus of every region, Pa.
        density: of every region, kg/m^3.
        origin: "centroid" (the tension centre), "shear_centre" or "given" (the origin of the outline's coordinates).
        axes: "given", or "principal" (of bending about the tension centre; d1 the one within 45 degrees of the
            first given axis).
    """
    compliance = np.einsum("r,rij->ij", np.array(shear), analysis.strains)
    stiffness = np.linalg.inv(compliance)
    held = stiffness @ analysis.strains @ stiffness
    # a torque-free shear force at the offset s from the origin twists by s x N, so that F[i, 2]/F[2, 2] is -(s x e_i)
    shear_centre = np.array([-compliance[1, 2], compliance[0, 2]]) / compliance[2, 2]

    area, x, y, xx, yy, xy = analysis.moments.T
    weight = np.array(youngs)
    angle = 0.0
    if axes == "principal":
        i1, i2, product = weight @ yy, weight @ xx, weight @ xy
        if math.hypot(i2 - i1, 2.0 * product) > 1e-9 * (i1 + i2):
            angle = _within_45_degrees(0.5 * math.atan2(2.0 * product, i2 - i1))
    offset = {
        "centroid": np.zeros(2),
        "shear_centre": shear_centre,
        "given": -analysis.centre,
    }[origin]
    mass = np.array(density)
    mass_centre = np.array([mass @ x, mass @ y]) / (mass @ area)
    centre = analysis.centre
    points = SectionPoints(
        _pair(centre + offset),
        _pair(centre),
        _pair(centre + shear_centre),
        _pair(centre + mass_centre),
        angle,
    )
    return Parts(
        moved(_extensional(analysis.moments), offset, angle),
        moved(_shearing(held), offset, angle),
        moved(_inertia(analysis.moments), offset, angle),
        points,
    )


def moved(matrix: Floats, offset: Floats, angle: float) -> Floats:
    """Return C' = X^T C X about the point `offset` (2,), m, along axes turned by `angle`, rad; see the module.

    Args:
        matrix: symmetric (..., 6, 6) about the origin: stiffness, damping or inertia.
        offset: the new origin in the old coordinates.
        angle: from d1 towards d2.
    """
    x, y = offset
    tilde = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    turn = np.array(
        [[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    shift = np.block([[turn, tilde @ turn], [np.zeros((3, 3)), turn]])
    result: Floats = shift.T @ matrix @ shift
    return (result + np.swapaxes(result, -1, -2)) / 2.0


def meshed_remark(analysis: SectionAnalysis) -> str:
    """Return one sentence on the mesh and its error."""
    error = (
        ""
        if math.isnan(analysis.error)
        else f"; halving the triangles changed the stiffnesses by {per_cent(100.0 * analysis.error)}"
    )
    return (
        f"torsion and shear of its section come from {analysis.triangles} triangles of at most "
        f"{show(float(f'{analysis.side:.3g}'))} m{error}"
    )


def _within_45_degrees(angle: float) -> float:
    quarter = math.pi / 2.0
    return angle - quarter * round(angle / quarter)


def _pair(point: Floats) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _extensional(moments: Floats) -> Floats:
    """Return int h h^T with e33 = h.eps, h = (0, 0, 1, y, -x, 0)."""
    area, x, y, xx, yy, xy = moments.T
    matrix = np.zeros((len(moments), 6, 6))
    matrix[:, 2:5, 2:5] = np.moveaxis(np.array([[area, y, -x], [y, yy, -xy], [-x, -xy, xx]]), -1, 0)
    return matrix


def _shearing(held: Floats) -> Floats:
    matrix = np.zeros((len(held), 6, 6))
    matrix[np.ix_(range(len(held)), (0, 1, 5), (0, 1, 5))] = held
    return matrix


def _inertia(moments: Floats) -> Floats:
    """Return int P^T P with the velocity P (v, w) = v + w x xi of a point."""
    area, x, y, xx, yy, xy = moments.T
    zero = np.zeros_like(area)
    rows = [
        [area, zero, zero, zero, zero, -y],
        [zero, area, zero, zero, zero, x],
        [zero, zero, area, y, -x, zero],
        [zero, zero, y, yy, -xy, zero],
        [zero, zero, -x, -xy, xx, zero],
        [-y, x, zero, zero, zero, xx + yy],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
