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
    legend_inside,
    scaled,
    time_colours,
    titled,
)
from viscorod.results.data_schema import AXES
from viscorod.results.decrement import Decrement
from viscorod.results.extremes import hermite
from viscorod.results.probe import instants_of, poses_at
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

    from viscorod.results.run import Run

_SNAPSHOTS = 13
_SIDE_BY_SIDE = 5  # snapshots of rods that would hide each other
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
        spread = np.ptp(run.history(place, "displacement").values, axis=0)
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
    grid = picture.add_gridspec(2, 1 if decay is None else 2, height_ratios=(1.0, 1.2))
    draw_history(picture.add_subplot(grid[0, :]), run, place, axis, decay)
    _snapshots(picture, grid[1, 0], run, decay)
    if decay is not None:
        _damping(picture.add_subplot(grid[1, 1]), decay)
    return picture


def draw_history(axes: Axes, run: Run, place: str, axis: str, decay: Decrement | None) -> None:
    """Draw a displacement over time into an axes, with the maxima and the envelope of a decay."""
    values = run.history(place, "displacement").sel(axis=axis).values
    scale, unit = scaled("m", values)
    clean(axes, "time [s]", f"displacement {axis} of {place} [{unit}]")
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    lone = "o" if run.time.size == 1 else None
    time, curve = _curve(run.time, values, run.history(place, "velocity").sel(axis=axis).values)
    axes.plot(time, scale * curve, color=BLUE, linewidth=1.6, marker=lone, label=f"displacement {axis}")
    axes.margins(x=0.01)
    if decay is not None:
        axes.plot(
            decay.time,
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
        label = f"envelope of {cycles}, exp({-rate:.3g} t/s)".replace("-", "\N{MINUS SIGN}")
        bottom, top = axes.get_ylim()
        for sign, text in ((1.0, label), (-1.0, None)):
            bound = scale * (decay.rest_at(run.time) + sign * envelope)
            axes.plot(run.time, bound, "--", color=ORANGE, linewidth=1.4, label=text)
        # Extrapolated to the start, the envelope may run far out of the large first swings.
        room = 0.05 * (top - bottom)
        axes.set_ylim(bottom - room, top + room)
    legend_above(axes, 3)


def _curve(time: Floats, value: Floats, rate: Floats) -> tuple[Floats, Floats]:
    """Return times and values of a smooth curve: cubics through the stored values and their rates."""
    parts = max(1, min(_BETWEEN, _ENOUGH // time.size))
    step, part = np.diff(time)[:, None], np.arange(parts) / parts
    between = hermite(part, value[:-1, None], value[1:, None], step * rate[:-1, None], step * rate[1:, None])
    return np.append(time[:-1, None] + step * part, time[-1]), np.append(between, value[-1])


def _snapshots(picture: Figure, spec: SubplotSpec, run: Run, decay: Decrement | None) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    start, end = (run.time[0], run.time[-1]) if decay is None else decay.time[:2]
    reference = np.asarray(run.data["reference_position"].values, dtype=float)
    curves = Curves(run)
    coiled = curves.coiled(reference)
    times = np.linspace(start, end, (_SIDE_BY_SIDE if coiled else _SNAPSHOTS) if end > start else 1)
    poses = poses_at(run, np.arange(run.data.sizes["station"]), instants_of(run, times))
    positions, rotations = poses.position, poses.rotation
    assembly = Assembly(run)
    ends = [assembly.ends(*state).reshape(-1, 3) for state in zip(positions, rotations, strict=True)]
    view = View.of(np.concatenate([*positions, reference, *ends]))
    shifts = view.strip(positions) if coiled else np.zeros((times.size, 3))
    axes = picture.add_subplot(spec)
    rods = "Rod" if len(run.sites.rods) == 1 else "Rods"
    first = decay is None or start - (end - start) < run.time[0]
    period = "" if decay is None else ", first period" if first else f", period from {start:.3g} s"
    rods += " and bodies" if assembly.bodies else ""
    view.prepare(axes, f"{rods} {view.name}{period}{', side by side' if coiled else ''}")
    colours = time_colours()
    span = Normalize(start, end if end > start else start + 1.0)
    if not coiled:
        draw_reference(axes, view, curves, run)
    states = list(zip(times, positions, rotations, shifts, strict=True))
    for time, position, rotation, shift in states:
        curves.draw(axes, view, position + shift, color=colours(span(time)), linewidth=1.8)
        if not assembly.empty:
            assembly.draw(axes, view.shifted(shift), position, rotation, colours(span(time)))
    for time, position, rotation, shift in states if coiled else (states[0], states[-1]):
        assembly.draw_springs(axes, view.shifted(shift), position, rotation, colours(span(time)))
    for shift in shifts if coiled else shifts[:1]:
        mark_supports(axes, view, run, positions[0] + shift)
    view.finish(axes, headroom=0.3 if coiled else 0.0)
    bar = picture.colorbar(ScalarMappable(span, colours), ax=axes, shrink=0.85, aspect=28, pad=0.03)
    bar.set_label("time [s]", fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
    legend_inside(axes)


def _damping(axes: Axes, decay: Decrement) -> None:
    amplitude, ratio = decay.mean_amplitude, decay.damping_ratio
    scale, unit = scaled("m", amplitude)
    clean(axes, f"mean amplitude of the cycle [{unit}]", "damping ratio")
    words, limit = decay.limit
    name = f"{words}: {limit:.4f}"
    heading(axes, "Damping ratio of every cycle (numbered)")
    axes.axhline(limit, color=ORANGE, linestyle="--", linewidth=1.4, label=name)
    style = "o" if decay.scattered else "o-"
    axes.plot(scale * amplitude, ratio, style, color=GREEN, markersize=6, linewidth=1.2)
    low, high = min(0.0, float(ratio.min())), max(float(ratio.max()), limit)
    step = max(1, ratio.size // 12)
    for number in range(0, ratio.size, step):
        axes.annotate(
            str(number + 1),
            (scale * amplitude[number], ratio[number]),
            xytext=(0, -16 if ratio[number] - low > 0.1 * (high - low) else 8),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL,
        )
    axes.set_ylim(1.25 * low, 1.25 * high if high > 0.0 else 0.1)
    axes.set_xlim(0.0, 1.08 * scale * float(amplitude.max()))
    axes.locator_params(axis="x", nbins=6)
    legend_inside(axes)
