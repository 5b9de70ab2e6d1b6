"""Pictures of frequency responses: size and phase over frequency, the complex plane, and both in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    SMALL,
    TEXT,
    clean,
    figure,
    heading,
    headline,
    legend_above,
)
from viscorod.results.frequency_response import FrequencyResponse, phases
from viscorod.results.text_numbers import quantity
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


__all__ = ["KINDS", "draw_response"]

KINDS = ("bode", "nyquist", "space")
COLOURS = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY)
MOST = 12
"""Responses that are drawn at most."""


def draw_response(result: FrequencyResponse, kind: str = "bode", ax: Axes | None = None) -> Figure:
    """Return the figure of all responses, at most twelve.

    Args:
        result: what is drawn; kind: see ``FrequencyResponse.plot``.
        ax: axes for one panel alone: the sizes of the first unit, or the first response.

    Raises:
        InputError: there is no such kind.
    """
    if kind not in KINDS:
        raise InputError(f"kind = {kind!r}: a response is drawn as one of {', '.join(KINDS)}")
    pairs = [(k, j) for k in range(len(result.outputs)) for j in range(len(result.inputs))]
    drawn = {"bode": _bode, "nyquist": _nyquist, "space": _space}[kind](result, pairs[:MOST], ax)
    if ax is not None:
        return within(ax)
    if result.title:
        headline(drawn, result.title)
    return drawn


def _label(result: FrequencyResponse, k: int, j: int) -> str:
    unit = result.unit(k, j)
    return f"{result.outputs[k]} over {result.inputs[j]}" + ("" if unit == "1" else f" [{unit}]")


def _units(result: FrequencyResponse, pairs: list[tuple[int, int]]) -> list[str]:
    return list(dict.fromkeys(result.unit(k, j) for k, j in pairs))


def _bode(result: FrequencyResponse, pairs: list[tuple[int, int]], ax: Axes | None) -> Figure:
    """Draw size and phase: one panel of sizes for each unit, one of all phases below."""
    units = _units(result, pairs)
    rows = len(units) + 1
    if ax is None:
        height = 1.4 + 2.6 * rows
        picture = figure(9.0, height)
        picture.subplots_adjust(top=1.0 - 0.85 / height, hspace=0.42)
    else:
        units, rows, picture = units[:1], 1, within(ax)
        pairs = [pair for pair in pairs if result.unit(*pair) == units[0]]
    hertz = result.frequencies
    logarithmic = hertz[0] > 0.0 and hertz[-1] > 8.0 * hertz[0]
    panels: list[Axes] = []
    for number in range(rows):
        axes = ax or picture.add_subplot(rows, 1, number + 1, sharex=panels[0] if panels else None)
        panels.append(axes)
        if logarithmic:
            axes.set_xscale("log")
        for s in result.poles:
            f = s.imag / (2.0 * np.pi)
            if hertz[0] <= f <= hertz[-1]:
                axes.axvline(f, color=LIGHT, linewidth=1.0, zorder=0)
    for colour, (k, j) in enumerate(pairs):
        line: dict[str, Any] = {"color": COLOURS[colour % len(COLOURS)], "linewidth": 1.5}
        line["linestyle"] = "-" if colour < len(COLOURS) else "--"
        values = result.response(k, j)
        axes = panels[units.index(result.unit(k, j))]
        axes.semilogy(
            hertz, np.maximum(np.abs(values), np.finfo(float).tiny), label=_label(result, k, j), **line
        )
        if ax is None:
            panels[-1].plot(*_with_gaps(hertz, phases(values)), **line)
    for axes, unit in zip(panels, units, strict=False):
        clean(axes, "" if ax is None else "frequency [Hz]", "size" if unit == "1" else f"size [{unit}]")
        axes.margins(x=0.0, y=0.14)
        legend_above(axes, 2)
    if ax is None:
        clean(panels[-1], "frequency [Hz]", "phase [degrees]")
        panels[-1].set_yticks(np.arange(-180, 181, 90))
        panels[-1].set_ylim(-190.0, 190.0)
        heading(panels[-1], "grey lines: poles; numbers at peaks: damping ratios by half power")
    _mark_peaks(result, pairs, units, panels)
    panels[0].set_xlim(hertz[0], hertz[-1]) if len(hertz) > 1 else None
    return picture


def _with_gaps(hertz: Floats, degrees: Floats) -> tuple[Floats, Floats]:
    """Return a curve of phases with a gap wherever they pass half a turn."""
    jumps = 1 + np.flatnonzero(np.abs(np.diff(degrees)) > 180.0)
    return np.insert(hertz, jumps, hertz[jumps]), np.insert(degrees, jumps, np.nan)


def _along(axes: Axes, hertz: float) -> float:
    """Return the place of a frequency along the axis of a panel."""
    return float(np.log10(hertz)) if axes.get_xscale() == "log" else float(hertz)


def _mark_peaks(
    result: FrequencyResponse, pairs: list[tuple[int, int]], units: list[str], panels: list[Axes]
) -> None:
    """Write at the peaks of the first response of every panel the damping ratio read off them."""
    for number, unit in enumerate(units):
        k, j = next(pair for pair in pairs if result.unit(*pair) == unit)
        width = 0.075 * (
            _along(panels[number], result.frequencies[-1]) - _along(panels[number], result.frequencies[0])
        )
        end = -np.inf
        for one in result.resonances(k, j):
            at = _along(panels[number], one.frequency)
            if (
                one.half_power is None
                or at < end
                or at + width > _along(panels[number], result.frequencies[-1])
            ):
                continue  # it would lie on the one before, or beyond the edge
            end = at + width
            panels[number].annotate(
                f"{100.0 * one.half_power:.3g} %",
                (one.frequency, one.amplitude),
                xytext=(4, 2),
                textcoords="offset points",
                fontsize=SMALL - 1.0,
                color=GREY,
            )


def _nyquist(result: FrequencyResponse, pairs: list[tuple[int, int]], ax: Axes | None) -> Figure:
    """Draw the responses in the complex plane, one panel each."""
    pairs = pairs if ax is None else pairs[:1]
    columns = min(3, len(pairs))
    rows = -(-len(pairs) // columns)
    if ax is None:
        picture = figure(1.0 + 4.4 * columns, 1.2 + 4.2 * rows)
        picture.subplots_adjust(hspace=0.4, wspace=0.35)
    else:
        picture = within(ax)
    for number, (k, j) in enumerate(pairs):
        axes = ax or picture.add_subplot(rows, columns, number + 1)
        values, unit = result.response(k, j), result.unit(k, j)
        axes.plot(values.real, values.imag, color=COLOURS[number % len(COLOURS)], linewidth=1.4)
        told: list[complex] = []
        largest = float(np.abs(values).max())
        for one in result.resonances(k, j):
            at = int(np.argmin(np.abs(result.frequencies - one.frequency)))
            if abs(values[at]) > 0.05 * largest:
                close = any(abs(values[at] - other) < 0.15 * largest for other in told)
                told.append(complex(values[at]))
                axes.plot(values[at].real, values[at].imag, "o", color=GREY, markersize=4)
                axes.annotate(
                    "" if close else quantity(one.frequency, "Hz", 4),
                    (values[at].real, values[at].imag),
                    xytext=(5, 5),
                    textcoords="offset points",
                    fontsize=SMALL,
                    bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6},
                )
        text = "" if unit == "1" else f" [{unit}]"
        clean(axes, f"real part{text}", f"imaginary part{text}")
        axes.set_aspect("equal", adjustable="datalim")
        heading(axes, f"{result.outputs[k]} over {result.inputs[j]}")
    return picture


def _space(result: FrequencyResponse, pairs: list[tuple[int, int]], ax: Axes | None) -> Figure:
    """Draw real and imaginary part over frequency in three dimensions, one panel each."""
    if ax is not None and ax.name != "3d":
        raise InputError("ax: kind = 'space' needs axes in space; make them with projection='3d'")
    pairs = pairs if ax is None else pairs[:1]
    columns = min(2, len(pairs))
    rows = -(-len(pairs) // columns)
    picture = figure(1.0 + 6.0 * columns, 1.0 + 5.0 * rows) if ax is None else within(ax)
    for number, (k, j) in enumerate(pairs):
        axes: Any = ax or picture.add_subplot(rows, columns, number + 1, projection="3d")
        values, unit, hertz = result.response(k, j), result.unit(k, j), result.frequencies
        colour = COLOURS[number % len(COLOURS)]
        axes.plot(hertz, values.real, values.imag, color=colour, linewidth=1.4)
        low = float(values.imag.min()) - 0.05 * float(np.ptp(values.imag))
        axes.plot(hertz, values.real, np.full(len(hertz), low), color=GREY, linewidth=0.7)
        text = "" if unit == "1" else f" [{unit}]"
        axes.set_xlabel("frequency [Hz]", fontsize=SMALL)
        axes.set_ylabel(f"real part{text}", fontsize=SMALL, labelpad=10.0)
        axes.set_zlabel(f"imaginary part{text}", fontsize=SMALL, labelpad=14.0)
        axes.zaxis.set_tick_params(pad=6.0)
        axes.tick_params(labelsize=SMALL - 1.0)
        axes.view_init(elev=22.0, azim=-60.0)
        axes.set_title(_label(result, k, j), loc="left", fontsize=TEXT)
    return picture
