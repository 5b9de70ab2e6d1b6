"""Least squares with estimated noise: coverage, Cramer and Rao's bound, what the data cannot tell, wrong models.

The models here are functions of time, no rods: what is tested are the statistics.
"""

import numpy as np
import pytest
from scipy import linalg, stats

from viscorod.solve.estimation.autoregression import (
    autocorrelation_of,
    chosen_partials,
    terms_of,
    whitened_by,
)
from viscorod.solve.estimation.information import criteria
from viscorod.solve.estimation.intervals import covariance, intervals
from viscorod.solve.estimation.least_squares import Scaled, estimate, searched
from viscorod.solve.estimation.noise import Series, SeriesNoise, ljung_box, noise_of
from viscorod.solve.estimation.predictions import central_differences
from viscorod.solve.estimation.unknowns import Unknown, Unknowns

TIMES = np.linspace(0.0, 5.0, 250)


class Swing:
    """A damped oscillator by its stiffness and retardation time; ``amplitude`` of a second, unknown motion."""

    accuracy = 1e-7

    def values(self, unknowns):
        omega = 6.0 * np.sqrt(unknowns[0])
        return np.exp(-0.5 * unknowns[1] * omega**2 * TIMES) * np.cos(omega * TIMES)

    def jacobian(self, unknowns, *, rough=False):
        return central_differences(self.values, unknowns, 1e-6 * np.abs(unknowns))

    def hold(self, unknowns):
        """Nothing is chosen."""


TRUTH = np.array([1.0, 0.02])
SOUGHT = Unknowns([Unknown("E", 1.2, logarithmic=True), Unknown("tau", 0.015, logarithmic=True)])
SIZE = 0.03


def histories(noise=None, told=False):
    return [Series("tip", slice(0, len(TIMES)), regular=True, noise=np.full(len(TIMES), SIZE), told=told)]


def coloured(rng, phi, count):
    out = rng.normal(size=count + 100)
    for k in range(1, len(out)):
        out[k] += phi * out[k - 1]
    return out[100:] * np.sqrt(1.0 - phi**2)


@pytest.mark.parametrize(("phi", "sets"), [(0.0, 80), (0.6, 80), (0.9, 80), (-0.9, 80)])
def test_intervals_cover_and_are_as_narrow_as_the_bound(phi, sets):
    rng = np.random.default_rng(5)
    model, count = Swing(), len(TIMES)
    slopes = model.jacobian(TRUTH) * TRUTH
    lags = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    noise = SIZE**2 * (phi**lags if phi else np.eye(count))
    bound = np.sqrt(np.diag(np.linalg.inv(slopes.T @ np.linalg.solve(noise, slopes))))  # Cramer and Rao
    inside, widths = 0, []
    for _ in range(sets):
        measured = model.values(TRUTH) + SIZE * coloured(rng, phi, count)
        found = estimate(model, measured, histories(), SOUGHT)
        known = covariance(found)
        inside += sum(
            one.low <= true <= one.high
            for one, true in zip(intervals(found, known, 0.95), TRUTH, strict=True)
        )
        widths.append(known.deviations / bound)
    # of so many intervals the probability to miss these limits is 1 in 1000 if they hold
    low, high = stats.binom.ppf([5e-4, 1.0 - 5e-4], 2 * sets, 0.95)
    assert low <= inside <= high
    np.testing.assert_allclose(np.mean(widths, axis=0), 1.0, atol=0.05)


def test_a_wrong_model_widens_the_intervals_and_is_told_by_the_residuals():
    rng = np.random.default_rng(7)
    model = Swing()
    clean = model.values(TRUTH) + SIZE * rng.normal(size=len(TIMES))
    beating = clean + 0.1 * np.cos(6.6 * TIMES) * np.exp(-0.2 * TIMES)
    right, wrong = (estimate(model, measured, histories(), SOUGHT) for measured in (clean, beating))
    assert (covariance(wrong).deviations > 2.0 * covariance(right).deviations).all()
    assert ljung_box(right.residuals)[1] > 0.01
    assert ljung_box(wrong.residuals)[1] < 1e-6


