"""Free decays in closed form with noise: intervals that hold, several modes, and what is wrong with a record."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

import viscorod as vr
from helpers.pictures import written
from helpers.synthetic_results import swing
from viscorod.cli.app import app
from viscorod.records.damped_sines import fit_sines, pencil_poles
from viscorod.records.decay_doubts import _trend
from viscorod.records.sine_noise import FitNoise
from viscorod.results.run import Run
from viscorod.solve.estimation.noise import SeriesNoise

FREQUENCY, RATIO = 2.0, 0.03
TIMES = np.arange(200) * 0.025


def sine(times, frequency=FREQUENCY, ratio=RATIO, amplitude=1.0, phase=0.4):
    """A damped sine with this natural frequency."""
    omega = 2.0 * np.pi * frequency
    return (
        amplitude * np.exp(-ratio * omega * times) * np.cos(omega * np.sqrt(1.0 - ratio**2) * times + phase)
    )


def test_intervals_of_noisy_decays_hold():
    """95 % intervals of 200 decays contain the truth 95 % of the time, within three binomial standard deviations."""
    rng = np.random.default_rng(4)
    start = np.array([2j * np.pi * FREQUENCY * 1.01 - 0.5])
    inside, ratios, widths = [], [], []
    for _ in range(200):
        fit = fit_sines(TIMES, sine(TIMES) + 0.2 + rng.normal(0.0, 0.05, len(TIMES)), start)
        (f,), (z,), ((df,), (dz,)) = fit.frequencies, fit.ratios, fit.half_widths(0.95)
        inside.append([abs(f - FREQUENCY) < df, abs(z - RATIO) < dz])
        ratios.append(z)
        widths.append(dz / 1.972)  # Student's quantile of 194 degrees of freedom
    assert np.mean(inside, axis=0) == pytest.approx([0.95, 0.95], abs=0.046)
    # and they are no wider than the scatter of the ratios
    assert np.mean(widths) == pytest.approx(np.std(ratios), rel=0.15)


def test_intervals_of_a_decay_lie_about_its_numbers():
    """As wide as the half widths that are stored, which hold as above; the truth of this one is in both."""
    rng = np.random.default_rng(6)
    found = vr.decay(TIMES, sine(TIMES) + rng.normal(0.0, 0.02, len(TIMES)))
    for intervals, numbers, true, name in (
        (found.frequency_intervals, found.frequencies, FREQUENCY, "frequency"),
        (found.damping_ratio_intervals, found.damping_ratios, RATIO, "damping_ratio"),
    ):
        (low, high), width = intervals[0], found.data[f"{name}_width"].values[0]
        assert (low + high) / 2.0 == pytest.approx(numbers[0], rel=1e-12)
        assert (high - low) / 2.0 == pytest.approx(width, rel=1e-9)
        assert low < true < high


def test_least_squares_scatters_less_than_the_matrix_pencil():
    rng = np.random.default_rng(5)
    off = []
    for _ in range(40):
        noisy = sine(TIMES) + rng.normal(0.0, 0.1, len(TIMES))
        start = pencil_poles(TIMES, noisy, 1)
        fit = fit_sines(TIMES, noisy, start)
        off.append([-s.real / abs(s) - RATIO for s in (start[0], fit.poles[0])])
    pencil, squares = np.std(off, axis=0)
    assert squares < pencil < 2.0 * squares


def coloured(rng, count, memory, size):
    """Noise of an AR(1) process with this standard deviation."""
    kicks = rng.normal(0.0, size * np.sqrt(1.0 - memory**2), count + 100)
    return lfilter([1.0], [1.0, -memory], kicks)[100:]


def test_intervals_hold_in_coloured_noise():
    """Within three binomial standard deviations; by the autocovariances of residuals 80 % of them held."""
    rng = np.random.default_rng(6)
    start = np.array([2j * np.pi * FREQUENCY - 0.4])
    inside = []
    for _ in range(150):
        fit = fit_sines(TIMES, sine(TIMES) + coloured(rng, len(TIMES), 0.9, 0.05), start)
        off = np.abs(fit.frequencies[0] - FREQUENCY), np.abs(fit.ratios[0] - RATIO)
        inside.append([one < width[0] for one, width in zip(off, fit.half_widths(0.95), strict=True)])
    assert np.mean(inside, axis=0) == pytest.approx([0.95, 0.95], abs=0.053)


def test_coloured_noise_is_no_further_mode():
    """Bayes' criterion of white noise found slow modes in two of three such records."""
    rng = np.random.default_rng(12)
    for _ in range(5):
        found = vr.decay(TIMES, sine(TIMES) + coloured(rng, len(TIMES), 0.9, 0.05), start=0.0)
        assert len(found.frequencies) == 1
        assert any("not white noise" in text for text in found.warnings)


