"""Inputs of other programs: each law as that program's source states it, written out here, against viscorod's D.

The worked examples are those of docs/reference/damping_programs.md: the cantilever of Linn, Lang and Tuganov
(0.01 m x 0.01 m, E 1 MPa, nu 0.3) with the times 0.02 s in shear and 0.03 s in volume change.
"""

import math
import re
import warnings
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import viscorod as vr
from viscorod import programs as vd
from viscorod.errors import InputError

OPTIONS = {"segment_length": 0.025, "frequency": 0.57}
TAU_E = (0.4 * 0.03 + 2.6 * 0.02) / 3.0  # LLT 4


def rubber(bulk_time=0.03, nu=0.3):
    return vr.Material(1e6, nu, 1000.0, damping=vr.KelvinVoigt(0.02, bulk_time))


def data_of(section=None, material=None):
    section = section or vr.Rectangle(0.01, 0.01)
    shaped = not isinstance(section, vr.StiffnessSection)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=section, material=(material or rubber()) if shaped else None
    )
    return vd.SectionData.of(rod)


def given_options(kind):
    return {word: OPTIONS[word] for word in kind.options}


def coupled(seed=0, size=0.3):
    """A stiffness with all couplings and strains of very different size."""
    rng = np.random.default_rng(seed)
    noise = rng.uniform(-1.0, 1.0, (6, 6))
    correlation = np.eye(6) + size * (noise + noise.T) / 2.0 * (1.0 - np.eye(6))
    scale = 10.0 ** rng.uniform(-2.0, 2.0, 6)
    return correlation * scale[:, None] * scale[None, :]


def rotation(seed):
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return matrix * np.linalg.det(matrix)


# ---- section matrices, times and materials


def test_six_times_of_a_material_and_back():
    data = data_of()
    assert data.times == pytest.approx([0.02, 0.02, TAU_E, TAU_E, TAU_E, 0.02], rel=1e-14)
    fit = vd.fit_material(data.times, 0.3)
    assert (fit.shear_time, fit.bulk_time) == pytest.approx((0.02, 0.03), rel=1e-9)
    assert fit.extensional_time == pytest.approx(TAU_E, rel=1e-9)
    assert fit.largest_deviation < 1e-12


def test_the_closest_material_is_a_least_squares_solution():
    times = np.array([0.02, 0.03, 0.04, 0.025, 0.05, 0.01])
    fit = vd.fit_material(times, 0.3)

    def cost(shear, bulk):
        extension = (0.4 * bulk + 2.6 * shear) / 3.0
        model = np.array([shear, shear, extension, extension, extension, shear])
        return ((model / times - 1.0) ** 2).sum()

    assert fit.shear_time > 0.0
    assert fit.bulk_time > 0.0
    best = cost(fit.shear_time, fit.bulk_time)
    for step in (1e-4, -1e-4):
        assert cost(fit.shear_time + step, fit.bulk_time) > best
        assert cost(fit.shear_time, fit.bulk_time + step) > best
    model = np.array([fit.shear_time] * 2 + [fit.extensional_time] * 3 + [fit.shear_time])
    assert fit.deviations == pytest.approx(model / times - 1.0, abs=1e-12)


def test_no_viscosity_is_negative_in_a_fit():
    fit = vd.fit_material([0.02, 0.02, 0.001, 0.001, 0.001, 0.02], 0.3)
    assert fit.bulk_time == 0.0
    assert fit.largest_deviation > 0.1
    assert vd.fit_material(np.zeros(6), 0.3).largest_deviation == 0.0
    incompressible = vd.fit_material(np.full(6, 0.02), 0.5)
    assert (incompressible.shear_time, incompressible.bulk_time) == pytest.approx((0.02, 0.02))
    unfit = vd.fit_material([0.0, 0.02, 0.02, 0.02, 0.02, 0.02], 0.3)
    assert unfit.deviations[0] == math.inf


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([0.1] * 5, "times: 5 numbers: six are needed; give one each for shear_1"),
        ([0.1] * 5 + [-1.0], r"times\[5\]: -1: a retardation time must not be negative"),
        ([0.1] * 5 + [math.nan], r"times\[5\]: nan"),
    ],
)
def test_six_times_are_checked(times, message):
    with pytest.raises(InputError, match=message):
        vd.symmetric_damping(np.eye(6), times)


def test_poissons_ratio_of_a_fit_is_checked():
    with pytest.raises(InputError, match=r"poissons_ratio: 0\.6"):
        vd.fit_material([0.1] * 6, 0.6)


# ---- products of times with a stiffness


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.4))
@settings(max_examples=60)
def test_the_smallest_factor_is_where_the_power_of_a_product_turns_negative(seed, size):
    rng = np.random.default_rng(seed)
    stiffness, mu = coupled(seed, size), 10.0 ** rng.uniform(-4.0, -1.0, 6)
    check = vd.check_product(stiffness, mu)
    diagonal = np.diag(np.diag(stiffness))

    def lowest(factor):
        law = mu[:, None] * (diagonal + factor * (stiffness - diagonal))
        scale = np.sqrt(mu * np.diag(stiffness))
        return np.linalg.eigvalsh((law + law.T) / 2.0 / scale[:, None] / scale[None, :])[0]

    if np.isfinite(check.factor):
        assert lowest(check.factor) == pytest.approx(0.0, abs=1e-9)
        assert lowest(0.99 * check.factor) > 0.0 > lowest(1.01 * check.factor)
        law = mu[:, None] * (diagonal + 1.01 * check.factor * (stiffness - diagonal))
        assert check.strain_rate @ law @ check.strain_rate < 0.0
    assert check.creates_energy == vd.creates_energy(mu[:, None] * stiffness, stiffness)
    # both orders take the same power
    rate = rng.normal(size=6)
    assert rate @ (mu[:, None] * stiffness) @ rate == pytest.approx(rate @ (stiffness * mu) @ rate, rel=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 10.0, 1000.0])
