"""The noise of measured values, from what a fit leaves: its size in every series, and how it goes with itself in time.

A series is what one channel of one record gave. Regular histories may have coloured noise: residuals are described
by an autoregression, whose order the Bayesian information criterion chooses (P. J. Brockwell and R. A. Davis, Time
Series: Theory and Methods, 1991, sections 8.2 and 9.3) and whose terms the restricted likelihood gives. Values are then
whitened by it, and all that follows (estimates, covariances, intervals) is generalised least squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import stats

from viscorod.solve.estimation.autoregression import (
    autocorrelation_of,
    chosen_partials,
    restricted_partials,
    terms_of,
    whitened_by,
)
from viscorod.solve.estimation.proportional_noise import proportional_shape
from viscorod.typing import Floats

__all__ = [
    "MEDIAN_TO_DEVIATION",
    "Noise",
    "Series",
    "SeriesNoise",
    "autocorrelation",
    "leverage",
    "ljung_box",
    "neighbours_alike",
    "noise_of",
]

LEAST_OWN = 30
"""Values that a series must have for a noise level of its own; smaller ones share one."""
PASSES = 3
"""Times that the noise of several coloured series is estimated beside each other's."""
LARGER = 0.01
"""Probability of such residuals below which noise that was told counts as larger."""
HUBER = 1.345
"""Residuals beyond so many standard deviations count less in a robust fit (95 % efficient for normal noise)."""
LAGS = 4000
"""Of autocorrelations that count, at most."""
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
        curves: of values that are not regular in time: of how many curves of equal length they are the points one after
            another, over frequency or load; 0 where neighbours have nothing to do with each other.
        halves: whether they are the two parts of complex numbers, one after another, to whose size noise that was not
            told may be in proportion.
        times: of histories that are not regular, s; None of all others.
    """

    label: str
    rows: slice
    regular: bool
    noise: Floats
    told: bool = False
    certain: bool = False
    group: str = ""
    curves: int = 0
    halves: bool = False
    times: Floats | None = None

    @property
    def count(self) -> int:
        """Number of values."""
        return int(self.rows.stop - self.rows.start)


@dataclass(frozen=True)
class SeriesNoise:
    """The noise of one series.

    Attributes:
        factor: its standard deviation over ``Series.noise``, the median if it is not the same for all rows.
        partials: partial autocorrelations of the residuals, none where they are white.
        doubt: covariance of their areas tangens.
        weights: of the rows in a robust fit; 1 of others.
        used: numbers that were fitted to the series.
        shape: standard deviations of the rows over their median, where a part is in proportion to the values.
    """

    factor: float
    partials: Floats = field(default_factory=lambda: np.zeros(0))
    doubt: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    weights: Floats | None = None
    used: float = 0.0
    shape: Floats | None = None

    def deviations(self, series: Series) -> Floats:
        """Return the standard deviations of the rows of the series ``(n,)``."""
        found = self.factor * series.noise
        return found if self.shape is None else found * self.shape

    @property
    def terms(self) -> Floats:
        """Terms of the autoregression of the residuals."""
        return terms_of(self.partials)[0]

    @property
    def innovation(self) -> float:
        """Standard deviation of what the autoregression leaves, over that of the residuals."""
        return terms_of(self.partials)[1]

    def moved(self, k: int, step: float) -> SeriesNoise:
        """Return the noise with another partial autocorrelation, its area tangens moved by a step.

        What the autoregression leaves keeps its size: that is known by itself.
        """
        partials = self.partials.copy()
        partials[k] = np.tanh(np.arctanh(partials[k]) + step)
        return replace(self, partials=partials, factor=self.factor * self.innovation / terms_of(partials)[1])

    def effective_part(self, count: int) -> float:
        """Return the effective over the actual number of values, for the variance of their mean square.

        That is ``1/sum (1 - k/n) rho_k^2`` of n values: those of a lasting vibration are two.
        """
        if not len(self.partials):
            return 1.0
        lags = min(count - 1, LAGS)
        rho = autocorrelation_of(self.terms, lags)[1 : lags + 1]
        return float(1.0 / (1.0 + 2.0 * np.sum((1.0 - np.arange(1, lags + 1) / count) * rho**2)))


@dataclass(frozen=True)
class Noise:
    """The noise of all series, by which values are whitened."""

    series: Sequence[Series]
    found: Sequence[SeriesNoise]

    def whitened(self, values: Floats) -> Floats:
        """Return residuals ``(n,)`` or derivatives ``(n, p)`` in units of independent noise of size one."""
        out = np.array(values, dtype=float)
        for series, noise in zip(self.series, self.found, strict=True):
            scale = noise.deviations(series)
            part = (out[series.rows].T / scale).T
            if noise.weights is not None:
                part = (part.T * np.sqrt(noise.weights)).T
            out[series.rows] = whitened_by(part, noise.partials) if len(noise.partials) else part
        return out

    @property
    def count(self) -> int:
        """Number of values of all series."""
        return sum(series.count for series in self.series)

    @property
    def effective_count(self) -> float:
        """Effective number of values of all series."""
        return sum(
            noise.effective_part(series.count) * series.count
            for series, noise in zip(self.series, self.found, strict=True)
        )


def leverage(white: Floats) -> Floats:
    """Return how much of every value a fit takes up: the diagonal of its hat matrix ``(n,)``."""
    return np.asarray(np.sum((white @ _mixing(white)) ** 2, axis=1))


def noise_of(
    series: Sequence[Series],
    residuals: Floats,
    slopes: Floats,
    before: Noise | None = None,
    *,
    predicted: Floats | None = None,
    coloured: bool = True,
    robust: bool = False,
) -> Noise:
    """Return the noise that residuals show.

    A level that was told is kept in series that are too short for their own, unless the residuals are
    significantly larger.

    Args:
        series: the series of the residuals.
        residuals: ``(n,)``; slopes: derivatives of the predictions by the unknowns ``(n, p)``.
        before: noise by which the values were weighted; as it was told, if not given.
        predicted: values ``(n,)``, to which noise may be in proportion; constant, if not given.
        coloured: whether regular series may have an autocorrelation.
        robust: whether large residuals count less.
    """
    now = before or Noise(tuple(series), tuple(SeriesNoise(1.0) for _ in series))
    for _ in range(PASSES):
        found = _once(series, residuals, slopes, now, predicted, coloured=coloured, robust=robust)
        now = Noise(tuple(series), found)
        if sum(len(one.partials) > 0 for one in found) == 0 or len(series) == 1:
            break
    return now


def _once(
    series: Sequence[Series],
    residuals: Floats,
    slopes: Floats,
    before: Noise,
    predicted: Floats | None,
    *,
    coloured: bool,
    robust: bool,
) -> tuple[SeriesNoise, ...]:
    """Return the noise of every series, weighted beside the others as before."""
    white = before.whitened(slopes)
    used = leverage(white)
    shapes = [_shape(one, residuals, predicted, slopes) for one in series]
    levels = [
        one.noise if shape is None else one.noise * shape for one, shape in zip(series, shapes, strict=True)
    ]
    found = []
    for number, one in enumerate(series):
        part = residuals[one.rows] / levels[number]
        taken = float(used[one.rows].sum())
        if one.certain:
            found.append(SeriesNoise(1.0, used=taken))
            continue
        if one.count < LEAST_OWN:
            alike = [
                (o, level)
                for o, level in zip(series, levels, strict=True)
                if o.count < LEAST_OWN and (o.group, o.told) == (one.group, one.told)
            ]
            factor = _shared(alike, residuals, used, told=one.told)
            found.append(SeriesNoise(factor, used=taken, shape=shapes[number]))
            continue
        weights = None
        free = max(one.count - taken, 1.0)
        if robust:
            size = MEDIAN_TO_DEVIATION * float(np.median(np.abs(part))) * np.sqrt(one.count / free)
            weights = np.minimum(1.0, HUBER * size / np.maximum(np.abs(part), 1e-300))
            factor = size
        else:
            factor = float(np.sqrt(part @ part / free))
        noise = SeriesNoise(factor or 1e-300, weights=weights, used=taken, shape=shapes[number])
        if coloured and one.regular:
            noise = _coloured(one, noise, part, slopes, white, before.found[number].factor, free)
        found.append(noise)
    return tuple(found)


def _shape(series: Series, residuals: Floats, predicted: Floats | None, slopes: Floats) -> Floats | None:
    """Return the deviations of a series' noise over their median, where a part of it is in proportion to the values."""
    if predicted is None or series.told or not series.halves:
        return None
    size = np.tile(np.hypot(*predicted[series.rows].reshape(2, -1)), 2)
    own = slopes[series.rows]
    return proportional_shape(residuals[series.rows], size, own @ _mixing(own))


