"""Outlines against closed forms and against the analysis of sectionproperties; centre lines beside the centroid."""

import math
import warnings

import numpy as np
import pytest

import viscorod as vr
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.sections.composite import Composite, CompositeRegion
from viscorod.model.sections.meshed_section import moved
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.section_shapes import Annulus, Circle, Ellipse, Rectangle, SquareTube

L_SHAPE = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.1), (0.1, 0.1), (0.1, 1.4), (0.0, 1.4)]
SHAPES = [Circle(0.7), Annulus(1.0, 0.6), Rectangle(0.4, 1.3), Ellipse(0.5, 1.2), Rectangle(1.0, 0.1)]


def outline_of(shape, **given):
    return PolygonSection(*shape.outline[0], **given)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: f"{s.shape} {s.half_width:.2g}")
def test_the_simple_shapes_come_out_again(shape):
    """With nu = 0 the energy's shear factors are Cowper's for solid shapes; a tube's differ by 1 in 500."""
    section = outline_of(shape)
    extensional, shearing, inertia = section.geometry(0.0)
    expected, expected_shear, expected_inertia = shape.geometry(0.0)
    size = np.sqrt(np.outer(np.diag(expected_inertia), np.diag(expected_inertia)))
    assert extensional / size == pytest.approx(expected / size, abs=1e-6)
    assert inertia / size == pytest.approx(expected_inertia / size, abs=1e-6)
    loose = 3e-3 if shape.shape == "annulus" else 2e-4
    if shape.shape == "ellipse":  # Cowper's factor of the ellipse is not the energy's even for nu = 0
        loose = 0.02
    assert np.diag(shearing)[:2] == pytest.approx(np.diag(expected_shear)[:2], rel=loose)
    assert shearing[5, 5] == pytest.approx(expected_shear[5, 5], rel=2e-4)
    assert section.torsion() == pytest.approx(shape.torsion(), rel=2e-4)
    assert section.half_width == pytest.approx(shape.half_width, rel=1e-3)


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.5])
def test_shear_stiffness_of_the_circle_by_the_known_stresses(nu):
    """Timoshenko and Goodier, section 115: the stresses of a round cantilever, their energy by quadrature."""
    g, w = np.polynomial.legendre.leggauss(12)
    r, weight = (g + 1) / 2, w / 2
    angle = np.arange(32) * 2 * math.pi / 32
    x, y = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))
    second_moment = math.pi / 4
    first = (3 + 2 * nu) / (8 * (1 + nu)) / second_moment * (1 - x**2 - (1 - 2 * nu) / (3 + 2 * nu) * y**2)
    second = -(1 + 2 * nu) / (4 * (1 + nu)) / second_moment * x * y
    ring = (weight * r)[:, None] * 2 * math.pi / 32
    assert (ring * first).sum() == pytest.approx(1.0, rel=1e-12)
    factor = 1.0 / (ring * (first**2 + second**2)).sum() / math.pi
    section = outline_of(Circle(1.0))
    assert section.shear_factors(nu) == pytest.approx((factor, factor), rel=1e-5)


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.5])
def test_shares_of_the_core_of_a_circle_by_the_known_stresses(nu):
    """As above: the squared shear strains in r < 1/2 and outside of it, of a force along d1."""
    law = Material(2.0 * (1.0 + nu), nu, 1.0)
    found = Composite(
        [CompositeRegion(law, Circle(0.5)), CompositeRegion(law, Annulus(1.0, 0.5))]
    )._analysis.strains[:, 0, 0]
    g, w = np.polynomial.legendre.leggauss(12)
    angle = np.arange(32) * 2 * math.pi / 32
    expected = []
    for low, high in ((0.0, 0.5), (0.5, 1.0)):
        r, weight = low + (high - low) * (g + 1) / 2, w * (high - low) / 2
        x, y = np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))
        inertia = math.pi / 4
        first = (3 + 2 * nu) / (8 * (1 + nu)) / inertia * (1 - x**2 - (1 - 2 * nu) / (3 + 2 * nu) * y**2)
        second = -(1 + 2 * nu) / (4 * (1 + nu)) / inertia * x * y
        expected.append(((weight * r)[:, None] * 2 * math.pi / 32 * (first**2 + second**2)).sum())
    assert found == pytest.approx(expected, rel=2e-4)