def test_the_limit_of_one_coupling(ratio):
    limit = 2.0 * math.sqrt(ratio) / (1.0 + ratio)
    for correlation, creates in ((0.999 * limit, False), (min(1.001 * limit, 0.9999), ratio > 1.0)):
        stiffness = np.diag([1.0, 1.0, 4.0, 1.0, 1.0, 100.0])
        stiffness[2, 5] = stiffness[5, 2] = correlation * 20.0
        check = vd.check_product(stiffness, [0.01, 0.01, 0.01, 0.01, 0.01, 0.01 * ratio])
        (coupling,) = check.couplings
        assert coupling.strains == ("stretch", "twist")
        assert coupling.limit == pytest.approx(limit, rel=1e-12)
        assert coupling.correlation == pytest.approx(correlation, rel=1e-12)
        assert check.creates_energy == creates
        assert ("creates energy in some motions" in check.text()) == creates


def test_an_undamped_strain_that_is_coupled_makes_any_product_create_energy():
    stiffness = np.eye(6)
    stiffness[0, 5] = stiffness[5, 0] = 1e-4
    mu = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1])
    check = vd.check_product(stiffness, mu)
    assert check.factor == 0.0
    assert check.strain_rate @ (mu[:, None] * stiffness) @ check.strain_rate < 0.0


def test_products_without_couplings_or_with_equal_times_create_nothing():
    assert vd.check_product(np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), np.arange(6.0)).factor == math.inf
    check = vd.check_product(coupled(3), np.full(6, 0.02))
    assert check.factor == math.inf
    assert "never creates energy here" in check.text()
    assert not vd.check_product(coupled(3), np.zeros(6)).creates_energy


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_the_symmetric_matrix_never_creates_energy(seed):
    rng = np.random.default_rng(seed)
    stiffness, times = coupled(seed), rng.uniform(0.0, 1.0, 6)
    times[rng.integers(6)] = 0.0
    damping = vd.symmetric_damping(stiffness, times)
    rates = rng.normal(size=(100, 6)) / np.sqrt(np.diag(stiffness))
    assert np.einsum("ni,ij,nj->n", rates, damping, rates).min() >= -1e-12
    assert vd.component_times(stiffness, damping) == pytest.approx(times, rel=1e-12, abs=0.0)


