"""Strain spectra known in closed form against what a run says of its damping."""

import json
import math

import numpy as np
import pytest
from scipy.integrate import quad

import viscorod as vr
from helpers.plain_text import flat
from helpers.synthetic_results import swing
from viscorod.errors import InputError

WIDTH = 0.05
"""Standard deviation of the strain pulse in time, s."""
MODULI, TIMES = [3e5, 2e5], [0.02, 0.001]


def series(modulus=1e6, viscosity=None):
    slow = sum(m * t for m, t in zip(MODULI, TIMES, strict=True))
    return {
        "modulus": modulus,
        "viscosity": slow if viscosity is None else viscosity,
        "equilibrium": 1e6,
        "moduli": MODULI,
        "times": TIMES,
    }


def pulse(law, component=3, spacing=0.004, width=WIDTH):
    """A run whose rod bends in a Gaussian pulse of time about 1 s, most at its first point."""
    data = swing()
    time = np.arange(0.0, 3.0, spacing)
    data = data.isel(time=[0] * len(time)).assign_coords(time=time)
    strain = np.zeros(data["strain"].shape)
    strain[:, :, component] = np.exp(-((time - 1.0) ** 2) / (2.0 * width**2))[:, None]
    strain[:, 1:, component] *= 0.5
    data["strain"] = (("time", "point", "component"), strain)
    data["section_force"] = (("time", "point", "component"), 8.3e-4 * strain)
    data.attrs["damping_laws"] = json.dumps({"beam": law})
    return vr.Run(data)


def plain(time):
    return {"times": [time] * 6, "maxwell": False}


def test_frequencies_of_a_gaussian_pulse():
    # eps^ ~ exp(-(s w)^2/2): the energy lost goes with w^2 exp(-(s w)^2), a Maxwell distribution of scale 1/(s sqrt 2):
    # mean 2 scale sqrt(2/pi), 95 % below 2.7954834829 scale
    (found,) = pulse(plain(1e-3)).damping_validity().strains
    scale = 1.0 / (WIDTH * math.sqrt(2.0))
    assert (found.rod, found.strain, found.time) == ("beam", "bend 1", 1e-3)
    assert 2.0 * math.pi * found.mean_frequency == pytest.approx(
        2.0 * scale * math.sqrt(2.0 / math.pi), rel=1e-4
    )
    assert 2.0 * math.pi * found.high_frequency == pytest.approx(2.7954834829 * scale, rel=1e-3)
    assert found.product == pytest.approx(2.7954834829 * scale * 1e-3, rel=1e-3)
    assert math.isnan(found.bound)


@pytest.mark.parametrize(("time", "valid"), [(0.01, True), (0.02, False)])
def test_times_against_the_spectrum(time, valid):
    # the product is 39.5 rad/s times the time
    report = pulse(plain(time)).damping_validity()
    assert report.valid is valid
    assert report.strains[0].limit == pytest.approx(0.5 / (2.0 * math.pi * time), rel=1e-12)
    words = (
        "right for this motion"
        if valid
        else "not right for this motion; it would be for frequencies up to 3.98 Hz"
    )
    assert words in flat(str(report))


@pytest.mark.parametrize("component", [0, 2, 4, 5])
def test_bound_of_a_gaussian_pulse(component):
    # LLT 2.6 with |eps^| = s sqrt(2 pi) exp(-(s w)^2/2)
    kind = "shear" if component in (0, 5) else "extension"
    (found,) = pulse(plain(1e-3) | {kind: series()}, component).damping_validity().strains

    def integrand(w):
        weight = sum(m * (t * w) ** 2 / math.hypot(1.0, t * w) for m, t in zip(MODULI, TIMES, strict=True))
        return WIDTH * math.sqrt(2.0 * math.pi) * math.exp(-((WIDTH * w) ** 2) / 2.0) * weight / math.pi

    expected = quad(integrand, 0.0, 40.0 / WIDTH, limit=200)[0] / 1e6
    assert found.bound == pytest.approx(expected, rel=1e-4)
    # the error itself, from a memory integral of the Prony series, is below the bound and not far from it
    time = np.arange(0.0, 3.0, 1e-4)
    rate = np.gradient(np.exp(-((time - 1.0) ** 2) / (2.0 * WIDTH**2)), time, edge_order=2)
    error = np.zeros_like(time)
    for m, t in zip(MODULI, TIMES, strict=True):
        memory = (
            np.convolve(rate, np.exp(-time / t))[: len(time)] * 1e-4 * (0.5e-4 / t) / math.sinh(0.5e-4 / t)
        )
        error += m * (memory * math.exp(-0.5e-4 / t) - t * rate)
    assert 0.2 * expected < np.abs(error).max() / 1e6 < expected


