"""Convert Rayleigh damping ``alpha M + beta K`` over a band of frequencies from and to Kelvin-Voigt times.

A mode with the angular frequency w has the ratio ``alpha/(2 w) + beta w/2``. Fits minimise the integral of the
squared difference of the ratios over the band, which has closed forms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from viscorod.argument_names import known_arguments, telling
from viscorod.checks import number
from viscorod.errors import Fault, InputError
from viscorod.typing import Floats

__all__ = ["Rayleigh", "rayleigh_for_constant_ratio", "rayleigh_from_time", "time_from_rayleigh"]


@known_arguments
@dataclass(frozen=True)
class Rayleigh:
    """Two constants fitted over a band.

    Attributes:
        alpha: factor of the mass matrix, 1/s.
        beta: factor of the stiffness matrix, s.
        low: lower end of the band, Hz.
        high: upper end of the band, Hz.
        largest_error: largest difference of the damping ratio from what was wanted, in the band.
    """

    alpha: float
    beta: float
    low: float
    high: float
    largest_error: float

    def ratio(self, frequency: float | Floats) -> Floats:
        """Return damping ratios of modes with the undamped frequencies (Hz), in an array of the same shape."""
        omega = 2.0 * math.pi * np.asarray(frequency, dtype=np.float64)
        return np.asarray(self.alpha / (2.0 * omega) + self.beta * omega / 2.0)


def _band(low: float, high: float) -> tuple[float, float]:
    if not 0.0 < number("low", low) < number("high", high):
        raise InputError(
            Fault(
                "band",
                f"{low:g} to {high:g} Hz",
                "a band has two different frequencies",
                "give 0 < low < high, Hz",
            )
        )
    return 2.0 * math.pi * low, 2.0 * math.pi * high


@telling
def rayleigh_from_time(time: float, low: float, high: float) -> Rayleigh:
    """Return the constants of a Kelvin-Voigt time (s): alpha = 0 and beta = tau, exactly and over any band (Hz)."""
    _band(low, high)
    return Rayleigh(0.0, time, low, high, 0.0)


@telling
def rayleigh_for_constant_ratio(ratio: float, low: float, high: float) -> Rayleigh:
    """Return the constants closest to the same damping ratio everywhere in a band (Hz).

    Normal equations with a = 1/w1 - 1/w2, b = w2 - w1, c = (w2^3 - w1^3)/3:
    a alpha + b beta = 2 zeta ln(w2/w1) and b alpha + c beta = zeta (w2^2 - w1^2).
    """
    w1, w2 = _band(low, high)
    if not 0.0 <= ratio < math.inf:
        raise InputError(
            Fault("damping_ratio", f"{ratio:g}", "outside what is allowed", "give a number >= 0")
        )
    a, b, c = 1.0 / w1 - 1.0 / w2, w2 - w1, (w2**3 - w1**3) / 3.0
    first, second = 2.0 * ratio * math.log(w2 / w1), ratio * (w2 * w2 - w1 * w1)
    determinant = a * c - b * b
    alpha, beta = (c * first - b * second) / determinant, (a * second - b * first) / determinant
    # the ratio is convex in w: it is farthest from the constant at the ends or at its minimum sqrt(alpha beta)
    values = [alpha / (2.0 * w) + beta * w / 2.0 for w in (w1, w2)]
    lowest = math.sqrt(alpha / beta) if alpha > 0.0 and beta > 0.0 else w1
    if w1 < lowest < w2:
        values.append(math.sqrt(alpha * beta))
    return Rayleigh(alpha, beta, low, high, max(abs(value - ratio) for value in values))


@telling
def time_from_rayleigh(alpha: float, beta: float, low: float, high: float) -> tuple[float, float]:
    """Return the Kelvin-Voigt time closest to two Rayleigh constants in a band (Hz).

    tau = beta + 3 alpha/(w1^2 + w1 w2 + w2^2).

    Returns:
        the time (s), and the largest difference of the damping ratio in the band.
    """
    w1, w2 = _band(low, high)
    for name, value in (("alpha", alpha), ("beta", beta)):
        if not 0.0 <= value < math.inf:
            raise InputError(Fault(name, f"{value:g}", "outside what is allowed", "give a number >= 0"))
    time = beta + 3.0 * alpha / (w1 * w1 + w1 * w2 + w2 * w2)
    # alpha/(2 w) - (tau - beta) w/2 falls with w
    return time, max(abs(alpha / (2.0 * w) + (beta - time) * w / 2.0) for w in (w1, w2))