def test_intervals_of_coloured_noise_are_those_of_its_covariance():
    """Least squares under an autoregression that is known: B' R B with R written out."""
    rng = np.random.default_rng(13)
    mixing = rng.normal(size=(40, 2))
    noise = SeriesNoise(0.3, np.array([0.8, -0.3]), 1e-12 * np.eye(2))
    first, second = 0.8 * (1.0 + 0.3), -0.3  # of r_t = a r_(t-1) + b r_(t-2)
    rho = [1.0, first / (1.0 - second)]
    for _ in range(38):
        rho.append(first * rho[-1] + second * rho[-2])
    covariance = 0.09 * mixing.T @ toeplitz(rho) @ mixing
    told = FitNoise(mixing, noise, 1_000_000)
    np.testing.assert_allclose(told.covariance, covariance, rtol=1e-12)
    np.testing.assert_allclose(
        told.half_widths(np.eye(2), 0.95), 1.95996 * np.sqrt(np.diag(covariance)), rtol=1e-5
    )


def test_two_modes_and_a_creeping_rest():
    rng = np.random.default_rng(7)
    times = np.arange(800) * 0.01
    rest = 0.3 + 0.2 * np.exp(-times / 1.5)
    values = sine(times) + sine(times, 7.3, 0.01, 0.2) + rest + rng.normal(0.0, 0.005, len(times))
    found = vr.decay(times, values)
    assert len(found.frequencies) == 2
    for k, truth in enumerate([(FREQUENCY, RATIO), (7.3, 0.01)]):
        assert found.frequencies[k] == pytest.approx(truth[0], abs=2.0 * found.data.frequency_width.values[k])
        assert found.damping_ratios[k] == pytest.approx(
            truth[1], abs=2.0 * found.data.damping_ratio_width.values[k]
        )
        assert found.data.damping_ratio_width.values[k] < 0.05 * truth[1]
    assert any("the rest moves by 0.1" in text for text in found.warnings)


def test_modes_that_beat_are_both_found():
    rng = np.random.default_rng(8)
    times = np.arange(2000) * 0.02
    values = sine(times, 2.0, 0.004) + sine(times, 2.12, 0.004, 0.7) + rng.normal(0.0, 0.01, len(times))
    found = vr.decay(times, values, start=0.0)
    assert sorted(found.frequencies) == pytest.approx([2.0, 2.12], rel=1e-3)
    assert found.damping_ratios == pytest.approx([0.004, 0.004], rel=0.05)
    assert any("beat with a period of 8.3" in text for text in found.warnings)


def test_ratios_that_differ_are_named_and_not_the_last_one_of_which_little_is_known():
    """Of 0.05 +- 0.001, 0.04 +- 0.001 and 0.045 +- 0.02 the first two are seven standard errors apart."""
    size = np.array([3.0, 2.0, 1.0])
    ratio, width = np.array([0.05, 0.04, 0.045]), 1.96 * np.array([1e-3, 1e-3, 2e-2])
    (told,) = _trend({"ratio": ratio, "ratio_width": width, "amplitude": size}, "ratio", "damping ratio", "")
    assert told.startswith("the damping ratio is not one number: 0.05 at the amplitude 3, 0.04 at 2;")


def test_ratio_that_depends_on_amplitude_is_told():
    """q'' + 2 zeta (1 + (a/A)) omega q' + omega^2 q = 0 with the amplitude a: a decay with a rate that falls."""
    times = np.arange(1500) * 0.01
    omega = 2.0 * np.pi * FREQUENCY
    low = 0.02 * omega
    # a' = -low (1 + a) a, a(0) = 1: a = 1/(2 exp(low t) - 1)
    amplitude = 1.0 / (2.0 * np.exp(low * times) - 1.0)
    values = amplitude * np.cos(omega * times) + np.random.default_rng(9).normal(0.0, 2e-3, len(times))
    found = vr.decay(times, values, start=0.0, cycles=3)
    ratio, size = found.data.piece_ratio.values, found.data.piece_amplitude.values
    clear = size > 0.1
    assert np.count_nonzero(clear) >= 3
    assert ratio[clear] == pytest.approx(0.02 * (1.0 + size[clear]), rel=0.03)
    assert np.ptp(ratio[clear]) > 0.008
    assert any("the damping ratio is not one number" in text for text in found.warnings)
    assert any("is not white noise" in text for text in found.warnings)


