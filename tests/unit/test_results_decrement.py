"""Cycles of a decay against damped oscillators in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers.plain_text import flat
from helpers.synthetic_results import oscillator
from viscorod import InputError
from viscorod.results.decrement import Decrement, decrement
from viscorod.results.extremes import creeping_rest, resting_value


def record(zeta, omega=3.6, step=0.02, duration=10.0, **options):
    time = np.arange(round(duration / step) + 1) * step
    return time, *oscillator(time, zeta, omega, **options)


@settings(deadline=None)
@given(st.floats(0.002, 0.3), st.floats(1e-6, 1e3))
def test_recovers_damping_ratio_and_period(zeta, amplitude):
    result = decrement(*record(zeta, amplitude=amplitude))
    # Hermite interpolation errs by (omega h)^4/384 = 7e-8 of the amplitude, in a decrement of 2 pi zeta.
    assert result.damping_ratio == pytest.approx(np.full(result.damping_ratio.size, zeta), abs=1e-6)
    assert result.period == pytest.approx(2 * np.pi / (3.6 * np.sqrt(1 - zeta**2)), rel=1e-4)
    assert result.small_amplitude_ratio == pytest.approx(zeta, abs=1e-6)
    assert result.time[0] == 0.0
    assert result.amplitude[0] == pytest.approx(amplitude)
    assert np.exp(-result.log_decrement) == pytest.approx(result.amplitude[1:] / result.amplitude[:-1])


def test_maxima_are_found_between_coarse_samples_with_third_order():
    errors = []
    for step in (0.08, 0.04):
        found = decrement(*record(0.05, step=step)).time
        period = 2 * np.pi / (3.6 * np.sqrt(1 - 0.05**2))
        errors.append(np.max(np.abs(found - np.arange(found.size) * period)))
    assert errors[1] < errors[0] / 6  # the slope of a cubic Hermite polynomial is of third order


def test_envelope_is_the_exponential_of_the_decay():
    size, rate = decrement(*record(0.05, amplitude=0.2)).envelope
    assert rate == pytest.approx(0.05 * 3.6, rel=1e-6)
    assert size == pytest.approx(0.2, rel=1e-6)


def test_limit_of_small_amplitude_is_extrapolated():
    # maxima whose ratio is 0.03 - 2 a^2: the limit is 0.03, though no cycle is near it
    amplitude = [0.06]
    for _ in range(6):
        ratio = 0.03 - 2.0 * amplitude[-1] ** 2
        amplitude.append(amplitude[-1] * np.exp(-2 * np.pi * ratio / np.sqrt(1 - ratio**2)))
    result = Decrement("beam.end", "y", 0.0, np.arange(7.0), np.array(amplitude))
    assert result.damping_ratio[-1] < 0.029
    assert result.small_amplitude_ratio == pytest.approx(0.03, rel=0.005)


@pytest.mark.parametrize(
    ("value", "count"), [([1.0, 0.5], 1), ([1.0, 0.999, 0.998, 0.9975], 3), ([1.0, 0.6, 0.45, 0.34], 2)]
)
def test_cycles_on_no_line_are_taken_as_one(value, count):
    result = Decrement("beam.end", "y", 0.0, np.arange(float(len(value))), np.array(value))
    delta = np.log(value[-1 - count] / value[-1]) / count
    assert result.small_amplitude_ratio == pytest.approx(delta / np.hypot(2 * np.pi, delta))
    assert f"last {count} cycle" in flat(str(result))


def test_higher_modes_at_the_start_are_no_dependence_on_the_amplitude():
    """Closed form: a cantilever released from a force at its end, Kelvin-Voigt, modes by their shares 1/(beta L)^4.

    The line through all three cycles had 5 % less than the ratio of the first mode.
    """
    zeta, omega = 0.05, 2 * np.pi
    time = np.arange(331) * 0.01
    value, rate = np.zeros((2, time.size))
    for beta in (1.8751, 4.6941, 7.8548):
        ratio = (beta / 1.8751) ** 2
        u, v = oscillator(time, zeta * ratio, omega * ratio, amplitude=(1.8751 / beta) ** 4)
        value, rate = value + u, rate + v
    found = decrement(time, value, rate)
    assert found.damping_ratio.size == 3
    assert found.damping_ratio[0] > 1.03 * zeta
    assert found.small_amplitude_ratio == pytest.approx(zeta, rel=2e-3)


def test_growth_has_a_negative_ratio():
    time, value, rate = record(-0.03)
    assert decrement(time, value, rate).damping_ratio == pytest.approx(-0.03, abs=1e-6)


def test_rest_is_estimated_from_the_last_extremes():
    time, value, rate = record(0.05, rest=-0.7)
    assert resting_value(time, value, rate) == pytest.approx(-0.7, rel=1e-6)
    assert decrement(time, value, rate, rest=None).damping_ratio == pytest.approx(0.05, abs=1e-5)
    time, value, rate = record(0.05, rest=1e-3)
    assert resting_value(time, value, rate) == 0.0  # within 2 % of the last amplitude


@pytest.mark.parametrize(
    ("zeta", "creep", "slow"),
    [(0.05, 0.2, 5.0), (0.05, -0.2, 5.0), (0.02, 0.1, 10.0), (0.005, 0.05, 20.0), (0.03, 3.0, 10.0)],
)
def test_rest_that_creeps_is_followed(zeta, creep, slow):
    """A damped cosine about ``creep exp(-t/slow)``, its rest small or large against the swing."""
    time, value, rate = record(zeta, duration=14.0)
    mean = creep * np.exp(-time / slow)
    motion = time, value + mean, rate - mean / slow
    for below in (False, True):
        found = decrement(*motion, rest=None, below=below)
        assert found.damping_ratio == pytest.approx(zeta, rel=5e-3)
        # left are the second difference of the creep, and that its speed moves the extremes: c^2/(2 a omega^2)
        exact = creep * np.exp(-found.time / slow)
        left = 1.2 * np.abs(exact) * (np.pi / 3.6 / slow) ** 2 / 4
        left += (exact / slow) ** 2 / (found.amplitude * 3.6**2)
        assert np.all(np.abs(found.rest - exact) < left)
        assert found.rest_at(found.time) == pytest.approx(found.rest)
    assert "about a rest that creeps from" in flat(str(found))


@pytest.mark.parametrize("duration", [3.55, 4.45, 5.55])
def test_a_ripple_on_a_slow_swing_is_no_creep(duration):
    """Two modes: where the record ends, the faster one has swung six times or more about the slower one's slope."""
    slow = record(0.02, omega=2 * np.pi, step=0.004, duration=duration)
    ripple = record(0.002, omega=24 * np.pi, step=0.004, duration=duration, amplitude=0.3)
    assert creeping_rest(slow[0], slow[1] + ripple[1], slow[2] + ripple[2]) is None


