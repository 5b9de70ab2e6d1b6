"""Draw the figure of docs/howto/sections.md and print its numbers.

python docs/figures/composite_section.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

import viscorod as vr
from viscorod.pictures.style import BLUE, GREY, INK, LIGHT, ORANGE, RED, SMALL, TEXT, figure, write

TARGET = Path(__file__).parents[1] / "images" / "composite_section.png"
MM = 1e3


def channel() -> vr.Composite:
    """Return an aluminium channel, 40 x 60 mm with walls of 3 mm, with a viscoelastic layer of 4 mm on its web."""
    aluminium = vr.Material(7e10, 0.33, 2700.0, damping=vr.KelvinVoigt(shear_time=1e-7, bulk_time=1e-7))
    layer = vr.Material(5e8, 0.45, 1400.0, damping=vr.KelvinVoigt(shear_time=2e-4, bulk_time=5e-5))
    walls = [(0, -0.03), (0.04, -0.03), (0.04, -0.027), (0.003, -0.027),
             (0.003, 0.027), (0.04, 0.027), (0.04, 0.03), (0, 0.03)]  # fmt: skip
    return vr.Composite(
        [
            vr.CompositeRegion(aluminium, points=walls),
            vr.CompositeRegion(layer, vr.Rectangle(0.004, 0.06), at=(-0.002, 0.0)),
        ],
        origin="given",
    )


def main() -> None:
    section = channel()
    picture = figure(7.2, 5.4)
    axes = picture.add_subplot()
    for region, colour, name in zip(section.regions, (LIGHT, ORANGE), ("aluminium", "layer"), strict=True):
        outline, _ = region.polygon
        ring = MM * np.array([*outline, outline[0]])
        axes.add_patch(PathPatch(Outline(ring), facecolor=colour, edgecolor=GREY, linewidth=1.0))
        at = {"aluminium": (30.0, 24.2), "layer": (-4.6, -24.0)}[name]
        axes.text(*at, name, ha="right" if name == "layer" else "center", va="top", fontsize=SMALL, color=INK)
    for direction, label in (((24.0, 0.0), "$d_1$"), ((0.0, 24.0), "$d_2$")):
        axes.annotate("", direction, (0, 0), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.6})
        axes.text(direction[0] + 0.8, direction[1] - 0.8, label, fontsize=TEXT, color=INK)
    centres = section.centres
    marks = (
        ("centre line", centres.origin, "o", INK, (4.5, -10.0)),
        ("tension centre", centres.tension_centre, "s", BLUE, (-1.0, 2.6)),
        ("mass centre", centres.mass_centre, "^", GREY, (-1.0, -5.0)),
        ("shear centre", centres.shear_centre, "D", RED, (0.0, 2.6)),
    )
    for label, point, marker, colour, shift in marks:
        x, y = MM * np.array(point)
        axes.plot([x], [y], marker, color=colour, markersize=8, zorder=5)
        if label == "centre line":  # far enough off to need a pointer
            axes.plot([x, x + 4.2], [y, y - 9.0], color=INK, linewidth=0.8)
        axes.text(x + shift[0], y + shift[1], label, ha="left" if label != "shear centre" else "center",
                  fontsize=SMALL, color=colour)  # fmt: skip
    axes.set(
        xlim=(-27, 47), ylim=(-34, 34), aspect="equal", xlabel="along $d_1$ [mm]", ylabel="along $d_2$ [mm]"
    )
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title("A channel with a damping layer, and its four points", loc="left", fontsize=TEXT)
    write(picture, TARGET)
    C, D, _ = section.matrices()
    print(centres)
    with np.printoptions(precision=4, linewidth=120):
        print(C, D, np.diag(D) / np.diag(C), section.remarks(), sep="\n")


if __name__ == "__main__":
    main()