DOUBTS = {
    "clipped": (
        np.arange(200) * 0.01,
        lambda t: np.clip(sine(t, ratio=0.01), -0.8, 0.8),
        "the record is clipped",
    ),
    "few cycles": (np.arange(100) * 0.01, sine, "only 2 cycles"),
    "sampling": (np.arange(200) * 0.125, lambda t: sine(t, ratio=0.005), "may be an alias of 6 or 10 Hz"),
    "bins": (
        np.arange(800) * 0.01,
        lambda t: sine(t, ratio=0.005),
        "half-power: refused; the width of 0.02 Hz",
    ),
}


@pytest.mark.parametrize("name", DOUBTS)
def test_what_is_wrong_with_a_record_is_told(name):
    times, values, message = DOUBTS[name]
    noise = np.random.default_rng(10).normal(0.0, 1e-3, len(times))
    noisy = values(times) if name == "clipped" else values(times) + noise
    assert any(message in text for text in vr.decay(times, noisy, start=0.0).warnings)


def test_a_record_that_is_clipped_at_first_is_used_from_there_on():
    """Intervals hold the truth: of the whole record the ratio came out a fifth too small, with an interval of 6 %."""
    times, inside = np.arange(1200) * 0.01, []
    for seed in range(6):
        noise = np.random.default_rng(seed).normal(0.0, 1e-3, len(times))
        found = vr.decay(times, np.clip(sine(times, ratio=0.01) + noise, -0.6, 0.6))
        off = np.abs(found.damping_ratios[0] - 0.01)
        inside.append(off < found.data.damping_ratio_width.values[0])
        assert off < 2e-4
        assert any("is clipped until" in text for text in found.warnings)
    assert sum(inside) >= 4  # of 6 intervals of 95 %; fewer have a probability of 0.0022


def test_a_clean_record_has_no_doubts():
    times = np.arange(2400) * 0.01
    values = sine(times) + np.random.default_rng(11).normal(0.0, 1e-3, len(times))
    assert vr.decay(times, values, start=0.0).warnings == []


def test_decay_of_a_run_saved_and_drawn(tmp_path):
    run = Run(swing(0.05, 3.6, duration=12.0))
    found = vr.decay(run, place="beam.end", direction="y")
    assert found.damping_ratios == pytest.approx([0.05], rel=1e-4)
    assert found.frequencies == pytest.approx([3.6 / (2.0 * np.pi)], rel=1e-4)
    again = vr.load(found.save(tmp_path / "decay.nc"))
    assert again.report() == found.report()
    assert written(again.plot, tmp_path / "decay.png").stat().st_size > 10_000
    with pytest.raises(vr.InputError, match="a free decay has no page in the browser"):
        vr.view(again, tmp_path / "decay.html")


def test_command(tmp_path, capsys):
    from typer.testing import CliRunner

    file = tmp_path / "tip.csv"
    held = np.where(TIMES < 1.0, 1.0, np.cos(2 * np.pi * 2 * (TIMES - 1.0)) * np.exp(-0.4 * (TIMES - 1.0)))
    noisy = held + np.random.default_rng(3).normal(0.0, 1e-3, len(TIMES))
    np.savetxt(file, np.column_stack([TIMES, 1e3 * noisy]), delimiter=",", header="t_s,tip_mm", comments="")
    told = CliRunner().invoke(
        app, ["damping", "decay", str(file), "--value", "tip", "-o", str(tmp_path / "out")]
    )
    assert told.exit_code == 0, told.output
    assert "samples from 1.125" in told.output or "samples from 1.15" in told.output
    found = vr.load(tmp_path / "out" / "decay.nc")
    pole = complex(-0.4, 4.0 * np.pi)
    assert found.damping_ratios[0] == pytest.approx(0.4 / abs(pole), rel=0.02)
    refused = CliRunner().invoke(app, ["damping", "decay", str(file), "--value", "top"])
    assert refused.exit_code == 2
    assert "did you mean 'tip'?" in refused.output


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.zeros(100), "nothing moves"),
        (np.exp(-np.arange(100) * 0.1), "no motion that swings"),
        (sine(np.arange(10) * 0.1), "a decay needs 16 at least"),
    ],
)
def test_what_is_no_decay_is_refused(values, message):
    with pytest.raises(vr.InputError, match=message):
        vr.decay(np.arange(len(values)) * 0.1, values, start=0.0)


