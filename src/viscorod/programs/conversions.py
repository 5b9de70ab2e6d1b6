"""Convert between the numbers that stand for damping: pure functions of plain numbers.

A Kelvin-Voigt law ``S = C (eps + tau eps_t)`` has one time tau, a Rayleigh law the beta = tau of its
stiffness-proportional part. A vibration at the angular frequency ``omega = 2 pi f`` has the complex stiffness
``C (1 + i omega tau)``, hence the loss factor d = omega tau; a mode with the undamped angular frequency omega
has ``x_tt + tau omega^2 x_t + omega^2 x = 0``, hence the damping ratio zeta = omega tau / 2. So d = 2 zeta at
the mode's undamped frequency, exactly and for any damping; what differs beyond small damping are the
logarithmic decrement and the width of the resonance (J. P. Den Hartog, Mechanical vibrations, chapter 2; L.
Meirovitch, Fundamentals of vibrations, chapter 2).
"""

from __future__ import annotations

import math

from viscorod.argument_names import telling
from viscorod.checks import number
from viscorod.errors import Fault, InputError

__all__ = [
    "bulk_time",
    "critical_frequency",
    "damped_frequency",
    "damping_ratio",
    "half_power_points",
    "log_decrement",
    "loss_factor",
    "quality_factor",
    "ratio_from_log_decrement",
    "ratio_from_quality_factor",
    "time_from_damping_ratio",
    "time_from_loss_factor",
    "viscosity",
]


def _checked(name: str, value: float, *, positive: bool = False, below: float = math.inf) -> float:
    """Return `value` if it is finite, non-negative (or positive) and below the bound."""
    value = number(name, value)
    low = value > 0.0 if positive else value >= 0.0
    if not (math.isfinite(value) and low and value < below):
        bound = f" and < {below:g}" if math.isfinite(below) else ""
        raise InputError(
            Fault(
                name,
                f"{value:g}",
                "outside what is allowed",
                f"give a number {'>' if positive else '>='} 0{bound}",
            )
        )
    return value


@telling
def viscosity(time: float, modulus: float) -> float:
    """Return the viscosity (Pa s) of a retardation time (s) and its modulus (Pa): eta = G tau_S (LLT 3)."""
    return _checked("time", time) * _checked("modulus", modulus, positive=True)


@telling
def loss_factor(time: float, frequency: float) -> float:
    """Return the loss factor d = 2 pi f tau of a retardation time (s) at a frequency (Hz)."""
    return 2.0 * math.pi * _checked("frequency", frequency, positive=True) * _checked("time", time)


@telling
def time_from_loss_factor(factor: float, frequency: float) -> float:
    """Return the retardation time tau = d/(2 pi f), s, of a loss factor at a frequency (Hz)."""
    return _checked("loss_factor", factor) / (2.0 * math.pi * _checked("frequency", frequency, positive=True))


@telling
def damping_ratio(time: float, frequency: float) -> float:
    """Return the damping ratio zeta = pi f tau of a mode whose undamped frequency (Hz) is given."""
    return loss_factor(time, frequency) / 2.0


@telling
def time_from_damping_ratio(ratio: float, frequency: float) -> float:
    """Return the retardation time tau = zeta/(pi f), s, of a mode's damping ratio and undamped frequency (Hz)."""
    return time_from_loss_factor(2.0 * _checked("damping_ratio", ratio), frequency)


@telling
def critical_frequency(time: float) -> float:
    """Return the undamped frequency (Hz) above which modes creep back instead of swinging: 1/(pi tau)."""
    return 1.0 / (math.pi * _checked("time", time, positive=True))


@telling
def damped_frequency(frequency: float, ratio: float) -> float:
    """Return the frequency (Hz) of the decaying swing, f sqrt(1 - zeta^2); zero for an overdamped mode."""
    _checked("frequency", frequency, positive=True)
    return frequency * math.sqrt(max(1.0 - _checked("damping_ratio", ratio) ** 2, 0.0))


