"""The picture of a section: axial stress, shear stress and von Mises stress over it, at one place and instant."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

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
from viscorod.results.stress import StressPatch, section_patch
from viscorod.results.text_numbers import quantity, scaled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

    from viscorod.results.result import Result
    from viscorod.typing import Floats

ARROWS = 130
"""About how many arrows show the shear stress."""
MILLIMETRES = 9e-3
"""A length [m] that is told in mm, as those of all sections are whose size is below a metre and no smaller."""


class _Panel(NamedTuple):
    """A stress over the section.

    Attributes:
        name: of the stress; values: at the points ``(n,)`` [Pa]; signed: it may be of either sign.
    """

    name: str
    values: Floats
    signed: bool = False


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
    patch = section_patch(result, place, time)
    width, height = np.ptp(patch.points, axis=0)
    beside = bool(height >= 0.5 * width)
    panels = (
        _Panel("axial stress s33", patch.stress[:, 2], signed=True),
        _Panel("shear stress |(s13, s23)|", np.linalg.norm(patch.stress[:, :2], axis=1)),
        _Panel("von Mises stress", patch.von_mises),
    )
    if ax is not None:
        picture = within(ax)
        drawn = _draw_panel(ax, patch, panels[2], beside=beside)
        _mark_largest(ax, patch)
        _colour_bar(picture, drawn, ax, "vertical", 0.03, 28)
        return picture
    # panels are 3 inches wide beside each other, 5.5 inches wide on top of each other
    tall = 2.5 + min(3.0 * height / width, 4.0) if beside else 1.4 + 3.0 * (0.9 + 5.5 * height / width)
    wide = 11.0 if beside else 7.6
    picture = titled(result, wide, tall)
    picture.subplots_adjust(
        left=0.8 / wide,
        right=1.0 - 0.2 / wide,
        bottom=(0.3 if beside else 0.65) / tall,
        top=1.0 - 1.2 / tall,
        wspace=0.3,
        hspace=0.9 / (5.5 * height / width),
    )
    bar = ("horizontal", 0.62 / (tall - 1.5), 28) if beside else ("vertical", 0.03, 6)
    marks = (None, _arrows, _mark_largest)
    for number, (panel, mark) in enumerate(zip(panels, marks, strict=True), 1):
        axes = picture.add_subplot(*((1, 3) if beside else (3, 1)), number)
        drawn = _draw_panel(axes, patch, panel, beside=beside)
        if beside and number > 1:
            axes.set_ylabel("")
        if mark is not None:
            mark(axes, patch)
        _colour_bar(picture, drawn, axes, *bar)
    text = f"{_what_is_shown(result, patch)}; {_largest(patch)}"
    picture.text(0.01, 1.0 - (0.62 if result.title else 0.35) / tall, text, fontsize=SMALL, color=INK)
    return picture


def _draw_panel(axes: Axes, patch: StressPatch, panel: _Panel, *, beside: bool) -> ScalarMappable:
    """Draw one stress over the section, whose outline it has, from light to strong; return what a bar explains.

    Args:
        beside: panels stand beside each other, not on top of each other.
    """
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.ticker import MaxNLocator
    from matplotlib.tri import Triangulation

    points, unit = _drawn_points(patch)
    # light to strong, so that dark arrows show everywhere
    heat = LinearSegmentedColormap.from_list("heat", colormaps["YlOrRd"](np.linspace(0.0, 0.72, 64)))
    factor, pascal = scaled("Pa", panel.values)
    top = factor * max(float(np.abs(panel.values).max()), np.finfo(float).tiny)
    drawn = axes.tripcolor(
        Triangulation(points[:, 0], points[:, 1], patch.triangles),
        factor * panel.values,
        shading="gouraud",
        cmap=colormaps["RdBu_r"] if panel.signed else heat,
        vmin=-top if panel.signed else 0.0,
        vmax=top,
        rasterized=True,
    )
    _outline(axes, points, patch.triangles)
    clean(axes, f"d1 [{unit}]", f"d2 [{unit}]")
    axes.grid(visible=False)
    axes.set_aspect("equal")
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.yaxis.set_major_locator(MaxNLocator(4 if beside else 2))
    heading(axes, f"{panel.name} [{pascal}]")
    return drawn


def _colour_bar(
    picture: Figure, drawn: ScalarMappable, axes: Axes, orientation: str, pad: float, aspect: float
) -> None:
    from matplotlib.ticker import MaxNLocator

    bar = picture.colorbar(drawn, ax=axes, orientation=orientation, pad=pad, aspect=aspect)
    bar.ax.tick_params(labelsize=SMALL)
    bar.locator = MaxNLocator(5)
    bar.update_ticks()


def _drawn_points(patch: StressPatch) -> tuple[Floats, str]:
    """Return the points as drawn ``(n, 2)``, and their unit."""
    reach = float(np.abs(patch.points).max())
    length, unit = scaled("m", reach if reach >= 1.0 else min(reach, MILLIMETRES))
    return length * patch.points, unit


def _mark_largest(axes: Axes, patch: StressPatch) -> None:
    """Mark the point of the largest von Mises stress."""
    at = _drawn_points(patch)[0][int(np.argmax(patch.von_mises))]
    axes.plot(*at, "o", color=BLUE, markersize=7, markeredgecolor="white", clip_on=False, zorder=5)


def _what_is_shown(result: Result, patch: StressPatch) -> str:
    """Return where the section is, and of which state."""
    level = {
        "time": f" at {quantity(patch.level, 's', 4)}",
        "load_factor": f" under {load_level(patch.level)}",
        "spin": f" at {patch.level:.4g} rad/s",
    }[result.dimension]
    return f"Section at {patch.place}{level}, d3 towards the reader"


def _largest(patch: StressPatch) -> str:
    """Return the largest von Mises stress in words."""
    factor, pascal = scaled("Pa", patch.von_mises)
    return f"largest von Mises stress {factor * patch.von_mises.max():.4g} {pascal} (dot)"


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


def _arrows(axes: Axes, patch: StressPatch) -> None:
    """Draw the shear stress as arrows on an even grid of places."""
    points, triangles, shear = _drawn_points(patch)[0], patch.triangles, patch.stress[:, :2]
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