def test_one_rest_for_a_creep_is_far_off():
    """What follows the creep is needed: one value, the best at the end, errs by more than 10 % there."""
    time, value, rate = record(0.05, duration=14.0)
    mean = 0.2 * np.exp(-time / 5.0)
    motion = time, value + mean, rate - mean / 5.0
    found = decrement(*motion, rest=resting_value(*motion))
    assert found.damping_ratio[-1] / 0.05 - 1.0 > 0.1


def test_ratio_of_a_maxwell_oscillator_is_that_of_its_eigenvalue():
    """Mass on the relaxing spring of the case rubber_strip, let go where it hung relaxed: decay by eigenvectors."""
    shares, times, stiffness = np.array([0.20, 0.15, 0.10]), np.array([0.001, 0.03, 1.0]), 228.2
    system = np.zeros((5, 5))  # displacement, velocity, elongations of the springs of the branches
    system[0, 1] = 1.0
    system[1] = -stiffness * np.concatenate([[1.0 - shares.sum(), 0.0], shares])
    system[2:, 1], system[2:, 2:] = 1.0, -np.diag(1.0 / times)
    roots, vectors = np.linalg.eig(system)
    parts = np.linalg.solve(vectors, [-0.08, 0.0, 0.0, 0.0, 0.0])
    time = np.linspace(0.0, 4.0, 801)
    value, rate = ((vectors * parts)[:2] @ np.exp(np.outer(roots, time))).real
    swinging = roots[np.argmax(roots.imag)]
    found = decrement(time, value, rate, rest=None, below=True)
    assert found.damping_ratio == pytest.approx(-swinging.real / abs(swinging), rel=1e-3)
    assert found.small_amplitude_ratio == pytest.approx(-swinging.real / abs(swinging), rel=1e-3)


def test_rest_that_stays_is_one_value():
    """Neither a constant rest nor the wandering midline of two modes is a creep."""
    time, value, rate = record(0.05, rest=-0.7)
    assert creeping_rest(time, value, rate) is None
    slow, slow_rate = oscillator(time, 0.05, 1.1, amplitude=0.1)
    assert creeping_rest(time, value + slow, rate + slow_rate) is None
    assert creeping_rest(time[:200], value[:200], rate[:200]) is None  # too short to tell


def test_ripple_on_a_swing_makes_no_cycle():
    time, value, rate = record(0.02)
    ripple = 0.05 * np.exp(-0.2 * time) * np.cos(40 * time)
    ripple_rate = -0.2 * ripple - 2.0 * np.exp(-0.2 * time) * np.sin(40 * time)
    result = decrement(time, value + ripple, rate + ripple_rate)
    assert result.period == pytest.approx(2 * np.pi / 3.6, abs=0.1)


