"""Pictures of periodic motions: amplitudes with their stability, Floquet multipliers, hysteresis loops."""

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
    clean,
    figure,
    heading,
    headline,
    legend_above,
    legend_over,
)
from viscorod.results.text_numbers import quantity, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.periodic import Periodic

__all__ = ["KINDS", "draw_periodic"]

KINDS = ("amplitude", "multipliers", "loops")
COLOURS = (BLUE, RED, GREEN, ORANGE, PURPLE, SKY)
MARKS = {"fold": "o", "period doubling": "s", "torus": "^", "branch point": "D"}
MOST = 6
"""Outputs, or loops, that are drawn at most."""


def draw_periodic(result: Periodic, kind: str = "amplitude", ax: Axes | None = None) -> Figure:
    """Return the figure of a curve of periodic motions.

    Args:
        result: what is drawn; kind: see ``Periodic.plot``.
        ax: axes for one panel alone: the amplitudes of the first unit, or the frequency of free vibrations.

    Raises:
        InputError: there is no such kind, or nothing to draw of it.
    """
    if kind not in KINDS:
        raise InputError(f"kind = {kind!r}: periodic motions are drawn as one of {', '.join(KINDS)}")
    free = result.data.attrs.get("over") == "amplitude"
    drawn = {"amplitude": _backbone if free else _amplitude, "multipliers": _multipliers, "loops": _loops}[
        kind
    ](result, ax)
    if ax is not None:
        return within(ax)
    if result.title:
        headline(drawn, result.title)
    return drawn


def _backbone(result: Periodic, ax: Axes | None) -> Figure:
    """Draw frequency and damping ratio of free vibrations over the amplitude."""
    size, unit = result.amplitude(0), str(result.data["output_unit"].values[0])
    along = f"amplitude of {result.outputs[0]} [{unit}]"
    if ax is None:
        picture = figure(8.0, 6.4)
        picture.subplots_adjust(top=0.86 if result.title else 0.94, hspace=0.42)
        upper = picture.add_subplot(2, 1, 1)
    else:
        picture, upper = within(ax), ax
    upper.plot(size, result.frequencies, color=BLUE, linewidth=1.6)
    upper.ticklabel_format(axis="y", useOffset=False)
    clean(upper, "" if ax is None else along, "frequency [Hz]")
    heading(upper, "free vibrations over their amplitude")
    if ax is not None:
        return picture
    lower = picture.add_subplot(2, 1, 2)
    lower.plot(size, result.damping_ratios, color=RED, linewidth=1.6, label="of the vibration")
    if len(size) > 2 and result.loss.all():
        shown = result.decrement_ratios(0)
        lower.plot(size, shown, color=GREEN, linewidth=1.6, label=f"by the decrement of {result.outputs[0]}")
    clean(lower, along, "damping ratio")
    lower.set_ylim(0.0, 1.12 * float(result.damping_ratios.max()) or 1.0)
    legend_above(lower, 2)
    return picture


def _along(result: Periodic) -> tuple[Floats, str]:
    """Return what changes along the curve, and its name."""
    if result.data.attrs.get("over") == "level":
        return result.levels, "level of the inputs"
    return result.frequencies, "frequency [Hz]"


def _known_stability(result: Periodic) -> np.ndarray | None:
    unstable = np.asarray(result.data["unstable"].values)
    return None if (unstable < 0).any() else unstable == 0


def _amplitude(result: Periodic, ax: Axes | None) -> Figure:
    """Draw the amplitudes: a panel for each unit."""
    outputs = list(range(min(len(result.outputs), MOST)))
    unit_of = [str(unit) for unit in result.data["output_unit"].values]
    units = list(dict.fromkeys(unit_of[k] for k in outputs))
    if ax is None:
        height = 1.3 + 3.2 * len(units)
        picture = figure(8.0, height)
        picture.subplots_adjust(top=1.0 - 0.85 / height, hspace=0.35)
    else:
        units, picture = units[:1], within(ax)
    x, label = _along(result)
    stable = _known_stability(result)
    panels: list[Axes] = []
    for number, unit in enumerate(units):
        axes = ax or picture.add_subplot(len(units), 1, number + 1, sharex=panels[0] if panels else None)
        panels.append(axes)
        mine = [k for k in outputs if unit_of[k] == unit]
        for colour, k in enumerate(mine):
            _curve(axes, x, result.amplitude(k), stable, result.outputs[k], COLOURS[colour])
        first = result.amplitude(mine[0])
        for word, mark in MARKS.items():
            at = [k for k, kind in result.bifurcations if kind == word]
            if at:
                axes.plot(x[at], first[at], mark, color=GREY, markersize=6, label=word, zorder=4)
        if stable is not None and not stable.all():
            axes.plot([], [], "--", color=GREY, linewidth=1.6, label="unstable")
        clean(axes, label if number == len(units) - 1 else "", f"amplitude [{unit}]")
        axes.set_ylim(bottom=0.0)
        legend_above(axes, 4)
    return picture


