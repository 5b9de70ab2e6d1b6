"""The picture of beam theories side by side: deflection, bending moment, and the motion where it is largest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import BLUE, GREEN, INK, ORANGE, clean, figure, heading, headline, legend_above
from viscorod.results.text_numbers import quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.theory_comparison import TheoryComparison

__all__ = ["draw_theories"]

COLOURS = {"euler_bernoulli": ORANGE, "timoshenko": GREEN, "von_karman": BLUE}
DASHES = {"euler_bernoulli": "-", "timoshenko": "--", "von_karman": "--"}


def draw_theories(found: TheoryComparison, ax: Axes | None = None) -> Figure:
    """Draw deflections and bending moments along the beam; of a motion those at the largest exact deflection.

    Into ``ax`` go the deflections alone.
    """
    moving = found.time.size > 1
    across = found.exact.displacement[..., 1]
    state, node = np.unravel_index(int(np.argmax(np.abs(across))), across.shape)
    rows = 3 if moving else 2
    if ax is None:
        picture = figure(10.0, 3.2 * rows)
        headline(picture, found.sentence.partition(":")[0])
        axes = list(picture.subplots(rows, 1))
    else:
        axes = [ax]
    for solution in (found.exact, *found.theories.values()):
        exact = solution is found.exact
        style = {
            "color": INK if exact else COLOURS[solution.word],
            "linewidth": 2.4 if exact else 1.6,
            "linestyle": "-" if exact else DASHES[solution.word],
            "label": solution.title,
        }
        axes[0].plot(found.s, solution.displacement[state, :, 1], **style)
        if ax is not None:
            continue
        axes[1].plot(found.point_s, solution.section_force[state, :, 2], **style)
        if moving:
            axes[2].plot(found.time, solution.displacement[:, node, 1], **style)
    clean(axes[0], "" if ax is None else "arc length [m]", "deflection [m]")
    if ax is not None:
        legend_above(ax, 4)
        return within(ax)
    clean(axes[1], "arc length [m]", "moment [N m]")
    legend_above(axes[0], 4)
    if moving:
        heading(axes[1], f"at {found.time[state]:.4g} s")
        clean(axes[2], "time [s]", f"deflection at {quantity(found.s[node], 'm', 4)} [m]")
    return picture