def test_couplings_of_one_material_are_products_exactly():
    """A shear centre off the centre line couples shear and twist, which have one time: T C T = tau C = D."""
    elastic = np.diag([0.0, 0.0, 3.0, 1.0, 2.0, 0.0])
    elastic[2, 3] = elastic[3, 2] = 0.5
    shearing = np.diag([2.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    shearing[0, 5] = shearing[5, 0] = 0.4
    material = rubber()
    stiffness = material.youngs_modulus * elastic + material.shear_modulus * shearing
    damping = material.extensional_viscosity * elastic + material.shear_viscosity * shearing
    times = vd.component_times(stiffness, damping)
    assert vd.symmetric_damping(stiffness, times) == pytest.approx(damping, rel=1e-12)
    assert times[:, None] * stiffness == pytest.approx(damping, rel=1e-12)
    assert vd.check_product(stiffness, times).factor == math.inf


# ---- the programs' own laws


def test_beamdyn_as_its_source_computes_it():
    """betaC = (R mu R^T)(R S R^T) in the global axes, strain rates v' - w x r' and w' (BeamDyn.f90)."""
    stiffness, mu, turn = coupled(5), np.array([1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3]), rotation(1)
    rng = np.random.default_rng(2)
    tangent, velocity_slope, spin, spin_slope = rng.normal(size=(4, 3))
    both = np.kron(np.eye(2), turn)
    beta_c = (both @ np.diag(mu) @ both.T) @ (both @ stiffness @ both.T)
    rate = np.concatenate([velocity_slope + np.cross(tangent, spin), spin_slope])
    force = beta_c @ rate
    # viscorod: body-frame rates V_t = R^T (v' - w x r'), U_t = R^T w'
    body = np.concatenate([turn.T @ (velocity_slope - np.cross(spin, tangent)), turn.T @ spin_slope])
    inputs = vd.BeamDyn(tuple(mu))
    assert both.T @ force == pytest.approx(inputs.law(stiffness) @ body, rel=1e-10)


def test_beamdyn_text_takes_the_place_of_the_lines_of_a_blade_file(tmp_path):
    """BeamDyn reads its file by the order of lines, headings too (BD_ReadBladeFile)."""
    rod = vr.Rod.straight((0, 0, 0), (0, 0, 9), section=vr.Rectangle(0.3, 0.02), material=rubber())
    path = tmp_path / "blade.dat"
    vd.write_beamdyn_blade(rod, path)
    lines = path.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.split()[1:2] == ["damp_type"])
    pasted = vd.BeamDyn((1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3)).text().splitlines()
    headings = [k for k, line in enumerate(pasted) if line.startswith("---")]
    assert headings == [k for k, line in enumerate(lines[first:][: len(pasted)]) if line.startswith("---")]
    path.write_text("\n".join([*lines[:first], *pasted, *lines[first + len(pasted) :]]) + "\n")
    assert vd.read_beamdyn_blade(path).mu == pytest.approx([1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3], rel=1e-15)


def test_gxbeam_as_its_source_computes_it():
    """Strain from the force less mu times the rate, S^-1 F - mu e_t = e, in the order axial first."""
    stiffness, mu = coupled(6), (1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3)
    places = [2, 0, 1, 5, 3, 4]
    ordered = stiffness[np.ix_(places, places)]
    strain, rate = np.random.default_rng(3).normal(size=(2, 6)) / np.sqrt(np.diag(ordered))
    force = ordered @ (strain + np.array(mu) * rate)
    assert np.linalg.solve(ordered, force) - np.array(mu) * rate == pytest.approx(strain, rel=1e-9)
    back = np.argsort(places)
    inputs = vd.GXBeam(mu)
    assert inputs.law(stiffness) @ rate[back] + stiffness @ strain[back] == pytest.approx(
        force[back], rel=1e-9
    )
    assert "take the same power" in inputs.losses(data_of(vr.StiffnessSection(stiffness, np.eye(6))))[-1]


def mbdyn_matrices(text):
    """The two matrices of a pasted law: diag, or sym with the upper triangle."""
    words = [w.strip() for line in text.splitlines() if "#" not in line for w in line.split(",") if w.strip()]
    assert words.pop(0) == "linear viscoelastic generic"
    matrices = []
    while words:
        kind = words.pop(0)
        matrix = np.zeros((6, 6))
        for i in range(6):
            for j in [i] if kind == "diag" else range(i, 6):
                matrix[i, j] = matrix[j, i] = float(words.pop(0))
        matrices.append(matrix)
    return matrices


@pytest.mark.parametrize("couple", [False, True])
def test_mbdyn_text_holds_both_matrices(couple):
    if couple:
        stiffness = coupled(7)
        times = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06]
        section = vr.StiffnessSection(stiffness, np.eye(6), vd.symmetric_damping(stiffness, times))
        data = data_of(section)
    else:
        data = data_of()
    inputs = vd.MBDyn.from_section(data)
    places = [2, 0, 1, 5, 3, 4]
    elastic, viscous = mbdyn_matrices(inputs.text())
    assert elastic == pytest.approx(data.stiffness[np.ix_(places, places)], rel=1e-9)
    assert viscous == pytest.approx(data.damping[np.ix_(places, places)], rel=1e-9)
    assert inputs.law(data.stiffness) == pytest.approx(data.damping, rel=1e-14)
    assert inputs.losses(data) == ("nothing: the 6x6 damping matrix is taken as it is",)
    factor = vd.MBDyn.from_numbers([0.02], data)
    assert factor.law(data.stiffness) == pytest.approx(0.02 * data.stiffness)


