"""The pictures of an identification: data and model, residuals, intervals, correlation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    MINUS,
    ORANGE,
    RED,
    SMALL,
    clean,
    figure,
    heading,
    headline,
)
from viscorod.results.text_numbers import per_cent
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.identification import Identification

__all__ = ["draw_autocorrelation", "draw_correlation", "draw_identification", "draw_intervals"]

MOST_PANELS = 8
"""Series that are drawn at most."""
WIDE = 30.0
"""Ratio of frequencies from which on they are drawn by their logarithms."""
FEW = 40
"""Values of a series up to which each has a mark of its own."""
WIDEST = 100.0
"""Relative half width of an interval, in per cent, up to which it is drawn to scale."""


def draw_identification(fit: Identification, ax: Axes | None = None) -> Figure:
    """Draw every series, measured and predicted over each other, with the residuals beside.

    Into ``ax`` goes the first series alone.
    """
    data = fit.data
    listed = [
        k for k in range(data.sizes["series"]) if not str(data["series"].values[k]).endswith(" beforehand")
    ]
    listed = listed[:MOST_PANELS]
    if ax is not None:
        _series(fit, listed[0], ax, None)
        ax.legend()
        return within(ax)
    height = 1.0 + 2.3 * len(listed)
    picture = figure(11.0, height)
    picture.subplots_adjust(
        hspace=0.62, wspace=0.3, left=0.085, right=0.985, top=1.0 - 0.85 / height, bottom=0.62 / height
    )
    if fit.title:
        headline(picture, fit.title)
    panels = picture.subplots(len(listed), 2, squeeze=False, width_ratios=(1.6, 1.0))
    for row, k in zip(panels, listed, strict=True):
        _series(fit, k, row[0], row[1])
    panels[0][0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, fontsize=SMALL)
    return picture


def _series(fit: Identification, k: int, left: Axes, right: Axes | None) -> None:
    """Draw series ``k``: measured and predicted values on the left, what is left over on the right."""
    data = fit.data
    mine = data["series_of"].values == k
    place, measured, predicted, deviation = (
        data[name].values[mine] for name in ("place", "measured", "predicted", "deviation")
    )
    unit, of_unit = str(data["place_unit"].values[k]), str(data["quantity_unit"].values[k])
    along = {"s": "time [s]", "Hz": "frequency [Hz]", "N": "load"}.get(unit, "mode")
    of_unit = f" [{of_unit}]" if of_unit not in ("", "1") else ""
    names = str(data["quantity"].values[k]).split(", ")
    pieces = np.split(np.arange(len(place)), np.flatnonzero(np.diff(place) <= 0.0) + 1)
    marks = len(place) <= FEW
    clean(left, along, (names[0] if len(pieces) == 1 else "measured") + of_unit)
    heading(left, str(data["series"].values[k]))
    panels = (left,) if right is None else (left, right)
    if unit == "Hz" and place.min() > 0.0 and place.max() > WIDE * place.min():
        for axes in panels:
            axes.set_xscale("log")
    for number, piece in enumerate(pieces):
        of_piece = f", {names[number]}" if len(pieces) > 1 and number < len(names) else ""
        _fit(left, place[piece], measured[piece], predicted[piece], number, f"model{of_piece}", marks=marks)
    if right is not None:
        clean(right, along, f"measured - model{of_unit}")
        for number, piece in enumerate(pieces):
            rest = (measured - predicted)[piece]
            _left_over(right, place[piece], rest, 1.96 * deviation[piece], number, marks=marks)
        right.axhline(0.0, color=INK, linewidth=0.7)
    if len(pieces) > 1:
        left.legend(loc="upper left", frameon=False, fontsize=SMALL)
    for axes in panels:
        axes.ticklabel_format(axis="y", scilimits=(-3, 4))
        if unit == "" and marks:
            axes.set_xticks(place[:: max(len(place) // 10, 1)])


def _fit(
    axes: Axes, place: Floats, measured: Floats, predicted: Floats, number: int, label: str, *, marks: bool
) -> None:
    """Draw measured and predicted values of piece ``number`` of a series, as ``marks`` if they are few."""
    axes.plot(
        place,
        measured,
        color=GREY,
        linestyle="none" if marks else "-",
        marker="o" if marks else ".",
        markersize=6.0,
        linewidth=0.6,
        label="" if number else "measured",
    )
    axes.plot(
        place,
        predicted,
        color=GREEN if number else BLUE,
        linewidth=1.0,
        linestyle="none" if marks else _line(number),
        marker="x" if marks else "",
        markersize=7.0,
        label=label,
    )


def _left_over(axes: Axes, place: Floats, rest: Floats, band: Floats, number: int, *, marks: bool) -> None:
    """Draw what is left over of piece ``number`` of a series, and the band in which its noise is."""
    axes.plot(
        place,
        rest,
        color=ORANGE,
        linewidth=0.9,
        linestyle="none" if marks else _line(number),
        marker="o" if marks else "",
        markersize=4.0,
    )
    axes.fill_between(place, -band, band, color=BLUE, alpha=0.13, linewidth=0.0)


def _line(number: int) -> str:
    return "--" if number else "-"


def draw_intervals(fit: Identification) -> Figure:
    """Draw the intervals of all told numbers as parts of their values; those not told as lines without ends."""
    numbers = [*fit.numbers.values(), *fit.combinations.values()]
    own = len(fit.numbers)
    picture = figure(11.0, 1.1 + 0.36 * len(numbers))
    axes = picture.subplots()
    picture.subplots_adjust(left=0.44, right=0.97, top=0.99, bottom=0.62 / (1.1 + 0.36 * len(numbers)))
    clean(axes, f"interval of {per_cent(100.0 * fit.level, 4)}, in % of the value", "")
    widest = 0.0
    for row, one in enumerate(numbers):
        colour = BLUE if row < own else ORANGE
        size = abs(one.value) or 1.0
        if one.told:
            low, high = (100.0 * (end - one.value) / size for end in (one.low, one.high))
            for end, outwards in ((low, -1.0), (high, 1.0)):
                if outwards * end > WIDEST:
                    _beyond(axes, outwards * WIDEST, row, end, colour)
            low, high = max(low, -WIDEST), min(high, WIDEST)
            widest = max(widest, -low, high)
            axes.plot([low, high], [row, row], color=colour, linewidth=3.0, solid_capstyle="butt")
        axes.plot([0.0], [row], marker="|", markersize=10.0, color=INK)
    widest = 1.15 * widest or 1.0
    for row, one in enumerate(numbers):
        if not one.told:
            axes.plot([-widest, widest], [row, row], color=RED, linewidth=1.2, linestyle=":")
            axes.text(widest, row, "not told ", ha="right", va="bottom", fontsize=SMALL, color=RED)
    axes.set_xlim(-widest, widest)
    axes.set_ylim(len(numbers) - 0.5, -0.7)
    axes.set_yticks(range(len(numbers)), [_in_lines(one.name) for one in numbers], fontsize=SMALL)
    axes.grid(visible=False, axis="y")
    return picture


def _beyond(axes: Axes, at: float, row: int, end: float, colour: str) -> None:
    """Draw an arrow where an interval leaves the picture, and write where it ends."""
    axes.plot([at], [row], marker=">" if at > 0.0 else "<", markersize=7.0, color=colour, clip_on=False)
    axes.text(
        at,
        row - 0.12,
        per_cent(end, 3).replace("-", MINUS),
        ha="right" if at > 0.0 else "left",
        va="bottom",
        fontsize=SMALL,
        color=INK,
    )


def draw_correlation(fit: Identification) -> Figure:
    """Draw the correlation of all unknowns as a table of colours with numbers."""
    names, matrix = list(fit.numbers), fit.correlation
    size = 2.2 + 0.62 * len(names)
    picture = figure(max(size + 3.6, 6.0), size)
    axes = picture.subplots()
    width = max(size + 3.6, 6.0)
    picture.subplots_adjust(left=3.9 / width, right=0.98, top=0.98, bottom=0.5 / size)
    axes.imshow(matrix, cmap="RdBu", vmin=-1.0, vmax=1.0, aspect="auto")
    for row in range(len(names)):
        for column in range(len(names)):
            value = float(matrix[row, column])
            colour = "white" if abs(value) > 0.6 else INK
            axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=SMALL, color=colour)
    numbered = [f"{_in_lines(name)}  {k + 1}" for k, name in enumerate(names)]
    axes.set_yticks(range(len(names)), numbered, fontsize=SMALL)
    axes.set_xticks(range(len(names)), [str(k + 1) for k in range(len(names))], fontsize=SMALL)
    axes.tick_params(length=0.0)
    return picture


def _in_lines(name: str) -> str:
    """Return the name of several numbers that are one, each in a line of its own."""
    return name.replace(", ", ",\n")


def draw_autocorrelation(fit: Identification) -> Figure | None:
    """Draw the autocorrelation of what is left of every history, before and after its own past is taken out."""
    data = fit.data
    listed = [k for k in range(data.sizes["series"]) if data["whiteness"].values[k] < 1.0][:MOST_PANELS]
    if not listed:
        return None
    height = 0.9 + 1.7 * len(listed)
    picture = figure(11.0, height)
    picture.subplots_adjust(
        hspace=0.75, left=0.085, right=0.985, top=1.0 - 0.5 / height, bottom=0.62 / height
    )
    panels = picture.subplots(len(listed), 1, squeeze=False)
    for (axes,), k in zip(panels, listed, strict=True):
        mine = data["series_of"].values == k
        count = int(mine.sum())
        lags = np.arange(1, min(60, count // 3) + 1)
        clean(axes, "samples apart", "autocorrelation")
        heading(axes, str(data["series"].values[k]))
        limit = 1.96 / np.sqrt(count)
        axes.axhspan(-limit, limit, color=GREY, alpha=0.2, linewidth=0.0)
        shown = [(fit.residuals[mine], ORANGE, "of what is left")]
        if data["noise_order"].values[k]:  # without it both are the same
            shown.append((data["white"].values[mine], BLUE, "once its own past is taken out"))
        for values, colour, label in shown:
            axes.plot(
                lags, _autocorrelation(values, lags), color=colour, marker=".", linewidth=0.8, label=label
            )
        axes.axhline(0.0, color=INK, linewidth=0.7)
        axes.set_ylim(-1.05, 1.05)
    named = {
        label: line
        for (axes,) in panels
        for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    panels[0][0].legend(
        named.values(),
        named.keys(),
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=2,
        frameon=False,
        fontsize=SMALL,
    )
    return picture


def _autocorrelation(values: Floats, lags: np.ndarray) -> Floats:
    size = float(values @ values) or 1.0
    return np.array([float(values[:-lag] @ values[lag:]) / size for lag in lags])
