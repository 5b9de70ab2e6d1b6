"""What windows of an analyser make of a pole and of the noise, line by line.

Lines are those of records of the length T, 1/T apart. A pole s is residue/(i omega - s) in what is measured after a
blow. Windows change that in ways that are known:

- after a blow, an exponential window exp(-t/tau) on the response: the pole lies at s - 1/tau;
- after a blow, a window of Hann on the response: each line is that line less half of the mean of its neighbours;
- under noise, by H1 (cross spectrum over that of the input): the impulse response is weighed by the window's
  autocorrelation, over T (J. S. Bendat and A. G. Piersol, Random Data, 2010, section 11.5).

Noise of lines that a window made is alike in neighbours, as the spectrum of the squared window is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky, solve_toeplitz, solve_triangular, toeplitz
from scipy.signal import lfilter

__all__ = ["LineShape", "line_shape"]

STEP = 1e-5
"""Of differences of a shape, beside its distance from the pole."""
SMALL, TERMS = 0.5, 16
"""Distance from a removable pole below which its power series is taken, and terms of that."""
REACH = 24
"""Lines over which the likeness of noise is followed."""
WHITE_PART = 1e-3
"""Part of the noise's variance that no window has made: rounding, the force's own noise."""
TURN = 2j * np.pi


@dataclass(frozen=True)
class LineShape:
    """A pole and the noise, over p = i (line - its line) + its decay rate in lines.

    Attributes:
        shape: of a pole, by p.
        widening: decay rate in lines that a window adds.
        likeness: autocorrelation of the noise over lines, from 0 on; one number where neighbours have nothing to do
            with each other.
    """

    shape: Callable[[np.ndarray], np.ndarray] | None = None
    widening: float = 0.0
    likeness: tuple[complex, ...] = (1.0,)

    def of(self, p: np.ndarray) -> np.ndarray:
        """Return the lines of a pole."""
        moved = p + self.widening
        return 1.0 / moved if self.shape is None else self.shape(moved)

    def slope(self, p: np.ndarray) -> np.ndarray:
        """Return their derivative by p."""
        moved = p + self.widening
        if self.shape is None:
            return -1.0 / moved**2
        step = STEP * np.maximum(np.abs(moved), 1.0)
        return np.asarray((self.shape(moved + step) - self.shape(moved - step)) / (2.0 * step))

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Return lines (n, ...) of unit noise with its likeness taken out."""
        if len(self.likeness) == 1:
            return rows
        known = np.zeros(min(REACH, len(rows)), dtype=complex)
        known[: min(len(self.likeness), len(known))] = self.likeness[: len(known)]
        known *= 1.0 - WHITE_PART
        known[0] = 1.0
        order = len(known) - 1
        first = solve_triangular(cholesky(toeplitz(known), lower=True), rows[: order + 1], lower=True)
        if len(rows) == order + 1:
            return np.asarray(first)
        # an autoregression foretells each line from those before it
        terms = solve_toeplitz(known[:-1], known[1:])
        left = float(np.real(known[0] - np.sum(terms * known[1:].conj())))
        later = lfilter(np.append(1.0, -terms), [1.0 + 0.0j], rows, axis=0)[order + 1 :]
        return np.concatenate([first, later / np.sqrt(left)])


def line_shape(window: str | None, decay: float | None, excitation: str | None, step: float) -> LineShape:
    """Return the shape that a window makes.

    Args:
        window: None, "exponential" or "hann".
        decay: time constant of an exponential one, s.
        excitation: "blow", as which None counts, or "noise".
        step: between lines, Hz.
    """
    if excitation == "noise":
        if window is None:
            return LineShape(_triangular)
        return LineShape(_hann_of_noise, likeness=(1.0, 4.0 / 9.0, 1.0 / 36.0))
    if window == "exponential":
        assert decay is not None
        rate = 1.0 / (decay * step)  # over the record
        lags = np.arange(REACH)
        alike = 2.0 * rate / (2.0 * rate + TURN * lags)
        return LineShape(None, rate / (2.0 * np.pi), tuple(alike.tolist()))
    if window == "hann":
        return LineShape(_hann_of_blow, likeness=(1.0, -2.0 / 3.0, 1.0 / 6.0))
    return LineShape()


def _hann_of_blow(p: np.ndarray) -> np.ndarray:
    return np.asarray(1.0 / p - 0.5 / (p - 1j) - 0.5 / (p + 1j))


def _triangular(p: np.ndarray) -> np.ndarray:
    return _ramped(2.0 * np.pi * p)


def _hann_of_noise(p: np.ndarray) -> np.ndarray:
    """Return the transform of (1 - u)(2/3 + cos(2 pi u)/3) + sin(2 pi u)/(2 pi), the autocorrelation of Hann's."""
    q = 2.0 * np.pi * p
    before, after = q - TURN, q + TURN
    return np.asarray(
        2.0 / 3.0 * _ramped(q)
        + (_ramped(before) + _ramped(after)) / 6.0
        + (_even(before) - _even(after)) / (2.0 * TURN)
    )


def _even(q: np.ndarray) -> np.ndarray:
    """Return the integral of exp(-q u) over u from 0 to 1."""
    return _regular(q, lambda far: (1.0 - np.exp(-far)) / far, 0)


def _ramped(q: np.ndarray) -> np.ndarray:
    """Return the integral of exp(-q u)(1 - u) over u from 0 to 1."""
    return _regular(q, lambda far: 1.0 / far - (1.0 - np.exp(-far)) / far**2, 1)


def _regular(q: np.ndarray, far: Callable[[np.ndarray], np.ndarray], more: int) -> np.ndarray:
    """Return a function that is a power series sum (-q)^k/(k + 1 + more)! where q is small."""
    q = np.asarray(q, dtype=complex)
    near = np.abs(q) < SMALL
    found = far(np.where(near, 1.0, q))
    term, total = np.full_like(q[near], 1.0 / (1 + more)), np.zeros_like(q[near])
    for k in range(TERMS):
        total = total + term
        term = -term * q[near] / (k + 2 + more)
    found[near] = total
    return np.asarray(found)