def test_matrices_of_other_programs_come_back():
    """A symmetric matrix is taken as it is, an unsymmetric one (MBDyn does not check) becomes T C T with a warning."""
    stiffness = coupled(7)
    damping = vd.symmetric_damping(stiffness, [0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    data = data_of(vr.StiffnessSection(stiffness, np.eye(6), damping))
    places = [2, 0, 1, 5, 3, 4]
    ordered = damping[np.ix_(places, places)]
    for kind in (vd.MBDyn, vd.Exudyn):
        for numbers in (ordered[np.triu_indices(6)], ordered.ravel()):
            found = kind.from_numbers(numbers, data).recovered(data)
            assert found.damping == pytest.approx(damping, rel=1e-12)
            assert found.difference == 0.0
    wrong = ordered.copy()
    wrong[0, 4] *= -3.0
    inputs = vd.MBDyn.from_numbers(wrong.ravel(), data)
    found = inputs.recovered(data)
    assert found.damping == pytest.approx(damping, rel=1e-12)
    assert any("is not symmetric" in text for text in found.warnings)
    assert "matr, " in inputs.text()
    with pytest.raises(InputError, match="mbdyn: 7 numbers: MBDyn has a 6x6 matrix here; give 6 numbers"):
        vd.MBDyn.from_numbers([1.0] * 7, data)


def test_chrono_tapered_coefficients_enter_squared():
    """Rm(0,0) = EA/L bx^2 and Rlaw = mb^T Klaw mb with mb = diag(bx, by, bz, bt, bz, by) (FPM element)."""
    section = vr.Rectangle(0.01, 0.02)
    data = data_of(section)
    inputs = vd.ChronoTapered.from_section(data)
    assert inputs.bx**2 == pytest.approx(TAU_E)
    assert inputs.bt**2 == pytest.approx(0.02)
    stiffness = coupled(8)
    places = [2, 0, 1, 5, 3, 4]
    b = np.diag([0.1, 0.2, 0.3, 0.4, 0.3, 0.2])
    ordered = b.T @ stiffness[np.ix_(places, places)] @ b
    assert vd.ChronoTapered(0.1, 0.2, 0.3, 0.4).law(stiffness)[np.ix_(places, places)] == pytest.approx(
        ordered, rel=1e-12
    )
    assert any("shear_1 has the time" in text for text in inputs.losses(data))


def test_chrono_by_belongs_to_bending_about_z_and_shear_along_y():
    """Chrono's y is d1, its z is d2; bending about z is bend_2 and bends towards y."""
    times = vd.ChronoTapered(0.0, 0.2, 0.3, 0.0).times
    assert times == pytest.approx([0.04, 0.09, 0.0, 0.09, 0.04, 0.0])


def test_chrono_cosserat_laws():
    data = data_of()
    rayleigh = vd.ChronoRayleigh.from_section(data)
    assert rayleigh.beta == pytest.approx(TAU_E)
    assert rayleigh.law(data.stiffness) == pytest.approx(TAU_E * data.stiffness)
    linear = vd.ChronoLinear.from_section(data)
    assert linear.coefficients[:3] == pytest.approx([TAU_E * 100.0, *np.diag(data.damping)[:2]])
    assert linear.law(data.stiffness) == pytest.approx(data.damping)
    assert linear.losses(data) == ()


def test_exudyn_text_is_the_matrix():
    data = data_of()
    pasted = SimpleNamespace()
    exec(vd.Exudyn.from_section(data).text(), {"np": np, "sectionData": pasted})
    places = [2, 0, 1, 5, 3, 4]
    assert pasted.dampingMatrix == pytest.approx(data.damping[np.ix_(places, places)], rel=1e-9)
    inputs = vd.Exudyn.from_section(data)
    assert inputs.numbers[0] == pytest.approx(TAU_E * 100.0)
    assert inputs.numbers[4] == pytest.approx(TAU_E * 1e6 * 1e-8 / 12.0)
    assert f"bendingDamping={inputs.numbers[4]:.10g}" in inputs.text()


def chain(stiffness, damping, masses):
    """Damping ratio over half the angular frequency of each swinging mode, s; equal to the time it has."""
    count = len(masses)
    inverse = np.diag(1.0 / masses)
    system = np.block([[np.zeros((count, count)), np.eye(count)], [-inverse @ stiffness, -inverse @ damping]])
    roots = np.linalg.eigvals(system)
    roots = roots[roots.imag > 1e-9 * np.abs(roots).max()]
    return 2.0 * -roots.real / np.abs(roots) ** 2


def test_mujoco_joints_give_bending_the_time_of_extension():
    """A planar chain of segments, torque -(EI/l) angle - damping rate, as in cable.cc and the joint's damping."""
    inputs = vd.MuJoCo.from_section(data_of(), segment_length=0.025)
    assert inputs.joint_damping == pytest.approx(TAU_E * 1e6 * 1e-8 / 12.0 / 0.025)
    count, length, spring = 12, 0.025, 1e6 * 1e-8 / 12.0 / 0.025
    # small angles of segments; the joint turns by the difference of two; masses lumped at the segments' ends
    difference = np.eye(count) - np.eye(count, k=-1)
    lower = np.tril(np.ones((count, count)))
    mass = length**2 * lower.T @ lower * 1000.0 * 1e-4 * length
    values, vectors = np.linalg.eigh(mass)
    root = vectors / np.sqrt(values) @ vectors.T
    shape = root @ difference.T @ difference @ root
    times = chain(spring * shape, inputs.joint_damping * shape, np.ones(count))
    assert times == pytest.approx(np.full(len(times), TAU_E), rel=1e-6)
    assert len(times) >= 1
    assert 'damping="0.0007111111111"' in inputs.text()


def test_newton_joints_give_stretch_its_time():
    inputs = vd.Newton.from_section(data_of(), segment_length=0.025)
    assert inputs.damping[0] == pytest.approx(TAU_E * 1e6 * 1e-4 / 0.025)
    count = 12
    difference = np.eye(count) - np.eye(count, k=-1)
    shape = difference.T @ difference
    times = chain(inputs.stiffness[0] * shape, inputs.damping[0] * shape, np.full(count, 0.0025))
    assert times == pytest.approx(np.full(len(times), TAU_E), rel=1e-6)
    assert "bend_stiffness=0.03333333333, bend_damping=0.0007111111111," in inputs.text()


# ---- ANCF (LLT 2.6)


def test_ancf_factors_give_the_lame_constants_of_the_paper():
    """gamma_v1 = tau_B, gamma_v2 = tau_S, mu_v = G tau_S, lambda_v = K tau_B - 2/3 G tau_S = zeta - 2/3 eta."""
    inputs, material = vd.ANCF.from_section(data_of()), rubber()
    assert inputs.numbers == pytest.approx((0.03, 0.02), rel=1e-14)
    eta, zeta = material.shear_viscosity, material.bulk_viscosity
    assert inputs.viscosities == pytest.approx((zeta - 2.0 / 3.0 * eta, eta), rel=1e-13)
    K, G = 1e6 / 3.0 / 0.4, 1e6 / 2.6
    assert inputs.viscosities == pytest.approx((K * 0.03 - 2.0 / 3.0 * G * 0.02, G * 0.02), rel=1e-13)
    assert inputs.lame == pytest.approx((K - 2.0 / 3.0 * G, G), rel=1e-13)
    for word, value in zip(("lambda_v", "mu_v"), inputs.viscosities, strict=True):
        assert f"{word} = {value:.10g}" in inputs.text()


@pytest.mark.parametrize("nu", [-0.4, 0.0, 0.3, 0.49])
def test_ancf_and_back(nu):
    """Both ways without loss; uniaxial stress of the solid, laterally free, gives tau_E to first order."""
    data = data_of(material=rubber(0.007, nu))
    inputs = vd.ANCF.from_section(data)
    found = vd.ANCF.from_numbers(inputs.numbers, data).recovered(data)
    assert found.damping == pytest.approx(data.damping, rel=1e-12)
    assert found.difference == 0.0
    assert (found.material.shear_time, found.material.bulk_time) == pytest.approx((0.02, 0.007), rel=1e-6)
    # 1/E* = 1/(9 K*) + 1/(3 G*) at a low frequency, from lambda and mu
    first, mu = (a + 1e-4j * b for a, b in zip(inputs.lame, inputs.viscosities, strict=True))
    modulus = mu * (3 * first + 2 * mu) / (first + mu)
    assert modulus.imag / modulus.real / 1e-4 == pytest.approx(inputs.times[2], rel=1e-6)
    rigid = (first + 2 * mu).imag / (first + 2 * mu).real / 1e-4
    assert inputs.time_of_rigid_section == pytest.approx(rigid, rel=1e-12)
    assert any("Poisson locking" in text for text in inputs.losses(data)) == (nu != 0.0)


def test_ancf_needs_a_compressible_material():
    with pytest.raises(
        InputError, match=r"ancf: nu = 0\.5: lambda of an incompressible material is infinite"
    ):
        vd.ANCF.from_section(data_of(material=rubber(0.02, 0.5)))
    with pytest.raises(
        InputError, match="ancf: a section given by its stiffness: the viscosities are those of"
    ):
        vd.ANCF.from_section(data_of(vr.StiffnessSection(np.eye(6), np.eye(6))))
    with pytest.raises(InputError, match=r"ancf\.gamma_v1: -1"):
        vd.ANCF.from_numbers([-1.0, 0.02], data_of())


@pytest.mark.parametrize("kind", [vd.SoRoSim, vd.SoRoMoX])
def test_sorosim_matrix(kind):
    """Eta diag(Ix, 3 Iy, 3 Iz, 3 A, A, A) with Ix = Iy + Iz (MEG.m), on a section with the same stiffness."""
    area, first = 2e-4, 3e-9
    section = vr.SectionProperties(area, first, first, 2.0 * first)
    data = data_of(section)
    inputs = kind.from_section(data)
    eta = inputs.eta
    assert eta == pytest.approx(data.material.extensional_viscosity / 3.0)
    expected = eta * np.diag([area, area, 3.0 * area, 3.0 * first, 3.0 * first, 2.0 * first])
    assert inputs.law(data.stiffness) == pytest.approx(expected, rel=1e-12)
    # the error of nu = 1/2: twist is off by eta_E/(3 eta) - 1
    error = data.material.extensional_viscosity / 3.0 / data.material.shear_viscosity - 1.0
    assert inputs.times[5] / 0.02 - 1.0 == pytest.approx(error, rel=1e-9)
    assert f"twist has the time {0.02 * (1 + error):.6g} s instead of 0.02 s, {error:+.1%}" in inputs.losses(
        data
    )
    assert "nu = 0.3 and eta_E/eta = 2.773" in inputs.losses(data)[-1]


def test_sorosim_loses_nothing_of_an_incompressible_material():
    material = vr.Material(1e6, 0.5, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    data = data_of(vr.Circle(0.01), material)
    assert vd.SoRoSim.from_section(data).losses(data) == (
        "nothing: eta_E = 3 eta for this material (nu = 0.5)",
    )


def test_sorosim_torsion_of_a_rectangle_is_told():
    data = data_of(vr.Rectangle(0.01, 0.04))
    assert any(
        "torsion stiffness is G (I1 + I2)" in text for text in vd.SoRoSim.from_section(data).losses(data)
    )
    with pytest.raises(
        InputError, match="sorosim: a section given by its stiffness: the viscosity is that of"
    ):
        vd.SoRoSim.from_section(data_of(vr.StiffnessSection(np.eye(6), np.eye(6))))


def test_pyelastica_agrees_at_one_frequency_only():
    """Velocities times exp(-constant dt) in each small step of an oscillator: the decay of the swing."""
    inputs = vd.PyElastica.from_section(data_of(), frequency=0.57)
    for frequency in (0.57, 5.7):
        omega = 2.0 * math.pi * frequency
        step = 1e-3 / omega
        x, v, peaks = 1.0, 0.0, []
        for _ in range(14000):
            old = v
            v = (v - step * omega * omega * x) * math.exp(-inputs.constant * step)
            x += step * v
            if old > 0.0 >= v:
                peaks.append(x)
        ratio = vd.ratio_from_log_decrement(math.log(peaks[0] / peaks[1]))
        assert ratio == pytest.approx(inputs.ratio(frequency), rel=0.01)
    assert inputs.ratio(0.57) == pytest.approx(math.pi * 0.57 * TAU_E, rel=1e-12)
    assert inputs.ratio(5.7) == pytest.approx(math.pi * 5.7 * TAU_E / 100.0, rel=1e-12)
    with pytest.raises(
        InputError, match=r"at 0.57 Hz has the same ratio with the extensional time 0.0213333 s"
    ):
        inputs.recovered(data_of())


# ---- both directions, for all of them


@pytest.mark.parametrize("word", [word for word in vd.PROGRAMS if word != "pyelastica"])
def test_numbers_come_back(word):
    kind, data = vd.PROGRAMS[word], data_of()
    options = given_options(kind)
    inputs = kind.from_section(data, **options)
    again = kind.from_numbers(inputs.numbers, data, **options)
    assert again.law(data.stiffness) == pytest.approx(inputs.law(data.stiffness), rel=1e-12)
    assert again.numbers == pytest.approx(inputs.numbers, rel=1e-12)
    found = inputs.recovered(data)
    assert found.difference == 0.0
    assert found.damping == pytest.approx(inputs.law(data.stiffness), rel=1e-12)
    assert found.material is not None
    if not any("has the time" in loss for loss in inputs.losses(data)):
        assert (found.material.shear_time, found.material.bulk_time) == pytest.approx((0.02, 0.03), rel=1e-6)
    for field in (kind.title, kind.meaning, *kind.sources, *kind.words):
        assert field


@pytest.mark.parametrize("word", list(vd.PROGRAMS))
def test_texts_and_sentences(word):
    kind, data = vd.PROGRAMS[word], data_of()
    inputs = kind.from_section(data, **given_options(kind))
    assert inputs.text().strip()
    for sentence in (*inputs.losses(data), *inputs.warnings(data)):
        assert "nan" not in sentence
        assert sentence == sentence.strip()


def test_coupled_products_are_warned_of_and_recovered_symmetric():
    stiffness = np.diag([1.0, 1.0, 4.0, 1.0, 1.0, 100.0])
    stiffness[2, 5] = stiffness[5, 2] = 0.7 * 20.0
    data = data_of(vr.StiffnessSection(stiffness, np.eye(6)))
    numbers = [0.01, 0.01, 0.001, 0.01, 0.01, 0.1]
    for kind, theirs in ((vd.BeamDyn, numbers), (vd.GXBeam, [0.001, 0.01, 0.01, 0.1, 0.01, 0.01])):
        inputs = kind.from_numbers(theirs, data)
        (first, *_) = inputs.warnings(data)
        assert "creates energy in some motions: the coupling of stretch and twist is 0.7 of" in first
        assert "and this pair alone creates energy above 0.198" in first
        found = inputs.recovered(data, 0.3)
        assert found.damping == pytest.approx(vd.symmetric_damping(stiffness, numbers))
        assert found.difference > 0.1
        assert any("the program's law is not symmetric" in text for text in found.warnings)
        assert any("no two times of an isotropic material" in text for text in found.warnings)


def test_lost_couplings_are_told():
    stiffness = coupled(9)
    data = data_of(
        vr.StiffnessSection(stiffness, np.eye(6), vd.symmetric_damping(stiffness, [0.01, 0.02, 0.03] * 2))
    )
    assert any(
        "viscous couplings differ by" in text for text in vd.ChronoLinear.from_section(data).losses(data)
    )
    assert any("viscous couplings differ by" in text for text in vd.BeamDyn.from_section(data).losses(data))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda d: vd.BeamDyn.from_numbers([1.0], d),
            "beamdyn: 1 numbers: BeamDyn has 6 here; give mu1, mu2",
        ),
        (lambda d: vd.ChronoTapered.from_numbers([1, 1, -1, 1], d), "chrono-tapered.bz: -1: outside"),
        (
            vd.MuJoCo.from_section,
            "segment_length: this program needs it; give segment_length (m)",
        ),
        (lambda d: vd.MuJoCo.from_section(d, segment_length=0.0), "segment_length: 0: outside"),
        (lambda d: vd.program("mujoko"), "program: mujoko: no such program; did you mean mujoco?"),
        (lambda d: vd.program("zzz"), "no such program; The programs are beamdyn"),
    ],
)
def test_messages(call, message):
    with pytest.raises(InputError) as caught:
        call(data_of())
    assert message in str(caught.value)


