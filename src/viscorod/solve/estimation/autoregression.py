"""Autoregressions of residuals: their order by Burg's method, their terms by the restricted likelihood.

r_t = sum_i a_i r_(t-i) + e_t is described by its partial autocorrelations k_1, k_2, ..., any numbers between -1 and 1,
whose Durbin-Levinson recursion gives the terms a_i; the coordinates in which they are sought are their areas tangens.
What a fit leaves goes less with itself than the noise did, since the fit follows what is slow. The likelihood of what
no value of the unknowns changes, the restricted likelihood, does not have this bias of first order (T.-K. Cheang and
G. C. Reinsel, Bias reduction of autoregressive estimates in time series regression model through restricted maximum
likelihood, J. Am. Stat. Assoc. 95 (2000) 1173-1184). The bias that is left is that of any likelihood; Jeffreys' prior
takes it from the areas tangens (D. Firth, Bias reduction of maximum likelihood estimates, Biometrika 80 (1993) 27-38).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize
from scipy.signal import lfilter, lfiltic

from viscorod.typing import Floats

__all__ = ["autocorrelation_of", "chosen_partials", "restricted_partials", "terms_of", "whitened_by"]

MOST_ORDER = 12
"""Terms of an autoregression at most."""
LARGEST = 5.0
"""Largest coordinate of a partial autocorrelation, which is 0.9999."""
FARTHEST = 3.0
"""Standard errors within which the restricted likelihood must have its maximum: beside a constant it is flat towards a
random walk, and where the model is wrong it may have none. Burg's autoregression stays then."""
STEP = 1e-3
"""Change of coordinates by which second differences of the likelihood are taken."""


def terms_of(partials: Floats) -> tuple[Floats, float]:
    """Return the terms of an autoregression, and the size of what it leaves over that of the whole."""
    terms = np.zeros(0)
    for one in partials:
        terms = np.append(terms - one * terms[::-1], one)
    return terms, float(np.sqrt(np.prod(1.0 - np.asarray(partials) ** 2)))


def autocorrelation_of(terms: Floats, count: int) -> Floats:
    """Return the autocorrelation of an autoregression at the lags 0 to ``count`` (Yule-Walker equations)."""
    order = len(terms)
    matrix = np.eye(order)
    for k in range(order):  # rho_(k+1) = sum_i a_i rho_|k+1-i|
        for i, term in enumerate(terms):
            lag = abs(k - i)
            if lag:
                matrix[k, lag - 1] -= term
    rho = np.ones(max(count, order) + 1)
    rho[1 : order + 1] = np.linalg.solve(matrix, np.array(terms, dtype=float))
    if order and len(rho) > order + 1:  # rho_k = sum_i a_i rho_(k-i), as a filter without input
        below = np.append(1.0, -np.asarray(terms))
        state = lfiltic([1.0], below, rho[order:0:-1])
        rho[order + 1 :] = lfilter([1.0], below, np.zeros(len(rho) - order - 1), zi=state)[0]
    elif not order:
        rho[1:] = 0.0
    return rho[: count + 1]


def whitened_by(part: Floats, partials: Floats) -> Floats:
    """Return what an autoregression leaves of residuals, over its size; the first ones less what fewer of them say.

    Args:
        part: residuals ``(n,)`` or derivatives ``(n, p)``; partials: partial autocorrelations of the noise.
    """
    terms, innovation = terms_of(partials)
    out = part.copy()
    for lag, term in enumerate(terms, start=1):
        out[lag:] -= term * part[:-lag]
    out /= innovation
    out[: len(terms)] = _beginning(partials)[: len(terms), : len(terms)] @ part[: len(terms)]
    return out


def _beginning(partials: Floats) -> Floats:
    """Return what whitens the first samples: each is foretold by those before it, one more than there are terms."""
    count = len(partials)
    found = np.zeros((count + 1, count + 1))
    row, size = np.ones(1), 1.0  # the last sample less what foretells it, the oldest first
    found[0, 0] = 1.0
    for k, one in enumerate(partials):
        row = np.append(0.0, row) - one * np.append(row[::-1], 0.0)
        size *= np.sqrt(1.0 - one * one)
        found[k + 1, : k + 2] = row / size
    return found


