"""Labels that find room: near what they name, off lines and off each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from viscorod.pictures.style import GREY, INK, SMALL
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DIRECTIONS = np.array([(1, 1), (-1, 1), (1, -1), (-1, -1), (0, 1), (0, -1), (1, 0), (-1, 0)], dtype=float)
_DISTANCES = (6.0, 12.0, 22.0, 36.0)
"""From the point to the text [pixels at 72 per inch]."""
_FITS, _STEEP = 1.05, 3.0
"""Of a line beside which a text stands turned: its length over that of the text, its rise over its run."""
_TURNED = 2.0
"""What it costs to read a text that is turned, in points of lines that it hides."""
_OF_SYMBOL = 6
"""Points of a symbol along each of its sides."""
_FAR = 18.0
"""Distance from which on a line leads from the point to its text."""


@dataclass(frozen=True)
class Label:
    """A text at a point on paper; ``along`` is a direction beside which it may stand turned, (2,)."""

    point: Floats
    text: str
    colour: str
    along: Floats | None = None


class Labels:
    """Collects labels, and lines and symbols to keep clear of, in the paper's coordinates."""

    def __init__(self) -> None:
        self._labels: list[Label] = []
        self._taken: list[Floats] = []
        self._symbols: list[tuple[Floats, float]] = []

    def add(self, point: Floats, text: str, colour: str = INK, along: Floats | None = None) -> None:
        """Ask for a text near a point (2,); ``along`` the line there, of the length of that, it may stand turned."""
        self._labels.append(Label(np.asarray(point, dtype=float), text, colour, along))

    def avoid(self, points: Floats) -> None:
        """Keep texts off points ``(2, n)``, which lines have enough of."""
        self._taken.append(np.asarray(points, dtype=float).reshape(2, -1))

    def avoid_symbols(self, points: Floats, size: float) -> None:
        """Keep texts off symbols of a size [pixels at 72 per inch] at points ``(2, n)``."""
        self._symbols.append((np.asarray(points, dtype=float).reshape(2, -1), size))

    def place(self, axes: Axes) -> None:
        """Write all labels, once everything else is drawn; what is in the way is what :meth:`avoid` was told."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        figure = axes.get_figure(root=True)
        assert figure is not None
        figure.draw_without_rendering()  # settles the limits
        axes.set_xlim(axes.get_xlim())
        axes.set_ylim(axes.get_ylim())
        canvas: Any = figure.canvas
        assert isinstance(figure.canvas, FigureCanvasAgg)
        renderer = canvas.get_renderer()
        dot = figure.dpi / 72.0
        pixels = axes.transData.transform
        taken = pixels(np.concatenate([np.zeros((2, 0)), *self._taken], axis=1).T)
        frame = axes.get_window_extent(renderer)
        boxes = np.zeros((0, 4))
        symbols = [_filled(pixels(points.T), dot * size) for points, size in self._symbols]
        lines = np.concatenate([taken, *symbols])
        for label in self._labels:
            text = axes.annotate(
                label.text,
                tuple(label.point),
                (0.0, 0.0),
                textcoords="offset points",
                fontsize=SMALL,
                color=label.colour,
                ha="center",
                va="center",
                zorder=9,
            )
            extent = text.get_window_extent(renderer)
            half = 0.5 * np.array([extent.width, extent.height]) + dot
            at = pixels(label.point)
            run = None if label.along is None else pixels(label.point + label.along) - at
            _, chosen = _best(_choices(half, run, dot), at, lines, boxes, frame)
            text.set_position(tuple(chosen.shift / dot))
            text.set_rotation(chosen.angle)
            box = np.concatenate([at + chosen.shift - chosen.half, at + chosen.shift + chosen.half])
            boxes = np.append(boxes, box[None], axis=0)
            gap = np.maximum(np.abs(chosen.shift) - chosen.half, 0.0)
            if float(np.hypot(*gap)) > _FAR * dot:
                near = chosen.shift - np.clip(chosen.shift, -chosen.half, chosen.half)
                _draw_leader(axes, label.point, near / dot)


def _choices(half: Floats, run: Floats | None, dot: float) -> list[_Choice]:
    """Return the ways to set a text: level, and upright beside a steep line that is long enough, all in pixels.

    Args:
        half: of the sides of the text (2,); run: of the line (2,), None without one; dot: pixels of a point.
    """
    choices = [_Choice(half, 0.0, _around(half, dot))]
    if run is not None:
        length = float(np.linalg.norm(run))
        if length > _FITS * 2.0 * half[0] and abs(run[1]) > _STEEP * abs(run[0]):
            beside = np.array([half[1] + 4.0 * dot, 0.0])
            choices.append(_Choice(half[::-1], 90.0, [(0, beside), (0, -beside)]))
    return choices


def _draw_leader(axes: Axes, point: Floats, near: Floats) -> None:
    """Draw a line from a point to the nearest corner or side of its text, ``near`` points away."""
    line = {"arrowstyle": "-", "color": GREY, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 2.0}
    axes.annotate("", tuple(point), tuple(near), textcoords="offset points", arrowprops=line)


def _filled(centres: Floats, size: float) -> Floats:
    """Return points all over symbols of a size about their centres ``(n, 2)``, all in pixels."""
    reach = 0.5 * size * np.linspace(-1.0, 1.0, _OF_SYMBOL)
    grid = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
    found: Floats = (centres[:, None] + grid).reshape(-1, 2)
    return found


class _Choice(NamedTuple):
    """A way to set a text: half of its sides, its angle [degrees], and shifts with their ranks, all in pixels."""

    half: Floats
    angle: float
    shifts: list[tuple[int, Floats]]


class _Set(NamedTuple):
    """How a text is set."""

    half: Floats
    angle: float
    shift: Floats


def _around(half: Floats, dot: float) -> list[tuple[int, Floats]]:
    """Return shifts of a text about its point, the nearest first."""
    return [
        (rank, direction * (half + dot * distance / max(1.0, float(np.abs(direction).sum()) ** 0.5)))
        for rank, distance in enumerate(_DISTANCES)
        for direction in _DIRECTIONS
    ]


def _best(choices: list[_Choice], at: Floats, lines: Floats, boxes: Floats, frame: Any) -> tuple[float, _Set]:
    """Return the way of setting a text that hides least, and its cost."""
    best, chosen = np.inf, _Set(choices[0].half, 0.0, np.zeros(2))
    for half, angle, shifts in choices:
        for rank, shift in shifts:
            low, high = at + shift - half, at + shift + half
            hidden = np.count_nonzero(np.all((lines > low) & (lines < high), axis=1))
            crossed = np.count_nonzero(
                (boxes[:, 0] < high[0])
                & (boxes[:, 2] > low[0])
                & (boxes[:, 1] < high[1])
                & (boxes[:, 3] > low[1])
            )
            outside = not (
                frame.x0 < low[0] and high[0] < frame.x1 and frame.y0 < low[1] and high[1] < frame.y1
            )
            cost = 1.0 * hidden + 300.0 * crossed + 300.0 * outside + 1.5 * rank + (_TURNED if angle else 0.0)
            if cost < best:
                best, chosen = cost, _Set(half, angle, shift)
    return best, chosen