def test_a_product_is_told_and_its_factors_are_not():
    rng = np.random.default_rng(3)

    class Product(Swing):
        def values(self, unknowns):
            return super().values(np.array([unknowns[0] * unknowns[1], 0.02]))

    sought = Unknowns([Unknown("E", 1.3, logarithmic=True), Unknown("I", 0.9, logarithmic=True)])
    model = Product()
    measured = model.values(np.ones(2)) + SIZE * rng.normal(size=len(TIMES))
    found = estimate(model, measured, histories(), sought)
    known = covariance(found)
    assert [one.told for one in intervals(found, known, 0.95)] == [False, False]
    assert known.told(np.array([1.0, 1.0]))
    assert not known.told(np.array([1.0, -1.0]))
    single = covariance(estimate(Swing(), measured, histories(), SOUGHT)).deviations[0]
    assert known.deviation(np.array([1.0, 1.0])) == pytest.approx(single, rel=0.02)
    assert found.values.prod() == pytest.approx(1.0, abs=5.0 * single)
    assert np.abs(np.log(found.values)).max() < 0.5  # what is not told stays near the start


def test_outliers_move_a_robust_fit_less():
    rng = np.random.default_rng(11)
    model = Swing()
    measured = model.values(TRUTH) + SIZE * rng.normal(size=len(TIMES))
    measured[40:60] += 0.6
    plain, robust = (
        np.abs(
            np.log(estimate(model, measured, histories(), SOUGHT, robust=word, coloured=False).values / TRUTH)
        )
        for word in (False, True)
    )
    assert (robust < 0.5 * plain).all()


def test_profile_of_a_skewed_unknown_is_that_of_the_sum_of_squares():
    """Of a saturating curve the rate is told from one side only; a grid of the sum of squares is independent."""
    rng = np.random.default_rng(2)
    at = np.linspace(0.2, 1.0, 40)

    class Saturating:
        accuracy = 1e-7

        def values(self, unknowns):
            return 1.0 - np.exp(-at * unknowns[0])

        def jacobian(self, unknowns, *, rough=False):
            return central_differences(self.values, unknowns, 1e-6 * unknowns)

        def hold(self, unknowns):
            """Nothing is chosen."""

    series = [Series("curve", slice(0, 40), regular=False, noise=np.full(40, 0.05))]
    sought = Unknowns([Unknown("rate", 8.0, logarithmic=True)])
    measured = Saturating().values(np.array([14.0])) + 0.05 * rng.normal(size=40)
    found = estimate(Saturating(), measured, series, sought)
    known, scaled = covariance(found), Scaled(Saturating(), sought)

    def square(z):
        return float(np.sum(found.noise.whitened(measured - scaled.values(z)) ** 2))

    def profile(_k, value, _start):
        return square(np.array([value])), np.array([value])

    (one,) = intervals(found, known, 0.95, square, profile)
    assert one.how == "profile"
    z = np.linspace(found.z[0] - 1.5, found.z[0] + 3.0, 4001)
    rise = np.array([square(np.array([value])) for value in z]) - found.square
    within = np.exp(z[rise <= stats.t.ppf(0.975, known.freedom[0]) ** 2])
    assert one.low == pytest.approx(within.min(), rel=0.01)
    assert one.high == pytest.approx(within.max(), rel=0.03)


def test_autoregressions():
    """The autocorrelation of an autoregression of order one is a power; of order two it is known (Yule)."""
    np.testing.assert_allclose(autocorrelation_of(np.array([0.7]), 5), 0.7 ** np.arange(6), rtol=1e-12)
    a, b = 0.9, -0.5
    found = autocorrelation_of(np.array([a, b]), 3)
    np.testing.assert_allclose(found[1:3], [a / (1.0 - b), a * a / (1.0 - b) + b], rtol=1e-12)
    rng = np.random.default_rng(0)
    series = [Series("r", slice(0, 2000), regular=True, noise=np.ones(2000))]
    noise = noise_of(series, coloured(rng, 0.8, 2000), np.zeros((2000, 0)))
    assert noise.found[0].terms[0] == pytest.approx(0.8, abs=0.05)
    assert noise.effective_count == pytest.approx(2000 * (1.0 - 0.8**2) / (1.0 + 0.8**2), rel=0.25)


def test_whitening_is_that_of_the_exact_covariance():
    """W R W' = 1 with R of an autoregression of order three, from the Yule-Walker equations."""
    partials = np.array([0.7, -0.4, 0.2])
    exact = linalg.toeplitz(autocorrelation_of(terms_of(partials)[0], 29))
    white = whitened_by(np.eye(30), partials)
    np.testing.assert_allclose(white @ exact @ white.T, np.eye(30), atol=1e-13)


