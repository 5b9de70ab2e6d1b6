"""What the fits about the peaks of responses say of their poles: likelihoods of the noise, and intervals.

The noise of a peak has a constant part a and one in proportion, b. A few lines about a narrow peak tell little of b,
by which the interval is as wide as b may be; the other peaks of the same measurement tell more. So b is taken to
scatter from peak to peak by a factor of about `ALIKE`, and what the other peaks say of it stands beside what the own
lines say (both by the restricted likelihood of D. A. Harville, J. Am. Stat. Assoc. 72, 1977). The interval is that of
the mixture of the normal distributions of the pole for all a and b.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr, stdtr

from viscorod.records.pole_about_peak import LevelFit, Peak
from viscorod.typing import Floats

__all__ = ["Pole", "poles_of"]

CONFIDENCE = 0.95
UNTOLD = 1.0
"""Part of a ratio that its standard deviation may be: beyond it the lines do not tell it."""
PARTS = 10.0 ** np.arange(-6.0, 0.51, 0.125)
"""Constant parts over the size of the peak, and parts in proportion, that are tried."""
ALIKE = 2.0
"""Factor by which the part in proportion differs from peak to peak."""
NEGLIGIBLE = 1e-6


@dataclass(frozen=True)
class Pole:
    """One pole found in one response.

    Attributes:
        frequency, ratio: natural frequency |s|/2 pi [Hz], -Re s/|s|.
        frequency_width, ratio_width: half of the 95 % interval.
        misfit: what is left over the peak, of its size.
        proportional: share of the noise's variance on the peak that is in proportion to the response.
        alike: how much alike neighbouring lines of what is left over are, in deviations of white noise.
    """

    frequency: float
    ratio: float
    frequency_width: float
    ratio_width: float
    misfit: float
    proportional: float
    alike: float


@dataclass(frozen=True)
class _Noise:
    """Logarithms of the likelihood over constant parts and parts in proportion, and which fit belongs to each pair."""

    logarithm: Floats
    fit: np.ndarray

    @property
    def of_proportion(self) -> Floats:
        """Likelihood of the part in proportion alone, the largest 1."""
        found: Floats = np.exp(self.logarithm - self.logarithm.max()).sum(axis=0)
        return np.asarray(found / found.max())


def poles_of(peaks: list[Peak]) -> list[Pole | None]:
    """Return the poles of the peaks of one measurement; None where a peak has none, or the lines do not tell it."""
    noises = [_noise(peak) for peak in peaks]
    told = [one.of_proportion for one in noises if one is not None]
    spread = np.subtract.outer(np.log(PARTS), np.log(PARTS)) / np.log(ALIKE)
    alike = np.exp(-0.5 * spread**2)
    alike /= alike.sum(axis=0)
    means = [np.log(np.maximum(alike @ one, np.finfo(float).tiny)) for one in told]
    everyone = np.sum(means, axis=0) if means else 0.0
    found: list[Pole | None] = []
    place = 0
    for peak, noise in zip(peaks, noises, strict=True):
        if noise is None:
            found.append(_pole_of_told(peak))
            continue
        others = everyone - means[place]
        place += 1
        believed = np.log(np.maximum(alike @ np.exp(others - np.max(others)), np.finfo(float).tiny))
        found.append(_pole(peak, noise, believed))
    return found


def _noise(peak: Peak) -> _Noise | None:
    """Return the likelihoods of the noise of a peak; None where the kind of the noise is known."""
    known = [level for level, _ in peak.levels if level is not None]
    if not known:
        return None
    levels = np.log(known)
    constant, proportion = np.meshgrid(PARTS, PARTS, indexing="ij")
    sought = np.log(constant / proportion)
    fit = np.abs(sought[..., None] - levels).argmin(axis=-1)
    median = np.array([np.median(np.abs(one.model)) for _, one in peak.levels])[fit]
    level = np.exp(levels)[fit]
    variance = (constant**2 + (proportion * median) ** 2) / (level**2 + median**2)
    squares = np.array([one.squares for _, one in peak.levels])[fit]
    own = np.array([one.likelihood for _, one in peak.levels])[fit]
    return _Noise(own - 0.5 * peak.freedom * np.log(variance) - 0.5 * squares / variance, fit)


def _pole(peak: Peak, noise: _Noise, believed: Floats) -> Pole | None:
    """Return the pole, with what is believed of the part in proportion: logarithms."""
    likely = noise.logarithm + believed
    likely = np.exp(likely - likely.max())
    likely /= likely.sum()
    constant, proportion = np.nonzero(likely > NEGLIGIBLE)
    fit, weight = noise.fit[constant, proportion], likely[constant, proportion]
    fits = [one for _, one in peak.levels]
    median = np.array([np.median(np.abs(one.model)) for one in fits])[fit]
    level = np.array([one or 0.0 for one, _ in peak.levels])[fit]
    variance = (PARTS[constant] ** 2 + (PARTS[proportion] * median) ** 2) / (level**2 + median**2)
    weight = weight / weight.sum()
    thetas = np.array([one.theta for one in fits])[fit]
    sizes = np.sqrt(np.array([np.diag(one.covariance) for one in fits])[fit] * variance[:, None])
    mean = weight @ thetas
    half = [_half_width(weight, thetas[:, j] - mean[j], sizes[:, j], None) for j in (0, 1)]
    deviation = float(np.sqrt(weight @ (sizes[:, 0] ** 2 + (thetas[:, 0] - mean[0]) ** 2)))
    share = float(weight @ (PARTS[proportion] ** 2 / (PARTS[constant] ** 2 + PARTS[proportion] ** 2)))
    return _described(peak, mean, half, deviation, int(fit[weight.argmax()]), share)


def _pole_of_told(peak: Peak) -> Pole | None:
    """Return the pole where the noise is known but for its size."""
    fit = peak.levels[0][1]
    sizes = np.sqrt(np.diag(fit.covariance) * fit.squares / peak.freedom)
    half = [_half_width(np.ones(1), np.zeros(1), sizes[j : j + 1], peak.freedom) for j in (0, 1)]
    return _described(peak, fit.theta, half, float(sizes[0]), 0, 0.0)


def _described(
    peak: Peak, theta: Floats, half: list[float], deviation: float, fit: int, share: float
) -> Pole | None:
    if deviation > UNTOLD:
        return None
    decay, centre = float(np.exp(theta[0])) * peak.step, peak.place + float(theta[1]) * peak.step
    frequency = float(np.hypot(centre, decay))
    ratio = decay / frequency
    misfit = float(np.sqrt(2.0 * np.sum(np.abs(peak.levels[fit][1].left) ** 2) / peak.freedom))
    return Pole(
        frequency, ratio, half[1] * peak.step, ratio * half[0], misfit, share, _alike(peak.levels[fit][1])
    )


def _alike(fit: LevelFit) -> float:
    """Return how much alike neighbouring lines of what is left are, in deviations of white noise."""
    off = fit.white
    products = float(np.sum((off[1:] * off[:-1].conj()).real))
    return (
        products / max(float(np.sum(np.abs(off) ** 2)), np.finfo(float).tiny) * float(np.sqrt(2 * len(off)))
    )


def _half_width(weight: Floats, means: Floats, sizes: Floats, freedom: int | None) -> float:
    """Return half the interval about zero that holds `CONFIDENCE` of a mixture of normal or Student's distributions."""
    sizes = np.maximum(sizes, np.finfo(float).tiny)

    def of(x: Floats) -> Floats:
        found: Floats = ndtr(x) if freedom is None else stdtr(freedom, x)
        return found

    def missing(half: float) -> float:
        inside = of((half - means) / sizes) - of((-half - means) / sizes)
        return float(weight @ inside) - CONFIDENCE

    high = float(np.max(np.abs(means) + 13.0 * sizes))
    return float(brentq(missing, 0.0, high, rtol=1e-10)) if missing(high) > 0.0 else high
