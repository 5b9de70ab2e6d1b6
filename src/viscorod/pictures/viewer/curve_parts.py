"""What pages of curves are made of: charts of curves and marks, tables, and a place along the curves that is chosen.

Arrays are in the page's pack; what is drawn refers to rows of them. A row may be that of the chosen place: then it
changes with the slider.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.pictures.viewer.packing import Pack
from viscorod.typing import Floats

__all__ = ["CurveParts", "places"]


def places(count: int, most: int, kept: list[int] | None = None) -> np.ndarray:
    """Return numbers of ``count`` places, ``most`` of them evenly and those to be kept."""
    return np.unique([*np.linspace(0, count - 1, min(count, most)).round().astype(int), *(kept or [])])


class CurveParts:
    """Collects the parts of a page.

    Args:
        heading: of what it shows, in a line; slider: what is chosen along the curves, with its unit.
        places: values of that ``(n,)``; chosen: numbers of those of the result's that are shown.
    """

    def __init__(self, heading: str, slider: tuple[str, str], places: Floats, chosen: np.ndarray) -> None:
        self.pack, self.chosen, self.total = Pack(), chosen, len(places)
        self._arrays = 0
        self.meta: dict[str, Any] = {
            "heading": heading,
            "slider": {"label": slider[0], "unit": slider[1], "places": self.rows(places[chosen][None])},
            "choices": [],
            "charts": [],
            "live": {"head": [], "rows": []},
            "tables": [],
        }

    def rows(self, values: Floats) -> str:
        """Put an array ``(rows, n)`` into the page; return its name."""
        name = f"a{self._arrays}"
        self._arrays += 1
        self.pack.plain(name, np.atleast_2d(values))
        return name

    def choice(self, label: str, names: tuple[str, ...]) -> int:
        """Add a list of which one is chosen, and charts with it; return its number."""
        self.meta["choices"].append({"label": label, "names": list(names)})
        return len(self.meta["choices"]) - 1

    def chart(
        self,
        title: str,
        x: str,
        y: str,
        curves: list[dict[str, Any]],
        *,
        marks: list[dict[str, Any]] | None = None,
        guides: list[dict[str, Any]] | None = None,
        when: dict[int, int] | None = None,
        **more: Any,
    ) -> None:
        """Add a chart.

        Args:
            title: above it; x, y: labels of its axes with units; curves: see :meth:`curve`.
            marks: points with a text, ``{"x", "y", "text", "kind"}``; guides: grey lines ``{"x", "y", "text"}``.
            when: number of a choice -> what has to be chosen for it to be shown.
            more: ``log`` axes ("x", "y"), ``range`` of y, ``equal`` units on both axes, ``side``: beside the others,
                ``follows``: it shows the chosen place, ``turn``: of an angle, over which it jumps.
        """
        self.meta["charts"].append(
            {
                "title": title,
                "x": x,
                "y": y,
                "curves": curves,
                "marks": marks or [],
                "guides": guides or [],
                "when": {str(number): value for number, value in (when or {}).items()},
                **more,
            }
        )

    @staticmethod
    def curve(
        name: str,
        x: tuple[str, int],
        y: tuple[str, int],
        *,
        dashed: tuple[str, int] | None = None,
        colour: int = 0,
        points: bool = False,
    ) -> dict[str, Any]:
        """Return a curve.

        Args:
            name: in words; x, y: array and row, -1 for that of the chosen place.
            dashed: where it is not 0 the curve is dashed; colour: number of one; points: draw points, no line.
        """
        return {"name": name, "x": x, "y": y, "dashed": dashed, "colour": colour, "points": points}

    def table(self, title: str, head: list[str], rows: list[list[Any]]) -> None:
        """Add a table, if it has rows; numbers are written by the page."""
        if rows:
            self.meta["tables"].append({"title": title, "head": head, "rows": rows})

    def live(self, head: list[str], rows: list[list[Any]]) -> None:
        """Add the table of the chosen place; cells are texts, or arrays with a row of which the place is taken."""
        self.meta["live"] = {"head": head, "rows": rows}
