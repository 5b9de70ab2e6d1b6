"""Shear stresses of sections under unit forces and torques, against closed forms, tables and each other."""

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.material import Material
from viscorod.model.sections.composite import Composite, CompositeRegion
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.section_shapes import Annulus, Circle, Ellipse, Rectangle, SquareTube
from viscorod.model.sections.stiffness_section import StiffnessSection
from viscorod.model.sections.stress_field import resultants

STEEL = Material(2.1e11, 0.3, 7850.0)
ANGLE = PolygonSection(
    [(0, 0), (0.05, 0), (0.05, 0.004), (0.004, 0.004), (0.004, 0.05), (0, 0.05)],
    origin="shear_centre",
    axes="principal",
)
LAYERS = Composite(
    [
        CompositeRegion(STEEL, Rectangle(0.02, 0.002)),
        CompositeRegion(Material(1e9, 0.3, 1100.0), Rectangle(0.02, 0.004), at=(0.001, 0.003)),
    ],
    origin="given",
)


def flow(section, points, nu=0.3, part=slice(None)):
    """Shear stresses (n, 2) of a unit force along d1, along d2 or a unit torque."""
    return section.stress_field(Material(1.0, nu, 1.0)).at(np.array(points, dtype=float)).flow[..., part]


@pytest.mark.parametrize(
    "section",
    [
        *(
            Circle(0.01),
            Annulus(0.01, 0.004),
            Rectangle(0.02, 0.01),
            Rectangle(0.1, 0.002),
            Ellipse(0.02, 0.005),
        ),
        *(SquareTube(0.02, 0.004), ANGLE, LAYERS),
    ],
    ids=lambda section: type(section).__name__,
)
def test_the_stresses_of_unit_forces_are_in_balance_with_them(section):
    """Forces and torque about the centre line; the closed forms also by the quadrature of their grids."""
    field = section.stress_field(None if section is LAYERS else STEEL)
    units = np.array([1.0, 1.0, section.half_width])
    found = resultants(field.rule.points, field.weight, field.rule.flow) * units / units[:, None]
    assert found == pytest.approx(np.eye(3), abs=1e-7)
    stiffness = section.matrices(None if section is LAYERS else STEEL)[0]
    young = np.array([m.youngs_modulus for m in field.materials])[field.rule.region]
    axial = np.einsum("q,qi,qj->ij", field.weight * young, field.rule.axial, field.rule.axial)
    size = np.sqrt(np.outer(*2 * [np.diag(axial)]))
    assert axial / size == pytest.approx(stiffness[2:5, 2:5] / size, abs=1e-12)


@pytest.mark.parametrize(("width", "height"), [(1.0, 1.0), (1.0, 2.0), (3.0, 1.0), (0.1, 1.0)])
def test_the_largest_shear_stress_of_a_twisted_rectangle(width, height):
    """Timoshenko and Goodier, article 109: 2 G theta a [1 - 8/pi^2 sum 1/(n^2 cosh(n pi b/2a))] in the long sides."""
    section = Rectangle(width, height)
    a, b = sorted((width / 2, height / 2))
    n = np.arange(1, 200, 2)
    with np.errstate(over="ignore"):
        largest = 2 * a * (1 - 8 / np.pi**2 * np.sum(1 / (n**2 * np.cosh(n * np.pi * b / (2 * a)))))
    middle = (a, 0.0) if width <= height else (0.0, a)
    found = np.linalg.norm(flow(section, [middle], part=2))
    assert found == pytest.approx(largest / section.torsion(), rel=1e-11)
    everywhere = section.stress_field(STEEL).patch.samples.flow[..., 2]
    assert np.linalg.norm(everywhere, axis=1).max() == pytest.approx(found, rel=1e-11)


@pytest.mark.parametrize(
    ("ratio", "centre", "edge"),
    [(0.5, 0.983, 1.033), (1.0, 0.940, 1.126), (2.0, 0.856, 1.396), (4.0, 0.805, 1.988)],
)
def test_the_shear_stress_of_a_rectangle_by_the_table_of_timoshenko(ratio, centre, edge):
    """Theory of elasticity, article 124, nu = 1/4: over 3 P/2 A, in the middle and at the ends of the neutral axis."""
    section = Rectangle(1.0, ratio)
    found = flow(section, [(0.0, 0.0), (0.0, ratio / 2)], nu=0.25)[:, 0, 0] / (1.5 / section.area)
    assert found == pytest.approx([centre, edge], abs=6e-4)


def test_without_lateral_contraction_the_shear_stress_of_a_rectangle_is_a_parabola():
    b, h = 0.03, 0.01
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (20, 2)) * [b, h]
    found = flow(Rectangle(b, h), points, nu=0.0)
    assert found[:, 1, 1] == pytest.approx(1.5 / (b * h) * (1 - (2 * points[:, 1] / h) ** 2), rel=1e-12)
    assert found[:, 0, 1] == pytest.approx(0.0, abs=1e-12 / (b * h))


