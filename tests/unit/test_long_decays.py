"""Long records of free decays, in which modes are looked for by means over blocks: closed forms, and all samples."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.records.coarse_samples import Coarse
from viscorod.records.damped_sines import fit_sines, residual_peak

RATE, COUNT = 4000.0, 20_000
TIMES = np.arange(COUNT) / RATE
SLOW = (23.0, 0.008, 1.0)


def decays(*modes, seed=0, noise=0.01):
    """Damped sines (natural frequency [Hz], ratio, amplitude) with noise."""
    values = noise * np.random.default_rng(seed).normal(size=COUNT)
    for hertz, ratio, size in modes:
        omega = 2.0 * np.pi * hertz
        values += (
            size * np.exp(-ratio * omega * TIMES) * np.cos(omega * np.sqrt(1.0 - ratio**2) * TIMES + 0.3)
        )
    return values


def holds(found, *modes):
    """Whether intervals of 95 %, twice as wide, contain the truth; the first mode has the most energy."""
    data = found.data
    for k, (hertz, ratio, _) in enumerate(modes):
        assert found.frequencies[k] == pytest.approx(hertz, abs=2.0 * data.frequency_width.values[k])
        assert found.damping_ratios[k] == pytest.approx(ratio, abs=2.0 * data.damping_ratio_width.values[k])
    assert len(found.frequencies) == len(modes)


@pytest.mark.parametrize(
    "second",
    [(141.0, 0.004, 0.3), (1500.0, 0.002, 0.3), (780.0, 0.03, 0.5), (600.0, 0.002, 0.3)],
    ids=["slow", "fast", "dies out early", "would be an alias"],
)
def test_second_modes_of_long_records_are_found(second):
    """The truth is that of the closed form; of blocks of six samples the last two would appear as other modes."""
    holds(vr.decay(TIMES, decays(SLOW, second), start=0.0), SLOW, second)


def test_block_means_have_the_poles_of_the_samples():
    """The mean of exp(s t) over blocks is a constant times exp(s t): without noise to round-off."""
    values = decays(SLOW, (141.0, 0.004, 0.3), noise=0.0) + 0.1 * np.exp(-TIMES / 1.5)
    coarse = Coarse.of(TIMES, values)
    assert coarse.length >= 6
    assert len(coarse.times) == COUNT // coarse.length
    poles = 2.0 * np.pi * np.array([23.0, 141.0]) * 1j - 1.0
    by_all, by_blocks = (
        fit_sines(t, y, poles, "relaxing") for t, y in ((TIMES, values), (coarse.times, coarse.values))
    )
    assert by_blocks.poles == pytest.approx(by_all.poles, rel=1e-9)


def test_samples_that_are_left_out_do_no_harm():
    kept = np.random.default_rng(2).random(COUNT) > 0.02
    modes = SLOW, (141.0, 0.004, 0.3)
    holds(vr.decay(TIMES[kept], decays(*modes)[kept], start=0.0), *modes)
    # but a gap longer than a block is none that may be bridged
    assert Coarse.of(TIMES[kept], decays(*modes)[kept]) is not None
    gap = (TIMES < 1.0) | (TIMES > 1.1)
    assert Coarse.of(TIMES[gap], decays(*modes)[gap]) is None


def test_what_dies_out_early_is_seen_in_what_a_fit_leaves():
    """A mode that is gone after a hundredth of the record: a window that begins at zero does not see it."""
    hertz, ratio = 780.0, 0.03
    pole = residual_peak(TIMES, decays((hertz, ratio, 0.5)))
    assert pole.imag / (2.0 * np.pi) == pytest.approx(hertz, rel=2e-3)
