"""Maxwell branches that follow a loss factor over a band of frequencies: non-negative least squares.

With the moduli m_j of the branches over that in equilibrium, loss and storage modulus at the angular frequency w are

    M''(w) = sum m_j w tau_j/(1 + (w tau_j)^2),     M'(w) = 1 + sum m_j (w tau_j)^2/(1 + (w tau_j)^2),

and M'' = eta M' is linear in the m_j for given times. A branch lives about a decade, so that times evenly spaced in
their logarithm follow a slowly varying loss factor with a ripple that falls exponentially as they move together.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.model.materials.nearest_kelvin_voigt import log_weights
from viscorod.model.materials.relaxation_modulus import RelaxationModulus
from viscorod.typing import Floats

__all__ = ["LossFit", "fit_loss_factors"]

MOST_PER_DECADE = 4
"""Branches per decade beyond which more of them follow nothing more closely."""
MARGINS = (-0.5, 1.5)
"""How far the times may go beyond the band at either end, decades."""
REPEATS = 3
"""Solutions with the storage modulus of the last one in the weights."""
BETTER = 0.99
"""More branches count only if they leave less than this part of the error."""


class LossFit(NamedTuple):
    """Branches that follow loss factors.

    Attributes:
        moduli: a relaxation modulus for every loss factor, with the modulus 1 in equilibrium; all on the same times.
        error: largest relative error of a loss factor within the band.
    """

    moduli: tuple[RelaxationModulus, ...]
    error: float


def fit_loss_factors(omega: Floats, losses: tuple[Floats, ...], tolerance: float) -> LossFit:
    """Return the fewest Maxwell branches whose loss factors are within a tolerance; the closest if none are.

    Args:
        omega: increasing angular frequencies over the band (n,), rad/s.
        losses: loss factors at them (n,), > 0 or all 0.
        tolerance: relative error.
    """
    decades = math.log10(float(omega[-1] / omega[0]))
    best = _fit(omega, losses, 1, 0.0)
    for count in range(1, 3 + math.ceil(MOST_PER_DECADE * decades)):
        if best.error <= tolerance:
            break
        found = _best_margin(omega, losses, count)
        if found.error < BETTER * best.error:
            best = found
    return best


def _best_margin(omega: Floats, losses: tuple[Floats, ...], count: int) -> LossFit:
    """Return the best fit with so many branches, over how far their times go beyond the band."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda margin: _fit(omega, losses, count, margin).error,
        bounds=MARGINS,
        method="bounded",
        options={"xatol": 0.02},
    )
    return _fit(omega, losses, count, float(found.x))


def _fit(omega: Floats, losses: tuple[Floats, ...], count: int, margin: float) -> LossFit:
    """Fit branches with times over the inverse of the band, and a margin beyond it, decades."""
    low, high = math.log10(1.0 / float(omega[-1])) - margin, math.log10(1.0 / float(omega[0])) + margin
    times = (
        np.logspace(low, high, count) if count > 1 and high > low else np.array([10 ** ((low + high) / 2)])
    )
    fits = tuple(_moduli(omega, loss, times) for loss in losses)
    return LossFit(fits, max(_error(omega, loss, fit) for loss, fit in zip(losses, fits, strict=True)))


def _moduli(omega: Floats, loss: Floats, times: Floats) -> RelaxationModulus:
    """Return the branches of given times whose loss factor is nearest, in the mean square of its relative error."""
    from scipy.optimize import nnls

    if not loss.any():
        return RelaxationModulus(1.0)
    product = omega[:, None] * times
    share = product / (1.0 + product**2)
    rows = share - loss[:, None] * share * product
    scale = np.sqrt(log_weights(omega)) / loss
    storage = np.ones(len(omega))
    moduli = np.zeros(len(times))
    for _ in range(REPEATS):
        weight = scale / storage
        moduli = nnls(weight[:, None] * rows, weight * loss)[0]
        storage = 1.0 + (share * product) @ moduli
    kept = moduli > 0.0
    return RelaxationModulus(1.0, tuple(moduli[kept].tolist()), tuple(times[kept].tolist()))


def _error(omega: Floats, loss: Floats, fit: RelaxationModulus) -> float:
    """Return the largest relative error of a loss factor; 0 where nothing is lost."""
    if not loss.any():
        return 0.0
    modulus = fit.complex_modulus(omega)
    return float(np.max(np.abs(modulus.imag / modulus.real / loss - 1.0)))
