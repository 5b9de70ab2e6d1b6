"""Numbers that stand for damping: against oscillators integrated or solved independently, and against each other."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize

import viscorod as vr
from viscorod import programs as vd
from viscorod.errors import InputError

ratios = st.floats(1e-6, 0.99)


def swing(time, frequency):
    """Complex frequency of x_tt + tau w^2 x_t + w^2 x = 0 with positive imaginary part."""
    w = 2.0 * math.pi * frequency
    return max(np.roots([1.0, time * w * w, w * w]), key=lambda root: root.imag)


@given(st.floats(1e-5, 0.5), st.floats(0.1, 0.6))
@settings(max_examples=50)
def test_a_time_gives_the_decay_of_its_oscillator(time, frequency):
    root = swing(time, frequency)
    ratio = vd.damping_ratio(time, frequency)
    assert ratio == pytest.approx(-root.real / abs(root), rel=1e-9)
    assert vd.damped_frequency(frequency, ratio) == pytest.approx(root.imag / (2.0 * math.pi), rel=1e-9)
    # amplitudes one damped period apart
    assert vd.log_decrement(ratio) == pytest.approx(-root.real * 2.0 * math.pi / root.imag, rel=1e-9)


def test_the_loss_factor_is_the_phase_of_the_complex_stiffness():
    stiffness = 1.0 + 2.0j * math.pi * 3.0 * 0.01
    assert vd.loss_factor(0.01, 3.0) == pytest.approx(math.tan(np.angle(stiffness)), rel=1e-14)
    assert vd.viscosity(0.02, 5e5) == 1e4


@given(ratios, st.floats(1e-3, 1e4))
@settings(max_examples=50)
def test_every_number_comes_back(ratio, frequency):
    time = vd.time_from_damping_ratio(ratio, frequency)
    assert vd.damping_ratio(time, frequency) == pytest.approx(ratio, rel=1e-12)
    assert vd.time_from_loss_factor(vd.loss_factor(time, frequency), frequency) == pytest.approx(
        time, rel=1e-12
    )
    assert vd.ratio_from_log_decrement(vd.log_decrement(ratio)) == pytest.approx(ratio, rel=1e-12)
    assert vd.ratio_from_quality_factor(vd.quality_factor(ratio)) == pytest.approx(ratio, rel=1e-12)
    assert vd.loss_factor(time, frequency) == pytest.approx(2.0 * ratio, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.35])
def test_quality_is_the_width_of_the_velocity_resonance_and_not_of_the_displacement(ratio):
    r = np.linspace(1e-4, 3.0, 2_000_001)
    displacement = 1.0 / np.hypot(1.0 - r * r, 2.0 * ratio * r)
    for response, exact in ((r * displacement, True), (displacement, False)):
        inside = r[response >= response.max() / math.sqrt(2.0)]
        width = inside[-1] - inside[0]
        if exact:
            assert 1.0 / width == pytest.approx(vd.quality_factor(ratio), rel=1e-4)
        else:
            low, high = vd.half_power_points(ratio)
            assert (inside[0], inside[-1]) == pytest.approx((low, high), abs=3e-6)
    assert 2.0 * ratio < vd.half_power_points(ratio)[1] - vd.half_power_points(ratio)[0]


def test_displacement_width_is_one_percent_off_at_a_tenth():
    low, high = vd.half_power_points(0.1)
    assert (high - low) / 0.2 == pytest.approx(1.01, abs=0.002)


def test_overdamped_above_the_critical_frequency():
    limit = vd.critical_frequency(0.02)
    assert vd.damping_ratio(0.02, limit) == pytest.approx(1.0, rel=1e-14)
    assert vd.damped_frequency(2.0 * limit, 2.0) == 0.0
    with pytest.raises(InputError, match=r"damping_ratio: 1\.5"):
        vd.log_decrement(1.5)
    assert vd.quality_factor(0.0) == math.inf


def test_the_bulk_time_of_two_measured_times():
    material = vr.Material(1e6, 0.3, 1.0, damping=vr.KelvinVoigt(0.02, 0.05))
    assert vd.bulk_time(material.extensional_time, 0.02, 0.3) == pytest.approx(0.05, rel=1e-12)
    # no bulk viscosity at all: exactly at the bound
    assert vd.bulk_time(2.6 * 0.02 / 3.0, 0.02, 0.3) == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(
        InputError, match=r"bulk viscosity would be negative; give at least .* = 0\.0173333 s"
    ):
        vd.bulk_time(0.01, 0.02, 0.3)
    with pytest.raises(InputError, match=r"-1 < nu < 0.5"):
        vd.bulk_time(0.02, 0.02, 0.5)


@pytest.mark.parametrize(("low", "high"), [(0.5, 5.0), (1.0, 1.2), (0.1, 100.0)])
def test_rayleigh_constants_of_a_constant_ratio_minimise_the_integral(low, high):
    found = vd.rayleigh_for_constant_ratio(0.03, low, high)
    w1, w2 = 2.0 * math.pi * low, 2.0 * math.pi * high

    def integral(x):
        alpha, beta = x * np.array([found.alpha, found.beta])
        return 1e6 * quad(lambda w: (alpha / (2 * w) + beta * w / 2 - 0.03) ** 2, w1, w2, limit=200)[0]

    best = minimize(integral, [1.01, 0.99], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-14}).x
    assert best == pytest.approx([1.0, 1.0], rel=2e-4)
    frequencies = np.geomspace(low, high, 20001)
    assert found.largest_error == pytest.approx(np.abs(found.ratio(frequencies) - 0.03).max(), rel=1e-6)


def test_a_kelvin_voigt_law_is_a_rayleigh_law():
    exact = vd.rayleigh_from_time(0.02, 0.1, 10.0)
    assert (exact.alpha, exact.beta, exact.largest_error) == (0.0, 0.02, 0.0)
    assert exact.ratio(3.0) == pytest.approx(vd.damping_ratio(0.02, 3.0))


def test_the_time_of_rayleigh_constants_minimises_the_integral():
    time, error = vd.time_from_rayleigh(0.4, 0.002, 0.5, 5.0)
    w1, w2 = math.pi, 10.0 * math.pi

    def slope(t):
        """Derivative of the integral of the squared difference by the time."""
        return quad(lambda w: (0.4 / (2 * w) + (0.002 - t) * w / 2) * w, w1, w2)[0]

    assert slope(time) == pytest.approx(0.0, abs=1e-9)
    w = np.linspace(w1, w2, 100001)
    assert error == pytest.approx(np.abs(0.4 / (2 * w) + (0.002 - time) * w / 2).max(), rel=1e-9)
    assert vd.time_from_rayleigh(0.0, 0.01, 1.0, 2.0) == (0.01, 0.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: vd.loss_factor(-1.0, 1.0), "time: -1: outside what is allowed; give a number >= 0"),
        (lambda: vd.loss_factor(1.0, 0.0), "frequency: 0: outside what is allowed; give a number > 0"),
        (lambda: vd.damping_ratio(math.nan, 1.0), "time: nan"),
        (
            lambda: vd.half_power_points(0.4),
            "damping_ratio: 0.4: outside what is allowed; give a number >= 0 and < 0.38",
        ),
        (lambda: vd.rayleigh_for_constant_ratio(0.1, 2.0, 1.0), "band: 2 to 1 Hz: a band has two different"),
        (lambda: vd.rayleigh_for_constant_ratio(-0.1, 1.0, 2.0), "damping_ratio: -0.1"),
        (lambda: vd.time_from_rayleigh(-0.1, 0.0, 1.0, 2.0), "alpha: -0.1"),
    ],
)
def test_messages(call, message):
    with pytest.raises(InputError) as caught:
        call()
    assert message in str(caught.value)
