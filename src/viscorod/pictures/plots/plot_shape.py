"""The picture of a static equilibrium, or of the shape that turns steadily."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.plots.assemblies import Assembly
from viscorod.pictures.plots.projection_view import Curves, View, draw_reference, mark_supports
from viscorod.pictures.style import BLUE, SKY, figure, headline, legend_over
from viscorod.results.reports.report_parts import load_level

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.results.steady_result import Steady


def draw_shape(equilibrium: Equilibrium | Steady, ax: Axes | None = None) -> Figure:
    """Return the figure of the reference shape, the load steps and the equilibrium, into ``ax`` if it is given."""
    if ax is not None:
        draw_shapes(ax, equilibrium)
        return within(ax)
    picture = figure(8.0, 6.4)
    if equilibrium.title:
        headline(picture, equilibrium.title)
    draw_shapes(picture.add_subplot(), equilibrium, columns=4)
    return picture


def draw_shapes(axes: Axes, equilibrium: Equilibrium | Steady, columns: int = 2) -> None:
    """Draw the shapes into an axes, with so many columns in their legend."""
    positions = equilibrium.field("position")
    reference = np.asarray(equilibrium.data["reference_position"].values, dtype=float)
    rotations = np.asarray(equilibrium.data["rotation"].values, dtype=float)
    assembly = Assembly(equilibrium)
    ends = assembly.ends(positions[-1], rotations[-1]).reshape(-1, 3)
    view = View.of(np.concatenate([*positions, reference, ends]), enlarged=assembly.empty)
    turning = equilibrium.kind == "steady"
    view.prepare(axes, f"{'Steady rotation' if turning else 'Static equilibrium'} {view.name}")
    curves = Curves(equilibrium)
    draw_reference(axes, view, curves, equilibrium)
    label = "on the way"
    level = equilibrium.data[equilibrium.dimension].values
    for factor, position in zip(level[:-1], positions[:-1], strict=True):
        if factor != 0.0:
            curves.draw(axes, view, position, color=SKY, linewidth=1.0, label=label)
            label = "_"
    reached = level[-1]
    name = "equilibrium" if reached == 1.0 else f"at {load_level(reached, 3)}"
    if turning:
        name = f"at {reached:.3g} rad/s"
    curves.draw(axes, view, positions[-1], color=BLUE, linewidth=2.4, label=name)
    if not assembly.empty:
        assembly.draw(axes, view, positions[-1], rotations[-1], BLUE)
        assembly.draw_springs(axes, view, positions[-1], rotations[-1], BLUE)
    mark_supports(axes, view, equilibrium, positions[-1])
    view.finish(axes)
    legend_over(axes, columns)
