"""The noise of measured values, from what a fit leaves: its size in every series, and how it goes with itself in time.

A series is what one channel of one record gave. Regular histories may have coloured noise: residuals are described
by an autoregression, r_t = sum a_i r_(t-i) + e_t, whose order the Bayesian information criterion chooses (Burg's
method; P. J.
Brockwell and R. A. Davis, Time Series: Theory and Methods, 1991, sections 8.2 and 9.3). Values are then whitened by it,
and all that follows (estimates, covariances, intervals) is generalised least squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy import linalg, stats

from viscorod.typing import Floats

__all__ = ["Noise", "Series", "SeriesNoise", "autocorrelation", "ljung_box", "noise_of"]

LEAST_OWN = 30
"""Values that a series must have for a noise level of its own; smaller ones share one."""
MOST_ORDER = 12
"""Terms of an autoregression at most."""
LARGER = 0.01
"""Probability of such residuals below which noise that was told counts as larger."""
HUBER = 1.345
"""Residuals beyond so many standard deviations count less in a robust fit (95 % efficient for normal noise)."""
MEDIAN_TO_DEVIATION = 1.4826
"""Median of the sizes of normal noise times this is its standard deviation."""


@dataclass(frozen=True)
class Series:
    """Rows of the values that one channel of one record gave.

    Attributes:
        label: of the series; rows: where its values stand.
        regular: whether they follow each other at equal times.
        noise: its standard deviation as it was told, one per row; or, if ``told`` is false, what the noise is taken to
            be in proportion to.
        told: whether the noise was told.
        certain: whether that is beyond doubt, as what was believed beforehand is.
        group: short series of one group share their noise level.
    """

    label: str
    rows: slice
    regular: bool
    noise: Floats
    told: bool = False
    certain: bool = False
    group: str = ""

    @property
    def count(self) -> int:
        """Number of values."""
        return int(self.rows.stop - self.rows.start)


@dataclass(frozen=True)
class SeriesNoise:
    """The noise of one series.

    Attributes:
        factor: its standard deviation over ``Series.noise``.
        terms: of the autoregression of the residuals, none where they are white.
        innovation: standard deviation of what the autoregression leaves, over that of the residuals.
        weights: of the rows in a robust fit; 1 of others.
        used: numbers that were fitted to the series.
    """

    factor: float
    terms: Floats = field(default_factory=lambda: np.zeros(0))
    innovation: float = 1.0
    weights: Floats | None = None
    used: float = 0.0

    @property
    def effective_part(self) -> float:
        """Effective over actual number of values, for the variance of their mean square: 1/sum rho_k^2."""
        if not len(self.terms):
            return 1.0
        rho = autocorrelation_of(self.terms, 400)
        return float(1.0 / (1.0 + 2.0 * np.sum(rho[1:] ** 2)))


@dataclass(frozen=True)
class Noise:
    """The noise of all series, by which values are whitened."""

    series: Sequence[Series]
    found: Sequence[SeriesNoise]

    def whitened(self, values: Floats) -> Floats:
        """Return residuals ``(n,)`` or derivatives ``(n, p)`` in units of independent noise of size one."""
        out = np.array(values, dtype=float)
        for series, noise in zip(self.series, self.found, strict=True):
            scale = noise.factor * series.noise
            part = (out[series.rows].T / scale).T
            if noise.weights is not None:
                part = (part.T * np.sqrt(noise.weights)).T
            out[series.rows] = _prewhitened(part, noise) if len(noise.terms) else part
        return out

    @property
    def effective_count(self) -> float:
        """Effective number of values of all series."""
        return sum(
            noise.effective_part * series.count for series, noise in zip(self.series, self.found, strict=True)
        )


def _prewhitened(part: Floats, noise: SeriesNoise) -> Floats:
    """Return residuals of an autoregression over their size; the first ones by the covariance of their start."""
    order = len(noise.terms)
    out = part.copy()
    for lag, term in enumerate(noise.terms, start=1):
        out[lag:] -= term * part[:-lag]
    out /= noise.innovation
    start = linalg.cholesky(linalg.toeplitz(autocorrelation_of(noise.terms, order)[:order]), lower=True)
    out[:order] = linalg.solve_triangular(start, part[:order], lower=True)
    return out


def autocorrelation_of(terms: Floats, count: int) -> Floats:
    """Return the autocorrelation of an autoregression at the lags 0 to ``count`` (Yule-Walker equations)."""
    order = len(terms)
    matrix, right = np.eye(order), np.array(terms, dtype=float)
    for k in range(order):  # rho_(k+1) = sum_i a_i rho_|k+1-i|
        for i, term in enumerate(terms):
            lag = abs(k - i)
            if lag:
                matrix[k, lag - 1] -= term
    right = np.array([terms[k] for k in range(order)])
    rho = np.ones(max(count, order) + 1)
    rho[1 : order + 1] = np.linalg.solve(matrix, right)
    for lag in range(order + 1, len(rho)):
        rho[lag] = terms @ rho[lag - order : lag][::-1]
    return rho[: count + 1]


def _autoregression(residuals: Floats) -> tuple[Floats, float]:
    """Return the terms that the Bayesian information criterion chooses, and the size of what they leave."""
    n = len(residuals)
    size = float(np.mean(residuals**2))
    if size == 0.0:
        return np.zeros(0), 1.0
    forward, backward = residuals.copy(), residuals.copy()
    terms, variance = np.zeros(0), size
    best = (n * np.log(size), terms, variance)
    for order in range(1, min(MOST_ORDER, n // 10) + 1):
        ahead, behind = forward[1:], backward[:-1]
        below = float(ahead @ ahead + behind @ behind)
        if below <= 1e-20 * n * size:
            break
        reflection = 2.0 * float(ahead @ behind) / below
        terms = np.append(terms - reflection * terms[::-1], reflection)
        variance *= 1.0 - reflection**2
        forward, backward = ahead - reflection * behind, behind - reflection * ahead
        if variance <= 1e-12 * size:
            break
        merit = n * np.log(variance) + order * np.log(n)
        if merit < best[0]:
            best = (merit, terms, variance)
    _, terms, variance = best
    # the size of noise with these terms, of which the residuals are one sample
    power = 1.0 / (1.0 - terms @ autocorrelation_of(terms, len(terms))[1:]) if len(terms) else 1.0
    return terms, float(np.sqrt(1.0 / power)) if len(terms) else 1.0


def noise_of(
    series: Sequence[Series], residuals: Floats, used: Floats, *, coloured: bool = True, robust: bool = False
) -> Noise:
    """Return the noise that residuals show.

    A level that was told is kept in series that are too short for their own, unless the residuals are
    significantly larger.

    Args:
        series: the series of the residuals.
        residuals: ``(n,)``.
        used: of every value, how much of it the fit has taken up (diagonal of the hat matrix, ``(n,)``).
        coloured: whether regular series may have an autocorrelation.
        robust: whether large residuals count less.
    """
    found = []
    for one in series:
        part = residuals[one.rows] / one.noise
        taken = float(used[one.rows].sum())
        if one.certain:
            found.append(SeriesNoise(1.0, used=taken))
            continue
        if one.count < LEAST_OWN:
            alike = [o for o in series if o.count < LEAST_OWN and (o.group, o.told) == (one.group, one.told)]
            found.append(SeriesNoise(_shared(alike, residuals, used, told=one.told), used=taken))
            continue
        weights = None
        free = max(one.count - taken, 1.0)
        if robust:
            size = MEDIAN_TO_DEVIATION * float(np.median(np.abs(part))) * np.sqrt(one.count / free)
            weights = np.minimum(1.0, HUBER * size / np.maximum(np.abs(part), 1e-300))
            factor = size
        else:
            factor = float(np.sqrt(part @ part / free))
        terms, innovation = np.zeros(0), 1.0
        if coloured and one.regular:
            terms, innovation = _autoregression(part if weights is None else part * weights)
        if len(terms):
            whole = SeriesNoise(1.0, terms, innovation, weights)
            white = Noise([one], [whole]).whitened(residuals)[one.rows]
            factor = float(np.sqrt(white @ white / free))
        found.append(SeriesNoise(factor or 1e-300, terms, innovation, weights, taken))
    return Noise(tuple(series), tuple(found))


def _shared(series: Sequence[Series], residuals: Floats, used: Floats, *, told: bool) -> float:
    """Return the common level of short series, over their noise; 1 of noise that was told, unless it is larger."""
    square = sum(float(np.sum((residuals[one.rows] / one.noise) ** 2)) for one in series)
    free = sum(one.count - float(used[one.rows].sum()) for one in series)
    if free <= 0.5 or square <= 0.0 or (told and float(stats.chi2.sf(square, free)) > LARGER):
        return 1.0
    return float(np.sqrt(square / free))


def autocorrelation(residuals: Floats, count: int) -> Floats:
    """Return the autocorrelation of residuals at the lags 0 to ``count``."""
    n, size = len(residuals), float(residuals @ residuals)
    if size == 0.0:
        return np.append(1.0, np.zeros(count))
    return np.array([float(residuals[: n - k] @ residuals[k:]) / size for k in range(count + 1)])


def ljung_box(residuals: Floats, fitted: int = 0) -> tuple[float, float]:
    """Return Ljung and Box's statistic of residuals and the probability of one as large if they were white.

    Args:
        residuals: of a regular series.
        fitted: numbers of an autoregression that was taken out.
    """
    n = len(residuals)
    lags = max(min(20, n // 5), fitted + 1)
    rho = autocorrelation(residuals, lags)[1:]
    statistic = n * (n + 2.0) * float(np.sum(rho**2 / (n - np.arange(1, lags + 1))))
    return statistic, float(stats.chi2.sf(statistic, lags - fitted))
