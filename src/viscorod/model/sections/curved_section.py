"""Sections of a curved rod: how the curvature of the reference shape changes stiffness, damping and inertia.

Fibres on the inside of a curved rod are shorter: at a point (x, y) the length J0 ds with J0 = 1 + y U01 - x U02
belongs to ds of the centre line (LLT 2.2). Stretched fibres press on each other there, and a section whose points move
by u in its plane changes their strain, too:

    e33 = (stretch + bend_1 y - bend_2 x + u . grad J0)/J0,    e_ab = (d_a u_b + d_b u_a)/2.

Per length of the centre line the energy of stretch and bending is the least of 1/2 int (e : H : e) J0 dA over all u,
with Hooke's law H. Where these strains are the same along the rod this is elasticity in three dimensions: in a
rectangle it is H. Golovin's ring (Timoshenko and Goodier, article 29), in a thin tube Th. von Karman's (1911), whose
section becomes oval. E. Winkler's theory (1858) leaves u out; its error is of second order in the thickness over the
radius as is the whole change. u is sought among polynomials. The mass is that of J0. Shear and twist are left as they
are: what curvature changes there is of second order too, in strains that matter less where rods are slender.
Damping and Maxwell branches take the shares of the elastic energy.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from viscorod.model.fields.definition import RefusedError
from viscorod.model.materials.material import Material
from viscorod.model.sections.section_base import AnySection, Branches, Matrices
from viscorod.model.sections.stress_field import SectionSamples, StressField
from viscorod.typing import Floats

__all__ = ["curved_branches", "curved_matrices", "curved_parts"]

AXIAL = np.ix_([2, 3, 4], [2, 3, 4])
DEGREE = 8
"""Of the polynomials in which the points of a section move."""
SOLID = 0.4999
"""Largest Poisson's ratio with which sections resist a change of their area."""
CHUNK = 4000
"""Points of a quadrature that are summed at once."""


class _Changes(NamedTuple):
    """What curvature adds to C_E of every region ``(r, 3, 3)``, and to its inertia per density ``(r, 6, 6)``."""

    extensional: Floats
    inertia: Floats
    materials: tuple[Material, ...]


def curved_matrices(
    matrices: Matrices, section: AnySection, material: Material | None, curvature: Floats
) -> Matrices:
    """Return stiffness C, damping D and inertia M per length, (6, 6) each, of a section of a curved rod.

    Args:
        matrices: of the same section in a straight rod.
        section: with its material.
        material: of a section that takes one.
        curvature: U01 and U02 of the reference shape (2,), 1/m.

    Raises:
        InputError: the points of the section are not known.
        RefusedError: it reaches to the centre of curvature.
    """
    changes = _changes(section, material, *_rounded(curvature))
    stiffness, damping, mass = (matrix.copy() for matrix in matrices)
    for m, stretched, moved in zip(changes.materials, changes.extensional, changes.inertia, strict=True):
        stiffness[AXIAL] += m.youngs_modulus * stretched
        if not m.branches:
            damping[AXIAL] += m.extensional_viscosity * stretched
        mass += m.inertial_density * moved
    return stiffness, damping, mass


def curved_branches(
    branches: Branches, section: AnySection, material: Material | None, curvature: Floats
) -> Branches:
    """Return Maxwell branches of a section of a curved rod; see :func:`curved_matrices`."""
    times, stiffness = branches
    if not len(times):
        return branches
    changes = _changes(section, material, *_rounded(curvature))
    found = stiffness.copy()
    for m, stretched in zip(changes.materials, changes.extensional, strict=True):
        for branch in m.branches:
            found[int(np.argmin(np.abs(times - branch.time)))][AXIAL] += branch.youngs_modulus * stretched
    return times, found


def curved_parts(
    parts: list[tuple[Material, Floats, Floats]],
    section: AnySection,
    material: Material | None,
    curvature: Floats,
) -> list[tuple[Material, Floats, Floats]]:
    """Return every material of a section of a curved rod with its C_E and C_G; see :func:`curved_matrices`."""
    changes = _changes(section, material, *_rounded(curvature))
    found = []
    for (own, extensional, shearing), stretched in zip(parts, changes.extensional, strict=True):
        bent = extensional.copy()
        bent[AXIAL] += stretched
        found.append((own, bent, shearing))
    return found


def _rounded(curvature: Floats) -> tuple[float, float]:
    """Return curvatures without their round-off, so that an arc has one section."""
    size = float(np.linalg.norm(curvature))
    digits = 11 - int(np.floor(np.log10(size))) if size > 0.0 else 0
    return round(float(curvature[0]), digits) + 0.0, round(float(curvature[1]), digits) + 0.0


@lru_cache(maxsize=16)
def _field(section: AnySection, material: Material | None) -> StressField:
    return section.stress_field(material)


