"""Peaks that frequencies do not show, responses that are none, and vibrations that nothing damps."""

import numpy as np
import pytest
import scipy.optimize

import viscorod as vr
from helpers.plain_text import flat
from viscorod.results.sweep_figures import figures_of

YOUNG, LENGTH, WIDTH, HEIGHT, TIME = 2.06e11, 0.3, 0.02, 0.002, 2e-5


def strip(damping: vr.KelvinVoigt | vr.LossFactor | None = None, turned: float = 0.0) -> vr.Model:
    """Return a steel cantilever whose section is turned about its axis [rad]."""
    steel = vr.Material(YOUNG, 0.29, 7850.0, damping=damping)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0),
        (LENGTH, 0, 0),
        section=vr.Rectangle(WIDTH, HEIGHT),
        material=steel,
        d1=(0, np.cos(turned), np.sin(turned)),
        elements=4,
        order=4,
        constraints="kirchhoff",
    )
    model.add("strip", rod)
    model.clamp("strip.start")
    return model


def tip_receptance(
    hertz: float, second_moment: float, loss: float | None = None, time: float = TIME
) -> complex:
    """Return tip displacement over tip force of an Euler-Bernoulli cantilever with E (1 + i w tau) [m/N].

    With a loss factor it is E (1 + i loss).
    """
    omega = 2 * np.pi * hertz
    EI = YOUNG * second_moment * (1 + 1j * (omega * time if loss is None else loss))
    beta = (7850.0 * WIDTH * HEIGHT * omega**2 / EI) ** 0.25
    c, s = np.cos(beta * LENGTH), np.sin(beta * LENGTH)
    C, S = np.cosh(beta * LENGTH), np.sinh(beta * LENGTH)
    return complex((s * C - c * S) / (EI * beta**3 * (1 + c * C)))


SOFT, STIFF = WIDTH * HEIGHT**3 / 12, HEIGHT * WIDTH**3 / 12


def test_a_peak_between_frequencies_is_told_and_not_guessed() -> None:
    """The peak at 18.389 Hz is 0.04 Hz wide; with 0.5 Hz between them frequencies say nothing about its height."""
    damped = strip(vr.KelvinVoigt(TIME, TIME))
    hertz = [10.0, 18.0, 18.5, 19.0, 30.0]
    coarse = damped.frequency_response(inputs="strip.end fz", outputs="strip.end uz", frequencies=hertz)
    (peak,) = coarse.resonances()
    assert not peak.resolved
    assert peak.half_power is None
    assert (peak.frequency, peak.name) == (18.5, "bend_1 1")
    assert peak.amplitude == pytest.approx(abs(tip_receptance(18.5, SOFT)), rel=2e-3)
    assert f"> {peak.amplitude:.5g}" in flat(coarse.report())
    assert "too far apart" in flat(coarse.report())

    fine = damped.frequency_response(inputs="strip.end fz", outputs="strip.end uz", band=(10.0, 30.0))
    (top,) = fine.resonances()
    assert top.resolved
    assert top.amplitude == pytest.approx(abs(tip_receptance(top.frequency, SOFT)), rel=1e-3)
    assert top.amplitude > 5 * peak.amplitude
    assert "too far apart" not in flat(fine.report())


BAND = (5.0, 200.0)
LOSS = 2e-4
QUICK = LOSS / (2 * np.pi * 18.39)


@pytest.mark.parametrize(
    ("damping", "loss"),
    [
        (vr.KelvinVoigt(QUICK, QUICK), None),
        (vr.LossFactor(extension=LOSS, shear=LOSS, band=BAND), LOSS),
    ],
    ids=["Kelvin-Voigt", "loss factor"],
)
@pytest.mark.parametrize("lines", [{"band": (10.0, 30.0)}, {"frequencies": np.arange(10.0, 31.0).tolist()}])
def test_the_largest_response_lies_between_the_frequencies(damping, loss, lines) -> None:
    """Of light damping, ratio 1e-4: the peak is 4 mHz wide, and whole hertz see less than a hundredth of it."""
    found = strip(damping).frequency_response(inputs="strip.end fz", outputs="strip.end uz", **lines)
    exact = scipy.optimize.minimize_scalar(
        lambda f: -abs(tip_receptance(f, SOFT, loss, QUICK)),
        bounds=(18.38, 18.4),
        method="bounded",
        options={"xatol": 1e-9},
    )
    top = found.summit()
    assert top.frequency == pytest.approx(exact.x, rel=2e-5)  # h^2/L^2/12 by rotary inertia, which it lacks
    assert top.amplitude == pytest.approx(-exact.fun, rel=1e-4)
    assert figures_of(found)["peak"] == top.amplitude
    assert figures_of(found)["peak_frequency"] == top.frequency
    if "frequencies" in lines:
        assert found.amplification().max() < 0.01 * top.amplitude


