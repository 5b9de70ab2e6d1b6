"""The picture of a Kelvin-Voigt fit: storage and loss modulus of fit and material over frequency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import BLUE, GREY, INK, ORANGE, clean, figure, heading, headline, legend_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.analyses.kelvin_voigt_fit import KelvinVoigtFit

__all__ = ["draw_fit"]

MOST = 1000.0
"""Relative error up to which the picture goes, in per cent."""


def draw_fit(fit: KelvinVoigtFit, ax: Axes | None = None) -> Figure:
    """Draw storage and loss modulus of both over frequency, and the relative errors.

    Into ``ax`` go the moduli alone.
    """
    if ax is not None:
        _moduli(ax, fit)
        ax.set_xlabel("frequency [Hz]")
        return within(ax)
    picture = figure(10.0, 7.2)
    headline(picture, f"Kelvin-Voigt in {fit.strain}, {fit.method.replace('_', ' ')} fit")
    upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(1.7, 1.0))
    _moduli(upper, fit)
    _errors(lower, fit)
    return picture


def _moduli(upper: Axes, fit: KelvinVoigtFit) -> None:
    """Draw storage and loss modulus of both."""
    clean(upper, "", "modulus [Pa]")
    for colour, name, exact, fitted in (
        (BLUE, "storage", fit.exact.real, fit.fitted.real),
        (ORANGE, "loss", fit.exact.imag, fit.fitted.imag),
    ):
        upper.plot(fit.frequency, exact, color=colour, linewidth=2.0, label=f"{name}, material")
        upper.plot(
            fit.frequency,
            fitted,
            color=colour,
            linewidth=1.6,
            linestyle="--",
            label=f"{name}, Kelvin-Voigt",
        )
    upper.set(xscale="log", yscale="log")
    legend_above(upper, 4)


def _errors(lower: Axes, fit: KelvinVoigtFit) -> None:
    """Draw the relative errors."""
    clean(lower, "frequency [Hz]", "relative error [%]")
    lower.plot(fit.frequency, 100.0 * fit.storage_error, color=BLUE, linewidth=1.6)
    lower.plot(fit.frequency, 100.0 * fit.loss_error, color=ORANGE, linewidth=1.6)
    lower.axhline(0.0, color=INK, linewidth=0.8)
    largest = 100.0 * max(float(np.abs(e).max()) for e in (fit.storage_error, fit.loss_error))
    if largest > 100.0:
        lower.set_yscale("symlog", linthresh=10.0)
        lower.set_ylim(-150.0, min(1.5 * largest, MOST))
        for value in (-10.0, 10.0):
            lower.axhline(value, color=GREY, linewidth=0.6, linestyle=":")
    elif largest > 0.0:
        lower.set_ylim(-1.1 * largest, 1.1 * largest)
    heading(lower, f"Kelvin-Voigt minus material{f' (up to {MOST:.0f} %)' if largest > MOST else ''}")
    if math.isfinite(fit.band[1]):
        lower.set_xlim(*fit.band)
