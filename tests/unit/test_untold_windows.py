"""Records that were multiplied by an exponential window which nobody told: a ratio that is too large is doubted."""

from types import SimpleNamespace

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.identification.common_faults import nuisances_left
from viscorod.casefile.case import case_from_dict
from viscorod.records.record_table import record_of

TIMES = np.linspace(0.0, 3.0, 300)
MODULUS = "materials.rubber.youngs_modulus"
SHEAR = "materials.rubber.damping.shear_time, materials.rubber.damping.bulk_time"
ABOUT = {"place": "beam.end", "quantity": "displacement", "direction": "y"}
BAR = case_from_dict(
    {
        "title": "bar",
        "materials": {
            "rubber": {
                "youngs_modulus": 1e8,
                "poissons_ratio": 0.3,
                "density": 1000.0,
                "damping": {"shear_time": 5e-4, "bulk_time": 5e-4},
            }
        },
        "rods": {
            "beam": {
                "shape": "straight",
                "start": [0.0, 0.0, 0.0],
                "end": [0.3, 0.0, 0.0],
                "section": {"shape": "rectangle", "width": 0.01, "height": 0.01},
                "material": "rubber",
                "elements": 1,
                "order": 4,
            }
        },
        "supports": [{"kind": "clamp", "at": "beam.start"}],
        "loads": [{"kind": "force", "at": "beam.end", "value": [0.0, 0.02, 0.0], "until": 0}],
        "simulate": {"duration": 3.0, "tolerance": 1e-6},
    }
)


def swing(hertz=5.7, ratio=0.009):
    rate = 2.0 * np.pi * hertz * ratio
    return np.exp(-rate * TIMES) * np.cos(2.0 * np.pi * hertz * TIMES)


@pytest.mark.parametrize("window", [1.0, 0.5])
@pytest.mark.parametrize("seed", range(2))
def test_noise_that_dies_out_along_a_decay_tells_the_window(window, seed):
    """A ratio of 0.9 % comes out as 3.7 and 6.5 %; the noise was level before the window, and its rate is 1/window.

    What the fit takes of the first noise for modes leaves a slower fall.
    """
    noisy = swing() + 0.01 * np.random.default_rng(seed).normal(size=300)
    assert not any("exponential window" in one for one in vr.decay(TIMES, noisy).warnings)
    plain = vr.decay(TIMES, noisy * np.exp(-TIMES / window))
    own = 1.0 / (2.0 * np.pi * 5.7 * window)
    assert plain.damping_ratios[0] == pytest.approx(0.009 + own, rel=0.02)
    (told,) = [one for one in plain.warnings if "the noise dies out with a time constant" in one]
    assert 0.9 * window < float(told.split("constant of about ")[1].split()[0]) < 1.4 * window
    right = vr.decay(TIMES, noisy * np.exp(-TIMES / window), window_time=window)
    assert abs(right.damping_ratios[0] - 0.009) < 2.0 * right.data["damping_ratio_width"].values[0]
    assert not any("exponential window" in one for one in right.warnings)


def test_modes_that_die_out_alike_tell_it_without_noise():
    own = swing(5.0, 0.002) + 0.3 * swing(17.0, 0.0005)
    (told,) = [one for one in vr.decay(TIMES, own * np.exp(-TIMES / 0.8)).warnings if "same rate" in one]
    rates = [1.0 / 0.8 + 2.0 * np.pi * hertz * ratio for hertz, ratio in ((17.0, 0.0005), (5.0, 0.002))]
    assert [float(one) for one in told.split("rate, ")[1].split(" 1/s")[0].split(" to ")] == pytest.approx(
        rates,
        abs=0.0051,  # three digits are said
    )
    assert not any(
        "same rate" in one for one in vr.decay(TIMES, swing(5.0, 0.01) + 0.3 * swing(17.0, 0.01)).warnings
    )


