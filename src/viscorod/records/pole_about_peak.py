"""Fits of a frequency response about a peak, by weights for noise whose kind is not known.

The noise of an average of responses is constant where the instrument makes it, and in proportion to the response where
the structure, the hammer's place or the transfer itself scatters (J. S. Bendat and A. G. Piersol, Random Data, 2010,
section 9.2.4). Its variance is a^2 + b^2 |H|^2, with H of the fit and not of the data, whose own noise would weigh
down what is too large. There is a fit for every a/b, from almost constant to almost in proportion; `peak_noise` tells
how likely each of them is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.optimize import least_squares

from viscorod.records.line_shapes import LineShape
from viscorod.typing import Floats

__all__ = ["LEAST", "LEVELS", "LevelFit", "Peak", "peak_fits", "rough_misfit", "rough_pole", "spacing"]

LEAST = 4
"""Lines on each side that take part at least."""
DEGREE = 2
"""Of the polynomial for all other modes."""
OFF = 1.5
"""Lines by which a pole may be off its peak, beside half of its half-power width."""
NEAR = 6.0
"""Reaches from the peak within which another mode has its own pole in the fit; beyond it the polynomial is as good."""
LEVELS = 10.0 ** np.arange(1.0, -2.1, -0.25)
"""a/b over the median size of the response; the first is as good as constant, the last as good as in proportion."""
PASSES, LARGEST = 12, 0.5
"""Steps, each by the weights of the fit before, at most; and how far one of them goes."""
SETTLED = 0.01
"""Part of its standard deviation by which a pole may still move."""


@dataclass(frozen=True)
class LevelFit:
    """A fit by weights.

    Attributes:
        theta: logarithm of the decay rate in lines, and the place of the pole in lines from the peak.
        covariance: of these, for a noise that is one of the weights (2, 2).
        step: of Gauss and Newton from there on.
        squares: of what is left, weighted, and likelihood: logarithm of the restricted one without them.
        model, left: the response that was fitted, and its distance from the measured one.
        white: the same in deviations, without what a window makes alike.
    """

    theta: Floats
    covariance: Floats
    step: Floats
    squares: float
    likelihood: float
    model: np.ndarray
    left: np.ndarray
    white: np.ndarray


Levels: TypeAlias = list[tuple[float | None, LevelFit]]


class _Form:
    """A pole i(x - c) + d, those of neighbours, and a polynomial, over the distance x from the peak in lines."""

    def __init__(self, x: Floats, y: np.ndarray, reach: int, beside: Floats, line: LineShape) -> None:
        self.x, self.y, self.line = x, y, line
        powers = (x / reach)[:, None] ** np.arange(DEGREE + 1)
        self.others = np.hstack([line.of(1j * (x[:, None] - beside[:, 0]) + beside[:, 1]), powers])
        self.freedom = 2 * len(x) - 2 - 2 * (1 + self.others.shape[1])

    def basis(self, theta: Floats) -> np.ndarray:
        return np.column_stack([self.line.of(self._distance(theta)), self.others])

    def _distance(self, theta: Floats) -> np.ndarray:
        return np.asarray(1j * (self.x - theta[1]) + np.exp(theta[0]))

    def fitted(self, theta: Floats, deviation: Floats) -> tuple[np.ndarray, np.ndarray]:
        """Return the linear numbers that fit best, and the model."""
        columns = self.basis(theta)
        whole = self.line.whitened(np.column_stack([columns, self.y]) / deviation[:, None])
        numbers = np.linalg.lstsq(whole[:, :-1], whole[:, -1], rcond=None)[0]
        return numbers, columns @ numbers

    def search(self, start: Floats, deviation: Floats) -> Floats:
        """Return the place of the pole by weights 1/deviation^2."""

        def misfit(theta: Floats) -> Floats:
            off = self.line.whitened((self.fitted(theta, deviation)[1] - self.y) / deviation)
            return np.concatenate([off.real, off.imag])

        found: Floats = least_squares(misfit, start, x_scale=[0.3, 0.1], max_nfev=200).x
        return found

    def weighted(self, theta: Floats, deviation: Floats) -> LevelFit | None:
        """Return what a fit says; None where its numbers cannot be told apart."""
        numbers, model = self.fitted(theta, deviation)
        by_theta = numbers[0] * self.line.slope(self._distance(theta))[:, None] * [np.exp(theta[0]), -1j]
        left = model - self.y
        whole = np.column_stack([by_theta, self.basis(theta), left]) / deviation[:, None]
        whole = self.line.whitened(whole)
        columns, white = whole[:, 2:-1], whole[:, -1]
        linear = np.vstack(
            [np.hstack([columns.real, -columns.imag]), np.hstack([columns.imag, columns.real])]
        )
        whole = np.hstack([np.vstack([whole[:, :2].real, whole[:, :2].imag]), linear])
        off = np.concatenate([white.real, white.imag])
        # The pole's two columns come last, then what is left: the end of the triangle has their covariance and step.
        whole = np.column_stack([np.roll(whole, -2, axis=1), off])
        triangle = np.asarray(np.linalg.qr(whole, mode="r"))
        diagonal = np.abs(np.diag(triangle))[:-1]
        if not diagonal.min() > 1e-13 * diagonal.max():
            return None
        inverse = np.linalg.inv(triangle[-3:-1, -3:-1])
        likelihood = -2.0 * float(np.sum(np.log(deviation))) - float(np.sum(np.log(diagonal)))
        squares = float(np.sum(np.abs(white) ** 2))
        step = -inverse @ triangle[-3:-1, -1]
        return LevelFit(theta, inverse @ inverse.T, step, squares, likelihood, model, left, white)

    def by_level(self, first: Floats) -> Levels:
        """Return the fits for all levels, with a/b in the units of the response."""
        known = self.weighted(first, np.ones(len(self.x)))
        found: Levels = []
        if known is None:
            return found
        for level in float(np.median(np.abs(known.model))) * LEVELS:
            for _ in range(PASSES):
                deviation = np.hypot(level, np.abs(known.model))
                tried = self.weighted(known.theta + np.clip(known.step, -LARGEST, LARGEST), deviation)
                if tried is None:
                    return found
                known = tried
                size = np.sqrt(np.diag(known.covariance) * known.squares / self.freedom)
                if (np.abs(known.step) < SETTLED * size).all():
                    break
            else:
                settled = self.weighted(self.search(known.theta, deviation), deviation)
                if settled is None:
                    return found
                known = settled
            found.append((float(level), known))
        return found


@dataclass(frozen=True)
class Peak:
    """The fits about one peak of one response.

    Attributes:
        place: of the peak, Hz; step: between lines, Hz; size: of the response there, by which all is divided.
        freedom: values less numbers that were fitted.
        levels: a/b and the fit with these weights; None and one fit where the noise is known but for a factor.
    """

    place: float
    step: float
    size: float
    freedom: int
    levels: Levels


def rough_pole(
    hertz: Floats, response: np.ndarray, k: int, reach: int, line: LineShape
) -> tuple[float, float] | None:
    """Return frequency [Hz] and damping ratio about a peak, all lines with one weight; None where there is no pole."""
    found = _searched(hertz, response, k, reach, line)
    if found is None:
        return None
    step = _step_about(hertz, k, reach)
    decay, centre = float(np.exp(found[1][0])) * step, float(hertz[k] + found[1][1] * step)
    return float(np.hypot(centre, decay)), decay / float(np.hypot(centre, decay))


def rough_misfit(
    hertz: Floats, response: np.ndarray, k: int, reach: int, line: LineShape
) -> tuple[float, int] | None:
    """Return the squares that such a fit leaves over those of the peak, and its degrees of freedom by two."""
    found = _searched(hertz, response, k, reach, line)
    if found is None:
        return None
    form, theta = found
    left = form.fitted(theta, np.ones(len(form.x)))[1] - form.y
    return max(float(np.sum(np.abs(left) ** 2)), np.finfo(float).eps), form.freedom // 2


def peak_fits(
    hertz: Floats,
    response: np.ndarray,
    k: int,
    reach: int,
    line: LineShape,
    noise: Floats | None = None,
    neighbours: Sequence[tuple[float, float]] = (),
) -> Peak | None:
    """Return the fits about a peak from the lines within reach; None where there is no pole.

    Args:
        hertz: lines, Hz (n,), evenly spaced unless `line` is that of a pole alone; response: complex (n,).
        k: the line of the peak; reach: lines on each side; line: what a pole looks like there.
        noise: standard deviations of the lines (n,), where they are known but for a factor.
        neighbours: frequencies [Hz] and damping ratios of other modes; those nearby have their own poles in the fit.
    """
    found = _searched(hertz, response, k, reach, line, neighbours)
    if found is None:
        return None
    form, theta = found
    levels: Levels
    if noise is None:
        levels = form.by_level(theta)
    else:
        deviation = noise[max(k - reach, 0) : k + reach + 1] / np.abs(response[k])
        one = form.weighted(form.search(theta, deviation), deviation)
        levels = [] if one is None else [(None, one)]
    if not levels:
        return None
    step = _step_about(hertz, k, reach)
    return Peak(float(hertz[k]), step, float(np.abs(response[k])), form.freedom, levels)


def _step_about(hertz: Floats, k: int, reach: int) -> float:
    """Return the mean distance of lines within reach of a peak, Hz."""
    first, last = max(k - reach, 0), min(k + reach, len(hertz) - 1)
    return float(hertz[last] - hertz[first]) / max(last - first, 1)


def spacing(hertz: Floats, place: float) -> float:
    """Return the distance of the lines on both sides of a place, Hz."""
    k = min(max(int(np.searchsorted(hertz, place)), 1), len(hertz) - 1)
    return float(hertz[k] - hertz[k - 1])


def _searched(
    hertz: Floats,
    response: np.ndarray,
    k: int,
    reach: int,
    line: LineShape,
    neighbours: Sequence[tuple[float, float]] = (),
) -> tuple[_Form, Floats] | None:
    inside = np.arange(max(k - reach, 0), min(k + reach + 1, len(hertz)))
    if len(inside) < 2 * LEAST:
        return None
    step = _step_about(hertz, k, reach)
    beside = np.array(
        [((f * np.sqrt(1.0 - z**2) - hertz[k]) / step, z * f / step) for f, z in neighbours if z < 1.0]
    ).reshape(-1, 2)
    beside = beside[np.abs(beside[:, 0]) < NEAR * reach]
    x, y = (hertz[inside] - hertz[k]) / step, response[inside] / np.abs(response[k])
    form = _Form(x, y, reach, beside, line)
    if form.freedom < 1:
        return None
    even = np.ones(len(inside))
    rates = (0.05 * max(1.0, 1e-3 * reach), 0.2 * reach)
    tries = [form.search(np.array([np.log(rate), shift]), even) for rate in rates for shift in (-0.3, 0.3)]
    best = min(tries, key=lambda theta: float(np.sum(np.abs(form.fitted(theta, even)[1] - form.y) ** 2)))
    return (form, best) if abs(best[1]) < OFF + line.widening + np.exp(best[0]) else None
