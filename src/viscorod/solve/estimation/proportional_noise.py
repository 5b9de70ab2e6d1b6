"""Noise of which a part is in proportion to what was measured, from what a fit leaves.

Where a transfer, an instrument's range or a sample's dimensions scatter, the noise is in proportion to the value; the
rest of it is constant. Its variance is ``a^2 + b^2 |v|^2``, with v of the model and not of the data, whose own noise
would weigh down what is too large (R. J. Carroll and D. Ruppert, Transformation and Weighting in Regression, 1988,
chapter 2).
"""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["proportional_shape"]

RATIOS = 10.0 ** np.arange(-1.5, 3.1, 0.125)
"""b over a, by the median size of the values, that are tried; the last is as good as in proportion alone."""


def proportional_shape(left: Floats, size: Floats, slopes: Floats) -> Floats | None:
    """Return the deviations of noise over their median ``(n,)``; None where they are constant as far as is told.

    The variance is the mean over all ratios of both parts, by their restricted likelihood (D. A. Harville, J. Am.
    Stat. Assoc. 72, 1977), unless constant noise is likelier than the likeliest of them by Bayes' criterion.

    Args:
        left: residuals ``(n,)``; size: of the values that were predicted ``(n,)``.
        slopes: of independent numbers that were fitted to them ``(n, p)``.
    """
    count, fitted = slopes.shape
    median = float(np.median(size))
    free = count - fitted - 1
    if not (median > 0.0 and left.any()) or free < 2:
        return None
    variances = 1.0 + (np.append(0.0, RATIOS / median)[:, None] * size) ** 2
    squares = np.sum(left**2 / variances, axis=1)
    likely = np.array([_likelihood(one, slopes) for one in variances]) - 0.5 * (free + 1) * np.log(squares)
    if likely.max() < likely[0] + 0.5 * float(np.log(count)):
        return None
    weight = np.exp(likely - likely.max())
    shape = np.sqrt((weight * squares / weight.sum()) @ variances)
    return np.asarray(shape / np.median(shape))


def _likelihood(variance: Floats, slopes: Floats) -> float:
    """Return the part of the logarithm of the restricted likelihood that no residuals are in."""
    triangle = np.linalg.qr(slopes / np.sqrt(variance)[:, None], mode="r")
    told = np.maximum(np.abs(np.diag(triangle)), np.finfo(float).tiny)
    return float(-0.5 * np.sum(np.log(variance)) - np.sum(np.log(told)))