def test_a_fit_to_a_weighed_record_is_doubted_and_right_without_the_window(tmp_path):
    """The time of 0.5 ms comes out as 2 ms; taken off, the record is the one of before, to the last digits."""
    still = vr.Record(TIMES, np.zeros(300), **ABOUT)
    clean = still.predicted(BAR.model(vr.Model).simulate(3.0, tolerance=1e-6))
    values = clean + 0.01 * np.ptp(clean) * np.random.default_rng(2).normal(size=300)
    weighed = values * np.exp(-TIMES)
    unknown = {MODULUS: 1.02e8, SHEAR: 6e-4}
    wrong = vr.identify(BAR, vr.Record(TIMES, weighed, **ABOUT), unknown, profile=False)
    assert wrong[SHEAR].low > 1.5e-3
    assert [one for one in wrong.sentences if "window_time of its table, record.without_exponential" in one]
    rows = "".join(f"{t!r},{x!r}\n" for t, x in zip(TIMES.tolist(), weighed.tolist(), strict=True))
    (tmp_path / "tip.csv").write_text("t [s],y [m]\n" + rows)
    record = record_of({"file": "tip.csv", "value": "y", "window_time": 1.0, **ABOUT}, tmp_path)
    np.testing.assert_allclose(record.values, values, rtol=1e-12, atol=1e-15)
    right = vr.identify(BAR, record, unknown, profile=False)
    assert right[SHEAR].low < 5e-4 < right[SHEAR].high
    assert not [one for one in right.sentences if "window" in one]


@pytest.mark.parametrize(
    ("window", "words"), [(0.0, "is positive"), (0.1, "would be down to 9e-14 at the end")]
)
def test_windows_that_cannot_be_taken_off_are_refused(window, words):
    with pytest.raises(vr.InputError, match=words):
        vr.Record(TIMES, swing(), **ABOUT).without_exponential(window)


def test_before_its_start_a_window_weighs_nothing():
    record = vr.Record(TIMES, swing(), **ABOUT).without_exponential(0.5, start=1.0)
    before = TIMES <= 1.0
    np.testing.assert_array_equal(record.values[before], swing()[before])
    np.testing.assert_allclose(record.values[-1], swing()[-1] * np.exp(4.0))


def test_a_record_of_which_next_to_nothing_is_explained_is_named():
    """A gauge along the wrong axis sees a tenth of its noise: the search ends anywhere, and what is left is white."""
    still = vr.Record(TIMES[:100], np.zeros(100), **ABOUT)
    clean = still.predicted(BAR.model(vr.Model).simulate(1.0, tolerance=1e-6))
    noise = np.std(clean) * np.random.default_rng(7).normal(size=100)
    record = vr.Record(TIMES[:100], 0.1 * clean + noise, **ABOUT)
    wrong = vr.identify(BAR, record, {MODULUS: 1.02e8}, profile=False)
    (told,) = [one for one in wrong.sentences if "% of the variance of beam.end: next to all of it is" in one]
    assert "Is beam.end, displacement y its place and direction?" in told


@pytest.mark.parametrize(("gain", "said"), [(1.0, False), (0.96, True)])
def test_a_gain_that_hides_in_the_damping_is_named(gain, said):
    """A camera that looks 16 degrees askew; most of what is left is noise, and the ratio is far off its interval."""
    rate, hertz = 2.0 * np.pi * 5.7 * 0.009, 5.7
    slopes = np.column_stack([-TIMES * swing(), np.gradient(swing(), TIMES) * TIMES / hertz])
    off = (gain - 1.0) * swing() + 0.01 * np.random.default_rng(3).normal(size=300)
    change = np.linalg.lstsq(slopes, off, rcond=None)[0]
    fit = SimpleNamespace(
        residuals=off - slopes @ change,
        predicted=swing() + slopes @ change,
        slopes=slopes,
        unknowns=SimpleNamespace(names=["rate", "frequency"]),
    )
    told = list(nuisances_left(vr.Record(TIMES, gain * swing(), name="tip", **ABOUT), fit, slice(None)))
    assert (abs(change[0]) > 0.05 * rate) == said
    assert len(told) == said
    if said:
        assert "another gain would leave, which would move rate by" in told[0]
        assert "give it unknown = ['gain']" in told[0]