def test_start_in_motion_is_no_maximum():
    time, value, rate = record(0.05)
    cut = time >= 0.3  # already on its way down
    result = decrement(time[cut], value[cut], rate[cut])
    assert result.time[0] == pytest.approx(2 * np.pi / 3.6, rel=2e-3)


def test_swing_cut_off_by_the_end_does_not_count():
    period = 2 * np.pi / (3.6 * np.sqrt(1 - 0.05**2))
    whole = decrement(*record(0.05, duration=5.0))
    cut = decrement(*record(0.05, duration=2.1 * period))
    assert whole.time.size == 3
    assert cut.time.size == 2


def test_noise_after_the_decay_makes_no_cycle():
    time, value, rate = record(0.3, duration=40.0)
    noise = 1e-9 * np.sin(50 * time)
    result = decrement(time, value + noise, rate + 5e-8 * np.cos(50 * time))
    assert result.amplitude.min() > 1e-6


@pytest.mark.parametrize(
    ("time", "value", "rate"),
    [
        (np.array([0.0]), np.array([1.0]), np.array([0.0])),
        (np.linspace(0, 1, 11), np.zeros(11), np.zeros(11)),
        (np.linspace(0, 1, 11), np.linspace(0, 1, 11), np.ones(11)),
        record(0.05, duration=1.0),
    ],
)
def test_fewer_than_two_maxima_is_an_input_error(time, value, rate):
    with pytest.raises(
        InputError, match=r"beam\.end along y passes (no|one) complete maximum.*simulate longer"
    ):
        decrement(time, value, rate, place="beam.end", axis="y")


def test_text_has_a_line_for_every_cycle():
    result = decrement(*record(0.05), place="beam.end", axis="y")
    lines = str(result).splitlines()
    assert lines[0] == "Decay of beam.end along y"
    assert len(lines) == 3 + result.time.size
    assert lines[2].split()[-1] == "0.05"


def test_a_motion_of_nanometres_and_microseconds_has_digits():
    time, value, rate = record(0.05)
    large = decrement(time, value, rate, place="a", axis="x")
    small = decrement(1e-6 * time, 1e-9 * value, 1e-3 * rate, place="a", axis="x")
    rows, shrunk = (str(found).splitlines() for found in (large, small))
    assert shrunk[1].split() == [
        word.replace("[s]", "[µs]").replace("[m]", "[nm]") for word in rows[1].split()
    ]
    assert [line.split() for line in shrunk[2:]] == [line.split() for line in rows[2:]]


@pytest.mark.parametrize(
    ("time", "value", "regular"),
    [
        ([0.0, 1.0, 2.1], [1.0, 0.5, 0.4], True),
        ([0.0, 1.0, 2.0], [1.0, 1.0, 1.001], True),
        ([0.0, 1.0, 2.4], [1.0, 0.5, 0.4], False),
        ([0.0, 1.0, 2.0], [1.0, 0.5, 0.6], False),
        ([0.0, 1.0], [1.0, 0.5], False),
    ],
)
def test_only_steady_shrinking_cycles_are_a_decay(time, value, regular):
    assert Decrement("", "", 0.0, np.array(time), np.array(value)).regular is regular


def test_minima_count_for_a_motion_that_starts_below_rest():
    time, value, rate = record(0.05, amplitude=0.2)
    above, below = decrement(time, value, rate), decrement(time, -value, -rate, below=True)
    np.testing.assert_allclose(below.value, -above.value)
    np.testing.assert_allclose(below.damping_ratio, above.damping_ratio)


def test_ratios_that_jump_are_taken_as_one():
    found = Decrement("", "", 0.0, np.arange(5.0), np.array([1.0, 0.6, 0.55, 0.3, 0.29]))
    assert found.scattered
    assert found.envelope[1] == pytest.approx(0.33, rel=0.1)
    assert "all cycles taken as one" in flat(str(found))
    assert not decrement(*record(0.05)).scattered


@pytest.mark.parametrize("end", [3.05, 3.2, 3.45, 3.55])
def test_a_ripple_at_the_last_maximum_is_no_swing(end):
    """Two modes without damping, the second with two bumps on every crest: the rest is 0, and so is the damping.

    The last three extremes, all of them at the crest, told a rest of 0.993 and damping ratios of 0.4.
    """
    time = np.linspace(0.0, end, 1221)
    slow, fast = 2.0 * np.pi, 2.0 * np.pi * 15.0
    value = np.cos(slow * time) - 0.008 * np.cos(fast * time)
    rate = -slow * np.sin(slow * time) + 0.008 * fast * np.sin(fast * time)
    assert resting_value(time, value, rate) == 0.0
    found = decrement(time, value, rate, rest=None)
    assert found.period == pytest.approx(1.0, rel=0.05)
    assert found.damping_ratio == pytest.approx(0.0, abs=1e-6)
