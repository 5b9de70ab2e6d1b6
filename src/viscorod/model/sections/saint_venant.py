"""Saint-Venant's torsion and flexure of a section of one or several isotropic materials, by finite elements.

The section lies in the plane of d1 (x) and d2 (y). Its points have the strains (LLT 12-19, with warping w)

    e33 = stretch + bend_1 y - bend_2 x
    (2 e31, 2 e32) = (shear_1 - twist y, shear_2 + twist x) + grad w

and the stresses E e33, G (2 e31, 2 e32). Torsion: w makes the shear stress divergence-free with no traction on
the boundary. Flexure: under shear forces (N1, N2) the curvatures change along the rod, B q' = (0, N2, -N1) with
the 3x3 stiffness B of (stretch, bend_1, bend_2), so that the shear stress t balances

    div t + E (q' . (1, y, -x)) = 0,    t = G (grad w - nu g),    t.n = 0 on the boundary,

where nu g is the lateral contraction that q' lets grow along the rod,

    g = (q1' x + q2' x y - q3' (x^2 - y^2)/2,  q1' y + q2' (y^2 - x^2)/2 - q3' x y).

(A. E. H. Love, Mathematical theory of elasticity, chapter XV; W. D. Pilkey, Analysis and design of elastic beams,
2002, chapters 5 and 6, the formulation of sectionproperties too.) With forces N1, N2 that exert no torque about the
origin and a torque T there are three stress fields t^i, and the shear strains they make give

    P_m[i, j] = int over material m of t^i . t^j / G^2,

so that F = sum G_m P_m is the compliance of (shear_1, shear_2, twist) under (N1, N2, T), and K = F^-1 their
stiffness. K P_m K is the part of the stiffness that material m holds, per its shear modulus: the shear centre's
offset is in the couplings. Forces in proportion to their shares (extension, bending: the moments of the regions)
then give damping and Maxwell branches of the section as sums over its materials.

The library's own warping analysis is not used: it weights shear with Young's modulus and one mean Poisson's ratio, and
returns only the sum over all materials. For one material both agree (tests/unit/test_composite_sections.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from viscorod.model.sections.kept_meshes import KeptMesh, kept_mesh, mesh_of
from viscorod.model.sections.polygons import Polygon
from viscorod.model.sections.section_mesh import SectionMesh, first_size
from viscorod.typing import Floats, Integers

__all__ = ["POINTS", "SectionAnalysis", "ShearFields", "analysed", "area_moments", "meshed", "shear_shares"]

ACCURACY = 2e-3
"""Refinement ends when the shear and torsion stiffnesses change by less than this fraction."""
ENOUGH = 10_000
"""Triangles beyond which the mesh is not refined further."""


@dataclass(frozen=True)
class SectionAnalysis:
    """Results that follow from the shape and the ratios of the moduli, about the tension centre along the given axes.

    Attributes:
        centre: tension centre (2,), where an axial force stretches without bending, in the given coordinates, m.
        moments: of every region (r, 6): int of 1, x, y, x^2, y^2, x y, m^2 to m^4.
        strains: P of every region (r, 3, 3): int of products of the shear strains under unit forces along d1, d2
            and a unit torque; 1/N^2 m^2 times m^0 to m^-2.
        warping: int of E w^2 with the warping w of a unit twist, freed of stretch and bending; N m^4.
        triangles: number of triangles; side: of the largest, m.
        error: change of the largest relative entry against the mesh before; NaN for a given mesh size.
    """

    centre: Floats
    moments: Floats
    strains: Floats
    warping: float
    triangles: int
    side: float
    error: float


def analysed(
    polygons: tuple[Polygon, ...],
    youngs: tuple[float, ...],
    shear: tuple[float, ...],
    nu: float,
    side: float | None,
) -> SectionAnalysis:
    """Analyse regions of the given moduli, Pa, on a mesh that is refined until the stiffnesses stay, or is kept.

    Args:
        polygons: of the regions, m.
        youngs: Young's modulus of every region.
        shear: shear modulus of every region.
        nu: Poisson's ratio of the lateral contraction in flexure.
        side: of the triangles, m; None refines automatically.

    Raises:
        RefusedError: the given side makes too many triangles, or a kept mesh does not suit.
    """
    return _analysed(polygons, youngs, shear, nu, side, kept_mesh(polygons))


@lru_cache(maxsize=256)
def _analysed(
    polygons: tuple[Polygon, ...],
    youngs: tuple[float, ...],
    shear: tuple[float, ...],
    nu: float,
    side: float | None,
    kept: KeptMesh | None,
) -> SectionAnalysis:
    moduli = np.array(youngs), np.array(shear)
    if kept is not None:
        side = kept.side
    if side is not None:
        return _once(polygons, *moduli, nu, side)
    side = first_size(polygons)
    coarse = _once(polygons, *moduli, nu, side)
    while coarse.triangles < ENOUGH:
        side /= 2.0
        fine = _once(polygons, *moduli, nu, side)
        before, after = (np.einsum("r,rii->i", moduli[1], x.strains) for x in (coarse, fine))
        change = float(np.abs(before / after - 1.0).max())
        coarse = replace(fine, error=change)
        if change < ACCURACY:
            break
    return coarse


def _once(
    polygons: tuple[Polygon, ...], youngs: Floats, shear: Floats, nu: float, side: float
) -> SectionAnalysis:
    mesh = meshed(polygons, side)
    first = area_moments(mesh, np.zeros(2))
    stiffness = youngs @ first
    centre = stiffness[1:3] / stiffness[0]
    moments = area_moments(mesh, centre)
    fields = ShearFields(mesh, centre, youngs, shear, nu)
    return SectionAnalysis(
        centre, moments, fields.shares(), fields.warping_stiffness(), len(mesh.triangles), side, math.nan
    )


def meshed(polygons: tuple[Polygon, ...], side: float) -> SectionMesh:
    """Return the mesh of regions with triangles of this side, m, or the one that is kept for them."""
    return _meshed(polygons, side, kept_mesh(polygons))


_meshed = lru_cache(maxsize=32)(mesh_of)


def area_moments(mesh: SectionMesh, about: Floats) -> Floats:
    """Integrate 1, x, y, x^2, y^2, x y over every region (r, 6) about a point (2,)."""
    rule = _Rule(mesh, about)
    x, y = rule.x, rule.y
    parts = np.stack([np.ones_like(x), x, y, x**2, y**2, x * y], axis=-1)
    per_triangle = (rule.weight[:, None] @ parts)[:, 0]
    regions = int(mesh.region.max()) + 1
    return np.stack([np.bincount(mesh.region, column, regions) for column in per_triangle.T], axis=-1)


class ShearFields:
    """Shear strains of a meshed section under unit forces and a unit torque at its tension centre; see the module.

    Lengths are scaled by the size of the section inside, moduli by the largest.

    Args:
        mesh: of the section; about: the tension centre (2,), m.
        youngs, shear: moduli of every region, Pa; nu: Poisson's ratio of the lateral contraction in flexure.
    """

    def __init__(self, mesh: SectionMesh, about: Floats, youngs: Floats, shear: Floats, nu: float) -> None:
        self.mesh, self.about, self.nu = mesh, about, nu
        self._regions = len(youngs)
        self.length = float(np.sqrt(area_moments(mesh, about)[:, 0].sum()))
        self.top = float(shear.max())
        e, g = youngs[mesh.region] / self.top, shear[mesh.region] / self.top
        scaled = SectionMesh((mesh.points - about) / self.length, mesh.triangles, mesh.region)
        self.rule = rule = _Rule(scaled, np.zeros(2))
        x, y = rule.x, rule.y
        stretched, sheared = ((modulus[:, None] * rule.weight)[..., None] for modulus in (e, g))

        # B q' = (0, N2, -N1): B from the moduli and moments, columns q' for N1 = 1 and N2 = 1
        axial = np.stack([np.ones_like(x), y, -x], axis=-1)
        bending = axial.reshape(-1, 3).T @ (stretched * axial).reshape(-1, 3)
        self._axial = e, axial, bending
        self._rates = np.linalg.solve(bending, np.array([[0.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]))
        given = self._given(x, y)
        source = np.concatenate([axial @ self._rates, np.zeros((*x.shape, 1))], axis=-1)
        load = rule.values.T @ (stretched * source) - rule.gradients @ _joined(sheared[..., None] * given)
        self._warping = _solved(rule, g, load)
        self._combined = np.eye(3)
        strains = self._strains(given, np.arange(len(mesh.triangles)), rule.slopes)
        # torque of each field about the origin; the forces' fields are freed of theirs by torsion
        moment = x[..., None] * strains[:, :, 1] - y[..., None] * strains[:, :, 0]
        torque = (sheared * moment).sum(axis=(0, 1))
        self._combined[2] = [-torque[0] / torque[2], -torque[1] / torque[2], 1.0 / torque[2]]
        self.fields = strains @ self._combined

    def shares(self) -> Floats:
        """Return the strains P of every region ``(r, 3, 3)``; see the module."""
        weighted = _joined(self.rule.weight[..., None, None] * self.fields)
        products = weighted.swapaxes(1, 2) @ _joined(self.fields)
        shares = np.zeros((self._regions, 3, 3))
        np.add.at(shares, self.mesh.region, products)
        scale = 1.0 / np.array([1.0, 1.0, self.length])
        return np.asarray(shares * np.outer(scale, scale) / self.length**2 / self.top**2)

    def warping_stiffness(self) -> float:
        """Return int of E w^2 of a unit twist about the shear centre, N m^4 (Vlasov's sectorial moment of inertia)."""
        e, axial, bending = self._axial
        w = self._warping[self.mesh.triangles, 2] @ self.rule.values.T
        weight = e[:, None] * self.rule.weight
        by = np.einsum("mq,mqi,mq->i", weight, axial, w)
        free = float(np.sum(weight * w**2) - by @ np.linalg.solve(bending, by))
        return max(free, 0.0) * self.top * self.length**6

    def _given(self, x: Floats, y: Floats) -> Floats:
        """Return the strains without warping (..., 2, 3): lateral contraction in flexure, rotation in torsion."""
        spread = np.stack(
            [
                np.stack([x, y], axis=-1),
                np.stack([x * y, (y**2 - x**2) / 2.0], axis=-1),
                np.stack([-(x**2 - y**2) / 2.0, -x * y], axis=-1),
            ],
            axis=-1,
        )
        turned = np.stack([-y, x], axis=-1)[..., None]
        return np.concatenate([-self.nu * spread @ self._rates, turned], axis=-1)

    def _strains(self, given: Floats, triangles: Integers, slopes: Floats) -> Floats:
        """Return the strains (n, q, 2, 3) in triangles (n,), at q points each, with warping."""
        nodes = self.mesh.triangles[triangles]
        warped = _joined(slopes.swapaxes(2, 3)) @ self._warping[nodes]
        found: Floats = given + warped.reshape(given.shape)
        return found @ self._combined

    def at(self, triangles: Integers, places: Floats) -> Floats:
        """Return the strains (n, 2, 3) in triangles (n,) at area coordinates (n, 3), 1/(Pa m^2) and 1/(Pa m^3)."""
        points = np.einsum("nc,ncd->nd", places, self.mesh.points[self.mesh.triangles[triangles, :3]])
        x, y = ((points - self.about) / self.length).T
        edges = self.rule.edge_slopes[triangles]
        slopes = np.einsum("nac,ncd->nad", _slopes(places), edges)[:, None]
        return self.physical(self._strains(self._given(x, y)[:, None], triangles, slopes)[:, 0])

    def physical(self, fields: Floats) -> Floats:
        """Return scaled strains (..., 3) in 1/(Pa m^2), and 1/(Pa m^3) for the torque."""
        scale = np.array([1.0, 1.0, 1.0 / self.length]) / self.length**2 / self.top
        return np.asarray(fields * scale)


def shear_shares(mesh: SectionMesh, about: Floats, youngs: Floats, shear: Floats, nu: float) -> Floats:
    """Return the strains P of every region (r, 3, 3) under unit forces and torque at the point `about`; see the module.

    `about` is the tension centre.
    """
    return ShearFields(mesh, about, youngs, shear, nu).shares()


class _Rule:
    """Integration points of six-noded triangles: weights (m, 6), positions, shape functions and their slopes.

    ``edge_slopes (m, 3, 2)`` are the gradients of the area coordinates, ``slopes (m, 6, 6, 2)`` those of the shape
    functions at the points, and ``gradients (m, 6, 12)`` the same with points and directions in one row: products of
    matrices take a tenth of the time of sums over five indices.
    """

    def __init__(self, mesh: SectionMesh, about: Floats) -> None:
        corners = mesh.points[mesh.triangles[:, :3]] - about
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        double = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        self.nodes, self.size = mesh.triangles, len(mesh.points)
        self.weight = 0.5 * np.abs(double)[:, None] * WEIGHTS
        self.x, self.y = np.einsum("qc,mcd->dmq", POINTS, corners)
        edges = np.stack([v - u, -v, u], axis=1)  # opposite to each corner
        slopes = np.stack([-edges[:, :, 1], edges[:, :, 0]], axis=-1) / double[:, None, None]
        self.edge_slopes = slopes
        self.values = _values(POINTS)

    @cached_property
    def slopes(self) -> Floats:
        found = _slopes(POINTS).reshape(-1, 3) @ self.edge_slopes
        return np.asarray(found.reshape(-1, len(POINTS), 6, 2))

    @cached_property
    def gradients(self) -> Floats:
        return _joined(self.slopes.swapaxes(2, 3)).swapaxes(1, 2)


def _joined(fields: Floats) -> Floats:
    """Return fields ``(m, q, d, k)`` with points and directions as one index ``(m, q d, k)``."""
    return fields.reshape(len(fields), -1, fields.shape[-1])


def _solved(rule: _Rule, modulus: Floats, load: Floats) -> Floats:
    """Solve for the warping (n, k) under the element loads (m, 6, k), with one node held against constant warping."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    weight = np.repeat(modulus[:, None] * rule.weight, 2, axis=1)[:, None]
    stiffness = (weight * rule.gradients) @ rule.gradients.swapaxes(1, 2)
    rows, columns = np.repeat(rule.nodes, 6, axis=1).ravel(), np.tile(rule.nodes, (1, 6)).ravel()
    matrix = coo_matrix((stiffness.ravel(), (rows, columns)), shape=(rule.size, rule.size)).tocsc()
    right = np.zeros((rule.size, load.shape[2]))
    np.add.at(right, rule.nodes, load)
    warping = np.zeros_like(right)
    factors = splu(matrix[1:, 1:], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    warping[1:] = factors.solve(right[1:])
    return warping


def _dunavant() -> tuple[Floats, Floats]:
    """Return six points that integrate polynomials of degree 4 over a triangle (Dunavant 1985), in area coordinates."""
    root = math.sqrt(38.0 - 44.0 * math.sqrt(2.0 / 5.0))
    near, far = ((8.0 - math.sqrt(10.0) + sign * root) / 18.0 for sign in (1.0, -1.0))
    big, small = (
        (620.0 + sign * math.sqrt(213125.0 - 53320.0 * math.sqrt(10.0))) / 3720.0 for sign in (1.0, -1.0)
    )
    points = [np.roll([1.0 - 2.0 * a, a, a], k) for a in (near, far) for k in range(3)]
    return np.array(points), np.array([big] * 3 + [small] * 3)


POINTS, WEIGHTS = _dunavant()


def _values(points: Floats) -> Floats:
    """Return the quadratic shape functions (q, 6) at points in area coordinates (q, 3)."""
    a, b, c = points.T
    return np.stack(
        [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a], axis=-1
    )


def _slopes(points: Floats) -> Floats:
    """Return derivatives (q, 6, 3) of the shape functions by the area coordinates."""
    a, b, c = points.T
    zero = np.zeros_like(a)
    return np.stack(
        [
            np.stack([4 * a - 1, zero, zero], axis=-1),
            np.stack([zero, 4 * b - 1, zero], axis=-1),
            np.stack([zero, zero, 4 * c - 1], axis=-1),
            np.stack([4 * b, 4 * a, zero], axis=-1),
            np.stack([zero, 4 * c, 4 * b], axis=-1),
            np.stack([4 * c, zero, 4 * a], axis=-1),
        ],
        axis=1,
    )
