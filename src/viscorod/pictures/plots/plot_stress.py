"""The picture of a section: axial stress, shear stress and von Mises stress over it, at one place and instant."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    INK,
    SMALL,
    clean,
    heading,
    titled,
)
from viscorod.results.reports.report_parts import load_level
from viscorod.results.stress import section_patch
from viscorod.results.text_numbers import quantity, scaled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.result import Result
    from viscorod.typing import Floats

ARROWS = 130
"""About how many arrows show the shear stress."""
MILLIMETRES = 9e-3
"""A length [m] that is told in mm, as those of all sections are whose size is below a metre and no smaller."""


def draw_stress(
    result: Result, place: str | int, time: float | None = None, ax: Axes | None = None
) -> Figure:
    """Return the figure of the stresses over the section at a place.

    Args:
        result: a run, an equilibrium or a steady rotation.
        place: on a rod.
        time: of a run [s]; by default the stored one with the largest von Mises stress there. Of others the last state.
        ax: axes for the von Mises stress alone.
    """
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.ticker import MaxNLocator
    from matplotlib.tri import Triangulation

    patch = section_patch(result, place, time)
    width, height = np.ptp(patch.points, axis=0)
    beside = bool(height >= 0.5 * width)
    # panels are 3 inches wide beside each other, 5.5 inches wide on top of each other
    size = (
        (11.0, 2.5 + min(3.0 * height / width, 4.0))
        if beside
        else (7.6, 1.4 + 3.0 * (0.9 + 5.5 * height / width))
    )
    picture = titled(result, *size) if ax is None else within(ax)
    if ax is None:
        picture.subplots_adjust(
            left=0.8 / size[0],
            right=1.0 - 0.2 / size[0],
            bottom=(0.3 if beside else 0.65) / size[1],
            top=1.0 - 1.2 / size[1],
            wspace=0.3,
            hspace=0.9 / (5.5 * height / width),
        )
    reach = float(np.abs(patch.points).max())
    length, unit = scaled("m", reach if reach >= 1.0 else min(reach, MILLIMETRES))
    points = length * patch.points
    grid = Triangulation(points[:, 0], points[:, 1], patch.triangles)
    across, along = np.linalg.norm(patch.stress[:, :2], axis=1), patch.stress[:, 2]
    # light to strong, so that dark arrows show everywhere
    heat = LinearSegmentedColormap.from_list("heat", colormaps["YlOrRd"](np.linspace(0.0, 0.72, 64)))
    panels = (
        ("axial stress s33", along, "RdBu_r", True),
        ("shear stress |(s13, s23)|", across, "heat", False),
        ("von Mises stress", patch.von_mises, "heat", False),
    )
    for number, (name, values, colours, signed) in enumerate(panels, 1):
        if ax is not None and number < len(panels):
            continue
        axes = picture.add_subplot(*((1, 3) if beside else (3, 1)), number) if ax is None else ax
        factor, pascal = scaled("Pa", values)
        top = factor * max(float(np.abs(values).max()), np.finfo(float).tiny)
        drawn = axes.tripcolor(
            grid,
            factor * values,
            shading="gouraud",
            cmap=heat if colours == "heat" else colormaps[colours],
            vmin=-top if signed else 0.0,
            vmax=top,
            rasterized=True,
        )
        _outline(axes, points, patch.triangles)
        if number == 2:
            _arrows(axes, points, patch.triangles, patch.stress[:, :2])
        if number == 3:
            at = points[int(np.argmax(values))]
            axes.plot(*at, "o", color=BLUE, markersize=7, markeredgecolor="white", clip_on=False, zorder=5)
        clean(axes, f"d1 [{unit}]", f"d2 [{unit}]" if number == 1 or not beside else "")
        axes.grid(visible=False)
        axes.set_aspect("equal")
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.yaxis.set_major_locator(MaxNLocator(4 if beside else 2))
        heading(axes, f"{name} [{pascal}]")
        bar = picture.colorbar(
            drawn,
            ax=axes,
            orientation="horizontal" if beside and ax is None else "vertical",
            pad=0.62 / (size[1] - 1.5) if beside and ax is None else 0.03,
            aspect=28 if beside or ax is not None else 6,
        )
        bar.ax.tick_params(labelsize=SMALL)
        bar.locator = MaxNLocator(5)
        bar.update_ticks()
    if ax is not None:
        return picture
    level = {
        "time": f" at {quantity(patch.level, 's', 4)}",
        "load_factor": f" under {load_level(patch.level)}",
        "spin": f" at {patch.level:.4g} rad/s",
    }[result.dimension]
    factor, pascal = scaled("Pa", patch.von_mises)
    largest = f"largest von Mises stress {factor * patch.von_mises.max():.4g} {pascal} (dot)"
    text = f"Section at {patch.place}{level}, d3 towards the reader; {largest}"
    picture.text(0.01, 1.0 - (0.62 if result.title else 0.35) / size[1], text, fontsize=SMALL, color=INK)
    return picture


def _outline(axes: Axes, points: Floats, triangles: np.ndarray) -> None:
    """Draw the edges that belong to one triangle only, where points that lie upon each other are one."""
    from matplotlib.collections import LineCollection

    size = np.ptp(points, axis=0).max()
    keys = np.unique(np.round(points / size, 7), axis=0, return_inverse=True)[1].reshape(-1)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    names = np.sort(keys[edges], axis=1)
    _, first, count = np.unique(names, axis=0, return_index=True, return_counts=True)
    border = edges[first[(count == 1) & (names[first, 0] != names[first, 1])]]
    axes.add_collection(LineCollection(points[border], colors=INK, linewidths=0.9))


def _arrows(axes: Axes, points: Floats, triangles: np.ndarray, shear: Floats) -> None:
    """Draw the shear stress as arrows on an even grid of places."""
    largest = np.linalg.norm(shear, axis=1).max()
    if not largest > 0.0:
        return
    corners = points[triangles]
    (ux, uy), (vx, vy) = ((corners[:, k] - corners[:, 0]).T for k in (1, 2))
    low, step = points.min(axis=0), np.sqrt(0.5 * np.abs(ux * vy - uy * vx).sum() / ARROWS)
    cell = np.floor((points - low) / step).astype(int)
    middle = low + (cell + 0.5) * step
    off = np.linalg.norm(points - middle, axis=1)
    order = np.lexsort((off, cell[:, 1], cell[:, 0]))
    chosen = order[np.unique(cell[order], axis=0, return_index=True)[1]]
    chosen = chosen[off[chosen] < 0.45 * step]
    axes.quiver(
        *points[chosen].T,
        *(shear[chosen] / largest).T,
        color=INK,
        angles="xy",
        scale_units="xy",
        scale=1.0 / (1.1 * step),
        width=0.005,
        headwidth=4.0,
    )