def test_maxwell_branches_are_refused():
    section = vr.StiffnessSection(np.eye(6), np.eye(6), branches=[{"time": 0.1, "stiffness": [1.0] * 6}])
    with pytest.raises(InputError, match="its section at 0 m has Maxwell branches"):
        data_of(section)


@pytest.mark.parametrize("kind", vd.PROGRAMS.values())
def test_an_option_that_a_program_does_not_take_is_refused(kind):
    """Every program, both ways; those without options used to drop what they were given."""
    options = dict.fromkeys(kind.options, 1.0) | {"frequence": 2.0}
    for call in (kind.from_section, lambda *args, **words: kind.from_numbers([1.0], *args, **words)):
        with pytest.raises(InputError, match=f"frequence: 2: {re.escape(kind.title)} has no use for it"):
            call(data_of(), **options)


def test_the_table_of_the_reference_page():
    """The worked example in docs/reference/damping_programs.md is what the package gives."""
    page = (Path(__file__).parents[2] / "docs" / "reference" / "damping_programs.md").read_text(
        encoding="utf-8"
    )
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if "|" in line
    ]
    table = {row[0]: row[-1] for row in rows if len(row) == 4}
    data = data_of()
    for title, kind in (
        ("BeamDyn", vd.BeamDyn),
        ("GXBeam.jl", vd.GXBeam),
        ("MBDyn", vd.MBDyn),
        ("Chrono, tapered Timoshenko", vd.ChronoTapered),
        ("Chrono, linear Cosserat", vd.ChronoLinear),
        ("Chrono, Rayleigh", vd.ChronoRayleigh),
        ("ANCF", vd.ANCF),
        ("MuJoCo cable", vd.MuJoCo),
        ("Newton rod", vd.Newton),
        ("SoRoSim, SoRoMoX", vd.SoRoSim),
        ("PyElastica", vd.PyElastica),
    ):
        printed = [
            float(word) for word in re.findall(r"-?\d+\.\d+(?:e-?\d+)?|(?<![\w.])0(?![\w.])", table[title])
        ]
        expected = kind.from_section(data, **given_options(kind)).numbers
        assert printed[: len(expected)] == pytest.approx(expected, rel=1e-5), title
    limits = {row[0]: row[1] for row in rows if len(row) == 2 and row[0].isdigit()}
    for ratio, limit in limits.items():
        times = [0.01] * 5 + [0.01 * float(ratio)]
        stiffness = np.eye(6)
        stiffness[2, 5] = stiffness[5, 2] = 0.1
        found = vd.check_product(stiffness, times).couplings[0].limit
        assert float(limit.split()[0]) == pytest.approx(found, abs=6e-4)


