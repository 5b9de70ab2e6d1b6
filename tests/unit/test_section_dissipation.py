"""Damping of sections against the power that the 3D strain rates of Linn, Lang and Tuganov (2013, LLT) dissipate."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.section_matrices import material, scaled
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.sections.composite import Composite, CompositeRegion
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.saint_venant import shear_shares
from viscorod.model.sections.section_mesh import triangulate
from viscorod.model.sections.section_shapes import Rectangle

L_SHAPE = [(0.0, 0.0), (0.05, 0.0), (0.05, 0.01), (0.02, 0.01), (0.02, 0.04), (0.0, 0.04)]
L_BOXES = [((0.0, 0.05), (0.0, 0.01)), ((0.0, 0.02), (0.01, 0.04))]
RECTANGLE = [((-0.02, 0.02), (-0.01, 0.01))]

NONE = st.just(0.0)


def power(boxes, eps, eta, zeta, nu, warping_slopes=lambda x, y: (0.0, 0.0)):
    """Int e_t : (zeta I x I + 2 eta P) : e_t over boxes by Gauss quadrature, P the projector on deviators.

    Strain rates: LLT (12) H = Gamma + kappa x xi; LLT (16), (19): E33 = H3, E_aa = -nu H3, E_a3 = H_a/2.
    """
    g, w = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for (x0, x1), (y0, y1) in boxes:
        x, y = np.meshgrid(
            (x0 + x1) / 2 + g * (x1 - x0) / 2, (y0 + y1) / 2 + g * (y1 - y0) / 2, indexing="ij"
        )
        weight = np.outer(w, w) * (x1 - x0) * (y1 - y0) / 4
        xi = np.stack([x, y, 0 * x], axis=-1)
        H = eps[:3] + np.cross(np.broadcast_to(eps[3:], xi.shape), xi)
        wx, wy = warping_slopes(x, y)
        E = np.zeros((*x.shape, 3, 3))
        E[..., 0, 0] = E[..., 1, 1] = -nu * H[..., 2]
        E[..., 2, 2] = H[..., 2]
        E[..., 0, 2] = E[..., 2, 0] = (H[..., 0] + eps[5] * wx) / 2
        E[..., 1, 2] = E[..., 2, 1] = (H[..., 1] + eps[5] * wy) / 2
        trace = np.trace(E, axis1=-2, axis2=-1)
        deviator = E - trace[..., None, None] * np.eye(3) / 3
        density = zeta * trace**2 + 2 * eta * (deviator**2).sum(axis=(-2, -1))
        total += (weight * density).sum()
    return total


@given(
    nu=st.floats(-0.9, 0.499),
    eta=NONE | st.floats(1e-30, 1e4),
    zeta=NONE | st.floats(1e-30, 1e4),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=40)
def test_a_rectangle_without_warping(nu, eta, zeta, seed):
    """LLT's kinematics is without warping: shear factors 1, J = I1 + I2."""
    plain = Rectangle(0.04, 0.02)
    stiff = SectionProperties(plain.area, plain.second_moment_1, plain.second_moment_2,
                    plain.second_moment_1 + plain.second_moment_2)  # fmt: skip
    damping = KelvinVoigt(shear_viscosity=eta, bulk_viscosity=zeta)
    _, D, _ = stiff.matrices(Material(youngs_modulus=1e6, poissons_ratio=nu, density=1.0, damping=damping))
    eps = np.random.default_rng(seed).normal(size=6)
    assert eps @ D @ eps == pytest.approx(power(RECTANGLE, eps, eta, zeta, nu), rel=1e-10, abs=1e-12)