def chosen_partials(residuals: Floats) -> Floats:
    """Return the partial autocorrelations, as many as the Bayesian information criterion chooses (Burg's method)."""
    n = len(residuals)
    size = float(np.mean(residuals**2))
    if size == 0.0:
        return np.zeros(0)
    forward, backward = residuals.copy(), residuals.copy()
    partials, variance = np.zeros(0), size
    best = (n * np.log(size), partials)
    for order in range(1, min(MOST_ORDER, n // 10) + 1):
        ahead, behind = forward[1:], backward[:-1]
        below = float(ahead @ ahead + behind @ behind)
        if below <= 1e-20 * n * size:
            break
        reflection = 2.0 * float(ahead @ behind) / below
        partials = np.append(partials, reflection)
        variance *= 1.0 - reflection**2
        forward, backward = ahead - reflection * behind, behind - reflection * ahead
        if variance <= 1e-12 * size:
            break
        merit = n * np.log(variance) + order * np.log(n)
        if merit < best[0]:
            best = (merit, partials)
    return best[1]


def restricted_partials(
    partials: Floats, residuals: Floats, slopes: Floats, others: Floats
) -> tuple[Floats, Floats]:
    """Return the partial autocorrelations by the restricted likelihood, and the covariance of their coordinates.

    Args:
        partials: to start from ``(m,)``; residuals: of one series ``(n,)``.
        slopes: derivatives of its values by independent combinations of the unknowns ``(n, k)``, in units of the noise.
        others: what other series tell of these combinations ``(k, k)``.

    Returns:
        The partial autocorrelations ``(m,)``, and the covariance of their areas tangens ``(m, m)``.
    """
    likelihood = _Restricted(len(partials), residuals, slopes, others)
    start = np.clip(np.arctanh(np.clip(partials, -0.99999, 0.99999)), -LARGEST, LARGEST)
    reach = FARTHEST / np.sqrt(len(residuals) * (1.0 - np.tanh(start) ** 2))
    low, high = np.maximum(start - reach, -LARGEST), np.minimum(start + reach, LARGEST)
    found = minimize(likelihood, start, method="L-BFGS-B", bounds=list(zip(low, high, strict=True)))
    inside = bool((np.abs(found.x - start) < 0.99 * reach).all()) and found.fun <= likelihood(start)
    best = np.asarray(found.x if inside else start)
    curvature = _second_differences(likelihood, best)
    size, ways = np.linalg.eigh(curvature)
    # a coordinate is known no better than by n independent pairs, and no worse than its range
    size = np.clip(size, 2.0 / LARGEST**2, 2.0 * len(residuals))
    doubt = np.asarray(2.0 * (ways / size) @ ways.T)
    # one step towards Jeffreys' prior, the product of (1 - k_j^2)^(-j/2): what bias of order 1/n is left goes with it
    step = doubt @ (np.arange(1.0, len(best) + 1.0) * np.tanh(best))
    far = float(np.sqrt(step @ np.linalg.solve(doubt, step)))
    if not inside:
        return np.tanh(best), doubt
    return np.tanh(np.clip(best + step / max(far, 1.0), -LARGEST, LARGEST)), doubt


class _Restricted:
    """Twice the negative logarithm of the restricted likelihood, the size of the noise eliminated, up to a constant.

    All sums over the samples are products of lagged residuals and slopes, which are made once.
    """

    def __init__(self, order: int, residuals: Floats, slopes: Floats, others: Floats) -> None:
        self._order, self._count, self._others = order, len(residuals), others
        both = np.column_stack([residuals, slopes])
        self._head = both[:order]
        lagged = np.stack([both[order - lag : len(both) - lag] for lag in range(order + 1)])
        self._products = np.einsum("inp,jnq->ijpq", lagged, lagged, optimize=True)
        self._free = len(residuals) - float(slopes.shape[1])
        if others.any():
            used = np.linalg.solve(others + slopes.T @ slopes, slopes.T @ slopes)
            self._free = len(residuals) - float(np.trace(used))

    def __call__(self, z: Floats) -> float:
        partials = np.tanh(z)
        rows = _beginning(partials)
        filtered = rows[-1, ::-1]
        square = filtered @ np.tensordot(filtered, self._products, 1).transpose(1, 0, 2)
        head = rows[:-1, :-1] @ self._head
        square = square + head.T @ head
        weights = self._count - np.arange(1.0, self._order + 1.0)
        volume = float(np.sum(weights * np.log1p(-(partials**2))))
        told = np.linalg.slogdet(self._others + square[1:, 1:])[1] if len(square) > 1 else 0.0
        return float(self._free * np.log(max(square[0, 0], 1e-300)) + volume + told)


def _second_differences(function: _Restricted, place: Floats) -> Floats:
    """Return the second derivatives of a function by central differences."""
    count = len(place)
    found = np.zeros((count, count))
    steps = STEP * np.eye(count)
    for k in range(count):
        for i in range(k + 1):
            corners = [
                sign * function(place + a * steps[k] + b * steps[i])
                for a, b, sign in ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))
            ]
            found[k, i] = found[i, k] = sum(corners) / (4.0 * STEP**2)
    return found
