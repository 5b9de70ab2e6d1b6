"""The picture of critical loads: in what shape the model gives way at each of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import chosen_numbers, columns_of, within
from viscorod.pictures.plots.projection_view import Curves, View, mark_supports
from viscorod.pictures.plots.swinging_shapes import Swing
from viscorod.pictures.style import BLUE, GREY, SMALL, panels_close, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.buckling import Buckling

__all__ = ["draw_buckling"]

SIZE = 0.2
"""Largest displacement that is drawn, as a part of the model."""


def draw_buckling(
    result: Buckling, count: int | None = None, number: int | None = None, ax: Axes | None = None
) -> Figure:
    """Return the figure of critical shapes, each in the plane of its motion or in space.

    Args:
        result: what is drawn; count: how many are drawn, all by default.
        number: of the one that is drawn alone, from 1; ax: axes for it, by default for the first.

    Raises:
        InputError: there is no such load.
    """
    factors, positions = result.load_factors, result.positions
    drawn = chosen_numbers(len(factors), count, number, ax, "critical load")
    count = len(drawn)
    columns = columns_of(count)
    rows = max(-(-count // columns), 1)
    width, height = 1.2 + 3.6 * columns, 1.6 + 3.7 * rows
    picture = titled(result, width, height) if ax is None else within(ax)
    panels: list[tuple[Axes, View]] = []
    if not count:
        (picture if ax is None else ax).text(0.05, 0.5, "no critical load was found", fontsize=SMALL)
        return picture
    curves = Curves(result)
    still = np.asarray(result.data["rotation"].values, dtype=float)[-1]
    for panel, k in enumerate(drawn, 1):
        base = positions[k]
        reach = SIZE * float(np.max(np.ptp(base, axis=0)))
        swing = Swing.of(base, result.shapes[k], still, result.rotations[k], reach)
        axes = picture.add_subplot(rows, columns, panel) if ax is None else ax
        view = View.of(swing.all_lines, swept=swing.swept, lines=curves.points(base))
        kind = "linear" if not result.exact else "it snaps" if result.limit[k] else "it buckles"
        seen = f"{view.name}, edges of what twists" if swing.edge else view.name
        view.prepare(axes, f"{k + 1}: load factor {factors[k]:.5g}, {kind}\n{seen}")
        for line, label in zip(swing.lines(1.0), ("gives way to here", "_"), strict=False):
            curves.draw(axes, view, line, color=BLUE, linewidth=2.0, label=label)
        curves.draw(
            axes, view, base, color=GREY, linestyle=(0, (4, 3)), linewidth=1.1, label="critical state"
        )
        axes.margins(0.08)
        mark_supports(axes, view, result, base)
        axes.title.set_fontsize(SMALL)
        panels.append((axes, view))
    if ax is None:
        labelled = any(view.plane is not None for _, view in panels)
        panels_close(picture, rows, columns, labelled=labelled)
    for axes, view in panels:
        view.finish(axes)
    return picture