@given(
    nu=st.floats(-0.9, 0.499),
    shear=NONE | st.floats(1e-30, 1.0),
    bulk=NONE | st.floats(1e-30, 1.0),
    seed=st.integers(0, 10**6),
)
@settings(max_examples=20)
def test_extension_and_bending_of_an_outline_about_a_line_beside_it(nu, shear, bulk, seed):
    section = PolygonSection(L_SHAPE, origin="given", mesh_size=0.01)
    law = material(2e6, nu, shear, bulk, density=1200.0)
    C, D, M = section.matrices(law)
    eps = np.random.default_rng(seed).normal(size=6) * [0, 0, 1, 1, 1, 0]
    found = power(L_BOXES, eps, law.shear_viscosity, law.bulk_viscosity, nu)
    assert eps @ D @ eps == pytest.approx(found, rel=1e-9, abs=1e-15)
    # with the moduli in the place of the viscosities it is the elastic energy
    found = power(L_BOXES, eps, law.shear_modulus, law.bulk_modulus, nu)
    assert eps @ C @ eps == pytest.approx(found, rel=1e-9)
    # kinetic energy of a rigid motion with the same six numbers
    motion = np.random.default_rng(seed + 1).normal(size=6)
    assert motion @ M @ motion == pytest.approx(kinetic(L_BOXES, motion) * law.density, rel=1e-10)


def kinetic(boxes, motion):
    """Int |v + w x xi|^2 by Gauss quadrature."""
    g, w = np.polynomial.legendre.leggauss(4)
    total = 0.0
    for (x0, x1), (y0, y1) in boxes:
        x, y = np.meshgrid(
            (x0 + x1) / 2 + g * (x1 - x0) / 2, (y0 + y1) / 2 + g * (y1 - y0) / 2, indexing="ij"
        )
        xi = np.stack([x, y, 0 * x], axis=-1)
        velocity = motion[:3] + np.cross(np.broadcast_to(motion[3:], xi.shape), xi)
        total += (np.outer(w, w) * (velocity**2).sum(axis=-1)).sum() * (x1 - x0) * (y1 - y0) / 4
    return total


def rectangle_warping(a, b):
    """Slopes of the warping of a rectangle 2a x 2b by the series of Timoshenko and Goodier (section 109).

    w = x y + sum A_k sin(m x) sinh(m y) with m = (2k+1) pi/2a makes (w,x - y, w,y + x) free of traction.
    """
    k = np.arange(60)
    m = (2 * k + 1) * math.pi / (2 * a)
    # traction on y = +-b: w,y + x = 2x + sum A m sin(m x) cosh(m b) = 0, x = sum 2 (-1)^k/(a m^2) sin(m x)
    A = -2.0 * 2.0 * (-1.0) ** k / (a * m**3)

    def slopes(x, y):
        sx, cx = np.sin(m * x[..., None]), np.cos(m * x[..., None])
        up, down = np.exp(m * (y[..., None] - b)), np.exp(-m * (y[..., None] + b))
        whole = 1.0 + np.exp(-2 * m * b)  # cosh(m b) without its growth
        sinh, cosh = (up - down) / whole, (up + down) / whole
        return y + (A * m * cx * sinh).sum(-1), x + (A * m * sx * cosh).sum(-1)

    return slopes


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_torsion_of_a_rectangle_by_the_series_of_its_warping(nu):
    law = material(2e6, nu, shear=0.01)
    slopes = rectangle_warping(0.02, 0.01)
    twist = np.array([0, 0, 0, 0, 0, 1.0])
    found = power(RECTANGLE, twist, law.shear_viscosity, 0.0, nu, slopes)
    assert Rectangle(0.04, 0.02).matrices(law)[1][5, 5] == pytest.approx(found, rel=1e-5)
    corners = [(-0.02, -0.01), (0.02, -0.01), (0.02, 0.01), (-0.02, 0.01)]
    assert PolygonSection(corners).matrices(law)[1][5, 5] == pytest.approx(found, rel=1e-4)


SECTIONS = {
    "rectangle": lambda law: Rectangle(0.04, 0.02).matrices(law),
    "outline": lambda law: PolygonSection(L_SHAPE, origin="given").matrices(law),
    "composite": lambda law: Composite([CompositeRegion(law, points=L_SHAPE)], origin="given").matrices(),
}