# ---- the programs themselves, where they are installed


def test_mujoco_itself():
    """Mass, stiffness and damping of a cable by MuJoCo: every bending mode has the time of extension."""
    mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed (extra: bench)")
    count, length, width = 12, 0.025, 0.01
    inputs = vd.MuJoCo.from_section(data_of(), segment_length=length)
    bodies = "".join(
        f'<body pos="{0.0 if k == 0 else length} 0 0">'
        + (f'<joint type="ball" damping="{inputs.joint_damping}"/>' if k else "")
        + f'<geom type="box" pos="{length / 2} 0 0" size="{length / 2} {width / 2} {width / 2}" density="1000" '
        'contype="0" conaffinity="0"/><plugin instance="cable"/>'
        for k in range(count)
    )
    text = (
        '<mujoco><option gravity="0 0 0"/><extension><plugin plugin="mujoco.elasticity.cable"><instance name="cable">'
        f'<config key="twist" value="{inputs.twist}"/><config key="bend" value="{inputs.bend}"/></instance></plugin>'
        f"</extension><worldbody>{bodies}{'</body>' * count}</worldbody></mujoco>"
    )
    try:
        model = mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        pytest.skip(f"this mujoco ({mujoco.__version__}) has no cable: {error}")
    state = mujoco.MjData(model)
    start, size, step = model.qpos0.copy(), model.nv, 1e-6

    def passive(position, velocity):
        state.qpos[:], state.qvel[:] = position, velocity
        mujoco.mj_forward(model, state)
        return state.qfrc_passive.copy()

    mass, stiffness, damping = np.zeros((3, size, size))
    for k in range(size):
        unit = np.eye(size)[k]
        column = np.zeros(size)
        passive(start, np.zeros(size))
        mujoco.mj_mulM(model, state, column, unit)
        mass[:, k] = column
        for sign in (1.0, -1.0):
            moved = start.copy()
            mujoco.mj_integratePos(model, moved, sign * step * unit, 1.0)
            stiffness[:, k] -= sign * passive(moved, np.zeros(size)) / (2.0 * step)
            damping[:, k] -= sign * passive(start, sign * step * unit) / (2.0 * step)
    solved = np.linalg.solve(mass, np.hstack([stiffness, damping]))
    system = np.block([[np.zeros((size, size)), np.eye(size)], [-solved]])
    roots = np.linalg.eigvals(system)
    slow = sorted(roots[roots.imag > 0.1], key=abs)[:2]  # the first bending mode in both directions
    assert len(slow) == 2
    for root in slow:
        assert 2.0 * -root.real / abs(root) ** 2 == pytest.approx(TAU_E, rel=1e-5)
        # Euler and Bernoulli, 1.8751^2 sqrt(EI/(rho A L^4)): the first of twelve rigid segments is clamped
        low, high = (1.87510407**2 * math.sqrt(1e6 * 1e-8 / 12 / 0.1 / free**4) for free in (0.3, 0.275))
        assert low < abs(root) < high