def test_flat_tops_with_noise_on_them_are_clipped():
    """A limit before the noise: the ratio came out 13 % too small, with a false mode at three times 5 Hz."""
    times, inside = np.arange(1000) * 0.005, []
    for seed in range(8):
        noise = np.random.default_rng(seed).normal(0.0, 2e-3, len(times))
        decay = np.exp(-0.02 * 10 * np.pi * times) * np.cos(10 * np.pi * np.sqrt(1 - 4e-4) * times)
        found = vr.decay(times, np.clip(decay, -0.6, 0.6) + noise)
        assert len(found.frequencies) == 1
        assert found.damping_ratios[0] == pytest.approx(0.02, rel=0.02)
        inside.append(abs(found.damping_ratios[0] - 0.02) < found.data.damping_ratio_width.values[0])
        assert any("is clipped until" in text for text in found.warnings)
    assert sum(inside) >= 5  # of 8 intervals of 95 %; fewer have a probability of 0.0004


def test_a_rod_that_is_held_before_its_release_is_not_clipped():
    times = np.arange(1200) * 0.005
    after = np.maximum(times - 1.0, 0.0)
    swing = np.exp(-0.02 * 10 * np.pi * after) * np.cos(10 * np.pi * after)
    for seed in range(4):
        found = vr.decay(times, swing + np.random.default_rng(seed).normal(0.0, 2e-3, len(times)))
        assert not any("clipped" in text for text in found.warnings)


def test_a_record_that_is_clipped_to_its_end_is_said_to_be():
    times = np.arange(400) * 0.005
    noise = np.random.default_rng(1).normal(0.0, 2e-3, len(times))
    lasting = np.exp(-0.002 * 10 * np.pi * times) * np.cos(10 * np.pi * times)
    found = vr.decay(times, np.clip(lasting + noise, -0.5, 0.5))
    assert any("the record is clipped there" in text for text in found.warnings)
    assert any("may be harmonics of 5" in text for text in found.warnings)


def test_a_drift_larger_than_the_swing_does_not_move_its_begin():
    times = np.arange(1000) * 0.005
    swing = np.exp(-0.02 * 10 * np.pi * times) * np.cos(10 * np.pi * times)
    found = vr.decay(times, swing + times + np.random.default_rng(2).normal(0.0, 2e-3, len(times)))
    assert found.data.time.values[0] < 0.3
    assert found.damping_ratios[0] == pytest.approx(0.02, abs=2.0 * found.data.damping_ratio_width.values[0])
    assert (
        found.data.damping_ratio_width.values[0] < 5e-5
    )  # 1.7e-3 from the last swings, where the drift is farthest


@pytest.mark.parametrize(("rate", "message"), [(0.0, "hardly dies out"), (0.08, "grows meanwhile")])
def test_what_is_driven_is_said_to_be_no_decay(rate, message):
    times = np.arange(1000) * 0.005
    swing = 0.01 * np.exp(rate * times) * np.sin(10 * np.pi * times)
    noise = np.random.default_rng(3).normal(0.0, 2e-5, len(times))
    found = vr.decay(times, swing + noise, start=0.0)
    assert any(message in text for text in found.warnings)


def test_steps_of_a_coarse_converter_are_no_spikes():
    """Sixteen levels: 40 samples were called strays where the swing had sunk below one step."""
    times = np.arange(1000) * 0.005
    swing = np.exp(-0.02 * 10 * np.pi * times) * np.cos(10 * np.pi * times)
    found = vr.decay(times, np.round(swing / 0.15) * 0.15)
    assert not any("stand far off" in text for text in found.warnings)


@pytest.mark.parametrize("again", [0.1, 0.3])
@pytest.mark.parametrize("phase", [0.5, 2.0])
def test_a_small_blow_in_the_middle_ends_the_record(again, phase):
    """Of a tenth of the first swing; frequencies were off by seven times what their intervals said."""
    times, inside = np.arange(1000) * 0.005, []
    pole = 10 * np.pi * complex(-0.02, 1.0)
    truth = np.array([abs(pole) / (2 * np.pi), 0.02 * 10 * np.pi / abs(pole)])
    for seed, blow in enumerate((1.5, 2.5, 4.0)):
        later = np.where(
            times >= blow, again * np.exp(pole * np.maximum(times - blow, 0.0) + 1j * phase), 0.0
        )
        noise = np.random.default_rng(seed).normal(0.0, 2e-3, len(times))
        found = vr.decay(times, np.exp(pole * times).real + later.imag + noise)
        assert found.data.time.values[-1] == pytest.approx(blow, abs=0.05)
        assert any("something sets it in motion again after" in text for text in found.warnings)
        assert len(found.frequencies) == 1
        off = np.abs(np.array([found.frequencies[0], found.damping_ratios[0]]) - truth)
        width = [found.data[f"{name}_width"].values[0] for name in ("frequency", "damping_ratio")]
        inside += list(off < np.array(width))
    assert sum(inside) >= 4  # of 6 intervals of 95 %; fewer have a probability of 0.0022


