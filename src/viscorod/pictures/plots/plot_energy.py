"""The picture of an energy account."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    RED,
    SKY,
    SMALL,
    TEXT,
    clean,
    figure,
    heading,
    legend_above,
    scaled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.run import Run

_ROUND_OFF = 1e-14  # percent


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
    if ax is None:
        picture = figure(10.0, 6.8)
        if run.title:
            picture.suptitle(run.title, fontsize=TEXT + 2.0, x=0.01, ha="left")
        picture.subplots_adjust(hspace=0.18)
        upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(2.3, 1.0))
    else:
        upper, lower = ax, None

    clean(upper, "" if lower is not None else "time [s]", f"energy [{unit}]")
    upper.stackplot(
        energy.time,
        *(scale * part for part in parts),
        labels=names,
        colors=colours,
        linewidth=0.0,
    )
    upper.fill_between(
        energy.time, scale * supplied, scale * top, color=RED, linewidth=0.8, label="numerical remainder"
    )
    upper.plot(
        energy.time,
        scale * supplied,
        color=INK,
        linewidth=1.4,
        label="initial energy + work done",
    )
    if energy.time.size > 1:
        upper.set_xlim(energy.time[0], energy.time[-1])
    upper.set_ylim(bottom=min(0.0, 1.05 * scale * float(supplied.min())))
    legend_above(upper, 5 if len(names) == 3 else 3)
    if lower is None:
        return within(upper)

    clean(lower, "time [s]", "|numerical| [% of moved]")
    moved = energy.moved
    if moved > 0.0:
        percent = np.maximum(100.0 * np.abs(energy.numerical) / moved, _ROUND_OFF)
        shown = energy.numerical != 0.0  # the start has none, which no logarithm shows
        alone = "o" if percent.size == 1 else None
        lower.semilogy(energy.time[shown], percent[shown], color=RED, linewidth=1.4, marker=alone)
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
        most = f"at most {100.0 * energy.numerical_fraction:.2g} %"
        text = f"Numerical remainder: {most} of the {scale * moved:.4g} {unit} that moved"
    else:
        text = "Nothing moved"
    heading(lower, text)
    return picture