@lru_cache(maxsize=4096)
def _changes(section: AnySection, material: Material | None, first: float, second: float) -> _Changes:
    field = _field(section, material)
    rule, curvature = field.rule, np.array([first, second])
    if not (field.patch.samples.curved(curvature) > 0.0).all():
        raise RefusedError(
            "the section reaches to the centre of curvature of the reference shape",
            "make the section thinner or the radius larger",
            found=f"curvature {np.linalg.norm(curvature):.6g} 1/m",
        )
    extensional = _extensional(field, curvature) - _extensional(field, np.zeros(2))
    x, y = rule.points.T
    zero, one = np.zeros_like(x), np.ones_like(x)
    velocity = np.array(
        [
            [one, zero, zero, zero, zero, -y],
            [zero, one, zero, zero, zero, x],
            [zero, zero, one, y, -x, zero],
        ]
    )
    more = rule.curved(curvature) - 1.0
    weight = np.where(rule.region == np.arange(len(field.materials))[:, None], field.weight * more, 0.0)
    inertia = np.einsum("rq,kiq,kjq->rij", weight, velocity, velocity, optimize=True)
    return _Changes(extensional, inertia, field.materials)


def _extensional(field: StressField, curvature: Floats) -> Floats:
    """Return the energy of stretch and bending in every region per Young's modulus ``(r, 3, 3)``."""
    rule, weight = field.rule, field.weight
    size = float(np.abs(rule.points).max())
    count = (DEGREE + 1) * (DEGREE + 2) // 2
    parts = np.zeros((len(field.materials), 2 * count + 3, 2 * count + 3))
    moved = np.zeros((3, 2 * count))
    for begin in range(0, len(weight), CHUNK):
        part = slice(begin, begin + CHUNK)
        some = SectionSamples(rule.points[part], rule.region[part], rule.flow[part])
        values, slopes = _polynomials(some.points / size, DEGREE)
        slopes = slopes / size
        strains = _strains(some, values, slopes, curvature)
        x, y = some.points.T
        w = weight[part]
        zero = np.zeros(count)
        moved += [
            [*(w @ values), *zero],
            [*zero, *(w @ values)],
            [*(-(w * y) @ values / size), *((w * x) @ values / size)],
        ]
        w = w * some.curved(curvature)
        for region, material in enumerate(field.materials):
            mine = some.region == region
            nu = min(material.poissons_ratio, SOLID)
            shear, lame = 0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
            law = np.diag([2.0 * shear, 2.0 * shear, 2.0 * shear, shear])
            law[:3, :3] += lame
            rows = strains[mine]
            weighted = (w[mine, None, None] * (law @ rows)).reshape(-1, 2 * count + 3)
            parts[region] += rows.reshape(-1, 2 * count + 3).T @ weighted
    young = np.array([m.youngs_modulus for m in field.materials])
    whole = np.tensordot(young / young.max(), parts, 1)
    # the centre line and d1, d2 move with the section's mean position and turn
    _, _, across = np.linalg.svd(moved)
    free = across[3:].T
    inside = free.T @ whole[: 2 * count, : 2 * count] @ free
    push = free.T @ whole[: 2 * count, 2 * count :]
    least = -free @ np.linalg.pinv(inside, rcond=1e-13, hermitian=True) @ push
    shape = np.concatenate([least, np.eye(3)])
    return np.asarray(shape.T @ parts @ shape)


def _strains(samples: SectionSamples, values: Floats, slopes: Floats, curvature: Floats) -> Floats:
    """Return e11, e22, e33 and 2 e12 ``(q, 4, 2 n + 3)`` of u1, u2 in ``n`` polynomials, and of the three strains."""
    points, count = values.shape
    found = np.zeros((points, 4, 2 * count + 3))
    found[:, 0, :count] = slopes[..., 0]
    found[:, 1, count : 2 * count] = slopes[..., 1]
    found[:, 3, :count] = slopes[..., 1]
    found[:, 3, count : 2 * count] = slopes[..., 0]
    found[:, 2, :count] = -curvature[1] * values
    found[:, 2, count : 2 * count] = curvature[0] * values
    found[:, 2, 2 * count :] = samples.axial
    found[:, 2] /= samples.curved(curvature)[:, None]
    return found


def _polynomials(points: Floats, degree: int) -> tuple[Floats, Floats]:
    """Return products of Legendre polynomials up to a total degree ``(q, n)``, and their slopes ``(q, n, 2)``."""
    legendre = np.polynomial.legendre
    values = [legendre.legvander(x, degree) for x in points.T]
    slope = legendre.legder(np.eye(degree + 1))  # of every polynomial, a column
    slopes = [legendre.legvander(x, degree - 1) @ slope for x in points.T]
    pairs = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    first, second = np.array(pairs).T
    return values[0][:, first] * values[1][:, second], np.stack(
        [slopes[0][:, first] * values[1][:, second], values[0][:, first] * slopes[1][:, second]], axis=-1
    )
