"""Draw the figure of docs/howto/precurved.md: reference shapes as ribbons that show the section's first axis.

python docs/figures/precurved.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection

import viscorod as vr
from viscorod.pictures.style import BLUE, INK, RED, SKY, figure, heading, write

TARGET = Path(__file__).parents[1] / "images" / "precurved.png"
EYE = np.array([[0.866, 0.5, 0.0], [-0.211, 0.366, 0.906]])  # right and up on paper
AWAY = -np.cross(*EYE)  # from the eye
WIDTH = 0.012


def rods() -> dict[str, vr.Rod]:
    """Return the rods of the page."""
    rubber = vr.Material(3e6, poissons_ratio=0.49, density=1100.0)
    strip = {"section": vr.Rectangle(WIDTH, 0.001), "material": rubber}
    return {
        "Rod.arc, d1 along the axis": vr.Rod.arc(
            (0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, np.pi / 2, d1=(0, 0, 1), **strip
        ),
        "Rod.helix": vr.Rod.helix(0.02, 0.03, 2.5, axis=(0, 0, -1), **strip),
        "Rod.through points": vr.Rod.through(
            [(0, 0, 0), (0.05, 0.03, 0), (0.1, 0, 0.02), (0.15, 0, 0)], **strip
        ),
        "Rod.curve": vr.Rod.curve(lambda u: (0.2 * u, 0, 0.02 * np.sin(2 * np.pi * u)), **strip),
        "Rod.straight, twist of a turn": vr.Rod.straight((0, 0, 0), (0.2, 0, 0), twist=2 * np.pi, **strip),
        "Rod.arc, twist of a turn": vr.Rod.arc(
            (0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, np.pi / 2, twist=2 * np.pi, **strip
        ),
    }


def main() -> None:
    picture = figure(10.0, 4.6)
    for axes, (name, rod) in zip(picture.subplots(2, 3).flat, rods().items(), strict=True):
        centre, frame = rod.frames(np.linspace(0.0, rod.length, 301))
        across = 0.5 * WIDTH * frame[:, :, 0]
        edges = [(centre + side * across) @ EYE.T for side in (-1.0, 1.0)]
        faces = np.stack([edges[0][:-1], edges[1][:-1], edges[1][1:], edges[0][1:]], axis=1)
        a, b = faces[:, 1] - faces[:, 0], faces[:, 3] - faces[:, 0]
        front = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0.0
        depth = np.argsort((centre[1:] + centre[:-1]) @ AWAY)[::-1]  # the farthest first
        colours = np.where(front, BLUE, SKY)
        axes.add_collection(
            PolyCollection(faces[depth], facecolors=colours[depth], edgecolors=colours[depth], linewidths=0.4)
        )
        line = centre @ EYE.T
        axes.plot(*line[0], "s", color=INK, markersize=6)
        tip = (centre[0] + 2.2 * across[0]) @ EYE.T
        axes.annotate("", tip, line[0], arrowprops={"arrowstyle": "->", "color": RED, "linewidth": 1.6})
        axes.set_aspect("equal")
        low, high = faces.reshape(-1, 2).min(axis=0) - 0.01, faces.reshape(-1, 2).max(axis=0) + 0.01
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        axes.set_axis_off()
        heading(axes, name)
    write(picture, TARGET)


if __name__ == "__main__":
    main()
