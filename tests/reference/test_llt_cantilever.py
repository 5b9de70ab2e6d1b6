"""The damped cantilever of Linn, Lang and Tuganov, section 3: the paper's claims, each as a number."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import viscorod as vr

from .cases import methods

LENGTH, FORCE = 0.3, 0.035
FIRST = 3.51601527
"""omega_1 L^2 sqrt(rho A/EI) of the clamped-free beam (case C1)."""


METHODS = methods(1e-5, 0.01)
LONG = {0.01: 90.0, 0.02: 45.0, 0.04: 24.0}
"""Duration [s] until the amplitude is small, by the time of damping [s]."""


def swing(tau, method, modulus=1e6, duration=24.0, factor=1.0):
    """See ``swung``; ``factor`` changes the step of methods with equal steps."""
    if "time_step" in method:
        method = method | {"time_step": factor * method["time_step"]}
    interval = {} if "time_step" in method else {"output_interval": 0.01 * factor}
    return swung(tau, modulus, duration, tuple((method | interval).items()))


@lru_cache
def swung(tau, modulus, duration, method):
    """LLT's rod, pulled sideways to about 0.66 L and released; equal retardation times."""
    rubber = vr.Material(
        modulus, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(shear_time=tau, bulk_time=tau)
    )
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    model.add(
        "beam",
        vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, material=rubber, elements=2, order=5),
    )
    model.clamp("beam.start")
    model.force("beam.end", (0, FORCE * modulus / 1e6, 0), until=0.0)
    return model.simulate(duration, **dict(method))


def first_frequency(modulus=1e6):
    """rad/s, of the same mesh, with shear and rotary inertia."""
    rubber = vr.Material(modulus, poissons_ratio=0.3, density=1000.0)
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    model.add(
        "beam",
        vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, material=rubber, elements=2, order=5),
    )
    model.clamp("beam.start")
    return 2 * np.pi * model.modes(1).frequencies[0]


@pytest.mark.parametrize("tau", [0.01, 0.02, 0.04])
@METHODS
def test_small_amplitude_damping_ratio_is_omega_tau_over_two(tau, method):
    """Within 0.5 %: cycles whose amplitude is below 0.04 L, where the nonlinear part of the frequency is below 1e-3."""
    omega = first_frequency()
    assert omega == pytest.approx(FIRST * np.sqrt(1e6 * 1e-4 / 12 / 1000) / LENGTH**2, rel=2e-3)
    decay = swing(tau, method, duration=LONG[tau], factor=2.0).decrement("beam.end", axis="y")
    small = decay.damping_ratio[np.abs(decay.amplitude[: len(decay.damping_ratio)]) < 0.04 * LENGTH]
    assert len(small) >= 2
    assert small == pytest.approx(omega * tau / 2, rel=5e-3)


@METHODS
def test_damping_ratios_scale_one_two_four(method):
    """In the small-amplitude regime 1 : 2 : 4 within 1 %."""
    ratios = [
        swing(tau, method, duration=LONG[tau], factor=2.0).decrement("beam.end", axis="y").damping_ratio[-1]
        for tau in (0.01, 0.02, 0.04)
    ]
    assert ratios[1] / ratios[0] == pytest.approx(2, rel=1e-2)
    assert ratios[2] / ratios[0] == pytest.approx(4, rel=1e-2)


@pytest.mark.parametrize("tau", [0.01, 0.02, 0.04])
@METHODS
def test_damping_is_weaker_at_large_amplitude(tau, method):
    """The first ratio is clearly below, and ratios rise with every cycle while the amplitude exceeds L/5."""
    decay = swing(tau, method).decrement("beam.end", axis="y")
    small = first_frequency() * tau / 2
    assert decay.damping_ratio[0] < 0.9 * small
    large = decay.damping_ratio[np.abs(decay.amplitude[: len(decay.damping_ratio)]) > LENGTH / 5]
    assert np.all(np.diff(large) > 0)


@METHODS
def test_nearly_linear_from_the_fifth_period(method):
    """LLT: linear from about the fifth period, amplitude about L/3: within 7 % of the small-amplitude ratio."""
    decay = swing(0.02, method).decrement("beam.end", axis="y")
    assert decay.amplitude[4] == pytest.approx(LENGTH / 3, rel=0.15)
    assert decay.damping_ratio[4] == pytest.approx(first_frequency() * 0.02 / 2, rel=0.07)


@METHODS
def test_fourfold_modulus_with_half_the_time_is_the_same_motion_twice_as_fast(method):
    """LLT: the curves coincide in time stretched by two, here within 1e-4 L over the whole motion."""
    slow, fast = (
        swing(0.02, method, duration=10.0),
        swing(0.01, method, modulus=4e6, duration=5.0, factor=0.5),
    )
    assert fast.time * 2 == pytest.approx(slow.time, abs=1e-9)
    gap = fast.history("beam.end").values - slow.history("beam.end").values
    assert np.abs(gap).max() < 1e-4 * LENGTH


@METHODS
def test_motion_stays_in_its_plane(method):
    """To round-off."""
    run = swing(0.02, method)
    assert np.abs(run.data["position"].values[..., 2]).max() < 1e-12 * LENGTH
    assert np.abs(run.data["velocity"].values[..., 2]).max() < 1e-10


@METHODS
def test_energy_account_closes(method):
    """The numerical remainder stays below 0.1 % of the energy that moved, and nothing dissipates a negative amount."""
    run = swing(0.02, method)
    assert run.energy.numerical_fraction < 1e-3
    # between the steps of radau the loss is that of a polynomial, which may fall where nothing moves
    viscous = run.data["viscous"].values
    assert np.diff(viscous).min() >= (-1e-7 * viscous[-1] if method["integrator"] == "radau" else 0.0)
