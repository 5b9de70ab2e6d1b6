"""Periodic functions by their values at equally spaced phases, which trigonometric polynomials pass through.

With ``2 H + 1`` phases the harmonics 0 to H are known. The derivative of the polynomial is exact, ``D`` (Trefethen,
Spectral Methods in MATLAB, 2000, chapter 3), so that derivatives of smooth periodic functions converge faster than any
power of H; where H harmonics resolve a motion this is harmonic balance with as many samples as unknowns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.typing import Floats

__all__ = ["Fourier"]


@dataclass(frozen=True)
class Fourier:
    """Trigonometric polynomials.

    Attributes:
        harmonics: H.
    """

    harmonics: int

    @property
    def count(self) -> int:
        """Number of phases, ``2 H + 1``."""
        return 2 * self.harmonics + 1

    @property
    def phases(self) -> Floats:
        """Phases ``(N,)`` [rad]."""
        return 2.0 * np.pi * np.arange(self.count) / self.count

    def derivative(self) -> Floats:
        """Return ``D (N, N)``: derivatives by the phase from values."""
        k = np.arange(self.count)
        apart = k[:, None] - k[None, :]
        with np.errstate(divide="ignore"):
            D = 0.5 * (-1.0) ** apart / np.sin(np.pi * apart / self.count)
        np.fill_diagonal(D, 0.0)
        return np.asarray(D)

    def at(self, phases: Floats) -> Floats:
        """Return weights ``(k, N)`` of the values for those at other ``phases (k,)`` [rad]."""
        apart = np.asarray(phases)[:, None] - self.phases[None, :]
        waves = np.cos(np.arange(1, self.harmonics + 1)[:, None, None] * apart)
        return np.asarray((1.0 + 2.0 * waves.sum(axis=0)) / self.count)

    def coefficients(self, values: Floats) -> np.ndarray:
        """Return ``c (H + 1, ...)`` of ``Re sum_k c_k exp(i k phase)`` from values ``(N, ...)``."""
        found = np.fft.rfft(values, axis=0) / self.count
        found[1:] *= 2.0
        return np.asarray(found)