def _coloured(
    series: Series,
    noise: SeriesNoise,
    part: Floats,
    slopes: Floats,
    white: Floats,
    factor: float,
    free: float,
) -> SeriesNoise:
    """Return the noise of a series with its autocorrelation, if it has one.

    Args:
        series: whose noise; noise: without it; part: residuals over the noise that was told ``(n,)``.
        slopes: derivatives of all values; white: the same, whitened as before; factor: of the noise then.
        free: values less the numbers that were fitted to them.
    """
    partials = chosen_partials(part if noise.weights is None else part * noise.weights)
    if not len(partials):
        return noise
    # combinations of the unknowns that all series together tell to the same degree
    mixed = _mixing(white)
    own = white[series.rows] @ mixed
    raw = (slopes[series.rows].T / (factor * series.noise)).T @ mixed
    seen = part
    if noise.weights is not None:
        seen, raw = part * np.sqrt(noise.weights), (raw.T * np.sqrt(noise.weights)).T
    others = (
        np.eye(mixed.shape[1]) - own.T @ own if len(own) < len(white) else np.zeros((mixed.shape[1],) * 2)
    )
    partials, doubt = restricted_partials(partials, seen, raw, others)
    whole = replace(noise, factor=1.0, partials=partials, doubt=doubt)
    left = whitened_by(seen, partials)
    return replace(whole, factor=float(np.sqrt(left @ left / free)) or 1e-300)


