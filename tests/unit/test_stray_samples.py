"""Decays as rigs record them: dropouts, spikes, hum, drift, a second release. Ratios are those of the closed form."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.records.stray_samples import dropouts, spikes

FREQUENCY, RATIO, RATE, RELEASE = 7.3, 0.012, 250.0, 0.5
TIMES = np.arange(1000) / RATE


def released(times, at=RELEASE):
    """A mass that is held at 12 and let go."""
    omega = 2.0 * np.pi * FREQUENCY
    damped, t = omega * np.sqrt(1.0 - RATIO**2), np.clip(times - at, 0.0, None)
    swing = np.cos(damped * t) + RATIO / np.sqrt(1.0 - RATIO**2) * np.sin(damped * t)
    return 12.0 * np.exp(-RATIO * omega * t) * swing


def noise(seed, times=TIMES):
    return 0.02 * np.random.default_rng(seed).normal(size=len(times))


def bursts(seed):
    rng = np.random.default_rng(seed)
    found = np.zeros(len(TIMES), dtype=bool)
    for first in rng.integers(0, len(TIMES) - 20, 12):
        found[first : first + rng.integers(2, 10)] = True
    return found


def with_spikes(seed):
    rng = np.random.default_rng(seed)
    return np.where(rng.random(len(TIMES)) < 0.01, 30.0 * rng.normal(size=len(TIMES)), 0.0)


RECORDS = {
    "dropouts to a code": (
        np.where(bursts(1), -9999.0, released(TIMES) + noise(1)),
        "stand far off the others",
    ),
    "dropouts to zero": (
        np.where(bursts(2), 0.0, released(TIMES) + 150.0 + noise(2)),
        "stand far off the others",
    ),
    "dropouts to the rest": (
        np.where(bursts(3), 0.0, released(TIMES) + noise(3)),
        "stand far off the others",
    ),
    "spikes": (released(TIMES) + noise(4) + with_spikes(4), "stand far off the others"),
    "hum": (
        released(TIMES) + noise(5) + 4.0 * np.sin(2.0 * np.pi * 50.0 * TIMES),
        "50 Hz does not die out: something else drives it",
    ),
    "drift": (released(TIMES) + noise(6) + 0.5 * TIMES**2, "the rest moves by"),
    "two releases": (
        np.where(TIMES < 2.6, released(TIMES), released(TIMES, 2.6)) + noise(7),
        "something sets it in motion again after 2.",
    ),
}


@pytest.mark.parametrize("name", RECORDS)
def test_what_rigs_do_to_a_record_does_not_change_the_ratio(name):
    values, message = RECORDS[name]
    found = vr.decay(TIMES, values)
    assert any(message in text for text in found.warnings), found.warnings
    for value, width, truth in (
        (found.frequencies[0], found.data.frequency_width.values[0], FREQUENCY),
        (found.damping_ratios[0], found.data.damping_ratio_width.values[0], RATIO),
    ):
        assert abs(value - truth) < 2.0 * width < 0.05 * truth


def test_a_long_rest_after_the_swing_does_no_harm():
    """The first pass of the fit overflowed where a record has 45 cycles and more in its creep."""
    times = np.arange(5000) / RATE
    found = vr.decay(times, released(times) + noise(8, times))
    assert found.warnings == []
    assert abs(found.damping_ratios[0] - RATIO) < 2.0 * found.data.damping_ratio_width.values[0]


def test_noise_steps_and_smooth_motions_have_no_stray_samples():
    rng = np.random.default_rng(9)
    white = rng.normal(size=4000)
    assert not spikes(white, 8.0).any()
    assert not spikes(np.cumsum(white), 8.0).any()
    # what a fit leaves of a first swing: large, and gone within some samples
    left = 5e-4 * np.exp(-np.arange(180) / 1.5) * np.cos(0.9 * np.arange(180)) + 3e-5 * np.sin(
        0.3 * np.arange(180)
    )
    assert not spikes(left + 3e-6 * rng.normal(size=180), 0.01).any()
    for values in (
        white,
        np.cumsum(white),
        np.round(released(TIMES) / 0.25) * 0.25,
        np.where(TIMES > RELEASE, released(TIMES), 0.0),
        np.clip(released(TIMES), -8.0, 8.0),
        np.sin(2.0 * np.pi * np.arange(400) / 8.3),
    ):
        assert not dropouts(values).any()


@pytest.mark.parametrize(("gap", "size", "phase"), [(0.4, 0.6, 1.0), (0.7, 0.6, 2.8), (0.25, 0.3, -1.5)])
def test_a_second_blow_within_a_few_cycles(gap, size, phase):
    """Both swings die out at 0.01; together they were fitted as 0.033 and 0.017, outside of their intervals."""
    times, rate = np.arange(2000) / 200.0, 8.0 * np.pi

    def swing(t, phase):
        return np.where(
            t < 0.0, 0.0, np.exp(-0.01 * rate * t) * np.cos(np.sqrt(1.0 - 1e-4) * rate * t + phase)
        )

    values = swing(times - 0.5, 0.3) + size * swing(times - 0.5 - gap, phase)
    found = vr.decay(times, values + 4e-3 * np.random.default_rng(5).standard_normal(2000))
    assert abs(found.damping_ratios[0] - 0.01) < 2.0 * float(found.data.damping_ratio_width[0]) < 2e-4
    assert [one for one in found.warnings if "it swings otherwise than later, as after a second blow" in one]
    assert found.data.time[0] > 0.5 + gap