@pytest.mark.parametrize("kind", SECTIONS)
@pytest.mark.parametrize("nu", [0.0, 0.2, 0.5])
def test_the_limits_of_llt(kind, nu):
    """LLT (4): tau_E = (tau_B + 2 tau_S)/3 for nu = 0, tau_S for nu = 1/2, tau for equal times."""
    C, D, _ = SECTIONS[kind](material(2e6, nu, shear=0.02, bulk=0.02))
    assert D == pytest.approx(0.02 * C, rel=1e-12)
    shear, bulk = 0.02, 0.05
    C, D, _ = SECTIONS[kind](material(2e6, nu, shear=shear, bulk=bulk))
    tau_E = {0.0: (bulk + 2 * shear) / 3, 0.2: (0.6 * bulk + 2.4 * shear) / 3, 0.5: shear}[nu]
    extension, shearing = [2, 3, 4], [0, 1, 5]
    assert D[np.ix_(extension, extension)] == pytest.approx(
        tau_E * C[np.ix_(extension, extension)], rel=1e-12
    )
    assert D[np.ix_(shearing, shearing)] == pytest.approx(shear * C[np.ix_(shearing, shearing)], rel=1e-12)
    assert not D[np.ix_(extension, shearing)].any()


def test_one_material_in_several_regions_is_one_material():
    law = material(2e6, 0.37, shear=0.01, bulk=0.03)
    below = [(0.0, 0.0), (0.05, 0.0), (0.05, 0.01), (0.0, 0.01)]
    above = [(0.0, 0.01), (0.02, 0.01), (0.02, 0.04), (0.0, 0.04)]
    parted = Composite(
        [CompositeRegion(law, points=below), CompositeRegion(law, points=above)], mesh_size=0.0015
    )
    whole = PolygonSection(L_SHAPE, mesh_size=0.0015)
    for one, two in zip(parted.matrices(), whole.matrices(law), strict=True):
        assert scaled(one, by=two) == pytest.approx(scaled(two), abs=2e-4)


def test_equal_times_in_all_materials_scale_the_stiffness():
    stiff, soft = material(2e9, 0.3, shear=0.01, bulk=0.01), material(1e7, 0.45, shear=0.01, bulk=0.01)
    section = Composite(
        [
            CompositeRegion(stiff, Rectangle(0.04, 0.01)),
            CompositeRegion(soft, Rectangle(0.02, 0.02), at=(-0.01, 0.015)),
        ],
        origin="given",
    )
    C, D, _ = section.matrices()
    assert np.abs(C - np.diag(np.diag(C))).max() > 0.0
    assert D == pytest.approx(0.01 * C, rel=1e-10)


def two_layers(mesh_size, lower, upper, nu=0.0):
    """P and the areas of two layers, 0.04 x 0.01 below and 0.04 x 0.02 above, on one mesh."""
    boxes = [
        (((-0.02, y0), (0.02, y0), (0.02, y1), (-0.02, y1)), ()) for y0, y1 in ((0.0, 0.01), (0.01, 0.03))
    ]
    mesh = triangulate(tuple(boxes), mesh_size)
    youngs, shear = np.array([lower[0], upper[0]]), np.array([lower[1], upper[1]])
    heights = np.array([0.005, 0.02])
    areas = np.array([4e-4, 8e-4])
    centre = np.array([0.0, (youngs * areas) @ heights / (youngs @ areas)])
    return shear_shares(mesh, centre, youngs, shear, nu)


def stiffness_of(youngs, shear):
    P = two_layers(0.003, (youngs[0], shear[0]), (youngs[1], shear[1]))
    return np.linalg.inv(shear[0] * P[0] + shear[1] * P[1])


def test_the_shares_are_the_derivatives_of_the_stiffness_by_the_moduli():
    """The complex stiffness to first order in the frequency: D = sum eta_m dK/dG_m, by central differences."""
    youngs, shear = np.array([5.0, 1.0]), np.array([2.0, 0.3])
    P, K = two_layers(0.003, (5.0, 2.0), (1.0, 0.3)), stiffness_of(youngs, shear)
    for m in (0, 1):
        step = 1e-5 * shear[m] * np.eye(2)[m]
        slope = (stiffness_of(youngs, shear + step) - stiffness_of(youngs, shear - step)) / (2 * step[m])
        assert scaled(K @ P[m] @ K, by=slope) == pytest.approx(scaled(slope), abs=1e-7)


