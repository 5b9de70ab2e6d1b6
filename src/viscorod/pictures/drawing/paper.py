"""The paper that a model is drawn on: lines, symbols and arrows at points in space, with labels that keep off them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.pictures.drawing.labels import Labels
from viscorod.pictures.style import label_once
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from viscorod.pictures.plots.projection_view import View

__all__ = ["ARROW", "MOST_NAMES", "SIDEWAYS", "Paper"]

MOST_NAMES = 12
"""Parts of a kind that are named in the picture."""
ARROW = 0.13
"""Length of an arrow as a part of the model's size."""
SIDEWAYS = 0.2
"""Part of its length below which an arrow counts as standing on the paper."""
_HEAD = 9.0


class Paper:
    """An axes with a view of space.

    Attributes:
        axes, view: where and how; labels: that are placed when all is drawn.
        size: of the model [m].
    """

    axes: Axes
    view: View
    labels: Labels
    size: float

    def line(self, points: Floats, **style: Any) -> None:
        """Draw a line through points ``(n, 3)`` [m] that labels keep off."""
        paper = self.view.on_paper(points)
        self.axes.plot(*paper, **style)
        if len(points) == 2:
            paper = paper[:, :1] + (paper[:, 1:] - paper[:, :1]) * np.linspace(0.0, 1.0, 25)
        self.labels.avoid(paper)

    def symbols(self, points: Floats, marker: str, size: float, name: str, **style: Any) -> None:
        """Draw a symbol at points ``(n, 3)`` [m]."""
        paper = self.view.on_paper(points)
        self.axes.plot(
            *paper, marker, markersize=size, linestyle="none", label=label_once(self.axes, name), **style
        )
        self.labels.avoid_symbols(paper, size)

    def arrow(self, tail: Floats, tip: Floats, colour: str, style: str) -> None:
        """Draw an arrow between two points of the paper (2,)."""
        self.axes.annotate(
            "",
            tuple(tip),
            tuple(tail),
            zorder=6,
            arrowprops={
                "arrowstyle": style, "color": colour, "linewidth": 1.4, "mutation_scale": _HEAD, "shrinkA": 0.0,
                "shrinkB": 0.0,
            },
        )  # fmt: skip
        self.axes.update_datalim([tuple(tail), tuple(tip)])
        self.labels.avoid(tail[:, None] + (tip - tail)[:, None] * np.linspace(0.0, 1.0, 15))