@telling
def log_decrement(ratio: float) -> float:
    """Return the logarithmic decrement of successive maxima, delta = 2 pi zeta / sqrt(1 - zeta^2).

    Raises:
        InputError: the ratio is 1 or more: such a mode has no successive maxima.
    """
    _checked("damping_ratio", ratio, below=1.0)
    return 2.0 * math.pi * ratio / math.sqrt(1.0 - ratio * ratio)


@telling
def ratio_from_log_decrement(decrement: float) -> float:
    """Return the damping ratio of a logarithmic decrement, zeta = delta / sqrt(4 pi^2 + delta^2)."""
    return _checked("log_decrement", decrement) / math.hypot(2.0 * math.pi, decrement)


@telling
def quality_factor(ratio: float) -> float:
    """Return the quality factor Q = 1/(2 zeta); infinite without damping.

    It is f/(f2 - f1) exactly, for any damping, when f1 and f2 are where the amplitude of the *velocity* under
    a force of constant amplitude is 1/sqrt(2) of its maximum, and f the undamped frequency. For the amplitude
    of the displacement see `half_power_points`.
    """
    return math.inf if _checked("damping_ratio", ratio) == 0.0 else 1.0 / (2.0 * ratio)


@telling
def ratio_from_quality_factor(quality: float) -> float:
    """Return the damping ratio of a quality factor, zeta = 1/(2 Q)."""
    return 1.0 / (2.0 * _checked("quality_factor", quality, positive=True))


@telling
def half_power_points(ratio: float) -> tuple[float, float]:
    """Return where the *displacement* amplitude under a force of constant amplitude is 1/sqrt(2) of its maximum.

    The two frequencies are r times the undamped one, r^2 = 1 - 2 zeta^2 -+ 2 zeta sqrt(1 - zeta^2). Their distance
    is 2 zeta (1 + zeta^2 ...), so a Q read from the displacement is too small, by 1 % at zeta = 0.1.

    Raises:
        InputError: the ratio is above 0.382: the lower point does not exist.
    """
    limit = math.sqrt((2.0 - math.sqrt(2.0)) / 4.0)
    _checked("damping_ratio", ratio, below=math.nextafter(limit, 1.0))
    middle, half = 1.0 - 2.0 * ratio * ratio, 2.0 * ratio * math.sqrt(1.0 - ratio * ratio)
    return math.sqrt(max(middle - half, 0.0)), math.sqrt(middle + half)


@telling
def bulk_time(extensional_time: float, shear_time: float, poissons_ratio: float) -> float:
    """Return the retardation time in volume change that gives a time in extension (bending, stretching), s.

    tau_B = [3 tau_E - 2 (1 + nu) tau_S] / (1 - 2 nu), LLT (4) solved for tau_B. With it, a damping ratio
    measured in bending and one measured in torsion give a material.

    Raises:
        InputError: nu = 0.5, where extension does not depend on it, or the result is negative: no material
            of this kind has these two times.
    """
    _checked("extensional_time", extensional_time)
    _checked("shear_time", shear_time)
    if not -1.0 < number("poissons_ratio", poissons_ratio) < 0.5:
        raise InputError(
            Fault(
                "poissons_ratio",
                f"{poissons_ratio:g}",
                "the time in volume change follows from extension only for -1 < nu < 0.5",
                "give a Poisson's ratio in that range",
            )
        )
    sheared = 2.0 * (1.0 + poissons_ratio) * shear_time
    found = (3.0 * extensional_time - sheared) / (1.0 - 2.0 * poissons_ratio)
    if found < -1e-12 * sheared:
        raise InputError(
            Fault(
                "extensional_time",
                f"{extensional_time:g} s",
                f"with a shear time of {shear_time:g} s and nu = {poissons_ratio:g} the bulk viscosity would be "
                "negative",
                f"give at least 2 (1 + nu) shear_time / 3 = {sheared / 3.0:.6g} s",
            )
        )
    return max(found, 0.0)