def test_samples_that_are_missing_unmarked_end_the_record():
    times = np.arange(1000) * 0.005
    swing = np.exp(-0.02 * 10 * np.pi * times) * np.cos(10 * np.pi * times)
    swing += np.random.default_rng(4).normal(0.0, 2e-3, len(times))
    found = vr.decay(times[:890], np.r_[swing[:400], swing[510:]])
    assert found.data.time.values[-1] == pytest.approx(2.0, abs=0.05)
    assert found.frequencies[0] == pytest.approx(5.001, abs=1e-3)
    assert any("or samples are missing there" in text for text in found.warnings)


@pytest.mark.parametrize("kind", ["air", "friction", "coloured"])
def test_damping_that_depends_on_the_amplitude_is_no_blow(kind):
    times = np.arange(1000) * 0.01
    low = 0.005 * 10 * np.pi * times
    size = np.exp(-low) / (1.0 + 4.0 * (1.0 - np.exp(-low))) if kind == "air" else np.exp(-4.0 * low)
    size = np.maximum(1.0 - 0.15 * times, 0.0) if kind == "friction" else size
    noise = np.random.default_rng(5).normal(0.0, 2e-3, len(times))
    if kind == "coloured":
        noise = lfilter([1.0], [1.0, -0.9], 5.0 * noise)
    found = vr.decay(times, size * np.cos(10 * np.pi * times) + noise)
    assert not any("sets it in motion again" in text for text in found.warnings)


def test_pieces_of_a_decay_behind_an_amplifier_that_blocks_constants_have_its_ratio():
    """A release by a, behind a first-order high pass: the rest is an exponential, in each piece nearly a line."""
    rate, hertz, ratio = 500.0, 7.3, 0.012
    times = np.arange(0.0, 3.0, 1.0 / rate)
    pole = 2.0 * np.pi * hertz * (-ratio + 1j * np.sqrt(1.0 - ratio**2))
    values = np.real(np.exp(pole * times)) - 0.9 * np.exp(-2.0 * np.pi * 0.5 * times)
    values += 0.005 * np.random.default_rng(2).normal(size=len(times))
    found = vr.decay(times, values, start=0.0)
    ratios, widths = (found.data[name].values for name in ("piece_ratio", "piece_ratio_width"))
    assert widths[0] < 4e-4
    assert (np.abs(ratios - ratio) < 2.0 * widths).all()


@pytest.mark.parametrize("seed", [1, 9], ids=["well", "by the interval"])
def test_hum_is_called_so_however_well_its_ratio_is_told(seed):
    """A swing that dies out within ten cycles, and a hum of 50 Hz for five seconds, little above the noise."""
    times = np.arange(0.0, 5.0, 0.004)
    values = 4.0 * np.exp(-2.0 * times) * np.cos(44.0 * times) + 0.1 * np.sin(2.0 * np.pi * 50.0 * times)
    found = vr.decay(times, values + 0.06 * np.random.default_rng(seed).normal(size=len(times)), start=0.0)
    assert found.frequencies == pytest.approx([44.0 / (2.0 * np.pi), 50.0], rel=2e-3)
    assert any("does not die out: something else drives it" in one for one in found.warnings)


def test_a_frequency_that_depends_on_the_amplitude_is_told():
    """A softening spring: omega = omega0 (1 - A/10), its phase in closed form; one number is right nowhere."""
    times = np.arange(0.0, 6.0, 0.01)
    rate, omega = 0.4, 2.0 * np.pi * 4.0
    size = np.exp(-rate * times)
    phase = omega * (times - 0.1 * (1.0 - size) / rate)
    noisy = size * np.cos(phase) + 1e-4 * np.random.default_rng(0).normal(size=len(times))
    (told,) = [
        one for one in vr.decay(times, noisy, modes=1).warnings if "the frequency is not one number" in one
    ]
    pairs = told.split(": ")[1].split("; ")[0].split(", ")
    for pair in pairs:
        hertz, amplitude = float(pair.split(" Hz")[0]), float(pair.split()[-1])
        assert hertz == pytest.approx(4.0 * (1.0 - 0.1 * amplitude), rel=2e-3)
    steady = np.exp(-rate * times) * np.cos(omega * times) + 1e-4 * np.random.default_rng(0).normal(
        size=len(times)
    )
    assert not [one for one in vr.decay(times, steady).warnings if "not one number" in one]
