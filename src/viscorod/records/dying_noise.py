"""Noise that dies out along a record, as an exponential window makes it: it weighs the noise along with the motion."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize
from scipy.stats import chi2

from viscorod.solve.estimation.noise import autocorrelation
from viscorod.typing import Floats

__all__ = ["dying_rate", "said_of_window"]

BY_CHANCE = 1e-8
"""Probability of such a fall of level noise, below which it is none."""
LEAST = 0.5
"""Logarithm by which noise must be less at the end than at the beginning, at least."""
SMOOTH = 0.6
"""Autocorrelation of what is left from which on it is a motion that a fit has not, and no noise."""
ALIKE = 3.0
"""Standard errors within which the noise dies out as the motion does, so that it may be in proportion to that."""


def dying_rate(times: Floats, residual: Floats) -> tuple[float, float] | None:
    """Return the rate at which noise dies out and its standard error, 1/s; None where it does not for sure.

    The likeliest variance a exp(-2 rate t) + c: what a fit of all samples errs by does not die out. What is left must
    not be smooth: a model that misses part of a decay leaves something that dies out, too.

    Args:
        times: s (n,); residual: what a fit leaves over (n,).
    """
    span, count = float(np.ptp(times)), len(residual)
    square = residual**2 / max(float(np.mean(residual**2)), 1e-300)
    if count < 20 or not square.any():
        return None
    t = (times - times[0]) / span

    def variance(z: Floats) -> Floats:
        return np.asarray(np.exp(z[0] - 2.0 * z[1] * t) + np.exp(z[2]))

    def unlikely(z: Floats) -> float:
        level = variance(z)
        return 0.5 * float(np.sum(np.log(level) + square / level))

    bounds = [(-20.0, 20.0), (0.0, 20.0), (-25.0, 5.0)]
    starts = ((2.0, 1.0, -8.0), (2.0, 4.0, -8.0))
    best = min(
        (minimize(unlikely, one, bounds=bounds, method="L-BFGS-B") for one in starts), key=lambda one: one.fun
    )
    if chi2.sf(2.0 * (0.5 * count - best.fun), 2) > BY_CHANCE or best.x[1] < LEAST:
        return None
    level = variance(best.x)
    falling = np.exp(best.x[0] - 2.0 * best.x[1] * t) / level
    high = falling > 0.5
    if np.count_nonzero(high) < 20:
        return None
    rho = autocorrelation((residual / np.sqrt(level))[high], 10)[1:]
    if np.abs(rho).max() > SMOOTH:
        return None
    slopes = np.column_stack([falling, -2.0 * t * falling, np.exp(best.x[2]) / level])
    error = float(np.sqrt(2.0 * np.linalg.pinv(slopes.T @ slopes)[1, 1]))
    return float(best.x[1]) / span, error / span


def said_of_window(found: tuple[float, float], motion: float, instead: str) -> str:
    """Return the sentence on what :func:`dying_rate` found.

    Args:
        motion: rate at which the motion dies out, 1/s; instead: what to do where there was a window.
    """
    rate, error = found
    other = ", or as noise in proportion to the motion does" if abs(rate - motion) < ALIKE * error else ""
    return (
        f"dies out with a time constant of about {1.0 / rate:.2g} s, as the noise of a record does that was multiplied "
        f"by an exponential window{other}. A window adds its own decay to that of every mode: {instead}"
    )
