"""How well a Kelvin-Voigt material stands for a measured or a Maxwell material over a band of frequencies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from viscorod.results.style import BLUE, GREY, INK, ORANGE, TEXT, clean, figure, heading, legend_above, write
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["KelvinVoigtFit"]

MOST = 1000.0
"""Relative error up to which the picture goes, in per cent."""


@dataclass(frozen=True, eq=False)
class KelvinVoigtFit:
    """A Kelvin-Voigt solid beside the complex modulus that it stands for.

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
        """The band, Hz, from the lowest frequency at which `error` is below `tolerance` to where it first exceeds it.

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
        return write(self.draw(), path)

    def draw(self) -> Figure:
        """The figure of :meth:`plot`."""
        picture = figure(10.0, 7.2)
        picture.suptitle(
            f"Kelvin-Voigt in {self.strain}, {self.method.replace('_', ' ')} fit",
            fontsize=TEXT + 2.0,
            x=0.01,
            ha="left",
        )
        upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(1.7, 1.0))
        clean(upper, "", "modulus [Pa]")
        for colour, name, exact, fitted in (
            (BLUE, "storage", self.exact.real, self.fitted.real),
            (ORANGE, "loss", self.exact.imag, self.fitted.imag),
        ):
            upper.plot(self.frequency, exact, color=colour, linewidth=2.0, label=f"{name}, material")
            upper.plot(
                self.frequency,
                fitted,
                color=colour,
                linewidth=1.6,
                linestyle="--",
                label=f"{name}, Kelvin-Voigt",
            )
        upper.set(xscale="log", yscale="log")
        legend_above(upper, 4)
        clean(lower, "frequency [Hz]", "relative error [%]")
        lower.plot(self.frequency, 100.0 * self.storage_error, color=BLUE, linewidth=1.6)
        lower.plot(self.frequency, 100.0 * self.loss_error, color=ORANGE, linewidth=1.6)
        lower.axhline(0.0, color=INK, linewidth=0.8)
        largest = 100.0 * max(float(np.abs(e).max()) for e in (self.storage_error, self.loss_error))
        if largest > 100.0:
            lower.set_yscale("symlog", linthresh=10.0)
            lower.set_ylim(-150.0, min(1.5 * largest, MOST))
            for value in (-10.0, 10.0):
                lower.axhline(value, color=GREY, linewidth=0.6, linestyle=":")
        elif largest > 0.0:
            lower.set_ylim(-1.1 * largest, 1.1 * largest)
        heading(lower, f"Kelvin-Voigt minus material{f' (up to {MOST:.0f} %)' if largest > MOST else ''}")
        if math.isfinite(self.band[1]):
            lower.set_xlim(*self.band)
        return picture
