"""A picture as an object: a Matplotlib figure of no global state, shown in notebooks, written when asked."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from viscorod.errors import InputError
from viscorod.pictures.style import legend_inside, with_prefixes, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Picture", "chosen_numbers", "columns_of", "delivered", "within"]

_EDGE = 0.08
"""Above what stands on top of a picture without a title [inches]."""


class Picture(Figure):
    """A Matplotlib figure that pyplot does not know of, so that nothing has to close it."""

    def savefig(self, fname: Any, *, transparent: bool | None = None, **kwargs: Any) -> None:
        """Write the picture as Matplotlib does; without a title, the band that is left for one is cut away."""
        if not self.get_suptitle() and kwargs.get("bbox_inches") is None:
            width, height = self.get_size_inches()
            top = min(height, self.get_tightbbox().y1 + _EDGE)
            kwargs["bbox_inches"] = Bbox([[0.0, 0.0], [width, top]])
        super().savefig(fname, transparent=transparent, **kwargs)

    def _repr_png_(self) -> bytes:
        """Return what a notebook shows."""
        content = io.BytesIO()
        self.savefig(content, format="png")
        return content.getvalue()

    def show(self, warn: bool = True) -> None:
        """Open the picture in a window, as pyplot does."""
        del warn  # Matplotlib's word for what cannot happen here
        import matplotlib.pyplot as plt

        manager = plt.figure(figsize=tuple(self.get_size_inches())).canvas.manager
        assert manager is not None
        manager.canvas.figure = self
        self.set_canvas(manager.canvas)
        plt.show()


def delivered(picture: Figure, path: str | Path | None) -> Figure:
    """Return a picture, written to a file first if there is a path.

    Raises:
        InputError: the suffix names no format, or the place cannot be written.
    """
    if isinstance(picture, Picture):  # axes of the user's keep the units that they have
        with_prefixes(picture)
    if path is not None:
        write(picture, path)
    return picture


def within(axes: Axes) -> Figure:
    """Return the figure of axes of the user's, in which one panel was drawn; the legend goes inside them."""
    if axes.get_legend() is not None:
        legend_inside(axes)
    return axes.figure.canvas.figure  # of a subfigure the whole


def chosen_numbers(
    known: int, count: int | None, number: int | None, ax: Axes | None, noun: str
) -> list[int]:
    """Return which of several shapes are drawn, from 0: the first ``count``, or one alone.

    Raises:
        InputError: there is no such shape.
    """
    for name, value in (("count", count), ("number", number)):
        whole = isinstance(value, int) and not isinstance(value, bool)
        if value is not None and not (whole and 1 <= value <= (known if name == "number" else value)):
            raise InputError(
                f"{name} = {value!r}: there is no such {noun}; give a whole number from 1 to {max(known, 1)}"
            )
    if number is not None or ax is not None:
        return [number - 1 if number else 0][:known]
    return list(range(min(count or known, known)))


def columns_of(panels: int) -> int:
    """Return in how many columns panels stand: four of them two by two, others up to three beside each other."""
    return 2 if panels == 4 else max(min(panels, 3), 1)
