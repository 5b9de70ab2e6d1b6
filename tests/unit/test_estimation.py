"""Least squares with estimated noise: coverage, Cramer and Rao's bound, what the data cannot tell, wrong models.

The models here are functions of time, no rods: what is tested are the statistics.
"""

import numpy as np
import pytest
from scipy import stats

from viscorod.solve.estimation.information import criteria
from viscorod.solve.estimation.intervals import covariance, intervals
from viscorod.solve.estimation.least_squares import Scaled, estimate, searched
from viscorod.solve.estimation.noise import Series, autocorrelation_of, ljung_box, noise_of
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


@pytest.mark.parametrize(("phi", "sets"), [(0.0, 80), (0.6, 80)])
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
    noise = noise_of(series, coloured(rng, 0.8, 2000), np.zeros(2000))
    assert noise.found[0].terms[0] == pytest.approx(0.8, abs=0.05)
    assert noise.effective_count == pytest.approx(2000 * (1.0 - 0.8**2) / (1.0 + 0.8**2), rel=0.25)


def test_starts_find_the_lower_of_two_minima():
    """A frequency far off locks into a neighbouring period; of many starts the right one wins."""
    sought = Unknowns([Unknown("E", 3.0, 0.3, 6.0, logarithmic=True), Unknown("tau", 0.01, logarithmic=True)])
    measured = Swing().values(TRUTH) + SIZE * np.random.default_rng(8).normal(size=len(TIMES))
    one = estimate(Swing(), measured, histories(), sought)
    many = estimate(Swing(), measured, histories(), sought, starts=12, seed=1)
    np.testing.assert_allclose(many.values, TRUTH, rtol=0.1)
    assert many.agreeing >= 2
    assert many.square <= one.square * 1.001


def test_criteria_prefer_fewer_unknowns_where_squares_are_alike():
    """For large counts the corrected criterion is Akaike's: 2 per unknown; the Bayesian one has log n per unknown."""
    few, many = criteria(1000.0, 1000.0, 2), criteria(1000.0, 1000.0, 3)
    assert many[0] - few[0] == pytest.approx(2.0, abs=0.02)
    assert many[1] - few[1] == pytest.approx(np.log(1000.0))


def test_a_search_stays_within_its_bounds():
    sought = Unknowns([Unknown("E", 1.2, 1.1, 2.0, logarithmic=True), Unknown("tau", 0.02, logarithmic=True)])
    measured = Swing().values(TRUTH)
    found = estimate(Swing(), measured, histories(), sought)
    assert found.values[0] == pytest.approx(1.1, rel=1e-3)
    held = searched(Scaled(Swing(), sought), measured, found.noise, sought.bounds, sought.start, sought.start)
    assert np.exp(held[0]) >= 1.1 * (1.0 - 1e-9)
