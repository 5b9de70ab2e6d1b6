"""Section constants against independent values: tables, numerical integration, and Cowper's integral itself."""

import math

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.section_shapes import Annulus, Circle, Ellipse, Rectangle, SquareTube

SHAPES = [
    Circle(0.7),
    Annulus(1.0, 0.6),
    Rectangle(0.4, 1.3),
    Ellipse(0.5, 1.2),
    SquareTube(1.0, 0.08),
]


def inside(section, x, y):
    """Whether points (x along d1, y along d2) lie in the section."""
    match section:
        case Circle(radius=r):
            return x**2 + y**2 < r**2
        case Annulus(outer_radius=big, inner_radius=small):
            return (x**2 + y**2 < big**2) & (x**2 + y**2 > small**2)
        case Rectangle(width=w, height=h):
            return (abs(x) < w / 2) & (abs(y) < h / 2)
        case Ellipse(semi_axis_1=a, semi_axis_2=b):
            return (x / a) ** 2 + (y / b) ** 2 < 1
        case SquareTube(width=w, thickness=t):
            size = np.maximum(abs(x), abs(y))
            return (size < w / 2) & (size > w / 2 - t)


@pytest.mark.parametrize("section", SHAPES, ids=lambda s: s.shape)
def test_area_and_second_moments_by_integration(section):
    size = section.half_width
    middles = (np.arange(2000) + 0.5) / 1000.0 * size - size
    x, y = np.meshgrid(middles, middles, indexing="ij")
    cell = (size / 1000.0) ** 2
    mask = inside(section, x, y)
    area = mask.sum() * cell
    first = (mask * y**2).sum() * cell
    second = (mask * x**2).sum() * cell
    # The midpoint rule errs on the boundary only: a few 1e-4 with 2000 x 2000 cells.
    assert section.area == pytest.approx(area, rel=3e-3)
    assert section.second_moment_1 == pytest.approx(first, rel=3e-3)
    assert section.second_moment_2 == pytest.approx(second, rel=3e-3)


def test_width_is_along_d1_and_height_along_d2():
    section = Rectangle(0.2, 0.5)
    assert section.second_moment_1 == pytest.approx(0.2 * 0.5**3 / 12.0, rel=1e-15)
    assert section.second_moment_2 == pytest.approx(0.5 * 0.2**3 / 12.0, rel=1e-15)


@pytest.mark.parametrize(
    ("ratio", "beta", "digits"),
    [
        (1.0, 0.1405770149551536, 1e-13),
        # Timoshenko and Goodier, Theory of elasticity, table of k1 (three digits).
        (1.2, 0.166, 5e-4),
        (1.5, 0.196, 5e-4),
        (2.0, 0.229, 5e-4),
        (2.5, 0.249, 5e-4),
        (3.0, 0.263, 5e-4),
        (4.0, 0.281, 5e-4),
        (5.0, 0.291, 5e-4),
        (10.0, 0.312, 1e-3),
    ],
)
def test_torsion_of_rectangles(ratio, beta, digits):
    assert Rectangle(ratio, 1.0).torsion() / ratio == pytest.approx(beta, abs=digits)
    assert Rectangle(1.0, ratio).torsion() == pytest.approx(Rectangle(ratio, 1.0).torsion(), rel=1e-15)


def test_torsion_of_a_rectangle_by_the_plain_series():
    a, b = 1.7, 1.0
    series = sum(math.tanh(n * math.pi * a / (2 * b)) / n**5 for n in range(1, 4001, 2))
    assert Rectangle(a, b).torsion() == pytest.approx(
        a * b**3 * (1 / 3 - 64 / math.pi**5 * b / a * series), rel=1e-12
    )


def test_torsion_of_very_flat_rectangles():
    assert Rectangle(1e6, 1.0).torsion() == pytest.approx(1e6 / 3.0, rel=1e-6)


def test_torsion_of_round_sections_is_polar():
    for section in (Circle(0.3), Annulus(0.3, 0.1)):
        assert section.torsion() == pytest.approx(
            section.second_moment_1 + section.second_moment_2, rel=1e-15
        )
    assert Ellipse(0.3, 0.3).torsion() == pytest.approx(Circle(0.3).torsion(), rel=1e-14)
    assert Annulus(0.3, 1e-9).torsion() == pytest.approx(Circle(0.3).torsion(), rel=1e-14)


