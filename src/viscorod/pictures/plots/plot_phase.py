"""The phase portrait of a motion: velocity over displacement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.picture import within
from viscorod.pictures.plots.plot_motion import chosen_motion
from viscorod.pictures.style import (
    GREY,
    INK,
    clean,
    colour_bar,
    legend_above,
    scaled,
    time_colours,
    titled,
)
from viscorod.results.data_schema import AXES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.run import Run

_POINTS = 6000


def draw_phase(
    run: Run, place: str | int | None = None, axis: str | None = None, ax: Axes | None = None
) -> Figure:
    """Return the figure of velocity over displacement of a place along an axis, coloured by time.

    Args:
        run: the run.
        place: by default the one that moves most; axis: by default the one along which it moves most.
        ax: axes to draw into.

    Raises:
        InputError: no such place or axis, or a run of one state.
    """
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize

    if run.time.size < 2:
        raise InputError("this run holds one state only; a phase portrait needs two or more")
    place, axis = chosen_motion(run, place, axis)
    if axis not in AXES:
        raise InputError(f"axis = {axis!r} is not a global axis; give x, y or z")
    count = max(2, min(_POINTS, 8 * run.time.size))
    times = np.linspace(run.time[0], run.time[-1], count)
    found = run.probe(place, times).sel(axis=axis).isel(place=0)
    x, v = found["displacement"].values, found["velocity"].values
    scale, unit = scaled("m", x)
    rate, rate_unit = scaled("m/s", v)
    points = np.stack([scale * x, rate * v], axis=-1)
    picture = titled(run, 7.6, 6.0) if ax is None else within(ax)
    axes = ax or picture.add_subplot()
    clean(axes, f"displacement {axis} of {place} [{unit}]", f"velocity {axis} [{rate_unit}]")
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    segments = np.stack([points[:-1], points[1:]], axis=1)
    lines = LineCollection(list(segments), cmap=time_colours(), norm=Normalize(times[0], times[-1]))
    lines.set_array(times[:-1])
    lines.set_linewidth(1.3)
    axes.add_collection(lines)
    axes.plot(*points[0], "o", markersize=7, color=INK, label="start")
    axes.plot(*points[-1], "s", markersize=6, markerfacecolor="white", markeredgecolor=INK, label="end")
    axes.autoscale_view()
    axes.margins(0.06)
    legend_above(axes, 2)
    colour_bar(picture, axes, lines, "time [s]")
    return within(axes) if ax is not None else picture
