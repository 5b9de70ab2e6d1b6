"""The picture of a free decay: samples with the fit, what is left over, and the damping ratio over the amplitude."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import BLUE, GREY, INK, ORANGE, clean, figure, heading, headline, legend_above
from viscorod.results.text_numbers import scaled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.decay_result import Decay

__all__ = ["draw_decay"]


def draw_decay(decay: Decay, ax: Axes | None = None) -> Figure:
    """Draw a free decay; into ``ax`` go the samples and what was fitted alone."""
    if ax is not None:
        _samples(ax, decay)
        ax.set_xlabel("time [s]")
        return within(ax)
    picture = figure(10.0, 8.6)
    headline(picture, f"Free decay{f' of {decay.title}' if decay.title else ''}")
    rows = picture.add_gridspec(2, 1, height_ratios=(1.6, 1.0), hspace=0.32)
    grid = rows[0].subgridspec(2, 1, height_ratios=(2.0, 1.0), hspace=0.12)
    lower = rows[1].subgridspec(1, 2, wspace=0.24)
    data = {name: np.asarray(decay.data[name].values, dtype=float) for name in decay.variables()}
    time = data["time"]
    upper = picture.add_subplot(grid[0])
    factor, unit = _samples(upper, decay)
    upper.tick_params(labelbottom=False)
    middle = picture.add_subplot(grid[1], sharex=upper)
    left = data["value"] - data["model"]
    small, small_unit = scaled(decay.unit, left) if decay.unit else (1.0, "")
    clean(middle, "time [s]", f"left over [{small_unit}]" if small_unit else "left over")
    middle.plot(time, small * left, color=INK, linewidth=0.7)
    middle.set_xlim(time[0], time[-1])
    _by_amplitude(picture.add_subplot(lower[0]), data, factor, unit, 100.0, "damping ratio [%]")
    _by_amplitude(picture.add_subplot(lower[1]), data, factor, unit, 1.0, "frequency [Hz]")
    return picture


def _samples(axes: Axes, decay: Decay) -> tuple[float, str]:
    """Draw the samples, the damped sines and the rest; return factor and unit of their values."""
    value, model, rest, time = (
        np.asarray(decay.data[name].values, dtype=float) for name in ("value", "model", "rest", "time")
    )
    factor, unit = scaled(decay.unit, value - rest) if decay.unit else (1.0, "")
    clean(axes, "", f"value [{unit}]" if unit else "value")
    axes.plot(time, factor * value, ".", color=GREY, markersize=4.0, label="samples")
    axes.plot(time, factor * model, color=BLUE, linewidth=1.3, label="damped sines")
    axes.plot(time, factor * rest, color=ORANGE, linewidth=1.3, label="rest")
    legend_above(axes, 3)
    return factor, unit


def _by_amplitude(
    axes: object, data: dict[str, np.ndarray], factor: float, unit: str, scale: float, what: str
) -> None:
    """Draw the ratio or frequency of the pieces with intervals, and that of the whole record as a band."""
    from matplotlib.axes import Axes

    assert isinstance(axes, Axes)
    ratio = what.startswith("damping")
    piece, whole = ("ratio", "damping_ratio") if ratio else ("frequency", "frequency")
    clean(axes, f"amplitude [{unit}]" if unit else "amplitude", what)
    axes.errorbar(
        factor * data["piece_amplitude"],
        scale * data[f"piece_{piece}"],
        scale * data[f"piece_{piece}_width"],
        fmt="o",
        color=BLUE,
        markersize=4.0,
        capsize=3.0,
    )
    value, width = scale * data[whole][0], scale * data[f"{whole}_width"][0]
    axes.axhspan(value - width, value + width, color=ORANGE, alpha=0.25, linewidth=0.0)
    axes.axhline(value, color=ORANGE, linewidth=1.3)
    heading(axes, "pieces, and all samples as one (orange), 95 %")
    if len(data["piece_amplitude"]) and data["piece_amplitude"].min() > 0.0:
        from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        axes.xaxis.set_minor_formatter(NullFormatter())