def _mixing(white: Floats) -> Floats:
    """Return the combinations of whitened derivatives that are orthonormal ``(p, k)``."""
    size = np.linalg.norm(white, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    _, values, right = np.linalg.svd(white / size, full_matrices=False)
    kept = values > 1e-10 * values.max(initial=0.0)
    return np.asarray((right[kept] / values[kept, None]).T / size[:, None])


def _shared(series: Sequence[tuple[Series, Floats]], residuals: Floats, used: Floats, *, told: bool) -> float:
    """Return the common level of short series, over theirs; 1 of noise that was told, unless it is larger."""
    square = sum(float(np.sum((residuals[one.rows] / level) ** 2)) for one, level in series)
    free = sum(one.count - float(used[one.rows].sum()) for one, _ in series)
    if free <= 0.5 or square <= 0.0 or (told and float(stats.chi2.sf(square, free)) > LARGER):
        return 1.0
    return float(np.sqrt(square / free))


def autocorrelation(residuals: Floats, count: int) -> Floats:
    """Return the autocorrelation of residuals at the lags 0 to ``count``."""
    n, size = len(residuals), float(residuals @ residuals)
    if size == 0.0:
        return np.append(1.0, np.zeros(count))
    return np.array([float(residuals[: n - k] @ residuals[k:]) / size for k in range(count + 1)])


def neighbours_alike(residuals: Floats, curves: int) -> float:
    """Return the probability that neighbours of independent residuals go together as much, by their products.

    Sum of r_k r_(k+1) over the root of the sum of their squares (White 1980), which holds for noise of any size from
    point to point.

    Args:
        residuals: of the points of curves, one after another; curves: how many.
    """
    parts = residuals.reshape(curves, -1)
    products = parts[:, 1:] * parts[:, :-1]
    size = float(np.sqrt(np.sum(products**2)))
    return float(2.0 * stats.norm.sf(abs(float(products.sum())) / size)) if size > 0.0 else 1.0


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