@pytest.fixture(scope="module")
def reference():
    """The library's own analysis of a polygon, on a mesh as fine as the outline's."""
    from sectionproperties.analysis import Section
    from sectionproperties.pre import Geometry
    from sectionproperties.pre import Material as Stuff
    from shapely import Polygon

    def analysed(points, nu, side):
        stuff = Stuff("stuff", 2.0 * (1.0 + nu), nu, 1.0, 1.0, "w")
        geometry = Geometry(Polygon(points), material=stuff)
        geometry.create_mesh([math.sqrt(3) / 4 * side**2])
        section = Section(geometry)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            section.calculate_geometric_properties()
            section.calculate_warping_properties()
        return section

    return analysed


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_an_angle_against_the_library(reference, nu):
    """Area, moments, principal axes, torsion, Trefftz's shear centre, and for nu = 0 the shear areas."""
    side = 0.03
    library, E = reference(L_SHAPE, nu, side), 2.0 * (1.0 + nu)
    section = PolygonSection(L_SHAPE, mesh_size=side)
    extensional, _, _ = section.geometry(nu)
    assert extensional[2, 2] == pytest.approx(library.get_area(), rel=1e-10)
    ixx, iyy, ixy = (value / E for value in library.get_eic())
    assert extensional[3:5, 3:5] == pytest.approx(np.array([[ixx, -ixy], [-ixy, iyy]]), rel=1e-9)
    assert section.centres.tension_centre == pytest.approx(library.get_c(), rel=1e-9)
    assert section.torsion() == pytest.approx(library.get_ej() / E, rel=1e-4)
    assert section.centres.shear_centre == pytest.approx(library.get_sc_t(), rel=1e-4)
    turned = PolygonSection(L_SHAPE, mesh_size=side, axes="principal")
    i1, i2 = np.diag(turned.geometry(nu)[0])[3:5]
    assert sorted([i1, i2]) == pytest.approx(sorted(value / E for value in library.get_eip()), rel=1e-9)
    assert turned.geometry(nu)[0][3, 4] == pytest.approx(0.0, abs=1e-9 * i1)
    assert math.degrees(turned.centres.angle) % 90 == pytest.approx(library.get_phi() % 90, abs=1e-6)
    if nu == 0.0:
        about = PolygonSection(L_SHAPE, mesh_size=side, origin="shear_centre").geometry(0.0)[1]
        compliance = np.linalg.inv(about[np.ix_((0, 1, 5), (0, 1, 5))])
        areas = [value / E for value in library.get_eas()]
        assert np.diag(compliance)[:2] == pytest.approx(1.0 / np.array(areas), rel=1e-4)


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_shear_areas_of_a_rectangle_against_the_library(reference, nu):
    """Where the elasticity and Trefftz's shear centre coincide the shear areas agree for every Poisson's ratio."""
    points = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
    library = reference(points, nu, 0.1)
    factors = PolygonSection(points, mesh_size=0.1).shear_factors(nu)
    areas = [value / (2.0 * (1.0 + nu)) for value in library.get_eas()]
    assert np.array(factors) * 2.0 == pytest.approx(areas, rel=1e-4)


def channel(b, h, t, **given):
    """A channel of the mid-line dimensions b (flanges), h (web), thickness t; the web's mid-line at x = 0."""
    x, y = t / 2, h / 2
    return PolygonSection([(-x, -y - x), (b, -y - x), (b, -y + x), (x, -y + x),
                    (x, y - x), (b, y - x), (b, y + x), (-x, y + x)], **given)  # fmt: skip


def test_a_channel_approaches_the_thin_walled_limit():
    """Shear centre 3 b^2/(h + 6 b) beyond the web, J = sum b t^3/3; the error falls with the thickness."""
    b, h, errors = 0.5, 1.0, []
    for t in (0.04, 0.02):
        section = channel(b, h, t)
        e = -section.centres.shear_centre[0]
        J = (2 * b + h) * t**3 / 3
        errors.append((abs(e / (3 * b**2 / (h + 6 * b)) - 1.0), abs(section.torsion() / J - 1.0)))
        assert section.centres.shear_centre[1] == pytest.approx(0.0, abs=1e-5)
    assert errors[1] < (4e-3, 4e-3)
    assert errors[1][0] < errors[0][0]
    assert errors[1][1] < errors[0][1]


def test_a_thin_square_tube_approaches_bredt_and_cowper():
    """Thin-wall formulas err in proportion to the thickness; extrapolated to none, the outline gives theirs."""
    excess = []
    for t in (0.04, 0.02):
        thin = SquareTube(1.0, t)
        tube = outline_of(thin)
        shear = tube.shear_factors(0.0)
        assert shear[0] == pytest.approx(shear[1], rel=1e-4)
        excess.append([tube.torsion() / thin.torsion() - 1.0, shear[0] / thin.shear_factors(0.0)[0] - 1.0])
    assert 2.0 * np.array(excess[1]) - excess[0] == pytest.approx([0.0, 0.0], abs=2e-3)