def _curve(axes: Axes, x: Floats, y: Floats, stable: np.ndarray | None, label: str, colour: str) -> None:
    """Draw a curve whose unstable parts are dashed."""
    if stable is None:
        axes.plot(x, y, color=colour, linewidth=1.6, label=label)
        return
    changes = np.flatnonzero(np.diff(stable.astype(int))) + 1
    starts, ends = [0, *changes.tolist()], [*changes.tolist(), len(x)]
    named = False
    for start, end in zip(starts, ends, strict=True):
        # what is unstable reaches to the stable motions beside it
        piece = slice(start, end) if stable[start] else slice(max(start - 1, 0), end + 1)
        line: dict[str, Any] = {
            "color": colour,
            "linewidth": 1.6,
            "linestyle": "-" if stable[start] else "--",
        }
        if stable[start] and not named:
            line["label"], named = label, True
        axes.plot(x[piece], y[piece], **line)
    if not named:
        axes.plot([], [], color=colour, linewidth=1.6, linestyle="--", label=label)


def _multipliers(result: Periodic, ax: Axes | None) -> Figure:
    """Draw the multipliers in the complex plane, coloured along the curve."""
    values = result.multipliers
    if not values.shape[1]:
        raise InputError("kind = 'multipliers': these motions were computed with stability = False")
    picture = figure(6.6, 5.6) if ax is None else within(ax)
    axes = ax or picture.add_subplot(1, 1, 1)
    turn = np.linspace(0.0, 2.0 * np.pi, 400)
    axes.plot(np.cos(turn), np.sin(turn), color=LIGHT, linewidth=1.5, zorder=0)
    number = np.repeat(np.arange(len(values)), values.shape[1])
    flat = values.ravel()
    inside = np.abs(flat) <= 1.0 + 1e-6
    dots = axes.scatter(flat.real[inside], flat.imag[inside], c=number[inside], s=7, cmap="viridis")
    axes.scatter(flat.real[~inside], flat.imag[~inside], c=RED, s=14, marker="x", zorder=3)
    picture.colorbar(dots, ax=axes, label="number of the motion on the curve", shrink=0.8)
    axes.set_aspect("equal")
    clean(axes, "real part", "imaginary part")
    beyond = "; crosses: beyond it, unstable" if (~inside).any() else ""
    heading(axes, f"Floquet multipliers; grey: unit circle{beyond}")
    return picture


def _loops(result: Periodic, ax: Axes | None) -> Figure:
    """Draw the hysteresis loops of the first force, of motions from the smallest to the largest loss."""
    forces = [k for k in range(len(result.inputs)) if result.data["conjugate"].values[:, k].any()]
    if not forces:
        raise InputError(
            "kind = 'loops': no input is a force or a moment, whose work would be the area of a loop"
        )
    source = forces[0]
    if ax is None:
        picture = figure(7.6, 5.6)
        picture.subplots_adjust(top=0.83)
    else:
        picture = within(ax)
    axes = ax or picture.add_subplot(1, 1, 1)
    order = np.argsort(result.loss)
    chosen = order[np.unique(np.linspace(len(order) // 2, len(order) - 1, MOST - 1).astype(int))]
    loops = {k: result.loop(k, source, 401) for k in sorted(chosen.tolist())}
    given = str(result.data["input_unit"].values[source])
    stretch, along = scaled(
        {"N": "m", "N m": "rad"}.get(given, "J"), [np.abs(y).max() for y, _ in loops.values()]
    )
    press, unit = scaled(given, [np.abs(force).max() for _, force in loops.values()])
    for colour, (k, (y, force)) in enumerate(loops.items()):
        level = "" if result.data.attrs.get("over") != "level" else f", level {result.levels[k]:.3g}"
        axes.plot(
            stretch * np.append(y, y[0]),
            press * np.append(force, force[0]),
            color=COLOURS[colour],
            linewidth=1.4,
            label=f"{quantity(result.frequencies[k], 'Hz', 5)}{level}: {quantity(result.work[k], 'J', 3)}",
        )
    name = result.inputs[source]
    clean(axes, f"displacement along {name} [{along}]", f"{name} [{unit}]")
    heading(axes, "Each loop encloses the work of the force in a cycle")
    legend_over(axes, 3)
    return picture
