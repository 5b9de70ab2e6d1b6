"""Materials from Prony series: conventions of the ratios, and branches against complex moduli."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viscorod.errors import InputError
from viscorod.model.materials.material import Material
from viscorod.model.materials.prony import Prony

OMEGA = np.logspace(-6, 6, 61)
RATIOS = st.floats(-0.9, 0.5)


def material(nu: float = 0.3, **damping) -> Material:
    return Material(3.0e6, nu, 1100.0, damping=Prony(**damping))


def moduli(m: Material) -> tuple[np.ndarray, np.ndarray]:
    """E* and G* from the branches of the material."""
    E, G = np.full(OMEGA.shape, m.youngs_modulus + 0j), np.full(OMEGA.shape, m.shear_modulus + 0j)
    for branch in m.branches:
        share = 1j * OMEGA * branch.time / (1.0 + 1j * OMEGA * branch.time)
        E += branch.youngs_modulus * share
        G += branch.shear_modulus * share
    return E, G


def one_term(equilibrium: float, modulus: float, time: float) -> np.ndarray:
    return equilibrium + modulus * 1j * OMEGA * time / (1.0 + 1j * OMEGA * time)


def test_shear_and_bulk():
    m = material(shear_moduli=[2e5, 1e5], shear_times=[1.0, 0.01], bulk_moduli=[5e5], bulk_times=[0.1])
    G = one_term(m.shear_modulus, 2e5, 1.0) + one_term(0.0, 1e5, 0.01)
    K = one_term(m.bulk_modulus, 5e5, 0.1)
    E_found, G_found = moduli(m)
    np.testing.assert_allclose(G_found, G, rtol=1e-12)
    np.testing.assert_allclose(E_found, 9.0 * K * G / (3.0 * K + G), rtol=1e-12)
    assert [branch.time for branch in m.branches] == sorted(branch.time for branch in m.branches)
    assert len(m.branches) == 5  # two of shear, three of extension
    assert m.youngs_modulus == 3.0e6


@given(RATIOS)
def test_shear_with_constant_poissons_ratio(nu):
    m = material(nu, shear_moduli=[2e5], shear_times=[1.0], constant="poissons_ratio")
    E, G = moduli(m)
    np.testing.assert_allclose(G, one_term(m.shear_modulus, 2e5, 1.0), rtol=1e-12)
    np.testing.assert_allclose(E, 2.0 * (1.0 + nu) * G, rtol=1e-12)
    assert (m.extensional_time, m.bulk_time) == pytest.approx((m.shear_time, m.shear_time), rel=1e-9)


@given(RATIOS)
def test_shear_with_constant_bulk_modulus(nu):
    m = material(nu, shear_moduli=[2e5], shear_times=[1.0], constant="bulk_modulus")
    E, G = moduli(m)
    K = m.bulk_modulus
    expected = 3.0 * G if math.isinf(K) else 9.0 * K * G / (3.0 * K + G)
    np.testing.assert_allclose(E, expected, rtol=1e-12)
    # LLT (3) with zeta = 0
    assert m.extensional_viscosity == pytest.approx(4.0 / 3.0 * 2e5 * (1.0 + nu) ** 2, rel=1e-9)


@given(st.floats(-0.9, 0.49))
def test_bulk_with_constant_shear_modulus(nu):
    m = material(nu, bulk_moduli=[2e5], bulk_times=[1.0], constant="shear_modulus")
    E, G = moduli(m)
    K = one_term(m.bulk_modulus, 2e5, 1.0)
    np.testing.assert_allclose(G, m.shear_modulus, rtol=1e-12)
    np.testing.assert_allclose(E, 9.0 * K * G / (3.0 * K + G), rtol=1e-12)
    assert m.shear_time == 0.0
    # LLT (3) with eta = 0
    assert m.extensional_viscosity == pytest.approx(2e5 * (1.0 - 2.0 * nu) ** 2, rel=1e-9)


def test_bulk_with_constant_poissons_ratio():
    m = material(0.2, bulk_ratios=[0.5], bulk_times=[1.0], constant="poissons_ratio")
    E, G = moduli(m)
    np.testing.assert_allclose(E, one_term(3.0e6, 1.5e6, 1.0), rtol=1e-12)
    np.testing.assert_allclose(G, E / 2.4, rtol=1e-12)


def test_extension_has_a_constant_poissons_ratio():
    m = material(0.2, extension_moduli=[1e6], extension_times=[0.5])
    E, G = moduli(m)
    np.testing.assert_allclose(E, one_term(3.0e6, 1e6, 0.5), rtol=1e-12)
    np.testing.assert_allclose(G, E / 2.4, rtol=1e-12)
    assert m.extensional_time == pytest.approx(0.5 / 3.0, rel=1e-12)


def test_ratios_to_the_instantaneous_modulus_with_instantaneous_constants():
    # E0 = 3e6, nu0 = 0.5: G0 = 1e6, G_inf = G0 (1 - 0.2 - 0.3)
    m = material(
        0.5, shear_ratios=[0.2, 0.3], shear_times=[0.1, 1.0], constant="bulk_modulus", moduli="instantaneous"
    )
    assert m.shear_modulus == pytest.approx(0.5e6, rel=1e-12)
    assert m.youngs_modulus == pytest.approx(1.5e6, rel=1e-12)
    assert m.poissons_ratio == 0.5
    assert [branch.shear_modulus for branch in m.branches] == pytest.approx([2e5, 3e5], rel=1e-12)
    assert m.to_dict()["youngs_modulus"] == 3.0e6
    assert Material.model_validate(m.to_dict()) == m


def test_abaqus_with_long_term_constants():
    # *ELASTIC, MODULI=LONG TERM beside g_i of the instantaneous modulus: G_0 = G_inf/(1 - sum g)
    m = material(
        0.5,
        shear_ratios=[0.2, 0.3],
        shear_times=[0.1, 1.0],
        constant="bulk_modulus",
        ratios_of="instantaneous",
    )
    assert m.shear_modulus == pytest.approx(1e6, rel=1e-12)
    assert [branch.shear_modulus for branch in m.branches] == pytest.approx([4e5, 6e5], rel=1e-12)


def test_instantaneous_constants_with_ratios_to_the_equilibrium_modulus():
    m = material(
        0.5,
        shear_ratios=[0.25, 0.75],
        shear_times=[0.1, 1.0],
        constant="bulk_modulus",
        moduli="instantaneous",
        ratios_of="equilibrium",
    )
    assert m.shear_modulus == pytest.approx(5e5, rel=1e-12)
    assert [branch.shear_modulus for branch in m.branches] == pytest.approx([1.25e5, 3.75e5], rel=1e-12)


def test_poissons_ratio_in_equilibrium_of_a_constant_bulk_modulus():
    m = material(0.3, shear_ratios=[0.5], shear_times=[1.0], constant="bulk_modulus", moduli="instantaneous")
    G, K = 0.5 * 3e6 / 2.6, 3e6 / (3.0 * 0.4)
    assert m.shear_modulus == pytest.approx(G, rel=1e-12)
    assert m.bulk_modulus == pytest.approx(K, rel=1e-12)
    assert m.poissons_ratio == pytest.approx((3 * K - 2 * G) / (6 * K + 2 * G), rel=1e-12)


def test_kelvin_voigt_law_has_the_viscosities_of_slow_motion():
    given = {
        "shear_moduli": [2e5, 1e5],
        "shear_times": [1.0, 0.01],
        "bulk_moduli": [5e5],
        "bulk_times": [0.1],
    }
    m = material(**given, law="kelvin_voigt")
    assert m.branches == ()
    assert m.shear_viscosity == pytest.approx(2.01e5, rel=1e-12)
    assert m.bulk_viscosity == pytest.approx(5e4, rel=1e-9)
    assert any("slow motion only" in text for text in m.assumptions)
    exact = material(**given)
    assert (exact.shear_time, exact.bulk_time) == (m.shear_time, m.bulk_time)


def test_terms_without_modulus_are_no_branches():
    m = material(shear_ratios=[0.0, 0.1], shear_times=[0.1, 1.0], constant="poissons_ratio")
    assert [branch.time for branch in m.branches] == [1.0]


def test_case_file_words():
    table = {
        "youngs_modulus": 1e6,
        "poissons_ratio": 0.4,
        "density": 1000.0,
        "damping": {
            "kind": "prony",
            "shear_ratios": [0.1],
            "shear_times": [1.0],
            "constant": "poissons_ratio",
        },
    }
    m = Material.model_validate(table)
    assert m.damping == Prony(shear_ratios=[0.1], shear_times=[1.0], constant="poissons_ratio")
    assert m.to_dict() == table


SHEAR = {"shear_moduli": [1e5], "shear_times": [1.0], "constant": "poissons_ratio"}


@pytest.mark.parametrize(
    ("damping", "message"),
    [
        ({}, "at least one term"),
        ({"shear_moduli": [1e5], "constant": "poissons_ratio"}, "shear_times"),
        ({"shear_times": [1.0], "constant": "poissons_ratio"}, "shear_moduli"),
        (SHEAR | {"shear_ratios": [0.1]}, "a modulus or a ratio"),
        (SHEAR | {"shear_times": [1.0, 2.0]}, "2 times for 1: .*give 1 times"),
        (SHEAR | {"shear_times": [0.0]}, "numbers > 0"),
        (SHEAR | {"shear_moduli": [-1.0]}, "numbers >= 0"),
        (SHEAR | {"shear_moduli": []}, "at least 1 numbers"),
        (SHEAR | {"shear_moduli": [1.0] * 201, "shear_times": [1.0] * 201}, "200 at most"),
        (SHEAR | {"constant": None}, "add constant = 'poissons_ratio' or 'bulk_modulus'"),
        (SHEAR | {"constant": "shear_modulus"}, "give 'poissons_ratio' or 'bulk_modulus'"),
        (SHEAR | {"constant": "poisson"}, "did you mean 'poissons_ratio'"),
        (SHEAR | {"bulk_moduli": [1.0], "bulk_times": [1.0]}, "leave it out"),
        (SHEAR | {"extension_moduli": [1.0], "extension_times": [1.0]}, "shear and bulk, or extension alone"),
        (SHEAR | {"ratios_of": "instantaneous"}, "there are no ratios"),
        (SHEAR | {"law": "zener"}, "give one of 'maxwell', 'kelvin_voigt'"),
        (SHEAR | {"moduli": "long_term"}, "give one of 'equilibrium', 'instantaneous'"),
        ({"bulk_moduli": [1.0], "bulk_times": [1.0], "constant": "bulk_modulus"}, "'shear_modulus'"),
    ],
)
def test_refused(damping, message):
    with pytest.raises(InputError, match=message):
        Prony(**damping)


@pytest.mark.parametrize(
    ("nu", "damping", "message"),
    [
        (
            0.3,
            SHEAR | {"shear_moduli": [2e6], "moduli": "instantaneous"},
            "damping.shear_moduli: .*nothing is left",
        ),
        (
            0.3,
            {
                "shear_ratios": [0.4, 0.6],
                "shear_times": [1.0, 2.0],
                "constant": "poissons_ratio",
                "moduli": "instantaneous",
            },
            "damping.shear_ratios: sum 1: .*a sum below 1",
        ),
        (
            0.5,
            {"bulk_moduli": [1.0], "bulk_times": [1.0], "constant": "shear_modulus"},
            "damping.bulk_times: an incompressible material",
        ),
    ],
)
def test_refused_with_the_material(nu, damping, message):
    with pytest.raises(InputError, match=message):
        material(nu, **damping)