def test_the_largest_response_without_damping_or_beyond_the_band_is_that_of_the_frequencies() -> None:
    for damping, hertz in ((None, [17.0, 19.0]), (vr.KelvinVoigt(TIME, TIME), [5.0, 10.0])):
        found = strip(damping).frequency_response(
            inputs="strip.end fz", outputs="strip.end uz", frequencies=hertz
        )
        assert found.summit() == (1, hertz[1], found.amplification()[1])


def test_responses_that_are_round_off_are_none() -> None:
    """Across the plane of the force a straight strip does not move."""
    damped = strip(vr.KelvinVoigt(TIME, TIME))
    outputs = ["strip.end uz", "strip.end uy", "strip.end rx", "strip@0.1 section_force twist"]
    found = damped.frequency_response(inputs="strip.end fz", outputs=outputs, band=(5.0, 300.0))
    assert found.amplification("strip.end uz").min() > 0.0
    for silent in outputs[1:]:
        assert not found.amplification(silent).any()
        assert not found.resonances(silent)
    assert found.report().count("no response") == 3


@pytest.mark.parametrize("angle", [1e-3, 1e-7])
def test_small_responses_stay(angle: float) -> None:
    """A section that is turned by a small angle couples both planes: sin cos (receptance soft - stiff)."""
    turned = strip(vr.KelvinVoigt(TIME, TIME), turned=angle)
    hertz = [5.0, 18.0, 60.0]
    found = turned.frequency_response(inputs="strip.end fz", outputs="strip.end uy", frequencies=hertz)
    exact = [
        -np.sin(angle) * np.cos(angle) * (tip_receptance(f, SOFT) - tip_receptance(f, STIFF)) for f in hertz
    ]
    assert found.response() == pytest.approx(np.array(exact), rel=2e-3)


def test_a_vibration_that_nothing_damps_is_told() -> None:
    """Its response has no bound, and no peak with a height."""
    found = strip().frequency_response(inputs="strip.end fz", outputs="strip.end uz", band=(5.0, 30.0))
    assert any("nothing damps the vibration at 18.38" in text for text in found.warnings)
    assert "-0" not in found.report()


def test_modes_of_one_frequency_share_what_a_pole_has_in_a_response() -> None:
    """Of a square rod bending both ways is one double pole: half of it each, whatever the direction of the load."""
    steel = vr.Material(YOUNG, 0.29, 7850.0, damping=vr.KelvinVoigt(QUICK, QUICK))
    model = vr.Model()
    square = vr.Rectangle(HEIGHT, HEIGHT)
    model.add(
        "rod", vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=square, material=steel, elements=4, order=4)
    )
    model.clamp("rod.start")
    hertz = [10.0, 18.0, 19.0, 30.0]
    found = model.frequency_response(inputs="rod.end fz", outputs="rod.end uz", frequencies=hertz)
    top = found.summit()
    there = model.frequency_response(inputs="rod.end fz", outputs="rod.end uz", frequencies=[top.frequency])
    assert top.amplitude == pytest.approx(there.amplification()[0], rel=1e-3)  # solved there, without poles
    assert top.amplitude > 50.0 * found.amplification().max()


def test_both_peaks_of_a_tuned_damper_are_listed():
    """Den Hartog: tuned for equal peaks, both are sqrt(1 + 2/mu) of the static deflection; the valley is shallow.

    They are those of two degrees of freedom, in closed form.
    """
    ratio, stiffness = 0.05, 1000.0
    small, tuning = ratio, 1.0 / (1.0 + ratio)
    soft, loss = (
        small * tuning**2 * stiffness,
        2.0 * small * np.sqrt(stiffness * 3.0 * ratio / (8.0 * (1.0 + ratio) ** 3)),
    )
    rigid = dict.fromkeys(("uy", "uz", "rx", "ry", "rz"), 1e9)
    model = vr.Model()
    model.add("block", vr.Box((0.1, 0.1, 0.1), mass=1.0))
    model.add("damper", vr.Box((0.05, 0.05, 0.05), mass=small))
    model.spring("block", stiffness={"ux": stiffness} | rigid)
    model.spring("damper", "block", stiffness={"ux": soft} | rigid, damping={"ux": loss})
    found = model.frequency_response(inputs=["block fx"], outputs=["block ux"], band=(2.0, 9.0))

    def size(hertz):
        w = 2.0 * np.pi * hertz
        link = soft + 1j * w * loss
        return abs((link - small * w**2) / ((stiffness + link - w**2) * (link - small * w**2) - link**2))

    peaks = found.resonances()
    for peak, near in zip(peaks, (4.5, 5.3), strict=True):
        top = scipy.optimize.minimize_scalar(
            lambda f: -size(f), bounds=(near - 0.3, near + 0.3), method="bounded"
        )
        assert peak.frequency == pytest.approx(top.x, rel=1e-3)
        assert peak.amplitude == pytest.approx(-top.fun, rel=1e-4)
        assert peak.amplitude * stiffness == pytest.approx(np.sqrt(1.0 + 2.0 / ratio), rel=2e-3)