def test_a_force_through_the_shear_centre_does_not_twist():
    """The reciprocal statement too: a torque turns the section about its shear centre (Pilkey 2002, section 6.3)."""
    section = channel(0.5, 1.0, 0.05, origin="given")
    x, y = section.centres.shear_centre
    C = sum(section.geometry(0.3)[:2])
    force = np.array([0.3, 1.0, 0.0, 0.0, 0.0, x * 1.0 - y * 0.3])
    assert np.linalg.solve(C, force)[5] == pytest.approx(0.0, abs=1e-9 * np.linalg.solve(C, force)[1])
    shear_1, shear_2, _, _, _, twist = np.linalg.solve(C, [0, 0, 0, 0, 0, 1.0])
    # a point at rest in the plane, Gamma + twist e3 x xi = 0
    assert shear_1 - twist * y == pytest.approx(0.0, abs=1e-9 * twist)
    assert shear_2 + twist * x == pytest.approx(0.0, abs=1e-9 * twist)


def test_an_axial_force_through_the_tension_centre_does_not_bend():
    section = PolygonSection(L_SHAPE, origin="given")
    x, y = section.centres.tension_centre
    C = sum(section.geometry(0.3)[:2])
    strain = np.linalg.solve(C, [0, 0, 1.0, y, -x, 0])
    assert strain[3:5] == pytest.approx([0.0, 0.0], abs=1e-9 * strain[2])
    # with the signs of bend_1 and bend_2: material at +y is stretched by bend_1 > 0, at +x compressed by bend_2 > 0
    assert C[2, 3] == pytest.approx(C[2, 2] * y)
    assert C[2, 4] == pytest.approx(-C[2, 2] * x)


@pytest.mark.parametrize("origin", ["centroid", "shear_centre", "given"])
@pytest.mark.parametrize("axes", ["given", "principal"])
def test_every_reference_line_tells_the_same_energy(origin, axes):
    """The same deformation, described about two lines by the displacement field u(xi) = Gamma + kappa x xi."""
    law = Material(youngs_modulus=3.0, poissons_ratio=0.3, density=2.0,
                   damping=KelvinVoigt(shear_time=0.1, bulk_time=0.7))  # fmt: skip
    plain, section = (
        PolygonSection(L_SHAPE, origin="given"),
        PolygonSection(L_SHAPE, origin=origin, axes=axes),
    )
    centres = section.centres
    turn = np.eye(3)
    turn[:2, :2] = [
        [math.cos(centres.angle), math.sin(centres.angle)],
        [-math.sin(centres.angle), math.cos(centres.angle)],
    ]
    eps = np.random.default_rng(3).normal(size=6)
    about = eps[:3] + np.cross(eps[3:], [*centres.origin, 0.0])  # H at the new origin
    new = np.concatenate([turn @ about, turn @ eps[3:]])
    for one, two in zip(plain.matrices(law), section.matrices(law), strict=True):
        assert new @ two @ new == pytest.approx(eps @ one @ eps, rel=1e-10)


def test_moving_a_matrix_there_and_back():
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(6, 6))
    matrix += matrix.T
    there = moved(matrix, np.array([0.3, -0.2]), 0.0)
    assert moved(there, np.array([-0.3, 0.2]), 0.0) == pytest.approx(matrix, rel=1e-12)
    turned = moved(matrix, np.zeros(2), 0.4)
    assert moved(turned, np.zeros(2), -0.4) == pytest.approx(matrix, rel=1e-12)
    assert np.linalg.eigvalsh(turned) == pytest.approx(np.linalg.eigvalsh(matrix), rel=1e-12)


def test_size_and_place_do_not_matter():
    """Lengths times s: areas s^2, moments s^4; far from the origin and tiny or huge."""
    base = outline_of(Rectangle(0.4, 1.3)).geometry(0.3)
    for s in (1e-6, 1e5):
        points = s * (np.array(Rectangle(0.4, 1.3).outline[0][0]) + np.array([300.0, -500.0]))
        powers = np.array([1, 1, 1, 2, 2, 2])
        size = s ** np.add.outer(powers, powers)
        for one, two in zip(base, PolygonSection(points).geometry(0.3), strict=True):
            assert two / size == pytest.approx(one, rel=1e-3, abs=1e-5)


def test_refinement_ends_within_what_it_tells():
    """The automatic mesh against one four times finer."""
    section = PolygonSection(L_SHAPE)
    (remark,) = section.remarks()
    assert "triangles" in remark
    fine = PolygonSection(L_SHAPE, mesh_size=0.01)
    assert section.torsion() == pytest.approx(fine.torsion(), rel=2e-3)
    assert section.shear_factors(0.3) == pytest.approx(fine.shear_factors(0.3), rel=4e-3)


def test_a_geometry_of_the_library():
    from sectionproperties.pre.library import rectangular_hollow_section

    geometry = rectangular_hollow_section(d=0.1, b=0.05, t=0.004, r_out=0.008, n_r=8)
    section = PolygonSection.from_geometry(geometry)
    assert len(section.holes) == 1
    assert section.moments()[0] == pytest.approx(geometry.calculate_area(), rel=1e-9)


