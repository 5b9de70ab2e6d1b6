"""The picture of a motion: history with envelope, snapshots of the rods, damping ratio of every cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.plots.assemblies import Assembly
from viscorod.pictures.plots.projection_view import Curves, View, draw_reference, mark_supports
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    SMALL,
    TEXT,
    clean,
    heading,
    legend_above,
    legend_over,
    time_colours,
    titled,
)
from viscorod.results.data_schema import AXES
from viscorod.results.decrement import Decrement
from viscorod.results.extremes import hermite
from viscorod.results.probe import instants_of, poses_at
from viscorod.results.text_numbers import number, quantity, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

    from viscorod.results.run import Run

_SNAPSHOTS = 13
_SIDE_BY_SIDE = 5  # snapshots of rods that would hide each other
_SHORT = 16  # letters of a place that an axis has room for
_FALLS = 0.7  # part of the largest amplitude to which it falls where ratios are drawn over it
_ROOM = 0.035  # of the number of a cycle, as a part of the largest amplitude
_BETWEEN, _ENOUGH = 8, 4000  # points drawn from one stored time to the next, and in all


def draw_tip(
    run: Run, place: str | int | None = None, axis: str | None = None, ax: Axes | None = None
) -> Figure:
    """Return the figure of one displacement over time alone, drawn into ``ax`` if it is given; see ``Run.plot``."""
    place, axis = chosen_motion(run, place, axis)
    if ax is not None:
        draw_history(ax, run, place, axis, run.free_decay(place, axis))
        return within(ax)
    picture = titled(run, 9.0, 4.4)
    draw_history(picture.add_subplot(), run, place, axis, run.free_decay(place, axis))
    return picture


def chosen_motion(run: Run, place: str | int | None, axis: str | None) -> tuple[str, str]:
    """Return a place in words and an axis: by default those that move most."""
    site, main_axis = run.main_motion
    if place is not None:
        site = run.sites.at(place)
        spread = np.ptp(run.vector(site, "displacement"), axis=0)
        main_axis = AXES[int(np.argmax(spread))]
    return site.label, main_axis if axis is None else axis


def draw_motion(
    run: Run, place: str | int | None = None, axis: str | None = None, ax: Axes | None = None
) -> Figure:
    """Return the figure of a motion, whose history alone goes into ``ax``; see ``Run.plot``."""
    if ax is not None:
        return draw_tip(run, place, axis, ax)
    place, axis = chosen_motion(run, place, axis)
    decay = run.free_decay(place, axis)
    picture = titled(run, 10.0, 7.6)
    grid = picture.add_gridspec(2, 1 if decay is None else 2, height_ratios=(1.0, 1.2), hspace=0.4)
    draw_history(picture.add_subplot(grid[0, :]), run, place, axis, decay)
    _snapshots(picture, grid[1, 0], run, _shown_span(run, place, axis, decay))
    if decay is not None:
        _damping(picture.add_subplot(grid[1, 1]), decay)
    return picture


def draw_history(axes: Axes, run: Run, place: str, axis: str, decay: Decrement | None) -> None:
    """Draw a displacement over time into an axes, with the maxima and the envelope of a decay."""
    values, rates = _history(run, place, axis)
    scale, unit = scaled("m", values)
    clock, second = scaled("s", run.time)
    clean(axes, f"time [{second}]", f"displacement {axis}{of_place(place)} [{unit}]")
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    lone = "o" if run.time.size == 1 else None
    time, curve = _curve(run.time, values, rates)
    name = f"displacement {axis} of {place}"
    axes.plot(clock * time, scale * curve, color=BLUE, linewidth=1.6, marker=lone, label=name)
    axes.margins(x=0.01)
    if decay is not None:
        axes.plot(
            clock * decay.time,
            scale * decay.value,
            "o",
            color=RED,
            markersize=5,
            clip_on=False,
            zorder=4,
            label="maxima" if decay.value[0] > decay.rest_at(decay.time)[0] else "minima",
        )
        size, rate = decay.envelope
        envelope = size * np.exp(-rate * run.time)
        cycles = "all cycles" if decay.scattered else "the last cycles"
        minus = "\N{MINUS SIGN}" if rate > 0.0 else ""
        label = (
            f"envelope of {cycles}, exp({minus}t / {quantity(1.0 / abs(rate), 's', 3)})"
            if rate
            else "envelope"
        )
        bottom, top = axes.get_ylim()
        for sign, text in ((1.0, label), (-1.0, None)):
            bound = scale * (decay.rest_at(run.time) + sign * envelope)
            axes.plot(clock * run.time, bound, "--", color=ORANGE, linewidth=1.4, label=text)
        # Extrapolated to the start, the envelope may run far out of the large first swings.
        room = 0.05 * (top - bottom)
        axes.set_ylim(bottom - room, top + room)
    legend_above(axes, 3)


def _history(run: Run, place: str, axis: str) -> tuple[Floats, Floats]:
    """Return the displacement [m] of a place along a global axis over time, and its rate [m/s]."""
    site, column = run.sites.at(place), AXES.index(axis)
    return run.vector(site, "displacement")[:, column], run.vector(site, "velocity")[:, column]


def of_place(place: str) -> str:
    """Return the place for the label of an axis, unless it is so long that the legend alone has room for it."""
    return f" of {place}" if len(place) <= _SHORT else ""


def _curve(time: Floats, value: Floats, rate: Floats) -> tuple[Floats, Floats]:
    """Return times and values of a smooth curve: cubics through the stored values and their rates."""
    parts = max(1, min(_BETWEEN, _ENOUGH // time.size))
    step, part = np.diff(time)[:, None], np.arange(parts) / parts
    between = hermite(part, value[:-1, None], value[1:, None], step * rate[:-1, None], step * rate[1:, None])
    return np.append(time[:-1, None] + step * part, time[-1]), np.append(between, value[-1])


def _shown_span(run: Run, place: str, axis: str, decay: Decrement | None) -> tuple[float, float, str]:
    """Return from when to when snapshots are taken [s], and words for it.

    It is a period of a decay. Without one it is the whole motion, also of what rests; of one that goes to and fro so
    often that snapshots of all of it would meet it anywhere, it is the start until it has gone to and fro once.
    """
    first, last = float(run.time[0]), float(run.time[-1])
    if decay is not None:
        start, end = map(float, decay.time[:2])
        begins = start - (end - start) < first
        return start, end, ", first period" if begins else f", period from {quantity(start, 's', 3)}"
    values, _ = _history(run, place, axis)
    above = values > 0.5 * (values.min() + values.max())
    crossed = run.time[1:][above[1:] != above[:-1]]
    if run.rests or crossed.size <= _SNAPSHOTS // 2:
        return first, last, ""
    return first, float(crossed[2]), ", first swing"


def _snapshots(picture: Figure, spec: SubplotSpec, run: Run, span: tuple[float, float, str]) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    start, end, words = span
    reference = np.asarray(run.stored["reference_position"].values, dtype=float)
    curves = Curves(run)
    coiled = curves.coiled(reference)
    times = np.linspace(start, end, (_SIDE_BY_SIDE if coiled else _SNAPSHOTS) if end > start else 1)
    poses = poses_at(run, np.arange(run.stored.sizes["station"]), instants_of(run, times))
    positions, rotations = poses.position, poses.rotation
    assembly = Assembly(run)
    ends = [assembly.ends(*state).reshape(-1, 3) for state in zip(positions, rotations, strict=True)]
    everything = np.concatenate([*positions, reference, *ends])
    view = View.of(everything, enlarged=assembly.empty, lines=curves.points(positions[0]))
    shifts = view.strip(positions) if coiled else np.zeros((times.size, 3))
    axes = picture.add_subplot(spec)
    rods = "Rod" if len(run.sites.rods) == 1 else "Rods"
    rods += " and bodies" if assembly.bodies else ""
    view.prepare(axes, f"{rods} {view.name}{words}{', side by side' if coiled else ''}")
    colours = time_colours()
    last = end if end > start else start + 1.0
    part = Normalize(start, last)
    if not coiled:
        draw_reference(axes, view, curves, run)
    states = list(zip(times, positions, rotations, shifts, strict=True))
    for time, position, rotation, shift in states:
        curves.draw(axes, view, position + shift, color=colours(part(time)), linewidth=1.8)
        if not assembly.empty:
            assembly.draw(axes, view.shifted(shift), position, rotation, colours(part(time)))
    for time, position, rotation, shift in states if coiled else (states[0], states[-1]):
        assembly.draw_springs(axes, view.shifted(shift), position, rotation, colours(part(time)))
    for shift in shifts if coiled else shifts[:1]:
        mark_supports(axes, view, run, positions[0] + shift)
    view.finish(axes)
    if times.size > 1:
        clock, second = scaled("s", times)
        shown = Normalize(clock * start, clock * last)
        bar = picture.colorbar(ScalarMappable(shown, colours), ax=axes, shrink=0.85, aspect=28, pad=0.03)
        bar.set_label(f"time [{second}]", fontsize=TEXT)
        bar.ax.tick_params(labelsize=SMALL)
    legend_over(axes, 4)


def _damping(axes: Axes, decay: Decrement) -> None:
    """Draw the damping ratio over the amplitude, or over the number of the cycle where the amplitude hardly falls."""
    from matplotlib.ticker import MaxNLocator

    amplitude, ratio = decay.mean_amplitude, decay.damping_ratio
    scale, unit = scaled("m", amplitude)
    falls = float(amplitude.min()) < _FALLS * float(amplitude.max())
    x = scale * amplitude if falls else np.arange(1.0, ratio.size + 1.0)
    clean(axes, f"mean amplitude of the cycle [{unit}]" if falls else "cycle", "damping ratio")
    words, limit = decay.limit
    heading(axes, "Damping ratio of every cycle (numbered)" if falls else "Damping ratio of every cycle")
    name = f"{words}: {number(limit, 4)}"
    axes.axhline(limit, color=ORANGE, linestyle="--", linewidth=1.4, label=name)
    style = "o" if decay.scattered else "o-"
    axes.plot(x, ratio, style, color=GREEN, markersize=6, linewidth=1.2)
    low, high = min(0.0, float(ratio.min())), max(float(ratio.max()), limit)
    if falls:
        _number_cycles(axes, x, ratio, low, high)
        axes.set_xlim(0.0, 1.08 * float(x.max()))
        axes.locator_params(axis="x", nbins=6)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlim(0.5, ratio.size + 0.5)
    axes.set_ylim(1.25 * low, 1.25 * high if high > 0.0 else 0.1)
    legend_over(axes, 1)


def _number_cycles(axes: Axes, x: Floats, ratio: Floats, low: float, high: float) -> None:
    """Write the numbers of cycles beside their points, those that have room."""
    last = np.inf
    for k in range(ratio.size):
        if abs(last - x[k]) < _ROOM * float(x.max()):
            continue
        last = x[k]
        axes.annotate(
            str(k + 1),
            (x[k], ratio[k]),
            xytext=(0, -16 if ratio[k] - low > 0.1 * (high - low) else 8),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL,
        )
