"""Pictures of strains and section forces: along the rods, over time, and over both."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    SMALL,
    clean,
    colour_bar,
    heading,
    legend_above,
    time_colours,
    titled,
)
from viscorod.results.array_pieces import extremes, largest
from viscorod.results.components import STRAINS, Component, chosen_component
from viscorod.results.run import Run
from viscorod.results.text_numbers import quantity, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.result import Result

_INSTANTS, _ALONG = 9, 120  # profiles, points along a rod
_TIMES, _PLACES = 600, 120  # of an image
_MOST_RODS = 4  # below each other

_ROUND_OFF = 1e-12
"""Strains, and turns along a whole rod [rad], that are none."""
_LEVELS = {"load_factor": "load factor", "spin": "angular speed [rad/s]"}
_AT = {"load_factor": ("load factor", ""), "spin": ("at", "rad/s"), "time": ("at", "s")}
"""What is said of the only state that there is, and the unit of its level."""


def draw_strain(
    result: Result, component: str | None = None, rod: str | None = None, ax: Axes | None = None
) -> Figure:
    """Return the figure of the strains: the largest of every component over time, and one of them along a rod.

    Args:
        result: a run, or load factors of an equilibrium.
        component: "shear_1", "shear_2", "stretch", "bend_1", "bend_2" or "twist"; by default what changes most.
        rod: by default the one where it changes most.
        ax: axes for the profiles along the rod alone.
    """
    shown = chosen_component(result, "strain", component)
    rod = rod or _busiest(result, shown, 1)[0]
    if ax is not None:
        _profiles(ax, result, shown, rod)
        return within(ax)
    picture = titled(result, 10.0, 7.4)
    level = np.asarray(result.data[result.dimension].values, dtype=float)
    clock, along = _levels(result, level)
    several = level.size > 1
    grid = picture.add_gridspec(2 if several else 1, 2, height_ratios=(1.0, 1.15) if several else None)
    if several:
        size = _above_round_off(result, largest(result, "strain"))
        for column, words in enumerate((list(STRAINS)[:3], list(STRAINS)[3:])):
            axes = picture.add_subplot(grid[0, column])
            first = 3 * column
            scale, unit = _percent(size[:, :3]) if column == 0 else scaled("1/m", size[:, 3:])
            clean(axes, along, f"largest size along the rods [{unit}]")
            for k, (word, colour) in enumerate(zip(words, (BLUE, ORANGE, GREEN), strict=True)):
                style = ("-", "--", ":")[k]
                axes.plot(
                    clock * level,
                    scale * size[:, first + k],
                    style,
                    color=colour,
                    linewidth=1.4,
                    label=word.replace("_", " "),
                )
            axes.margins(x=0.01)
            axes.set_ylim(bottom=0.0)
            legend_above(axes, 3)
    _profiles(picture.add_subplot(grid[-1, :]), result, shown, rod)
    return picture


def draw_space_time(
    result: Run,
    quantity: str = "section_force",
    component: str | None = None,
    rod: str | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Return the figure of one component over arc length and time, an image for every rod.

    Args:
        result: the run.
        quantity: "strain", "section_force" or "dissipation".
        component: by default the one that changes most.
        rod: by default all, or the four where it is largest.
        ax: axes for the image of one rod, by default of the one where it changes most.

    Raises:
        InputError: no such quantity, component or rod, or a run of one state.
    """
    shown = chosen_component(result, quantity, component)
    if result.time.size < 2:
        raise InputError("this run holds one state only; an image over time needs two or more")
    rods = [rod] if rod is not None else _busiest(result, shown, 1 if ax is not None else _MOST_RODS)
    for name in rods:
        _require_rod(result, name)
    times = np.linspace(result.time[0], result.time[-1], _TIMES)
    images = []
    for name in rods:
        s = _arc(result, name, _PLACES)
        found = result.probe(name, times, s=s)[quantity].values
        images.append((name, s, shown.of(found)))
    most = max(float(np.max(np.abs(image))) for _, _, image in images)
    clock, along = _levels(result, times)
    scale, unit = _percent(np.array([most])) if shown.unit == "1" else scaled(shown.unit, most)
    signed = quantity != "dissipation"
    if ax is None:
        picture = titled(result, 10.0, 1.6 + 2.9 * len(rods))
        panels = np.atleast_1d(np.asarray(picture.subplots(len(rods), 1, sharex=True)))
    else:
        panels, picture = np.array([ax]), within(ax)
    top = scale * most or 1.0
    for axes, (name, s, image) in zip(panels, images, strict=True):
        reach, metre = scaled("m", s)
        clean(axes, along if axes is panels[-1] else "", f"arc length [{metre}]")
        axes.grid(visible=False)
        mesh = axes.pcolormesh(
            clock * times,
            reach * s,
            scale * image.T,
            cmap="RdBu_r" if signed else "viridis",
            vmin=-top if signed else 0.0,
            vmax=top,
            shading="gouraud",
            rasterized=True,
        )
        left_out = axes is panels[0] and 1 < len(rods) < len(result.sites.rods)
        which = f": {len(rods)} of {len(result.sites.rods)} rods, where it is largest" if left_out else ""
        heading(axes, f"{shown.name.capitalize()} along {name}{which}")
        colour_bar(picture, axes, mesh, f"{shown.short} [{unit}]")
    return picture