def test_outlines_take_the_damping_of_their_material_per_branch_and_region():
    law = Material(youngs_modulus=3.0, poissons_ratio=0.3, density=2.0,
                   damping=KelvinVoigt(shear_time=0.1, bulk_time=0.7))  # fmt: skip
    section = PolygonSection(L_SHAPE, origin="given")
    extensional, shearing, inertia = section.geometry(0.3)
    C, D, M = section.matrices(law)
    assert C == pytest.approx(3.0 * extensional + law.shear_modulus * shearing, rel=1e-14)
    assert D == pytest.approx(
        law.extensional_viscosity * extensional + law.shear_viscosity * shearing, rel=1e-14
    )
    assert M == pytest.approx(2.0 * inertia, rel=1e-14)
    alone = Composite([CompositeRegion(law, points=L_SHAPE)], origin="given")
    for one, two in zip(alone.matrices(), (C, D, M), strict=True):
        assert one == pytest.approx(two, rel=1e-9, abs=1e-12)


def test_an_outline_that_a_formula_closes_but_for_round_off():
    """A NACA 0012 from trailing edge to trailing edge: round-off there; its area in closed form."""
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 60)))
    polynomial = -0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4
    y = 0.6 * (0.2969 * np.sqrt(x) + polynomial)
    points = [*zip(x[::-1], y[::-1], strict=True), *zip(x[1:], -y[1:], strict=True)]
    assert points[0] != points[-1]
    exact = 2.0 * 0.6 * (0.2969 * 2 / 3 - 0.126 / 2 - 0.3516 / 3 + 0.2843 / 4 - 0.1036 / 5)
    assert PolygonSection(points).moments()[0] == pytest.approx(exact, rel=2e-3)


def thin_walls(kind):
    """Return corners of an I or a channel of walls 1 mm thick, whose middles are 0.1 m high and 0.05 m wide."""
    b, h, t = 0.05, 0.1, 0.001
    if kind == "channel":
        x, y = b + 0.5 * t, h + t
        return [(0, 0), (x, 0), (x, t), (t, t), (t, y - t), (x, y - t), (x, y), (0, y)]
    x, y = 0.5 * b, 0.5 * (h + t)
    right = [(x, -y), (x, t - y), (0.5 * t, t - y), (0.5 * t, y - t), (x, y - t), (x, y)]
    return right + [(-p, -q) for p, q in right]


@pytest.mark.parametrize(
    ("kind", "inertia"),
    [
        ("I", 0.001 * 0.05**3 * 0.1**2 / 24.0),
        ("channel", 0.001 * 0.05**3 * 0.1**2 / 12.0 * (3 * 0.05 + 2 * 0.1) / (6 * 0.05 + 0.1)),
    ],
)
def test_held_warping_of_thin_walls_is_vlasovs(kind, inertia):
    """Sectorial moments of inertia of thin walls (Vlasov 1961); J = sum of l t^3/3. What is told is not the error."""
    section = vr.PolygonSection(thin_walls(kind))
    torsion = (2 * 0.05 + 0.1) * 0.001**3 / 3.0
    expected = np.sqrt(2.6 * inertia / torsion)
    assert section.warping_length(vr.Material(2e11, 0.3, 7850.0)) == pytest.approx(expected, rel=2e-2)
    for length, told in ((expected / 0.12, True), (expected / 0.08, False)):
        model = vr.Model()
        rod = vr.Rod.straight(
            (0, 0, 0), (length, 0, 0), section=section, material=vr.Material(2e11, 0.3, 7850.0)
        )
        model.add("beam", rod)
        model.clamp("beam.start")
        found = [text for text in model.check().warnings if "the warping of its section" in text]
        assert bool(found) == told
        if told:  # M = pi/L sqrt(EI (GJ + EIw pi^2/L^2)), Timoshenko and Gere 1961, 6.3
            reach = section.warping_length(vr.Material(2e11, 0.3, 7850.0))
            assert f"up to {100.0 * (np.hypot(1.0, np.pi * reach / length) - 1.0):.2g} % larger" in found[0]


def test_a_composite_warps_as_its_parts_do():
    """Two materials of one kind are that material; a solid bar holds its warping over a part of its width."""
    steel = vr.Material(2e11, 0.3, 7850.0)
    whole = vr.PolygonSection([(0, 0), (0.02, 0), (0.02, 0.01), (0, 0.01)])
    half = vr.Rectangle(0.01, 0.01)
    parts = vr.Composite([vr.CompositeRegion(steel, half, at=(x, 0.0)) for x in (-0.005, 0.005)])
    assert parts.warping_length() == pytest.approx(whole.warping_length(steel), rel=2e-3)
    assert whole.warping_length(steel) < 0.01
