"""The picture of a path of equilibria: loads over displacement beside the shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.plots.plot_shape import draw_shapes
from viscorod.pictures.style import BLUE, INK, ORANGE, RED, clean, figure, heading, headline, legend_inside
from viscorod.results.data_schema import AXES
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.equilibrium_result import Equilibrium


def draw_path(path: Equilibrium, ax: Axes | None = None) -> Figure:
    """Return the figure of a path: the load factor over the displacement that changes most, and the shapes.

    Into ``ax`` goes the curve alone.
    """
    if ax is not None:
        _curve(ax, path)
        return within(ax)
    picture = figure(12.0, 5.6)
    if path.title:
        headline(picture, path.title)
    curve, shapes = picture.subplots(1, 2)
    _curve(curve, path)
    draw_shapes(shapes, path)
    return picture


def _curve(curve: Axes, path: Equilibrium) -> None:
    """Draw the load factor over the displacement that changes most."""
    site, axis = path.main_motion
    moved = path.vector(site, "displacement")[:, AXES.index(axis)]
    scale, unit = scaled("m", moved)
    moved, factors = scale * moved, path.load_factor
    unstable = np.asarray(path.data["negative_eigenvalues"].values) > 0
    # a segment is stable where both of its ends are, apart from the limit point or bifurcation in it
    special = np.concatenate([path.special_points(kind) for kind in ("limit_points", "bifurcations")])
    doubtful = unstable.copy()
    doubtful[special] = False
    either = doubtful[:-1] | doubtful[1:]
    either |= unstable[:-1] & unstable[1:]
    for chosen, colour, style, label in (
        (~either, BLUE, "-", "stable"),
        (either, RED, "--", "unstable"),
    ):
        if chosen.any():
            x, y = (_pieces(values, chosen) for values in (moved, factors))
            curve.plot(x, y, color=colour, linestyle=style, linewidth=1.8, label=label)
    for kind, marker, label in (("limit_points", "o", "limit point"), ("bifurcations", "D", "bifurcation")):
        at = path.special_points(kind)
        if len(at):
            curve.plot(moved[at], factors[at], marker, color=ORANGE, markeredgecolor=INK, label=label)
    clean(curve, f"displacement of {site.label} along {axis} [{unit}]", "load factor")
    heading(curve, "Path of equilibria")
    legend_inside(curve)


def _pieces(values: Floats, chosen: np.ndarray) -> Floats:
    """Return the points of chosen segments, with gaps between runs of segments."""
    shown = np.append(chosen, False)
    shown[1:] |= chosen
    pieces = np.where(shown, values, np.nan)
    # two runs of other segments may meet in one point that belongs to no chosen segment beside it
    alone = np.flatnonzero(shown[:-1] & shown[1:] & ~chosen) + 1
    result: Floats = np.insert(pieces, alone, np.nan)
    return result
