"""How far the numbers of a least-squares fit may be off, from the noise that it leaves, which may be coloured.

Least squares of sines is hardly worse than the best estimate under coloured noise (U. Grenander and M. Rosenblatt,
Statistical Analysis of Stationary Time Series, 1957, chapter 7), and loses no mode to a description of the noise. Its
covariance is B' R B with the covariance R of the noise, an autoregression by the restricted likelihood
(`viscorod.solve.estimation`), and B from values to numbers. Degrees of freedom are Satterthwaite's (1946), by the
doubts of the level of the noise and of its autocorrelations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import matmul_toeplitz
from scipy.stats import t as student

from viscorod.solve.estimation.autoregression import autocorrelation_of, chosen_partials, terms_of
from viscorod.solve.estimation.noise import LEAST_OWN, Series, SeriesNoise, noise_of
from viscorod.typing import Floats

__all__ = ["FitNoise", "colour_gain"]

STEP = 1e-3
"""Change of coordinates of autocorrelations by which differences are taken."""
LEAST_FREEDOM = 2.0
"""Degrees of freedom below which derivatives of a standard error say nothing of it."""
MOST_FORETOLD = 0.05
"""Part of the variance of a residual that its autoregression leaves at least, when fits are compared: what can be
foretold better is a motion that the fit has not, and no noise."""


@dataclass(frozen=True, eq=False)
class FitNoise:
    """The noise of a fit, and what it does to the fitted numbers.

    Attributes:
        mixing: change of the numbers over that of the values, B (n, p).
        noise: of the values.
        freedom: samples less fitted numbers.
    """

    mixing: Floats
    noise: SeriesNoise
    freedom: int

    @classmethod
    def of(
        cls, residual: Floats, slopes: Floats, mixing: Floats, alike: SeriesNoise | None = None
    ) -> FitNoise:
        """Return the noise that a residual shows.

        Args:
            residual: samples less model (n,); slopes: derivatives of the model by all numbers (n, m).
            mixing: change of the numbers in question over that of the values (n, p).
            alike: noise whose colour is taken where there are too few samples for an own one.
        """
        count, freedom = slopes.shape[0], slopes.shape[0] - slopes.shape[1]
        level = float(np.sqrt(residual @ residual / freedom)) or 1e-300
        if count < LEAST_OWN:
            noise = SeriesNoise(level)
            if alike is not None:
                noise = SeriesNoise(level, alike.partials, alike.doubt)
            return cls(mixing, noise, freedom)
        series = Series("", slice(0, count), regular=True, noise=np.full(count, level))
        (found,) = noise_of([series], residual, slopes).found
        order = _stable_order(found.partials, count)
        while True:
            noise = SeriesNoise(level * found.factor, found.partials[:order], found.doubt[:order, :order])
            told = cls(mixing, noise, freedom)
            if not order or (np.diag(told.covariance) > 0.0).all():
                return told
            order -= 1  # rounding of what is nearly one leaves no variance

    @property
    def covariance(self) -> Floats:
        """Covariance of the numbers (p, p)."""
        return self._covariance(self.noise)

    def _covariance(self, noise: SeriesNoise) -> Floats:
        if not len(noise.partials):
            return np.asarray(noise.factor**2 * self.mixing.T @ self.mixing)
        rho = autocorrelation_of(noise.terms, len(self.mixing) - 1)
        return np.asarray(noise.factor**2 * self.mixing.T @ matmul_toeplitz(rho, self.mixing))

    def half_widths(self, gradients: Floats, level: float) -> Floats:
        """Return half the widths of intervals of combinations of the numbers.

        Args:
            gradients: of the combinations (k, p); level: probability of an interval.
        """
        square = np.einsum("ki,ij,kj->k", gradients, self.covariance, gradients)
        doubt = np.full(len(square), 1.0 / self.freedom)
        changes = []
        for k in range(len(self.noise.partials)):
            above, below = (self._covariance(self.noise.moved(k, sign * STEP)) for sign in (1.0, -1.0))
            change = np.einsum("ki,ij,kj->k", gradients, above - below, gradients) / (2.0 * STEP)
            changes.append(change / np.maximum(square, 1e-300))
        if changes:
            doubt = doubt + 0.5 * np.einsum("ik,ij,jk->k", changes, self.noise.doubt, changes)
        quantile = student.ppf(0.5 + 0.5 * level, np.maximum(1.0 / doubt, LEAST_FREEDOM))
        return np.asarray(quantile * np.sqrt(np.maximum(square, 0.0)))


def _stable_order(partials: Floats, count: int) -> int:
    """Return how many partial autocorrelations have an autocorrelation that rounding leaves below one.

    What a fit leaves of a computed motion is smooth, and several of them are nearly one: their poles lie together.
    """
    for order in range(len(partials), 1, -1):
        kept = np.tanh(np.arctanh(partials[:order]) + 2.0 * STEP * np.sign(partials[:order]))
        with np.errstate(all="ignore"):
            rho = autocorrelation_of(terms_of(kept)[0], count - 1)
        if np.isfinite(rho).all() and np.abs(rho).max() <= 1.0 + 1e-9:
            return order
    return min(len(partials), 1)


def colour_gain(residual: Floats) -> tuple[float, int]:
    """Return the logarithm of the part of a residual that its past does not foretell, and how many numbers it takes."""
    partials = chosen_partials(residual)
    left = float(np.sum(np.log1p(-(partials**2))))
    return max(left, float(np.log(MOST_FORETOLD))), len(partials)