def test_torsion_of_the_ellipse_by_its_stress_function():
    """Prandtl's function of the ellipse, phi = c (1 - x^2/a^2 - y^2/b^2), has J = 4 int phi / (-lap phi)."""
    a, b = 0.7, 0.2
    integral, laplacian = math.pi * a * b / 2.0, 2.0 / a**2 + 2.0 / b**2
    assert Ellipse(a, b).torsion() == pytest.approx(4.0 * integral / laplacian, rel=1e-14)


def test_torsion_of_the_thin_square_tube():
    """Bredt against the tube as the difference of membranes, J of thin walls -> b_m^3 t."""
    assert SquareTube(1.0, 0.01).torsion() == pytest.approx(0.99**3 * 0.01, rel=1e-14)
    assert SquareTube(1.0, 0.05).remarks() == ()
    assert SquareTube(1.0, 0.2).remarks() != ()
    assert SquareTube(1.0, 0.2, torsion_constant=0.1).remarks() == ()


def cowper(inside_points, boundary, normals, area, second_moment, other_moment, nu):
    """Cowper's integral (1966, equation 23) for shear along x, with the flexure function fitted on the boundary.

    chi is harmonic with d chi/dn = -n_x [nu x^2/2 + (1 - nu/2) y^2] - n_y (2 + nu) x y, and
    k = 2 (1 + nu) I / [nu/2 (I_x - I) - A/I int x (chi + x y^2)], I = int x^2, I_x = int y^2.
    """
    points, weights = inside_points
    x, y = boundary.T
    wanted = -normals[:, 0] * (nu * x**2 / 2 + (1 - nu / 2) * y**2) - normals[:, 1] * (2 + nu) * x * y
    powers = np.arange(1, 24, 2)
    z = x + 1j * y
    scale = np.abs(z).max()
    slopes = np.array([n * (z / scale) ** (n - 1) / scale for n in powers])
    system = (slopes.real * normals[:, 0] - slopes.imag * normals[:, 1]).T
    coefficients = np.linalg.lstsq(system, wanted, rcond=None)[0]
    chi = sum(
        c * (((points[:, 0] + 1j * points[:, 1]) / scale) ** n).real
        for c, n in zip(coefficients, powers, strict=True)
    )
    integral = (weights * points[:, 0] * (chi + points[:, 0] * points[:, 1] ** 2)).sum()
    return (
        2
        * (1 + nu)
        * second_moment
        / (nu / 2 * (other_moment - second_moment) - area / second_moment * integral)
    )


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("axes", [(1.0, 1.0), (1.0, 0.4), (0.4, 1.0)])
def test_shear_factors_of_circle_and_ellipse_by_cowpers_integral(axes, nu):
    a, b = axes
    r, w = np.polynomial.legendre.leggauss(20)
    r, w = (r + 1) / 2, w / 2
    angles = np.arange(64) * 2 * math.pi / 64
    radius, angle = np.meshgrid(r, angles, indexing="ij")
    points = np.column_stack([(a * radius * np.cos(angle)).ravel(), (b * radius * np.sin(angle)).ravel()])
    weights = (a * b * (w * r)[:, None] * np.full(64, 2 * math.pi / 64)).ravel()
    boundary = np.column_stack([a * np.cos(angles), b * np.sin(angles)])
    normals = np.column_stack([np.cos(angles) / a, np.sin(angles) / b])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    section = Ellipse(a, b)
    k = cowper(
        (points, weights),
        boundary,
        normals,
        section.area,
        section.second_moment_2,
        section.second_moment_1,
        nu,
    )
    assert section.shear_factors(nu)[0] == pytest.approx(k, rel=1e-10)
    if a == b:
        assert Circle(a).shear_factors(nu) == pytest.approx((k, k), rel=1e-10)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("sides", [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)])