def test_bound_of_a_fit_over_a_band():
    # another modulus at rest counts by itself, times the largest strain
    given = plain(1e-3) | {"extension": series(1.2e6, 4e3)}
    (found,) = pulse(given).damping_validity().strains

    def integrand(w):
        exact = sum(m * 1j * t * w / (1.0 + 1j * t * w) for m, t in zip(MODULI, TIMES, strict=True))
        return (
            WIDTH
            * math.sqrt(2.0 * math.pi)
            * math.exp(-((WIDTH * w) ** 2) / 2.0)
            * abs(exact - 4e3j * w)
            / math.pi
        )

    expected = (quad(integrand, 0.0, 40.0 / WIDTH, limit=200)[0] + 2e5) / 1.2e6
    assert found.bound == pytest.approx(expected, rel=1e-4)
    assert not found.valid
    assert found.limit == 0.0


def test_limit_of_a_zener_solid():
    law = {"modulus": 1e6, "viscosity": 5e4, "equilibrium": 1e6, "moduli": [5e5], "times": [0.1]}
    (found,) = pulse(plain(0.05) | {"extension": law}).damping_validity(tolerance=0.05).strains
    # 0.5 x^2/sqrt(1 + x^2) = 0.05 |1 + 0.5 i x|
    x = np.linspace(0.0, 1.0, 1_000_001)[1:]
    crossing = x[np.argmax(0.5 * x**2 / np.hypot(1.0, x) > 0.05 * np.hypot(1.0, 0.5 * x))]
    assert 2.0 * math.pi * found.limit * 0.1 == pytest.approx(crossing, rel=0.01)
    assert found.valid is (found.bound <= 0.05)


def test_what_takes_no_part_is_left_out():
    nothing = pulse({"times": [None] * 6, "maxwell": True}).damping_validity()
    assert nothing.valid
    assert nothing.strains == ()
    assert "its Maxwell branches are solved as they are" in flat(str(nothing))
    undamped = pulse(plain(0.0)).damping_validity()
    assert str(undamped) == "No rod with Kelvin-Voigt damping was strained."


def test_records_too_far_apart():
    assert pulse(plain(1e-3)).damping_validity().notes == ()
    (note,) = pulse(plain(1e-3), spacing=0.06).damping_validity().notes
    assert "give a smaller output_interval" in note


@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_a_computed_run_keeps_what_is_needed(tmp_path):
    damping = vr.Prony(shear_ratios=[0.3], shear_times=[0.02], constant="poissons_ratio", law="kelvin_voigt")
    rubber = vr.Material(1e6, 0.45, 1000.0, damping=damping)
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=rubber, elements=2))
    model.clamp("beam.start")
    model.force("beam.end", (0.0, 0.002, 0.0), until=0.0)
    run = model.simulate(4.0, tolerance=1e-3)
    report = run.damping_validity()
    (bending,) = (strain for strain in report.strains if strain.strain == "bend 2")
    # it swings with its first frequency, higher modes on top; LLT's bound for the first alone is 0.3 (0.02 w)^2
    frequency = model.modes(1).frequencies[0]
    assert frequency < bending.mean_frequency < 2.0 * frequency
    assert bending.time == pytest.approx(0.006, rel=1e-12)
    assert 0.3 * (0.04 * math.pi * frequency) ** 2 < bending.bound < 0.1
    assert report.valid
    again = vr.load(run.save(tmp_path / "run.nc")).damping_validity()
    assert str(again) == str(report)
    quick = model.simulate(0.5, tolerance=1e-3, output_interval=0.005).damping_validity(tolerance=1e-4)
    assert not quick.valid


def test_refused():
    with pytest.raises(InputError, match=r"tolerance = 0\.0: give an accepted error"):
        pulse(plain(1.0)).damping_validity(tolerance=0.0)
    with pytest.raises(InputError, match="does not hold its damping laws"):
        vr.Run(swing()).damping_validity()
    short = pulse(plain(1.0))
    short.data = short.data.isel(time=slice(0, 5))
    with pytest.raises(InputError, match="8 states at least, and this run holds 5"):
        vr.Run(short.data).damping_validity()
