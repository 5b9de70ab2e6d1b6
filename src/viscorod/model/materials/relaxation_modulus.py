"""Relaxation moduli as Prony series, and the modulus in extension that follows from shear and volume change.

A generalised Maxwell solid: a spring beside Maxwell branches. With the moduli M_j and relaxation times tau_j

    M(t) = M_inf + sum_j M_j exp(-t/tau_j),      M*(omega) = M_inf + sum_j M_j i omega tau_j/(1 + i omega tau_j)

(Linn, Lang and Tuganov 2013, section 2.6).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from viscorod.argument_names import known_arguments
from viscorod.errors import Fault, InputError
from viscorod.typing import Floats

__all__ = ["RelaxationModulus", "extension_of"]

NOTHING = 1e-30
"""Branches of less than this part of the equilibrium modulus are none."""

Complexes: TypeAlias = npt.NDArray[np.complex128]


@known_arguments
@dataclass(frozen=True)
class RelaxationModulus:
    """A relaxation modulus; branches of equal time are merged, those without modulus left out.

    Attributes:
        equilibrium: what remains of the modulus after a long time, > 0, Pa; infinite for a strain that cannot occur.
        moduli: of the branches, Pa, in the order of their times.
        times: relaxation times of the branches, increasing, s.

    Raises:
        InputError: as many moduli as times are needed; moduli may not be negative, times must be positive.
    """

    equilibrium: float
    moduli: tuple[float, ...] = ()
    times: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.moduli) != len(self.times):
            found = f"{len(self.moduli)} moduli and {len(self.times)} times"
            raise InputError(
                Fault("times", found, "each branch has one modulus and one time", "give as many")
            )
        if not self.equilibrium > 0.0:
            raise InputError(
                Fault("equilibrium", f"{self.equilibrium:g}", "a solid keeps a modulus", "give a number > 0")
            )
        merged: dict[float, float] = {}
        for modulus, time in zip(self.moduli, self.times, strict=True):
            if not (0.0 <= modulus < math.inf and 0.0 < time < math.inf):
                found = f"modulus {modulus:g} Pa with time {time:g} s"
                raise InputError(
                    Fault("moduli", found, "outside what is allowed", "give moduli >= 0 and times > 0")
                )
            if modulus > NOTHING * self.equilibrium or math.isinf(self.equilibrium):
                merged[float(time)] = merged.get(float(time), 0.0) + float(modulus)
        object.__setattr__(self, "equilibrium", float(self.equilibrium))
        object.__setattr__(self, "times", tuple(sorted(merged)))
        object.__setattr__(self, "moduli", tuple(merged[time] for time in self.times))

    @property
    def instantaneous(self) -> float:
        """The modulus in fast motion, M_inf + sum M_j, Pa."""
        return self.equilibrium + math.fsum(self.moduli)

    @property
    def viscosity(self) -> float:
        """The viscosity of slow motion, sum M_j tau_j, Pa s."""
        return math.fsum(m * t for m, t in zip(self.moduli, self.times, strict=True))

    @property
    def retardation_time(self) -> float:
        """Viscosity over equilibrium modulus, s: the Kelvin-Voigt time of slow motion."""
        return self.viscosity / self.equilibrium

    def complex_modulus(self, omega: Floats | float) -> Complexes:
        """Return storage (real part) and loss modulus (imaginary part) at angular frequencies, Pa.

        Args:
            omega: rad/s, of any shape.
        """
        omega = np.asarray(omega, dtype=float)
        product = omega[..., None] * np.array(self.times)
        share = product / (1.0 + product**2)
        total: Complexes = np.sum(np.array(self.moduli) * share * (product + 1j), axis=-1) + self.equilibrium
        return total

    def relaxation_modulus(self, t: Floats | float) -> Floats:
        """Return stress over strain at the times t >= 0 after a strain was suddenly imposed, Pa.

        Args:
            t: s, of any shape.
        """
        decay = np.exp(-np.asarray(t, dtype=float)[..., None] / np.array(self.times))
        total: Floats = np.sum(np.array(self.moduli) * decay, axis=-1) + self.equilibrium
        return total

    def kelvin_voigt_bound(self, omega: Floats, spectrum: Floats) -> float:
        """Return a bound of the stress error, Pa, of the Kelvin-Voigt solid of slow motion for a strain spectrum.

        (1/2 pi) int ``|eps^(w)|`` sum M_j (tau_j w)^2/sqrt(1 + (tau_j w)^2) dw over both signs of the frequency (Linn,
        Lang and Tuganov 2013, end of section 2.6), by the trapezoidal rule.

        Args:
            omega: increasing angular frequencies >= 0 (n,), rad/s.
            spectrum: size of the strain's Fourier transform at them (n,), s.

        Raises:
            InputError: the two have different lengths, or the frequencies do not increase from 0 or above.
        """
        omega, spectrum = np.asarray(omega, dtype=float), np.abs(np.asarray(spectrum))
        if omega.ndim != 1 or omega.shape != spectrum.shape or omega.size < 2:
            found = f"{omega.shape} and {spectrum.shape}"
            raise InputError(
                Fault(
                    "spectrum",
                    found,
                    "each frequency has one value",
                    "give two lists of the same length, 2 at least",
                )
            )
        if omega[0] < 0.0 or not (np.diff(omega) > 0.0).all():
            raise InputError(Fault("omega", "", "frequencies must increase from 0 or above", "sort them"))
        product = omega[:, None] * np.array(self.times)
        weight = np.sum(np.array(self.moduli) * product**2 / np.sqrt(1.0 + product**2), axis=1)
        return float(np.trapezoid(spectrum * weight, omega)) / math.pi

    def shifted(self, factor: float) -> RelaxationModulus:
        """Return the same relaxation at another temperature: all times times a positive factor."""
        return RelaxationModulus(self.equilibrium, self.moduli, tuple(t * factor for t in self.times))

    def scaled(self, factor: float) -> RelaxationModulus:
        """Return the same relaxation of another modulus: all moduli times a positive factor."""
        return RelaxationModulus(
            self.equilibrium * factor, tuple(m * factor for m in self.moduli), self.times
        )


def extension_of(shear: RelaxationModulus, bulk: RelaxationModulus) -> RelaxationModulus:
    """Return Young's modulus as a Prony series, from the moduli of shear G and volume change K.

    By the correspondence principle E* = 9 K* G*/(3 K* + G*) at every complex frequency. With x = -1/s the moduli are
    K = K_inf + sum K_j tau_j/(tau_j - x), G likewise, and E has the relaxation times T at which 3 K + G vanishes: one
    above each time of shear or bulk, below the next. There K = -G/3, so that T E_T = 27 K^2/(3 K + G)' is positive. A
    time that shear and bulk share is one of E too, with 9 K_j G_j/(3 K_j + G_j).

    Args:
        shear: the shear modulus.
        bulk: the bulk modulus; infinite for an incompressible material, which makes E = 3 G.

    Returns:
        Young's modulus; its low-frequency viscosity is that of Linn, Lang and Tuganov 2013, equation 3.
    """
    if math.isinf(bulk.equilibrium):
        return shear.scaled(3.0)
    G, K = shear.equilibrium, bulk.equilibrium
    weights: dict[float, float] = dict(zip(shear.times, shear.moduli, strict=True))
    for time, modulus in zip(bulk.times, bulk.moduli, strict=True):
        weights[time] = weights.get(time, 0.0) + 3.0 * modulus
    times = np.array(sorted(weights))
    moduli = np.array([weights[time] for time in times.tolist()])
    found: list[tuple[float, float]] = []
    for index in range(len(times)):
        origin, offset = _zero(3.0 * K + G, moduli, times, index)
        time = origin + offset
        slope = float(np.sum(moduli * times / ((times - origin) - offset) ** 2))
        volume, spread = _at(bulk, origin, offset)
        third, third_spread = (value / 3.0 for value in _at(shear, origin, offset))
        smaller = volume if spread <= third_spread else third
        found.append((time, 27.0 * smaller**2 / (slope * time)))
    shares = dict(zip(shear.times, shear.moduli, strict=True))
    found += [
        (time, 9.0 * k * shares[time] / (3.0 * k + shares[time]))
        for time, k in zip(bulk.times, bulk.moduli, strict=True)
        if time in shares
    ]
    return RelaxationModulus(
        9.0 * K * G / (3.0 * K + G), tuple(modulus for _, modulus in found), tuple(time for time, _ in found)
    )


def _zero(equilibrium: float, moduli: Floats, times: Floats, index: int) -> tuple[float, float]:
    """Find the zero above `times[index]` and below the next of M_inf + sum M_j tau_j/(tau_j - x).

    It is returned as its distance from the nearer of the two times, so that it keeps all digits however close it is.
    """
    from scipy.optimize import brentq

    weights = moduli * times

    def function(near: int, offset: float) -> float:
        return float(equilibrium + np.sum(weights / ((times - times[near]) - offset)))

    near, side = index, 1.0
    if index == len(times) - 1:
        farthest = float(weights.sum()) / equilibrium  # there all branches together are at most the spring
    else:
        farthest = float(times[index + 1] - times[index]) / 2.0
        if function(index, farthest) < 0.0:
            near, side = index + 1, -1.0
    others = np.delete(np.abs(weights / np.where(times == times[near], 1.0, times - times[near])), near)
    nearest = 0.5 * weights[near] / (equilibrium + 2.0 * float(others.sum()))
    nearest = min(nearest, 0.5 * farthest)

    def logarithmic(exponent: float) -> float:
        return function(near, side * math.exp(exponent))

    low, high = math.log(nearest), math.log(farthest)
    if logarithmic(low) * logarithmic(high) >= 0.0:  # rounding: the zero is at the far end
        return float(times[near]), side * farthest
    exponent = brentq(logarithmic, low, high, xtol=1e-300, rtol=4.0 * np.finfo(float).eps, maxiter=500)
    return float(times[near]), side * math.exp(exponent)


def _at(modulus: RelaxationModulus, origin: float, offset: float) -> tuple[float, float]:
    """Return the modulus at x = origin + offset, and the sum of the sizes of its terms."""
    times, moduli = np.array(modulus.times), np.array(modulus.moduli)
    terms = moduli * times / ((times - origin) - offset)
    return modulus.equilibrium + float(terms.sum()), modulus.equilibrium + float(np.abs(terms).sum())
