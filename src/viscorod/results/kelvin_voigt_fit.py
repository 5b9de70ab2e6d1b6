"""Fit of a Kelvin-Voigt material to a measured or a Maxwell material over a band of frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from viscorod.typing import Floats

__all__ = ["KelvinVoigtFit"]


@dataclass(frozen=True, eq=False)
class KelvinVoigtFit:
    """A Kelvin-Voigt solid and the complex modulus to which it is fitted.

    Attributes:
        strain: "extension" or "shear".
        method: "best" over the band, or "low_frequency".
        modulus: of the Kelvin-Voigt solid, Pa.
        viscosity: Pa s.
        frequency: at which the two are compared (n,), Hz.
        exact: complex modulus at these frequencies (n,), Pa.
    """

    strain: str
    method: str
    modulus: float
    viscosity: float
    frequency: Floats
    exact: npt.NDArray[np.complex128]

    @property
    def time(self) -> float:
        """Retardation time, viscosity over modulus, s."""
        return self.viscosity / self.modulus

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency of the comparison, Hz."""
        return float(self.frequency[0]), float(self.frequency[-1])

    @property
    def fitted(self) -> npt.NDArray[np.complex128]:
        """Complex modulus of the Kelvin-Voigt solid (n,), Pa."""
        return np.asarray(self.modulus + 2j * np.pi * self.frequency * self.viscosity, dtype=np.complex128)

    @property
    def storage_error(self) -> Floats:
        """Relative error of the storage modulus (n,)."""
        return np.asarray(self.fitted.real / self.exact.real - 1.0)

    @property
    def loss_error(self) -> Floats:
        """Relative error of the loss modulus (n,); over the whole modulus where there is no loss."""
        scale = np.where(self.exact.imag > 0.0, self.exact.imag, np.abs(self.exact))
        return np.asarray((self.fitted.imag - self.exact.imag) / scale)

    @property
    def error(self) -> Floats:
        """Relative error of the complex modulus, ``|fit - exact|/|exact|`` (n,)."""
        return np.asarray(np.abs(self.fitted - self.exact) / np.abs(self.exact))

    def band_within(self, tolerance: float) -> tuple[float, float] | None:
        """Return the band, Hz, from the lowest frequency with an `error` below `tolerance` to where it exceeds it.

        None if it holds nowhere.
        """
        good = self.error <= tolerance
        if not good.any():
            return None
        first = int(np.argmax(good))
        bad = np.flatnonzero(~good[first:])
        last = first + int(bad[0]) - 1 if bad.size else len(good) - 1
        return float(self.frequency[first]), float(self.frequency[last])

    def __str__(self) -> str:
        low, high = self.band
        storage, loss = (100.0 * float(np.abs(e).max()) for e in (self.storage_error, self.loss_error))
        return (
            f"Kelvin-Voigt in {self.strain}: modulus {self.modulus:.4g} Pa, retardation time {self.time:.4g} s "
            f"({self.method.replace('_', ' ')} fit). From {low:.4g} to {high:.4g} Hz the storage modulus is wrong by "
            f"{storage:.2g} % at most, the loss modulus by {loss:.2g} %."
        )

    def plot(self, path: str | Path) -> Path:
        """Draw storage and loss modulus of both over frequency, and the relative errors; returns the path."""
        from viscorod.pictures.plots.plot_kelvin_voigt_fit import draw_fit
        from viscorod.pictures.style import write

        return write(draw_fit(self), path)
