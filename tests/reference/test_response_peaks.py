"""Peaks that frequencies do not show, responses that are none, and vibrations that nothing damps."""

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

YOUNG, LENGTH, WIDTH, HEIGHT, TIME = 2.06e11, 0.3, 0.02, 0.002, 2e-5


def strip(damping: vr.KelvinVoigt | None = None, turned: float = 0.0) -> vr.Model:
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


def tip_receptance(hertz: float, second_moment: float) -> complex:
    """Return tip displacement over tip force of an Euler-Bernoulli cantilever with E (1 + i w tau) [m/N]."""
    omega = 2 * np.pi * hertz
    EI = YOUNG * second_moment * (1 + 1j * omega * TIME)
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