def test_an_autocorrelation_is_not_underestimated_beside_what_was_fitted():
    """A fit of slow columns takes up what is slow in the noise, and what is left goes less with itself.

    The area tangens of the estimate is the truth's to a third of its scatter over the data sets, which is that of
    the information of an autoregression of order one, 1/(n (1 - phi^2)). Burg's is far below.
    """
    rng = np.random.default_rng(4)
    count, sets, phi = 400, 100, 0.9
    slow = np.cos(np.outer(np.arange(count) / count, np.pi * np.arange(1, 5)))
    series = [Series("r", slice(0, count), regular=True, noise=np.ones(count))]
    found, doubts, plain = [], [], []
    for _ in range(sets):
        noise = coloured(rng, phi, count)
        left = noise - slow @ np.linalg.lstsq(slow, noise, rcond=None)[0]
        now = noise_of(series, left, slow)
        for _ in range(3):  # the fit is weighted by it
            white = now.whitened(slow)
            left = noise - slow @ np.linalg.lstsq(white, now.whitened(noise), rcond=None)[0]
            now = noise_of(series, left, slow, now)
        found.append(np.arctanh(now.found[0].partials[0]))
        doubts.append(now.found[0].doubt[0, 0])
        plain.append(np.arctanh(chosen_partials(left)[0]))
    scatter = 1.0 / np.sqrt(count * (1.0 - phi**2))
    assert np.mean(found) == pytest.approx(np.arctanh(phi), abs=scatter / 3.0)
    assert np.mean(plain) < np.arctanh(phi) - 0.75 * scatter
    assert np.sqrt(np.median(doubts)) == pytest.approx(scatter, rel=0.3)


def test_two_series_of_different_colour_share_one_number():
    """Both tell it together; its standard error is that of generalised least squares with the true covariance."""
    rng = np.random.default_rng(6)
    count, sizes = 300, (0.5, 2.0)
    shape = np.concatenate([np.cos(0.3 * np.arange(count)), np.ones(count)])[:, None]

    class Line:
        accuracy = 1e-9

        def values(self, unknowns):
            return shape[:, 0] * unknowns[0]

        def jacobian(self, unknowns, *, rough=False):
            return shape

        def hold(self, unknowns):
            """Nothing is chosen."""

    series = [
        Series(name, slice(k * count, (k + 1) * count), regular=True, noise=np.ones(count))
        for k, name in enumerate("ab")
    ]
    lags = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    told = sum(
        shape[one.rows, 0] @ np.linalg.solve(size**2 * phi**lags, shape[one.rows, 0])
        for one, size, phi in zip(series, sizes, (0.8, 0.5), strict=True)
    )
    errors, off = [], []
    for _ in range(40):
        noise = [size * coloured(rng, phi, count) for size, phi in zip(sizes, (0.8, 0.5), strict=True)]
        found = estimate(
            Line(), shape[:, 0] + np.concatenate(noise), series, Unknowns([Unknown("level", 1.0)])
        )
        errors.append(covariance(found).deviations[0])
        off.append(found.values[0] - 1.0)
    assert np.mean(errors) == pytest.approx(1.0 / np.sqrt(told), rel=0.04)
    assert np.std(off) == pytest.approx(1.0 / np.sqrt(told), rel=0.35)


def test_starts_find_the_lower_of_two_minima():
    """A frequency far off locks into a neighbouring period; of many starts the right one wins."""
    sought = Unknowns([Unknown("E", 3.0, 0.3, 6.0, logarithmic=True), Unknown("tau", 0.01, logarithmic=True)])
    measured = Swing().values(TRUTH) + SIZE * np.random.default_rng(8).normal(size=len(TIMES))
    one = estimate(Swing(), measured, histories(), sought)
    many = estimate(Swing(), measured, histories(), sought, starts=12, seed=1)
    np.testing.assert_allclose(many.values, TRUTH, rtol=0.1)
    assert many.agreeing >= 2
    assert many.square <= one.square * 1.001