def test_exudyn_itself():
    """A cable of exudyn with the two constants: the decay of its swing is that of the time of extension."""
    exudyn = pytest.importorskip("exudyn", reason="exudyn is not installed (extra: bench)")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ratio, frequency, dropped = _exudyn_cantilever(exudyn)
    assert ratio == pytest.approx(math.pi * frequency * TAU_E, rel=0.01)
    assert dropped, (
        "ObjectBeamGeometricallyExact now keeps dampingMatrix: correct the note in inputs/damping_matrices.py"
    )


def _exudyn_cantilever(exudyn):
    import exudyn.itemInterface

    item = exudyn.itemInterface

    inputs = vd.Exudyn.from_section(data_of())
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    count, length = 8, 0.3
    nodes = [
        system.AddNode(item.NodePointSlope1(referenceCoordinates=[length * k / count, 0, 0, 1, 0, 0]))
        for k in range(count + 1)
    ]
    for first, last in pairwise(nodes):
        cable = item.ObjectANCFCable(
            nodeNumbers=[first, last], physicsLength=length / count, physicsMassPerLength=0.1,
            physicsBendingStiffness=1e6 * 1e-8 / 12.0, physicsAxialStiffness=100.0,
            physicsBendingDamping=inputs.numbers[4], physicsAxialDamping=inputs.numbers[0],
        )  # fmt: skip
        system.AddObject(cable)
    ground = system.AddMarker(
        item.MarkerNodeCoordinate(nodeNumber=system.AddNode(item.NodePointGround()), coordinate=0)
    )
    for place in range(6):
        marker = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=place))
        system.AddObject(item.CoordinateConstraint(markerNumbers=[ground, marker]))
    tip = system.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[-1]))
    system.AddLoad(item.Force(markerNumber=tip, loadVector=[0, 1e-5, 0]))
    sensor = system.AddSensor(
        item.SensorNode(
            nodeNumber=nodes[-1],
            outputVariableType=exudyn.OutputVariableType.Displacement,
            storeInternal=True,
        )
    )
    section = exudyn.BeamSection()
    section.dampingMatrix = np.eye(6)
    section.stiffnessMatrix, section.massPerLength = np.eye(6), 1.0
    beam_nodes = [
        system.AddNode(item.NodeRigidBodyEP(referenceCoordinates=[x, 9, 0, 1, 0, 0, 0])) for x in (0, 1)
    ]
    beam = system.AddObject(
        item.ObjectBeamGeometricallyExact(nodeNumbers=beam_nodes, physicsLength=1.0, sectionData=section)
    )
    dropped = not np.any(system.GetObject(beam)["sectionData"].dampingMatrix)
    for number in beam_nodes:  # it is only read back: hold it
        marker = system.AddMarker(item.MarkerNodeRigid(nodeNumber=number))
        body = system.AddMarker(item.MarkerBodyRigid(bodyNumber=system.AddObject(item.ObjectGround()),
                                                     localPosition=[float(number == beam_nodes[1]), 9, 0]))  # fmt: skip
        system.AddObject(item.GenericJoint(markerNumbers=[body, marker]))
    system.Assemble()
    choice = exudyn.SimulationSettings()
    choice.timeIntegration.numberOfSteps, choice.timeIntegration.endTime = 3000, 6.0
    choice.timeIntegration.verboseMode = 0
    choice.timeIntegration.generalizedAlpha.spectralRadius = 1.0
    choice.solutionSettings.writeSolutionToFile = False
    system.SolveDynamic(choice)
    history = system.GetSensorStoredData(sensor)
    swing = history[:, 2] - 1e-5 * length**3 / 3.0 / (1e6 * 1e-8 / 12.0)
    peaks = [k for k in range(1, len(swing) - 1) if swing[k - 1] < swing[k] >= swing[k + 1]]
    decrement = math.log(swing[peaks[0]] / swing[peaks[1]])
    return (
        vd.ratio_from_log_decrement(decrement),
        1.0 / (history[peaks[1], 0] - history[peaks[0], 0]),
        dropped,
    )


