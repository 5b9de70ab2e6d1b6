"""Decays that a converter has held or rounded to few levels; the truth is a damped cosine."""

import numpy as np
import pytest

import viscorod as vr

TIMES = np.arange(2000) / 200.0
SWING = np.exp(-0.02 * 10.0 * np.pi * TIMES) * np.cos(10.0 * np.pi * np.sqrt(1.0 - 0.02**2) * TIMES)
"""5 Hz, a ratio of 0.02."""


def test_values_that_are_held_are_one_sample_each():
    rng = np.random.default_rng(1)
    noisy = SWING + 0.01 * rng.normal(size=len(TIMES))
    found = vr.decay(TIMES, np.repeat(noisy[::4], 4))
    assert len(found.frequencies) == 1
    assert abs(found.damping_ratios[0] - 0.02) < 2.0 * found.data.damping_ratio_width.values[0]
    assert any("every value stands 4 times in a row" in text for text in found.warnings)
    assert not any("stands" in text or "clipped" in text for text in vr.decay(TIMES, noisy).warnings)


@pytest.mark.parametrize(("levels", "offset"), [(16, 0.05), (32, 0.1)])
def test_a_swing_within_two_levels_is_no_part_of_a_decay(levels, offset):
    """With it there were up to six modes, and 0.0176 +- 0.0005 for 0.02."""
    found = vr.decay(TIMES, np.round((SWING + offset) * levels / 2.0) * 2.0 / levels)
    assert len(found.frequencies) == 1
    width = found.data.damping_ratio_width.values[0]
    assert abs(found.damping_ratios[0] - 0.02) < 2.0 * width < 0.002
    assert not any("in motion again" in text for text in found.warnings)


def rubbed(times, hertz, ratio, friction):
    """Return a swing with viscous and dry friction: damped cosines about +-friction, one for each half cycle."""
    omega = 2.0 * np.pi * hertz
    damped = omega * np.sqrt(1.0 - ratio**2)
    half = np.pi / damped
    turning, values = 1.0, np.zeros(len(times))
    for k in range(int(times[-1] / half) + 1):
        about = friction * np.sign(turning)
        inside = (times >= k * half) & (times < (k + 1) * half)
        t = times[inside] - k * half
        swing = np.cos(damped * t) + ratio / np.sqrt(1.0 - ratio**2) * np.sin(damped * t)
        values[inside] = about + (turning - about) * np.exp(-ratio * omega * t) * swing
        turning = about - (turning - about) * np.exp(-ratio * omega * half)
        if abs(turning) < friction:
            values[times >= (k + 1) * half] = turning
            break
    return values


def test_friction_is_not_taken_for_modes_on_either_side():
    """Dry friction of a hundredth of the first swing came out as three modes, and its ratios by amplitude without two.

    A cycle loses 4 friction of its amplitude: the ratio is 2 friction/(pi amplitude) beside the viscous one.
    """
    times = np.arange(0.0, 12.0, 0.01)
    values = rubbed(times, 3.0, 0.002, 0.01) + 0.002 * np.random.default_rng(0).normal(size=len(times))
    found = vr.decay(times, values)
    assert len(found.frequencies) == 1
    assert any("the damping ratio is not one number" in text for text in found.warnings)
    amplitude, ratio = (found.data[f"piece_{name}"].values for name in ("amplitude", "ratio"))
    large = amplitude > 0.2
    assert np.count_nonzero(large) >= 4
    np.testing.assert_allclose(ratio[large], 0.002 + 0.02 / (np.pi * amplitude[large]), rtol=0.08)