def test_shear_factors_of_rectangles_by_cowpers_integral(sides, nu):
    width, height = sides
    g, w = np.polynomial.legendre.leggauss(40)
    x, y = np.meshgrid(g * width / 2, g * height / 2, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel()])
    weights = np.outer(w * width / 2, w * height / 2).ravel()
    right = np.column_stack([np.full(40, width / 2), g * height / 2])
    upper = np.column_stack([g * width / 2, np.full(40, height / 2)])
    boundary = np.vstack([right, upper])
    normals = np.vstack([np.tile([1.0, 0.0], (40, 1)), np.tile([0.0, 1.0], (40, 1))])
    section = Rectangle(width, height)
    k = cowper(
        (points, weights),
        boundary,
        normals,
        section.area,
        section.second_moment_2,
        section.second_moment_1,
        nu,
    )
    # Harmonic polynomials approach the corners slowly.
    assert section.shear_factors(nu)[0] == pytest.approx(k, rel=1e-4)


def test_shear_factors_of_tubes_in_their_limits():
    assert Annulus(1.0, 1e-9).shear_factors(0.3) == pytest.approx(Circle(1.0).shear_factors(0.3), rel=1e-14)
    # Thin round tube, Cowper's table: 2(1 + nu)/(4 + 3 nu).
    thin = Annulus(1.0, 1.0 - 1e-9).shear_factors(0.3)[0]
    assert thin == pytest.approx(2.0 * 1.3 / 4.9, rel=1e-9)
    # Thin square tube, Cowper's table.
    assert SquareTube(1.0, 0.01).shear_factors(0.3)[1] == pytest.approx(20.0 * 1.3 / (48.0 + 11.7), rel=1e-14)


def test_overrides_replace_formulas():
    section = Rectangle(1.0, 2.0, torsion_constant=0.25, shear_factor_2=0.9)
    assert section.torsion() == 0.25
    k1, k2 = section.shear_factors(0.2)
    assert (k1, k2) == (pytest.approx(12.0 / 14.2, rel=1e-14), 0.9)


@pytest.mark.parametrize(
    "section", [*SHAPES, SectionProperties(1.0, 0.2, 0.3, 0.4, 0.8, 0.9)], ids=lambda s: s.shape
)
def test_matrices(section):
    material = Material(3.0e6, 0.25, 1200.0, damping=KelvinVoigt(0.03, 0.01))
    stiffness, damping, inertia = section.matrices(material)
    area, first, second = section.moments()
    k1, k2 = section.shear_factors(0.25)
    young, shear = 3.0e6, 1.2e6
    tau_e = ((1 - 0.5) * 0.01 + 2 * 1.25 * 0.03) / 3
    expected = [k1 * shear * area, k2 * shear * area, young * area, young * first, young * second]
    expected.append(shear * section.torsion())
    assert stiffness == pytest.approx(np.diag(expected), rel=1e-14)
    times = [0.03, 0.03, tau_e, tau_e, tau_e, 0.03]
    assert damping == pytest.approx(np.diag(np.multiply(expected, times)), rel=1e-13)
    mass = np.diag([area, area, area, first, second, first + second])
    assert inertia == pytest.approx(1200.0 * mass, rel=1e-14)


@pytest.mark.parametrize(
    ("build", "path"),
    [
        (lambda: Circle(0.0), "Circle.radius"),
        (lambda: Circle(-1.0), "Circle.radius"),
        (lambda: Circle(math.nan), "Circle.radius"),
        (lambda: Annulus(1.0, 1.0), "Annulus.inner_radius"),
        (lambda: Annulus(1.0, 2.0), "Annulus.inner_radius"),
        (lambda: Rectangle(1.0, [1.0]), "Rectangle.height"),
        (lambda: Rectangle(1.0), "Rectangle.height"),
        (lambda: Rectangle(1.0, 1.0, shear_factor_1=0.0), "Rectangle.shear_factor_1"),
        (lambda: Ellipse(1.0, math.inf), "Ellipse.semi_axis_2"),
        (lambda: SquareTube(1.0, 0.5), "SquareTube.thickness"),
        (lambda: SectionProperties(1.0, 1.0, 1.0, -1.0), "SectionProperties.torsion_constant"),
        (lambda: Rectangle(1.0, 2.0, 3.0), "Rectangle"),
        (lambda: Rectangle(1.0, 2.0, width=3.0), "Rectangle.width"),
        (lambda: Circle(1.0).matrices(None), "material"),
    ],
)
def test_refused(build, path):
    with pytest.raises(InputError) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead
