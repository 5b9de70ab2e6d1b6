"""Draws from posteriors in closed form: a straight line with noise of unknown size, and a skewed number."""

import numpy as np
import pytest
from scipy import stats

from viscorod.errors import InputError
from viscorod.solve.estimation.intervals import covariance
from viscorod.solve.estimation.least_squares import Scaled, estimate
from viscorod.solve.estimation.noise import Series
from viscorod.solve.estimation.posterior import drawn
from viscorod.solve.estimation.predictions import central_differences
from viscorod.solve.estimation.unknowns import Unknown, Unknowns


class Predicted:
    """Values by a function, differentiated centrally."""

    accuracy = 1e-8

    def __init__(self, values):
        self.values = values

    def jacobian(self, unknowns, *, rough=False):
        return central_differences(self.values, unknowns, 1e-5 * np.maximum(np.abs(unknowns), 1e-3))

    def hold(self, unknowns):
        """Nothing is chosen."""


def posterior(values, measured, unknowns, noise, told, count):
    predictions = Predicted(values)
    series = [Series("line", slice(0, len(measured)), False, np.full(len(measured), noise), told)]
    found = estimate(predictions, measured, series, unknowns, coloured=False)
    scaled = Scaled(predictions, unknowns)

    def square(z):
        white = found.noise.whitened(measured - scaled.values(z))
        return float(white @ white)

    return found, drawn(found, covariance(found), square, count, seed=3)


def test_a_line_with_noise_of_unknown_size_has_students_posterior():
    """Slope and offset follow Student's distribution about the estimate with n - 2 degrees of freedom."""
    x = np.linspace(0.0, 1.0, 12)
    measured = 1.0 + 2.0 * x + 0.3 * np.random.default_rng(1).normal(size=12)
    unknowns = Unknowns([Unknown("offset", 0.5), Unknown("slope", 1.0)])
    pytest.importorskip("emcee")
    found, draws = posterior(lambda p: p[0] + p[1] * x, measured, unknowns, 0.3, False, 8000)
    values = draws.z.reshape(-1, 2) * [0.5, 1.0]
    design = np.column_stack([np.ones(12), x])
    centre, square, *_ = np.linalg.lstsq(design, measured, rcond=None)
    spread = np.linalg.inv(design.T @ design) * square / 10.0
    assert np.abs(found.values - centre).max() < 0.05 * np.sqrt(np.diag(spread)).min()
    for k in (0, 1):
        exact = stats.t(10, centre[k], np.sqrt(spread[k, k]))
        parts = exact.cdf(values[:, k])  # uniform from 0 to 1 if the draws are right
        quantiles = np.quantile(parts, [0.025, 0.25, 0.5, 0.75, 0.975])
        np.testing.assert_allclose(quantiles, [0.025, 0.25, 0.5, 0.75, 0.975], atol=0.03)
    assert np.corrcoef(values.T)[0, 1] == pytest.approx(
        spread[0, 1] / np.sqrt(spread[0, 0] * spread[1, 1]), abs=0.04
    )
    assert draws.accepted > 0.5


def test_a_skewed_posterior_is_that_of_its_integral():
    """exp(-z) seen once with 50 % noise that was told: the density over z is known, and far from normal."""
    pytest.importorskip("emcee")
    unknowns = Unknowns([Unknown("decay", 1.0, low=1e-3, high=20.0, logarithmic=True)])
    measured = np.array([0.5, 0.4])
    _, draws = posterior(lambda p: np.exp(-p[0]) * np.ones(2), measured, unknowns, 0.2, True, 5000)
    z = np.linspace(np.log(1e-3), np.log(20.0), 4001)
    density = np.exp(-0.5 * np.sum((measured[:, None] - np.exp(-np.exp(z))) ** 2, axis=0) / 0.04)
    whole = np.cumsum(density) / density.sum()
    for part in (0.1, 0.5, 0.9):
        exact = float(np.interp(part, whole, z))
        inside = float(np.mean(draws.z < exact))
        assert inside == pytest.approx(part, abs=0.04)


def test_what_the_data_do_not_tell_has_no_posterior():
    unknowns = Unknowns([Unknown("a", 1.0), Unknown("b", 1.0)])
    with pytest.raises(InputError, match="posterior has no end"):
        posterior(
            lambda p: (p[0] + p[1]) * np.ones(4), np.array([1.9, 2.1, 2.0, 2.0]), unknowns, 0.1, True, 100
        )
