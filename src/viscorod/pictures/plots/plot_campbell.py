"""Pictures of modes that were followed: frequencies and damping ratios over the speed or the load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
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
from viscorod.results.text_numbers import above_rounding
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.campbell import Campbell
    from viscorod.results.followed_modes import FollowedModes
    from viscorod.results.stability_result import Stability

__all__ = ["draw_campbell", "draw_stability"]

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, "#7a5c00", "#005f46", "#444444")
ROUND = 0.9
"""Whirl from which on it is marked."""
MARKS = 9
"""Marks of whirl on a line."""
APART = 0.042
"""Least distance of two labels, as a part of the height of a panel."""
TINY = float(np.finfo(float).tiny)
OVERDAMPED = 0.9
"""Damping ratio from which on a mode may leave the picture."""


def draw_campbell(result: Campbell, ax: Axes | None = None) -> Figure:
    """Return the figure of a Campbell diagram; into ``ax`` go the frequencies alone."""
    picture, above = followed_panels(result, "angular speed [rad/s]", ax=ax)
    speeds, f = result.speeds, result.frequencies
    top = above.get_ylim()[1]
    for order in result.engine_orders:
        line = order * speeds / (2.0 * np.pi)
        above.plot(speeds, line, color=GREY, linewidth=1.0, linestyle=(0, (6, 3)), zorder=1)
        reached = min(float(speeds[-1]), 2.0 * np.pi * top / order)
        above.annotate(
            f"{order:g}x",
            (0.97 * reached, 0.97 * reached * order / (2.0 * np.pi)),
            xytext=(0, 3),
            textcoords="offset points",
            fontsize=SMALL - 1.0,
            color=GREY,
            ha="right",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6},
            zorder=5,
        )
    above.set_ylim(0.0, top)
    _mark_whirl(result, above, f)
    critical = result.critical_speeds
    if critical:
        above.plot(
            [one.speed for one in critical],
            [one.frequency for one in critical],
            "o",
            color=INK,
            markersize=6.5,
            markerfacecolor="white",
            markeredgewidth=1.4,
            label="critical speed",
            zorder=6,
        )
    if above.get_legend_handles_labels()[1]:
        legend_above(above, 4)
    if ax is not None:
        return within(ax)
    _in_turns(picture)
    seen = "on the model that turns" if result.frame == "turning" else "from space"
    picture.text(0.01, 0.012, f"frequencies as seen {seen}", fontsize=SMALL - 0.5, color=GREY)
    return picture


def _in_turns(picture: Figure) -> None:
    """Add the angular speed in turns per minute under that in rad/s."""
    below = picture.axes[-1]
    turns = below.secondary_xaxis("bottom", functions=(_per_minute, _per_second))
    turns.spines["bottom"].set_position(("outward", 40.0))
    turns.set_xlabel("[rpm]", fontsize=TEXT)
    turns.tick_params(labelsize=SMALL, colors=INK)
    picture.subplots_adjust(bottom=0.165)


def _per_minute(speed: ArrayLike) -> Floats:
    return np.asarray(speed, dtype=float) * (30.0 / np.pi)


def _per_second(turning: ArrayLike) -> Floats:
    return np.asarray(turning, dtype=float) * (np.pi / 30.0)


def draw_stability(result: Stability, ax: Axes | None = None) -> Figure:
    """Return the figure of stability along a load; into ``ax`` go the frequencies alone."""
    picture = followed_panels(result, "load factor", growth=True, ax=ax)[0]
    return picture if ax is None else within(ax)


def followed_panels(
    result: FollowedModes, along: str, *, growth: bool = False, ax: Axes | None = None
) -> tuple[Figure, Axes]:
    """Return a figure with frequencies above and damping ratios, or rates of ``growth``, below; and the upper panel.

    Into ``ax`` go the frequencies alone.
    """
    if ax is None:
        picture = figure(9.5, 8.2)
        picture.subplots_adjust(right=0.87, top=0.9 if result.title else 0.945, hspace=0.14, bottom=0.095)
        above = picture.add_subplot(2, 1, 1)
        panels = [above, picture.add_subplot(2, 1, 2, sharex=above)]
    else:
        picture, above, panels = within(ax), ax, [ax]
    values, f = result.values, result.frequencies
    if growth:
        size = np.maximum(np.abs(result.eigenvalues), TINY)
        shown = above_rounding(result.eigenvalues.real / size) * size
    else:
        shown = 100.0 * above_rounding(result.damping_ratios)
    for axes, curves in zip(panels, (f, shown), strict=False):
        for k in range(len(result.modes)):
            line: dict[str, Any] = {"color": COLOURS[k % len(COLOURS)], "linewidth": 1.6}
            dashes = "-" if k < len(COLOURS) else (0, (5, 2))
            axes.plot(values, curves[:, k], linestyle=dashes, **line)
    clean(above, along if ax is not None else "", "frequency [Hz]")
    above.set_xlim(values[0], values[-1])
    above.set_ylim(0.0, 1.06 * float(f.max()) or 1.0)
    if ax is None:
        below = panels[-1]
        clean(below, along, "growth rate Re s [1/s]" if growth else "damping ratio [%]")
        above.tick_params(labelbottom=False)
        below.set_ylim(*_range(shown, result.damping_ratios))
        below.axhline(0.0, color=INK, linewidth=0.8)
        if (result.eigenvalues.real > 1e-7 * np.abs(result.eigenvalues)).any():
            heading(below, f"{'above' if growth else 'below'} zero: it grows")
        if result.title:
            headline(picture, result.title)
    for number, one in enumerate(result.limits):
        for axes in panels:
            axes.axvline(one.at, color=RED, linewidth=1.2, linestyle=(0, (1, 1.5)), zorder=1)
        above.plot(
            one.at,
            one.frequency,
            "X",
            color=RED,
            markersize=8,
            zorder=7,
            label="limit of stability" if number == 0 else "_",
        )
    _names(result, above, f[-1])
    if above.get_legend_handles_labels()[1]:
        legend_above(above, 4)
    return picture, above


def _range(shown: Floats, ratios: Floats) -> tuple[float, float]:
    """Return the ends of an axis on which zero and what is not overdamped is seen."""
    mild = shown[np.abs(ratios) < OVERDAMPED]
    low, high = (float(end) for end in (min(mild.min(initial=0.0), 0.0), max(mild.max(initial=0.0), 0.0)))
    if not mild.size or high - low <= 1e-9 * float(np.abs(shown).max(initial=0.0)):
        low, high = min(float(shown.min()), 0.0), max(float(shown.max()), 0.0)
    margin = 0.08 * (high - low) or 1.0
    return low - margin, high + margin


def _names(result: FollowedModes, axes: Axes, ends: Floats) -> None:
    """Write the names of the modes beside the ends of their lines, moved apart where they would overlap."""
    low, high = axes.get_ylim()
    order = np.argsort(ends, kind="stable")
    places = (ends[order] - low) / (high - low)
    for k in range(1, len(places)):
        places[k] = max(places[k], places[k - 1] + APART)
    if len(places) and places[-1] > 1.0:  # from the top down
        places[-1] = 1.0
        for k in range(len(places) - 2, -1, -1):
            places[k] = min(places[k], places[k + 1] - APART)
    for place, mode in zip(places, order, strict=True):
        axes.annotate(
            result.modes[mode],
            (1.0, (ends[mode] - low) / (high - low)),
            xycoords="axes fraction",
            xytext=(1.018, float(place)),
            textcoords="axes fraction",
            fontsize=SMALL - 1.0,
            color=COLOURS[mode % len(COLOURS)],
            va="center",
            annotation_clip=False,
            arrowprops={
                "arrowstyle": "-",
                "color": "#bbbbbb",
                "linewidth": 0.6,
                "shrinkA": 0,
                "shrinkB": 0,
                "relpos": (0.0, 0.5),  # to the beginning of the name: to its middle it would cross others
            },
        )


def _mark_whirl(result: Campbell, axes: Axes, f: Floats) -> None:
    """Mark lines with triangles upwards where a mode goes with the spin, downwards where it goes against it."""
    speeds, whirl = result.speeds, result.whirl
    spacing = (len(speeds) - 1) / MARKS
    for way, mark, label in ((1.0, "^", "forward whirl"), (-1.0, "v", "backward whirl")):
        named = False
        first = (0.75 if way > 0.0 else 0.25) * spacing  # lines of both may lie upon each other
        where = np.unique((first + spacing * np.arange(MARKS)).round().astype(int))
        for k in range(whirl.shape[1]):
            there = where[way * whirl[where, k] > ROUND]
            if not len(there):
                continue
            axes.plot(
                speeds[there],
                f[there, k],
                mark,
                color=COLOURS[k % len(COLOURS)],
                markersize=5.0,
                zorder=4,
            )
            if not named:
                axes.plot([], [], mark, color=GREY, markersize=5.0, label=label)
                named = True