def test_the_shear_stress_of_a_circle():
    """Timoshenko and Goodier, article 122, nu = 0.3: 1.38 P/A in the centre, 1.23 P/A at the ends of the diameter."""
    r = 0.01
    found = flow(Circle(r), [(0, 0), (0, r)])[:, 0, 0] * np.pi * r**2
    assert found == pytest.approx([1.38, 1.23], abs=0.006)
    assert flow(Ellipse(r, r), [(0.3 * r, 0.5 * r)]) == pytest.approx(
        flow(Circle(r), [(0.3 * r, 0.5 * r)]), rel=1e-12
    )
    thin = Annulus(r, 0.999 * r)  # 2 P/A on the neutral axis
    assert flow(thin, [(0, 0.9995 * r)])[0, 0, 0] * thin.area == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize(
    "section", [Annulus(1.0, 0.4), Rectangle(1.0, 0.5), Rectangle(0.5, 1.5), Ellipse(1.0, 0.4)], ids=repr
)
def test_closed_forms_obey_the_equations_and_leave_the_outline_free(section):
    """div t = -x/I2 and the curl of compatibility by differences; no traction on the outline."""
    nu, h, (area, I1, I2) = 0.3, 1e-4, section.moments()
    field = section.stress_field(Material(1.0, nu, 1.0))
    points = field.rule.points[:: len(field.rule.points) // 40]
    inside = (
        points[np.linalg.norm(points, axis=1) > 0.45] * 0.95 if isinstance(section, Annulus) else 0.9 * points
    )
    by_x, by_y = (
        (field.at(inside + step).flow - field.at(inside - step).flow) / (2 * h) for step in ([h, 0], [0, h])
    )
    x, y = inside.T
    contraction = nu / (1 + nu)
    wanted = (
        np.stack([-x / I2, -y / I1, 0 * x], -1),
        np.stack([-contraction * y / I2, contraction * x / I1, 2 / section.torsion() + 0 * x], -1),
    )
    found = by_x[:, 0] + by_y[:, 1], by_x[:, 1] - by_y[:, 0]
    for one, other in zip(found, wanted, strict=True):
        assert one == pytest.approx(other, abs=3e-5 * area / min(I1, I2))
    if isinstance(section, Rectangle):
        a, b = section.width / 2, section.height / 2
        edge, normal = (
            np.array([(a, 0.3 * b), (a, b), (-a, -0.99 * b), (0.2 * a, b)]),
            [(1, 0), (1, 0), (-1, 0), (0, 1)],
        )
    else:
        turn = np.linspace(0.1, 6.0, 9)
        a, b = section.extent.halves
        edge = np.stack([a * np.cos(turn), b * np.sin(turn)], -1)
        normal = edge / np.array([a, b]) ** 2
        if section.extent.hole:
            edge, normal = np.concatenate([edge, 0.4 * edge]), np.concatenate([normal, normal])
    traction = np.einsum("ndk,nd->nk", field.at(edge).flow, np.array(normal))
    assert np.abs(traction).max() < 1e-12 * np.abs(field.rule.flow).max() * np.abs(normal).max()


def test_a_mesh_gives_the_stresses_of_the_closed_form():
    a, b = 0.02, 0.01
    meshed = PolygonSection([(-a, -b), (a, -b), (a, b), (-a, b)], mesh_size=b / 6)
    points = np.random.default_rng(2).uniform(-0.95, 0.95, (50, 2)) * [a, b]
    exact = flow(Rectangle(2 * a, 2 * b), points)
    assert np.abs(flow(meshed, points) - exact).max(axis=(0, 1)) == pytest.approx(
        0.0, abs=0.02 * np.abs(exact).max()
    )
    assert np.sqrt(np.mean((flow(meshed, points) - exact) ** 2)) < 4e-3 * np.abs(exact).max()


def test_forces_beside_the_shear_centre_twist():
    """The same section about another point: a force there is one at the centre with its torque."""
    corners = ANGLE.points
    about, given = (
        PolygonSection(corners, origin=origin, mesh_size=0.004) for origin in ("shear_centre", "given")
    )
    p = np.array(about.centres.origin)
    points = np.array([(0.0013, 0.0207), (0.0211, 0.0027)])
    first, second = flow(given, points), flow(about, points - p)
    torque = np.array([p[1], -p[0]])  # of forces at the origin about the shear centre
    assert first[..., 2] == pytest.approx(second[..., 2], rel=1e-5)
    assert first[..., :2] == pytest.approx(second[..., :2] + second[..., 2:] * torque, rel=1e-5)


def test_layers_share_the_shear_stress_as_beam_theory_says():
    """Without lateral contraction: t = V/(b EI) int E (y - y0) dy from the free side, the same across the width."""
    b, heights, youngs = 0.04, (0.01, 0.02), (7e10, 2e9)
    section = Composite(
        [
            CompositeRegion(Material(youngs[0], 0.0, 1.0), Rectangle(b, heights[0]), at=(0, -heights[0] / 2)),
            CompositeRegion(Material(youngs[1], 0.0, 1.0), Rectangle(b, heights[1]), at=(0, heights[1] / 2)),
        ],
        origin="given",
    )
    y0 = section.centres.tension_centre[1]
    bending = b * sum(
        E * h * (h**2 / 12 + (m - y0) ** 2)
        for E, h, m in zip(youngs, heights, (-heights[0] / 2, heights[1] / 2), strict=True)
    )
    y = np.array([0.001, 0.008, 0.015])
    beyond = youngs[1] * (heights[1] ** 2 - y**2 - 2 * y0 * (heights[1] - y)) / 2
    found = section.stress_field().at(np.stack([[0.0, 0.01, -0.019], y], -1)).flow[:, 1, 1]
    assert found == pytest.approx(beyond / bending, rel=2e-4)


def test_points_outside_and_sections_without_points_are_refused():
    with pytest.raises(InputError, match="outside the section"):
        flow(Circle(0.01), [(0.0, 0.0), (0.0101, 0.0)])
    with pytest.raises(InputError, match="outside the section"):
        flow(Annulus(0.01, 0.005), [(0.0, 0.0)])
    with pytest.raises(InputError, match="outside the section"):
        flow(ANGLE, [(0.05, 0.05)])
    numbers = SectionProperties(1e-4, 1e-9, 1e-9, 1e-9)
    with pytest.raises(InputError, match="describe it by its shape"):
        numbers.stress_field(STEEL)
    with pytest.raises(InputError, match="describe it by its shape"):
        StiffnessSection([1.0] * 6, [1.0] * 6).stress_field()
