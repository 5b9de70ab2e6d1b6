"""Loads in the picture of a model: forces, moments, what is spread, and the weight."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.pictures.drawing.load_arrows import DrawnLoad
from viscorod.pictures.drawing.paper import ARROW, MOST_NAMES, SIDEWAYS, Paper
from viscorod.pictures.style import RED, SMALL, label_once
from viscorod.typing import Floats

__all__ = ["draw_gravity", "draw_loads"]

_SHORTEST = 0.4
"""Of the arrows of one unit, as a part of the longest."""


def draw_loads(paper: Paper, loads: list[DrawnLoad]) -> None:
    """Draw the arrows of all loads but gravity; lengths grow as the square root of what they show."""
    named = len(loads) <= MOST_NAMES
    largest: dict[str, float] = {}
    for load in loads:
        largest[load.unit] = max(largest.get(load.unit, 0.0), load.largest)
    for load in loads:
        part = (1.0 if named else 0.5) * max((load.largest / largest[load.unit]) ** 0.5, _SHORTEST)
        tips = load.points + part * ARROW * paper.size * load.values
        feet, ends = paper.view.on_paper(load.points), paper.view.on_paper(tips)
        turning = load.turning
        for tail, tip, value in zip(feet.T, ends.T, load.values, strict=True):
            if float(np.linalg.norm(value)) < 0.02:
                continue
            across = np.linalg.norm(paper.view.projection @ value) < SIDEWAYS * np.linalg.norm(value)
            if turning and across:
                towards = float(np.cross(*paper.view.projection) @ value) > 0.0
                _turn(paper, tail, anticlockwise=towards)
                continue
            paper.arrow(tail, tip, RED, style="-|>")
            if turning:  # two heads: a moment about this direction
                paper.arrow(tail, tail + 0.8 * (tip - tail), RED, style="-|>")
        if load.spread:
            paper.axes.plot(*ends, color=RED, linewidth=0.9, zorder=6)
            paper.labels.avoid(ends)
        kind, marker = ("moment", r"$\circlearrowleft$") if turning else ("force", ">")
        line: dict[str, Any] = {
            "color": RED,
            "linewidth": 0.0 if turning else 1.4,
            "marker": marker,
            "markersize": 12.0 if turning else 6.0,
        }
        paper.axes.plot([], [], label=label_once(paper.axes, kind), **line)
        if named:
            middle = len(load.points) // 2
            paper.labels.add(ends[:, middle], load.text, RED)


def _turn(paper: Paper, centre: Floats, *, anticlockwise: bool) -> None:
    """Draw a moment about the direction across the paper."""
    radius = 0.35 * ARROW * paper.size * paper.view.scale
    angle = np.radians(np.linspace(-60.0, 200.0, 40))
    if not anticlockwise:
        angle = np.pi - angle
    arc = centre[:, None] + radius * np.array([np.cos(angle), np.sin(angle)])
    paper.axes.plot(*arc, color=RED, linewidth=1.4, zorder=6)
    paper.arrow(arc[:, -4], arc[:, -1], RED, style="-|>")
    paper.labels.avoid(arc)


def draw_gravity(paper: Paper, gravity: Floats) -> None:
    """Draw the weight in the upper right corner."""
    size = float(np.linalg.norm(gravity))
    if size == 0.0:
        return
    axes, direction = paper.axes, paper.view.projection @ gravity / size
    text = f"gravity\n{size:.3g} m/s²"
    axes.annotate(
        text, (1.12, 0.20), xycoords="axes fraction", ha="center", va="bottom", fontsize=SMALL, color=RED
    )
    start = (1.12, 0.17)
    if float(np.linalg.norm(direction)) < SIDEWAYS:
        towards = float(np.cross(*paper.view.projection) @ gravity) > 0.0
        axes.annotate(
            "out of the paper" if towards else "into the paper",
            start,
            xycoords="axes fraction",
            ha="center",
            va="top",
            fontsize=SMALL,
        )
        return
    middle = (1.12, 0.09)
    axes.annotate(
        "",
        middle,
        xycoords="axes fraction",
        xytext=tuple(-34.0 * direction),
        textcoords="offset points",
        annotation_clip=False,
        arrowprops={
            "arrowstyle": "-|>", "color": RED, "linewidth": 1.6, "mutation_scale": 12.0, "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
    )  # fmt: skip
