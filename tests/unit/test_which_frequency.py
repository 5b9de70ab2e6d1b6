"""Which frequency of a damped mode is listed: |s|/2 pi or |Im s|/2 pi, and that the tables say so where they differ."""

import numpy as np
import pytest

import viscorod as vr


def strip(time):
    """A short cantilever whose first mode at w has the damping ratio w time/2 (Kelvin-Voigt, one time for all)."""
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(time, time))
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.02)
    model.add("rod", vr.Rod.straight((0, 0, 0), (0.2, 0, 0), section=section, material=rubber, elements=2))
    model.clamp("rod.start")
    model.force("rod.end", (1e-9, 0, 0))
    return model


@pytest.mark.parametrize(("time", "told"), [(0.05, True), (0.02, False)])
def test_frequencies_differ_by_the_root_of_one_minus_the_ratio_squared(time, told):
    """Closed form of proportional damping: ratio w time/2 of a mode whose natural frequency damping leaves alone."""
    undamped = strip(0.0).modes(1).frequencies[0]
    ratio = np.pi * undamped * time
    modes, followed = strip(time).modes(1), strip(time).stability([0.5, 1.0], modes=1)
    assert modes.damping_ratios[0] == pytest.approx(ratio, rel=1e-6)
    assert modes.frequencies[0] == pytest.approx(undamped, rel=1e-6)
    assert followed.frequencies[:, 0] == pytest.approx(undamped * np.sqrt(1.0 - ratio**2), rel=1e-5)
    assert bool(ratio > 0.1) is told
    texts = [" ".join(result.report().split()) for result in (modes, followed)]
    assert ("Frequencies are natural ones, |s|/2 pi" in texts[0]) is told
    assert ("Frequencies are those of oscillations, |Im s|/2 pi" in texts[1]) is told
    assert "|s|/2 pi" in modes.data["eigenvalue"].attrs["long_name"]
    assert "|Im s| over 2 pi" in followed.data["frequency"].attrs["long_name"]


def test_creeping_modes_alone_need_no_note():
    """Overdamped modes do not swing: their rates have no two frequencies."""
    modes = strip(2.0).modes(2)
    assert (modes.eigenvalues.imag == 0.0).all()
    assert "natural ones" not in modes.report()