@pytest.mark.parametrize("kind", vd.PROGRAMS.values(), ids=lambda kind: kind.program)
def test_units_of_inputs_are_those_that_they_scale_by(kind):
    """A section of lengths a times as long, masses b times as large, times c times as long: a number with the unit
    N^i m^j s^k Pa^l is (b a/c^2)^i a^j c^k (b/a/c^2)^l times as large.
    """
    a, b, c = 2.0, 3.0, 5.0
    sizes = {"N": b * a / c**2, "m": a, "s": c, "Pa": b / a / c**2, "rad": 1.0, "1": 1.0}

    def made(length, mass, time):
        stiff = 1e6 * mass / length / time**2
        damping = vr.KelvinVoigt(0.02 * time, 0.03 * time)
        material = vr.Material(stiff, 0.3, 1000.0 * mass / length**3, damping=damping)
        data = data_of(vr.Rectangle(0.01 * length, 0.01 * length), material)
        options = {"segment_length": 0.025 * length, "frequency": 0.57 / time}
        mine = {key: value for key, value in options.items() if key in kind.options}
        return kind.from_section(data, **mine).named_numbers

    for (word, unit, before), (_, _, after) in zip(made(1, 1, 1), made(a, b, c), strict=True):
        if before:
            factor = 1.0
            above, _, below = unit.replace("(1/2)", "0.5").partition("/")
            for sign, part in ((1.0, above), (-1.0, below)):
                for one in part.split():
                    base, _, power = one.partition("^")
                    factor *= sizes[base] ** (sign * float(power or 1))
            assert after == pytest.approx(factor * before, rel=1e-9), word
