"""The picture of a modal fit: sizes of the responses with their modes, and damping ratios over the frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    clean,
    figure,
    heading,
    headline,
    legend_above,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.modal_fit_result import ModalFit

__all__ = ["draw_modal_fit"]


def draw_modal_fit(fit: ModalFit, ax: Axes | None = None) -> Figure:
    """Draw a modal fit; into ``ax`` go the responses alone."""
    if ax is not None:
        _responses(ax, fit)
        ax.set_xlabel("frequency [Hz]")
        return within(ax)
    picture = figure(10.0, 7.2)
    headline(picture, fit.title or "Modes of measured responses")
    upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(1.4, 1.0))
    _responses(upper, fit)
    _ratios(lower, fit)
    return picture


def _responses(upper: Axes, fit: ModalFit) -> None:
    """Draw the size of the responses, with the frequencies of the modes."""
    hertz = fit.data["line_frequency"].values
    parts = fit.data["response"].values
    clean(upper, "", "size of the response")
    shown = hertz > 0.0
    for k, name in enumerate(fit.data["record_name"].values):
        size = np.hypot(parts[k, :, 0], parts[k, :, 1])
        colour = (BLUE, GREEN, PURPLE, GREY)[k % 4]
        upper.plot(hertz[shown], size[shown], color=colour, linewidth=1.0, label=str(name))
    for frequency in fit.frequencies:
        upper.axvline(frequency, color=ORANGE, linewidth=1.0, linestyle="--", zorder=0.5)
    upper.set_yscale("log")
    legend_above(upper, 4)


def _ratios(lower: Axes, fit: ModalFit) -> None:
    """Draw the damping ratios with their intervals."""
    clean(lower, "frequency [Hz]", "damping ratio [%]")
    width = fit.data["damping_ratio_width"].values
    lower.errorbar(
        fit.frequencies,
        100.0 * fit.damping_ratios,
        100.0 * width,
        fmt="o",
        color=ORANGE,
        markersize=4.5,
        capsize=3.0,
    )
    lower.set_ylim(bottom=0.0)
    heading(lower, "pole fits, 95 %")