@pytest.mark.parametrize("count", [100, 1000])
def test_a_lasting_vibration_counts_as_two_values(count):
    """Of rho_k = cos(0.3 k) the sum of (1 - k/n) rho_k^2 over both sides is n/2: n/(n/2) values."""
    root = 1.0 - 1e-9
    first = (
        2.0 * root * np.cos(0.3) / (1.0 + root**2)
    )  # partial autocorrelations of x_k = 2 r cos x_(k-1) - r^2 x_(k-2)
    noise = SeriesNoise(1.0, np.array([first, -(root**2)]))
    assert count * noise.effective_part(count) == pytest.approx(2.0, rel=0.05)


def test_the_correction_for_small_samples_does_not_decide_where_few_values_of_many_count():
    """Two effective values of 300: a number more costs some units, not tens; of six values all is as it was."""
    few, more = criteria(100.0, 2.0, 4, 300.0), criteria(100.0, 2.0, 5, 300.0)
    assert 2.0 < more[0] - few[0] < 5.0
    few, more = criteria(100.0, 6.0, 4, 6.0), criteria(100.0, 6.0, 5, 6.0)
    assert more[0] - few[0] == pytest.approx(2.0 * (5.0 * 7.0 - 4.0 * 6.0))


def test_criteria_prefer_fewer_unknowns_where_squares_are_alike():
    """For large counts the corrected criterion is Akaike's: 2 per unknown; the Bayesian one has log n per unknown."""
    few, many = criteria(1000.0, 1000.0, 2, 1000.0), criteria(1000.0, 1000.0, 3, 1000.0)
    assert many[0] - few[0] == pytest.approx(2.0, abs=0.02)
    assert many[1] - few[1] == pytest.approx(np.log(1000.0))


def test_a_search_stays_within_its_bounds():
    sought = Unknowns([Unknown("E", 1.2, 1.1, 2.0, logarithmic=True), Unknown("tau", 0.02, logarithmic=True)])
    measured = Swing().values(TRUTH)
    found = estimate(Swing(), measured, histories(), sought)
    assert found.values[0] == pytest.approx(1.1, rel=1e-3)
    held = searched(Scaled(Swing(), sought), measured, found.noise, sought.bounds, sought.start, sought.start)
    assert np.exp(held[0]) >= 1.1 * (1.0 - 1e-9)


class Peak:
    """A resonance by its frequency, damping ratio and size: real, then imaginary parts."""

    accuracy = 1e-7

    def __init__(self, hertz):
        self.hertz = hertz

    def values(self, unknowns):
        frequency, ratio, size = unknowns
        bare = frequency**2 - self.hertz**2 + 2j * ratio * frequency * self.hertz
        found = size * frequency**2 / bare
        return np.concatenate([found.real, found.imag])

    def jacobian(self, unknowns, *, rough=False):
        return central_differences(self.values, unknowns, 1e-6 * np.abs(unknowns))

    def hold(self, unknowns):
        """Nothing is chosen."""


@pytest.mark.parametrize(("constant", "part"), [(0.01, 0.0), (0.0, 0.03), (0.002, 0.02)])
def test_intervals_hold_though_noise_is_in_proportion_to_a_response(constant, part):
    """Constant noise alone gave 30 and 36 % of the truths in intervals of 95 %, from standard errors of a fifth."""
    true = np.array([20.0, 0.02, 1.0])
    starts = zip(("f", "ratio", "size"), (20.3, 0.03, 0.9), strict=True)
    sought = Unknowns([Unknown(name, start, logarithmic=True) for name, start in starts])
    model, rng, sets = Peak(np.arange(5.0, 60.0, 0.5)), np.random.default_rng(2), 40
    clean, count = model.values(true), len(model.hertz)
    size = np.tile(np.hypot(clean[:count], clean[count:]), 2)
    deviation = np.hypot(constant * size.max(), part * size)
    slopes = model.jacobian(true) * true / deviation[:, None]
    bound = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))  # Cramer and Rao
    inside, widths = 0, []
    for _ in range(sets):
        measured = clean + deviation * rng.normal(size=2 * count)
        whole = slice(0, 2 * count)
        series = [Series("r", whole, False, np.full(2 * count, measured.std()), curves=2, halves=True)]
        found = estimate(model, measured, series, sought)
        known = covariance(found)
        limits = intervals(found, known, 0.95)
        inside += sum(one.low <= value <= one.high for one, value in zip(limits, true, strict=True))
        widths.append(known.deviations / bound)
    assert inside >= stats.binom.ppf(5e-4, 3 * sets, 0.95)
    np.testing.assert_allclose(np.mean(widths, axis=0), 1.0, atol=0.06)