def test_shear_of_layers_by_the_shear_flow():
    """Jourawski: with nu = 0 the shear stress of a layered rectangle depends on y only, and t b is the integral of the

    axial stress gradient above y. Forces along d2, one material share after the other.
    """
    (E1, G1), (E2, G2), b = (5.0, 2.0), (1.0, 0.3), 0.04
    y0 = (E1 * 0.01 * 0.005 + E2 * 0.02 * 0.02) / (E1 * 0.01 + E2 * 0.02)
    rigidity = b * (
        E1 * (0.01**3 / 12 + 0.01 * (0.005 - y0) ** 2) + E2 * (0.02**3 / 12 + 0.02 * (0.02 - y0) ** 2)
    )
    g, w = np.polynomial.legendre.leggauss(6)
    lower, upper = 0.005 * (1 + g), 0.01 + 0.01 * (1 + g)
    # the integral of E (y - y0) from 0 to y
    below = E1 * ((lower - y0) ** 2 - y0**2) / 2
    above = E1 * ((0.01 - y0) ** 2 - y0**2) / 2 + E2 * ((upper - y0) ** 2 - (0.01 - y0) ** 2) / 2
    shares = [
        b * (0.005 * w * (below / rigidity / G1) ** 2).sum(),
        b * (0.01 * w * (above / rigidity / G2) ** 2).sum(),
    ]
    P = two_layers(0.002, (E1, G1), (E2, G2))
    assert P[:, 1, 1] == pytest.approx(shares, rel=1e-4)


def prandtl(G1, G2, n):
    """Torsion of the two layers by Prandtl's stress function on a grid: div(grad phi/G) = -2, phi = 0 outside.

    Finite volumes, cell faces on the interface. Returns the torsion stiffness and P of a unit torque.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import spsolve

    h, ny, nx = 0.03 / (3 * n), 3 * n, 4 * n  # unknowns at the interior grid points
    index = -np.ones((ny + 1, nx + 1), dtype=int)
    index[1:-1, 1:-1] = np.arange((ny - 1) * (nx - 1)).reshape(ny - 1, nx - 1)
    cell = np.where(np.arange(ny) < n, 1.0 / G1, 1.0 / G2)  # 1/G of the row of cells j..j+1
    rows, columns, values = [], [], []

    def link(first, second, weight):
        for i, j in ((first, second), (second, first)):
            mask = i >= 0
            rows.append(i[mask]), columns.append(i[mask]), values.append(weight[mask])
            mask = (i >= 0) & (j >= 0)
            rows.append(i[mask]), columns.append(j[mask]), values.append(-weight[mask])

    vertical = np.repeat(cell[:, None], nx + 1, axis=1)
    link(index[:-1].ravel(), index[1:].ravel(), vertical.ravel())
    horizontal = np.zeros((ny + 1, nx))
    horizontal[1:-1] = ((cell[:-1] + cell[1:]) / 2)[:, None]
    link(index[:, :-1].ravel(), index[:, 1:].ravel(), horizontal.ravel())
    size = (ny - 1) * (nx - 1)
    matrix = coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (size, size)
    )
    phi = np.zeros((ny + 1, nx + 1))
    phi[1:-1, 1:-1] = spsolve(matrix.tocsc(), np.full(size, 2.0 * h**2)).reshape(ny - 1, nx - 1)
    rigidity = 2.0 * phi.sum() * h**2
    along = ((phi[1:] - phi[:-1]) ** 2).sum(axis=1)  # squares of the slopes, cell row by cell row
    across = ((phi[:, 1:] - phi[:, :-1]) ** 2).sum(axis=1)
    per_row = along + (across[:-1] + across[1:]) / 2
    strain = per_row * cell**2 / rigidity**2
    return rigidity, np.array([strain[:n].sum(), strain[n:].sum()])


def test_torsion_of_two_materials_by_prandtls_function():
    """Richardson's extrapolation of a second-order grid solution in stresses, against elements in displacements."""
    G1, G2 = 2.0, 0.3
    (coarse, some), (fine, more) = prandtl(G1, G2, 40), prandtl(G1, G2, 80)
    rigidity, shares = fine + (fine - coarse) / 3, more + (more - some) / 3
    P = two_layers(0.001, (5.0, G1), (1.0, G2))
    K = np.linalg.inv(G1 * P[0] + G2 * P[1])
    # the torsion stiffness is that about the shear centre: 1/F22
    assert 1.0 / (G1 * P[0] + G2 * P[1])[2, 2] == pytest.approx(rigidity, rel=2e-4)
    assert P[:, 2, 2] == pytest.approx(shares, rel=5e-4)
    assert K[2, 2] > rigidity