def _profiles(axes: Axes, result: Result, shown: Component, rod: str) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    _require_rod(result, rod)
    s = _arc(result, rod, _ALONG)
    level = np.asarray(result.data[result.dimension].values, dtype=float)
    if isinstance(result, Run) and level.size > 1:
        levels = np.linspace(level[0], level[-1], _INSTANTS)
        values = shown.of(result.probe(rod, levels, s=s)[shown.quantity].values)
    else:
        chosen = np.unique(np.linspace(0, level.size - 1, _INSTANTS).round().astype(int))
        levels = level[chosen]
        values = shown.of(result.probe(rod, s=s)[shown.quantity].values[chosen])
    scale, unit = _percent(values) if shown.unit == "1" else scaled(shown.unit, values)
    clock, along = _levels(result, level)
    reach, metre = scaled("m", s)
    clean(axes, f"arc length of {rod} [{metre}]", f"{shown.name} [{unit}]")
    colours = time_colours()
    ordered = np.sort(levels)
    first, last = float(ordered[0]), float(ordered[-1] if ordered[-1] > ordered[0] else ordered[0] + 1.0)
    span = Normalize(first, last)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    for at, profile in zip(levels, values, strict=True):
        axes.plot(reach * s, scale * profile, color=colours(span(at)), linewidth=1.6)
    axes.margins(x=0.01)
    instants = f" at {len(levels)} instants" if result.dimension == "time" and len(levels) > 1 else ""
    heading(axes, f"{shown.name.capitalize()}{instants}")
    if len(levels) > 1:
        shown_span = Normalize(clock * first, clock * last)
        colour_bar(axes.figure, axes, ScalarMappable(shown_span, colours), along)
    else:
        said, unit = _AT[result.dimension]
        axes.annotate(
            f"{said} {quantity(float(levels[0]), unit, 4)}",
            (1.0, 1.0),
            xycoords="axes fraction",
            ha="right",
            va="bottom",
            fontsize=SMALL,
        )


def _above_round_off(result: Result, sizes: Floats) -> Floats:
    """Return strains and curvatures ``(states, 6)`` with 0 in place of what rounding of positions leaves of them."""
    length = float(np.abs(result.data["point_s"].values).max(initial=0.0)) or 1.0
    noise = np.repeat([_ROUND_OFF, _ROUND_OFF / length], 3)
    return np.where(sizes < noise, 0.0, sizes)


def _percent(values: Floats) -> tuple[float, str]:
    """Return factor and unit of a strain without dimension: percent, or micrometres per metre where it is small."""
    size = float(np.max(np.abs(values), initial=0.0))
    return (1e6, "µm/m") if 0.0 < size < 1e-4 else (100.0, "%")


def _levels(result: Result, level: Floats) -> tuple[float, str]:
    """Return factor and label of what states are stored along: times with a prefix."""
    if result.dimension != "time":
        return 1.0, _LEVELS[result.dimension]
    clock, second = scaled("s", level)
    return clock, f"time [{second}]"


def _busiest(result: Result, shown: Component, count: int) -> list[str]:
    """Return so many rods in which a component is largest, in the order of the model."""
    low, high = extremes(result, shown.quantity)
    size = np.maximum(np.abs(shown.of(low)), np.abs(shown.of(high)))
    of_rod = result.data["point_rod"].values
    largest = {rod: float(size[of_rod == rod].max(initial=0.0)) for rod in result.sites.rods}
    chosen = sorted(largest, key=largest.__getitem__, reverse=True)[:count]
    return [rod for rod in result.sites.rods if rod in chosen]


def _require_rod(result: Result, rod: str) -> None:
    if rod not in result.sites.rods:
        raise InputError(f"rod = {rod!r}: no rod is called so; it can be {', '.join(result.sites.rods)}")


def _arc(result: Result, rod: str, count: int) -> Floats:
    ends = [site.s for site in result.sites.ends(rod)]
    return np.linspace(ends[0], ends[1], count)
