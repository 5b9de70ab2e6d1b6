"""Draw the set-up of the hinged beam for docs/explanation/awp_beams.md, with all of its data.

python docs/figures/awp_setup.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Polygon

from viscorod.pictures.style import BLUE, GREY, INK, RED, clean, heading

TARGET = Path(__file__).parents[1] / "images" / "awp_setup.png"
SHOWN = np.array([[1.0, 0.0], [-0.42, -0.36], [0.0, 1.0]])
"""Where the axis of the rod, e2 and e3 point in the picture."""
DATA = (
    ("length, line mass", "1 m, 1 kg/m"),
    ("rotary inertia about e1, e2, e3", "4e-4, 2e-4, 2e-4 kg m"),
    ("stretching stiffness EA", "1e4 N (printed: 1e5)"),
    ("shear stiffness", "5e3 N, both"),
    ("GJ, EI about e2 and e3", "1, 1, 2 N m²"),
    ("retardation times, all six", "0.01, 0.001 or 0.0001 s"),
    ("gravity", "none"),
)


def point(*place: float) -> np.ndarray:
    return np.array(place) @ SHOWN


def arrow(axes: Axes, start: np.ndarray, end: np.ndarray, colour: str, width: float = 1.6) -> None:
    axes.add_patch(
        FancyArrowPatch(
            start, end, arrowstyle="-|>", mutation_scale=13, color=colour, lw=width, shrinkA=0, shrinkB=0
        )
    )


def moment(axes: Axes, start: np.ndarray, end: np.ndarray, colour: str) -> None:
    """Draw a moment: an arrow with two heads."""
    arrow(axes, start, end, colour, 2.2)
    arrow(axes, start, start + 0.84 * (end - start), colour, 2.2)


def draw_beam(axes: Axes) -> None:
    half, length = 0.035, 2.6
    corners = [(0, half, half), (length, half, half), (length, half, -half), (0, half, -half)]
    axes.add_patch(Polygon([point(*c) for c in corners], fc="#cfe0ee", ec=INK, lw=1.0, zorder=2))
    top = [(0, half, half), (length, half, half), (length, -half, half), (0, -half, half)]
    axes.add_patch(Polygon([point(*c) for c in top], fc="#e7f0f7", ec=INK, lw=1.0, zorder=2))
    end = [(length, half, half), (length, -half, half), (length, -half, -half), (length, half, -half)]
    axes.add_patch(Polygon([point(*c) for c in end], fc="#b5cfe2", ec=INK, lw=1.0, zorder=2))
    axes.add_patch(Circle((0, 0), 0.085, fc="white", ec=INK, lw=1.4, zorder=3))
    ground = -0.3
    axes.plot([0, 0], [-0.085, ground], color=INK, lw=1.4)
    axes.plot([-0.22, 0.22], [ground, ground], color=INK, lw=1.4)
    for x in np.linspace(-0.22, 0.16, 6):
        axes.plot([x, x - 0.06], [ground, ground - 0.08], color=INK, lw=0.9)
    axes.annotate("ball joint: turns freely", (0.26, ground - 0.04), fontsize=9.5, va="center")
    at = point(1.1, 0, 0.36)
    for vector, name in (((0.36, 0, 0), "e1, along the beam"), ((0, 0.5, 0), "e2"), ((0, 0, 0.3), "e3")):
        tip = at + point(*vector)
        arrow(axes, at, tip, GREY)
        right = name != "e2"
        axes.annotate(
            name, tip, xytext=(6 if right else -5, 0), textcoords="offset points", fontsize=9.5, color=INK,
            ha="left" if right else "right", va="center",
        )  # fmt: skip
    tip = point(length, 0, 0)
    for vector, name in (((0, 1.0, 0), "u(t) about e2"), ((0, 0, 0.56), "u(t) about e3")):
        head = tip + point(*vector)
        moment(axes, tip, head, RED)
        below = name.endswith("e2")
        axes.annotate(
            name, head, xytext=(0, -4 if below else 4), textcoords="offset points", fontsize=9.5, color=RED,
            ha="center", va="top" if below else "bottom",
        )  # fmt: skip
    left, right = point(0, 0, -0.62), point(length, 0, -0.62)
    axes.annotate("", right, left, arrowprops={"arrowstyle": "<->", "color": GREY, "lw": 1.0})
    axes.annotate(
        "L = 1 m", (left + right) / 2, xytext=(0, 4), textcoords="offset points", ha="center", fontsize=9.5
    )
    axes.plot([0, 0], [ground - 0.12, -0.7], color=GREY, lw=0.7)
    axes.set(xlim=(-0.4, 3.25), ylim=(-0.8, 0.75), aspect="equal")
    axes.set_axis_off()


def draw_torque(axes: Axes) -> None:
    time = np.linspace(0, 0.5, 201)
    axes.plot([*time, 1.0], [*(0.5 * np.sin(4 * np.pi * time)), 0.0], color=RED, lw=1.8)
    axes.axhline(0, color="0.8", lw=0.8, zorder=0)
    clean(axes, "time [s]", "u [N m]")
    axes.set(xlim=(0, 1), ylim=(-0.6, 0.6), xticks=(0, 0.25, 0.5, 0.75, 1), yticks=(-0.5, 0, 0.5))
    heading(axes, "u = ½ sin 4πt until 0.5 s")


def draw_data(axes: Axes) -> None:
    axes.set_axis_off()
    for k, (name, value) in enumerate(DATA):
        y = 0.93 - k * 0.145
        colour = BLUE if "printed" in value else INK
        axes.text(0.0, y, name, fontsize=9.5, color=INK, va="center", transform=axes.transAxes)
        axes.text(0.56, y, value, fontsize=9.5, color=colour, va="center", transform=axes.transAxes)


def main() -> None:
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.5, 1.0))
    draw_beam(top.subplots())
    torque, data = bottom.subplots(1, 2, width_ratios=(1.0, 1.35))
    draw_torque(torque)
    draw_data(data)
    figure.savefig(TARGET, dpi=110)


if __name__ == "__main__":
    main()
