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
