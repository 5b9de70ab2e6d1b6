"""The picture of an energy account."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.described_model import weight_of
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
    clean,
    figure,
    heading,
    headline,
    legend_above,
)
from viscorod.results.text_numbers import number, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.run import Run

_ROUND_OFF = 1e-14  # percent
_BAR = 0.1  # half the width of the bar of a single state


def gravity_potential(run: Run) -> Floats | None:
    """Return the potential energy of gravity less that at the start ``(times,)`` [J]; None where there is none.

    It is the work against gravity, -g times the integral of the linear momentum over time: its spline is integrated.
    """
    pull = weight_of(run)
    if pull is None or "linear_momentum" not in run.stored or run.time.size < 4:
        return None
    from scipy.interpolate import CubicSpline

    rate = -np.asarray(run.stored["linear_momentum"].values, dtype=float) @ pull
    time, first = np.unique(run.time, return_index=True)
    work: Floats = CubicSpline(time, rate[first]).antiderivative()(run.time)
    return work if np.any(work) else None


def draw_energy(run: Run, ax: Axes | None = None) -> Figure:
    """Return the figure of the account: what is where, and the numerical remainder against what moved.

    Into ``ax`` goes the account alone.
    """
    energy = run.energy
    names = [
        "lost to viscosity" if np.any(energy.viscous) else "lost to viscosity (none)",
        "elastic",
        "kinetic",
    ]
    parts, colours = [energy.viscous, energy.elastic, energy.kinetic], [ORANGE, SKY, BLUE]
    if energy.outside.any():
        names, parts, colours = ["lost to drag", *names], [energy.outside, *parts], [GREEN, *colours]
    top = np.sum(parts, axis=0)
    supplied = energy.supplied
    scale, unit = scaled("J", np.maximum(top, supplied))
    clock, second = scaled("s", energy.time)
    time = clock * energy.time
    if time.size == 1:  # a state is no line: its energies become a bar
        time = time + np.array([-_BAR, _BAR])
        parts, top, supplied = (
            [np.repeat(part, 2) for part in parts],
            np.repeat(top, 2),
            np.repeat(supplied, 2),
        )
    if ax is None:
        picture = figure(10.0, 6.8)
        if run.title:
            headline(picture, run.title)
        picture.subplots_adjust(hspace=0.18)
        upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(2.3, 1.0))
    else:
        upper, lower = ax, None

    clean(upper, "" if lower is not None else f"time [{second}]", f"energy [{unit}]")
    upper.stackplot(
        time,
        *(scale * part for part in parts),
        labels=names,
        colors=colours,
        linewidth=0.0,
    )
    upper.fill_between(
        time, scale * supplied, scale * top, color=RED, linewidth=0.8, label="numerical remainder"
    )
    upper.plot(
        time,
        scale * supplied,
        color=INK,
        linewidth=1.4,
        label="initial energy + work done",
    )
    potential = gravity_potential(run) if energy.time.size > 1 else None
    if potential is not None:
        name = "potential of gravity, from its start"
        upper.plot(time, scale * potential, color=PURPLE, linewidth=1.4, linestyle="-.", label=name)
    if energy.time.size > 1:
        upper.set_xlim(time[0], time[-1])
    else:
        upper.set_xlim(*(5.0 * (time - time.mean()) + time.mean()))
        upper.set_xticks([time.mean()])
    lowest = min(float(supplied.min()), 0.0 if potential is None else float(potential.min()))
    upper.set_ylim(bottom=min(0.0, 1.05 * scale * lowest))
    if legend_above(upper, 5) > 1 and ax is None:
        picture.subplots_adjust(top=0.85)  # two rows, below the title
    if lower is None:
        return within(upper)

    clean(lower, f"time [{second}]", "|numerical| [%]")
    moved = energy.moved
    if moved > 0.0:
        percent = np.maximum(100.0 * np.abs(energy.numerical) / moved, _ROUND_OFF)
        shown = energy.numerical != 0.0  # the start has none, which no logarithm shows
        alone = "o" if percent.size == 1 else None
        lower.semilogy(clock * energy.time[shown], percent[shown], color=RED, linewidth=1.4, marker=alone)
        lower.minorticks_off()
        lower.yaxis.set_major_formatter("{x:g}")
        lower.axhline(1.0, color=GREY, linestyle="--", linewidth=1.2)
        lower.annotate(
            "1 %",
            (1.0, 1.0),
            xycoords=("axes fraction", "data"),
            xytext=(-4, 3),
            textcoords="offset points",
            ha="right",
            fontsize=SMALL,
            color=GREY,
        )
        typical = float(np.median(percent))
        lower.set_ylim(max(_ROUND_OFF, min(0.1, 1e-3 * typical)), max(10.0, 3.0 * float(percent.max())))
        most = f"at most {number(100.0 * energy.numerical_fraction, 2)} %"
        text = f"Numerical remainder: {most} of the {scale * moved:.4g} {unit} that moved"
    else:
        text = "Nothing moved"
    heading(lower, text)
    return picture
