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
    if ax is not None:
        _draw_account(run, ax, alone=True)
        return within(ax)
    picture = figure(10.0, 6.8)
    if run.title:
        headline(picture, run.title)
    picture.subplots_adjust(hspace=0.18)
    upper, lower = picture.subplots(2, 1, sharex=True, height_ratios=(2.3, 1.0))
    if _draw_account(run, upper) > 1:
        picture.subplots_adjust(top=0.85)  # two rows, below the title
    _draw_remainder(run, lower)
    return picture


def _draw_account(run: Run, axes: Axes, *, alone: bool = False) -> int:
    """Draw what is where, upon each other, and what was supplied; return how many rows the legend has.

    Args:
        alone: no other axes below have the label of time.
    """
    energy = run.energy
    names, parts, colours = _held_energies(run)
    top, supplied = np.sum(parts, axis=0), energy.supplied
    scale, unit = scaled("J", np.maximum(top, supplied))
    clock, second = scaled("s", energy.time)
    time = clock * energy.time
    if time.size == 1:  # a state is no line: its energies become a bar
        time = time + np.array([-_BAR, _BAR])
        parts = [np.repeat(part, 2) for part in parts]
        top, supplied = np.repeat(top, 2), np.repeat(supplied, 2)
    clean(axes, f"time [{second}]" if alone else "", f"energy [{unit}]")
    axes.stackplot(time, *(scale * part for part in parts), labels=names, colors=colours, linewidth=0.0)
    remainder = "numerical remainder"
    axes.fill_between(time, scale * supplied, scale * top, color=RED, linewidth=0.8, label=remainder)
    axes.plot(time, scale * supplied, color=INK, linewidth=1.4, label="initial energy + work done")
    lowest = min(float(supplied.min()), 0.0)
    potential = gravity_potential(run) if energy.time.size > 1 else None
    if potential is not None:
        name = "potential of gravity, from its start"
        axes.plot(time, scale * potential, color=PURPLE, linewidth=1.4, linestyle="-.", label=name)
        lowest = min(lowest, float(potential.min()))
    if energy.time.size > 1:
        axes.set_xlim(time[0], time[-1])
    else:
        axes.set_xlim(*(5.0 * (time - time.mean()) + time.mean()))
        axes.set_xticks([time.mean()])
    axes.set_ylim(bottom=min(0.0, 1.05 * scale * lowest))
    return legend_above(axes, 5)


def _held_energies(run: Run) -> tuple[list[str], list[Floats], list[str]]:
    """Return what holds the energy: names, energies [J] and colours, from the lowest one on."""
    energy = run.energy
    lost = "lost to viscosity" if np.any(energy.viscous) else "lost to viscosity (none)"
    names, parts = [lost, "elastic", "kinetic"], [energy.viscous, energy.elastic, energy.kinetic]
    colours = [ORANGE, SKY, BLUE]
    if energy.outside.any():
        return ["lost to drag", *names], [energy.outside, *parts], [GREEN, *colours]
    return names, parts, colours


def _draw_remainder(run: Run, axes: Axes) -> None:
    """Draw the numerical remainder in per cent of the energy that moved."""
    energy, moved = run.energy, run.energy.moved
    clock, second = scaled("s", energy.time)
    clean(axes, f"time [{second}]", "|numerical| [%]")
    if not moved > 0.0:
        heading(axes, "Nothing moved")
        return
    percent = np.maximum(100.0 * np.abs(energy.numerical) / moved, _ROUND_OFF)
    shown = energy.numerical != 0.0  # the start has none, which no logarithm shows
    marker = "o" if percent.size == 1 else None
    axes.semilogy(clock * energy.time[shown], percent[shown], color=RED, linewidth=1.4, marker=marker)
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    axes.axhline(1.0, color=GREY, linestyle="--", linewidth=1.2)
    axes.annotate(
        "1 %", (1.0, 1.0), xycoords=("axes fraction", "data"), xytext=(-4, 3), textcoords="offset points",
        ha="right", fontsize=SMALL, color=GREY,
    )  # fmt: skip
    typical = float(np.median(percent))
    axes.set_ylim(max(_ROUND_OFF, min(0.1, 1e-3 * typical)), max(10.0, 3.0 * float(percent.max())))
    held = np.sum(_held_energies(run)[1], axis=0)
    scale, unit = scaled("J", np.maximum(held, energy.supplied))
    most = f"at most {number(100.0 * energy.numerical_fraction, 2)} %"
    heading(axes, f"Numerical remainder: {most} of the {scale * moved:.4g} {unit} that moved")
