"""The picture of a static equilibrium, or of the shape that turns steadily."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.plots.assemblies import Assembly
from viscorod.pictures.plots.projection_view import Curves, View, draw_reference, mark_supports
from viscorod.pictures.style import BLUE, SKY, figure, headline, legend_over
from viscorod.results.reports.report_parts import load_level

_ON_THE_WAY = 3
"""States before the last that are drawn of what is coiled."""

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
    curves = Curves(equilibrium)
    everything = np.concatenate([*positions, reference, ends])
    view = View.of(everything, enlarged=assembly.empty, lines=curves.points(positions[-1]))
    coiled = curves.coiled(reference)
    turning = equilibrium.kind == "steady"
    beside = ", side by side" if coiled else ""
    view.prepare(axes, f"{'Steady rotation' if turning else 'Static equilibrium'} {view.name}{beside}")
    level = equilibrium.data[equilibrium.dimension].values
    passed = np.flatnonzero(level[:-1])
    if coiled:  # states that would hide each other
        passed = passed[np.unique(np.linspace(0, passed.size - 1, min(passed.size, _ON_THE_WAY)).astype(int))]
    shapes = [reference, *positions[passed], positions[-1]]
    shifts = view.strip(np.array(shapes)) if coiled else np.zeros((len(shapes), 3))
    draw_reference(axes, view, curves, equilibrium)
    for place, (shape, shift) in enumerate(zip(shapes[1:-1], shifts[1:-1], strict=True)):
        label = "_" if place else "on the way"
        curves.draw(axes, view, shape + shift, color=SKY, linewidth=1.0, label=label)
    reached = level[-1]
    name = "equilibrium" if reached == 1.0 else f"at {load_level(reached, 3)}"
    if turning:
        name = f"at {reached:.3g} rad/s"
    last = shifts[-1]
    curves.draw(axes, view, positions[-1] + last, color=BLUE, linewidth=2.4, label=name)
    if not assembly.empty:
        assembly.draw(axes, view.shifted(last), positions[-1], rotations[-1], BLUE)
        assembly.draw_springs(axes, view.shifted(last), positions[-1], rotations[-1], BLUE)
    mark_supports(axes, view, equilibrium, positions[-1] + last)
    view.finish(axes)
    legend_over(axes, columns)
