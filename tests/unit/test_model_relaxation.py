"""Prony series, and Young's modulus from shear and bulk moduli, against the correspondence principle."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad

from viscorod.errors import InputError
from viscorod.model.materials.relaxation_modulus import RelaxationModulus, extension_of

OMEGA = np.logspace(-6, 6, 121)
MODULI = st.floats(1e-3, 1e3)
TIMES = st.floats(-5.0, 5.0).map(lambda exponent: 10.0**exponent)


def series(most: int):
    terms = st.lists(st.tuples(MODULI, TIMES), max_size=most)
    return st.builds(
        lambda rest, pairs: RelaxationModulus(rest, tuple(m for m, _ in pairs), tuple(t for _, t in pairs)),
        MODULI,
        terms,
    )


def through_frequencies(shear: RelaxationModulus, bulk: RelaxationModulus) -> np.ndarray:
    """E* of a material from its complex shear and bulk moduli, frequency by frequency."""
    G, K = shear.complex_modulus(OMEGA), bulk.complex_modulus(OMEGA)
    return 9.0 * K * G / (3.0 * K + G)


@given(series(6), series(6))
@example(RelaxationModulus(1.0, (2.0, 3.0), (0.1, 10.0)), RelaxationModulus(5.0, (2.0, 3.0), (0.1, 10.0)))
@example(RelaxationModulus(1.0, (2.0,), (0.1,)), RelaxationModulus(5.0, (2.0,), (0.1 * (1 + 1e-15),)))
@example(
    RelaxationModulus(1.0, (2.0, 1.0), (0.1, 0.1 * (1 + 1e-9))),
    RelaxationModulus(5.0, (2.0,), (0.1 * (1 + 1e-12),)),
)
@example(RelaxationModulus(1.0, (1e-9,), (1.0,)), RelaxationModulus(1e-9, (1e9,), (1e-6,)))
def test_extension_at_every_frequency(shear, bulk):
    extension = extension_of(shear, bulk)
    expected = through_frequencies(shear, bulk)
    np.testing.assert_array_less(
        np.abs(extension.complex_modulus(OMEGA) - expected), 1e-12 * np.abs(expected)
    )
    assert len(extension.times) <= len(shear.times) + len(bulk.times)
    assert all(modulus > 0.0 for modulus in extension.moduli)


@given(series(5), series(5))
def test_slow_extension_is_llt_3(shear, bulk):
    # eta_E = zeta (1-2nu)^2 + 4/3 eta (1+nu)^2 with the moduli in equilibrium
    G, K = shear.equilibrium, bulk.equilibrium
    nu = (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G)
    expected = bulk.viscosity * (1.0 - 2.0 * nu) ** 2 + 4.0 / 3.0 * shear.viscosity * (1.0 + nu) ** 2
    extension = extension_of(shear, bulk)
    assert extension.viscosity == pytest.approx(expected, rel=1e-9)
    assert extension.equilibrium == pytest.approx(2.0 * G * (1.0 + nu), rel=1e-12)


@given(series(5), series(5))
def test_fast_extension_is_that_of_the_instantaneous_moduli(shear, bulk):
    G, K = shear.instantaneous, bulk.instantaneous
    assert extension_of(shear, bulk).instantaneous == pytest.approx(9.0 * K * G / (3.0 * K + G), rel=1e-12)


def test_extension_in_time_by_stepping_the_three_dimensional_material():
    # a bar stretched suddenly and held: the lateral strain follows from vanishing lateral stress; two Maxwell
    # branches of shear and one of bulk, as ordinary differential equations, independent of any transform
    from scipy.integrate import solve_ivp

    shear, bulk = RelaxationModulus(1.0, (2.0, 0.5), (0.3, 4.0)), RelaxationModulus(2.0, (3.0,), (1.0,))

    def lateral(memory):  # 0 = K0 vol - sum K_j m_j - 2/3 (G0 dev - sum G_j m_j) with dev = axial - lateral
        K0, G0 = bulk.instantaneous, shear.instantaneous
        relaxed = 3.0 * memory[2] - 2.0 / 3.0 * (2.0 * memory[0] + 0.5 * memory[1])
        # K0 (1 + 2 e) - relaxed_K - 2/3 (G0 (1 - e) - relaxed_G) = 0
        return (relaxed - K0 + 2.0 / 3.0 * G0) / (2.0 * K0 + 2.0 / 3.0 * G0)

    def rate(t, memory):
        e = lateral(memory)
        return [
            (1.0 - e - memory[0]) / 0.3,
            (1.0 - e - memory[1]) / 4.0,
            (1.0 + 2.0 * e - memory[2]) / 1.0,
        ]

    times = np.array([0.0, 0.1, 0.5, 1.0, 3.0, 10.0, 40.0])
    solution = solve_ivp(rate, (0.0, 40.0), [0.0, 0.0, 0.0], t_eval=times, rtol=1e-11, atol=1e-13)
    for index, memory in enumerate(solution.y.T):
        e = lateral(memory)
        deviator = shear.instantaneous * (1.0 - e) - 2.0 * memory[0] - 0.5 * memory[1]
        volume = bulk.instantaneous * (1.0 + 2.0 * e) - 3.0 * memory[2]
        stress = volume + 4.0 / 3.0 * deviator
        expected = extension_of(shear, bulk).relaxation_modulus(times[index])
        assert stress == pytest.approx(float(expected), rel=1e-8)


def test_bound_of_the_kelvin_voigt_solid():
    # a Gaussian pulse of the width b: eps^ = b sqrt(2 pi) exp(-(b w)^2/2); LLT 2.6 by adaptive quadrature
    relaxation, b = RelaxationModulus(1.0, (2.0, 3.0), (0.1, 1.0)), 2.0
    omega = np.linspace(0.0, 8.0, 4001)
    spectrum = b * np.sqrt(2.0 * np.pi) * np.exp(-((b * omega) ** 2) / 2.0)

    def integrand(w):
        weight = 2.0 * (0.1 * w) ** 2 / math.hypot(1.0, 0.1 * w) + 3.0 * w**2 / math.hypot(1.0, w)
        return b * math.sqrt(2.0 * math.pi) * math.exp(-((b * w) ** 2) / 2.0) * weight / (2.0 * math.pi)

    expected = quad(integrand, -8.0, 8.0)[0]
    assert relaxation.kelvin_voigt_bound(omega, spectrum) == pytest.approx(expected, rel=1e-6)
    # slow pulses: sum M_j tau_j^2 over b^2, of second order
    slow = RelaxationModulus(1.0, (2.0, 3.0), (1e-3, 1e-2)).kelvin_voigt_bound(omega, spectrum)
    assert slow == pytest.approx((2.0 * 1e-6 + 3.0 * 1e-4) / b**2, rel=1e-3)
    assert RelaxationModulus(1.0).kelvin_voigt_bound(omega, spectrum) == 0.0


@pytest.mark.parametrize(
    ("omega", "spectrum", "message"),
    [
        ([0.0, 1.0], [1.0], "same length"),
        ([1.0], [1.0], "same length"),
        ([1.0, 0.5], [1.0, 1.0], "must increase"),
        ([-1.0, 0.5], [1.0, 1.0], "must increase"),
    ],
)
def test_spectrum_refused(omega, spectrum, message):
    with pytest.raises(InputError, match=message):
        RelaxationModulus(1.0, (2.0,), (1.0,)).kelvin_voigt_bound(omega, spectrum)


def test_incompressible_extension_is_three_times_shear():
    shear = RelaxationModulus(1.0, (2.0, 3.0), (0.1, 1.0))
    assert extension_of(shear, RelaxationModulus(math.inf)) == shear.scaled(3.0)


def test_complex_modulus_is_the_transform_of_the_relaxation_modulus():
    relaxation = RelaxationModulus(1.5, (2.0, 3.0), (0.1, 1.0))

    def decaying(t):
        return float(relaxation.relaxation_modulus(t)) - 1.5

    for omega in (0.3, 5.0):
        storage = 1.5 + omega * quad(decaying, 0.0, np.inf, weight="sin", wvar=omega)[0]
        loss = omega * quad(decaying, 0.0, np.inf, weight="cos", wvar=omega)[0]
        assert relaxation.complex_modulus(omega) == pytest.approx(storage + 1j * loss, rel=1e-7)


def test_moduli_without_branches_are_constant():
    relaxation = RelaxationModulus(2.0)
    assert relaxation.complex_modulus(OMEGA).tolist() == [2.0] * len(OMEGA)
    assert relaxation.relaxation_modulus([0.0, 1.0]).tolist() == [2.0, 2.0]
    assert (relaxation.viscosity, relaxation.retardation_time, relaxation.instantaneous) == (0.0, 0.0, 2.0)


def test_terms_are_sorted_merged_and_dropped():
    relaxation = RelaxationModulus(1.0, (1.0, 2.0, 0.0, 4.0), (3.0, 1.0, 2.0, 3.0))
    assert (relaxation.moduli, relaxation.times) == ((2.0, 5.0), (1.0, 3.0))
    assert relaxation.viscosity == 17.0
    assert relaxation.retardation_time == 17.0
    assert relaxation.instantaneous == 8.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1.0, (1.0,), ()), "one modulus and one time"),
        ((0.0,), "a solid keeps a modulus"),
        ((math.nan,), "a solid keeps a modulus"),
        ((1.0, (-1.0,), (1.0,)), "moduli >= 0 and times > 0"),
        ((1.0, (1.0,), (0.0,)), "moduli >= 0 and times > 0"),
        ((1.0, (math.nan,), (1.0,)), "moduli >= 0 and times > 0"),
        ((1.0, (1.0,), (math.inf,)), "moduli >= 0 and times > 0"),
    ],
)
def test_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        RelaxationModulus(*arguments)
