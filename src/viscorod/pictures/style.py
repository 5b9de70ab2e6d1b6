"""The style of pictures: figures without global state, a palette for every eye, units in readable sizes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from viscorod.errors import InputError
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure, SubFigure

    from viscorod.results.result import Result

# Okabe and Ito's palette, told apart by readers with any kind of colour vision.
BLUE, ORANGE, GREEN, RED, SKY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9"
PURPLE = "#CC79A7"
INK, GREY, LIGHT = "#222222", "#8a8a8a", "#d8d8d8"
TEXT, SMALL = 11.0, 9.5
DPI = 120

_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of the given size [inches] that no global state knows.

    Margins are fixed: measuring all texts for a layout takes longer than drawing them.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from viscorod.pictures.picture import Picture

    result = Picture(figsize=(width, height), dpi=DPI)
    result.subplots_adjust(
        left=0.9 / width,
        right=1.0 - 0.25 / width,
        bottom=0.6 / height,
        top=1.0 - 0.75 / height,
        wspace=0.24,
        hspace=0.33,
    )
    FigureCanvasAgg(result)
    return result


def legend_of_all(picture: Figure, height: float) -> None:
    """Put what the first panel names, without shadows, above all panels of a picture [inches]."""
    handles, labels = picture.axes[0].get_legend_handles_labels()
    wanted = [k for k, label in enumerate(labels) if "shadow" not in label]
    picture.legend(
        [handles[k] for k in wanted],
        [labels[k] for k in wanted],
        loc="upper left",
        bbox_to_anchor=(0.005, 1.0 - 0.36 / height),
        ncols=4,
        frameon=False,
        fontsize=SMALL,
    )


def titled(result: Result, width: float, height: float) -> Figure:
    """Return an empty figure [inches] with the title of the case, if it has one."""
    picture = figure(width, height)
    if result.title:
        picture.suptitle(result.title, fontsize=TEXT + 2.0, x=0.01, ha="left")
    return picture


def time_colours() -> LinearSegmentedColormap:
    """Return the colours of instants, early to late; the light end of viridis would not show on white."""
    from matplotlib import colormaps
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("time", colormaps["viridis"](np.linspace(0.0, 0.88, 64)))


def colour_bar(picture: Figure | SubFigure, axes: Axes, mappable: ScalarMappable, label: str) -> None:
    """Put a labelled colour bar beside an axes."""
    bar = picture.colorbar(mappable, ax=axes, aspect=28, pad=0.03)
    bar.set_label(label, fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)


def write(picture: Figure, path: str | Path) -> Path:
    """Write a figure in the format that the suffix of ``path`` names, making its folder; returns the path.

    Raises:
        InputError: the format is unknown or the place cannot be written.
    """
    path = Path(path)
    known = sorted(picture.canvas.get_supported_filetypes())
    if path.suffix[1:].lower() not in known:
        raise InputError(
            f"{path}: the suffix {path.suffix!r} is not a picture format; use .{', .'.join(known)}"
        )
    with replacing(path) as new:
        picture.savefig(new)
    return path


def clean(axes: Axes, xlabel: str, ylabel: str) -> None:
    """Label an axes, at readable sizes, with a light grid and no box."""
    axes.set_xlabel(xlabel, fontsize=TEXT)
    axes.set_ylabel(ylabel, fontsize=TEXT)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def legend_above(axes: Axes, columns: int) -> None:
    """Put the legend above an axes, where it hides nothing."""
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=columns,
        frameon=False,
        fontsize=SMALL,
        borderaxespad=0.2,
        handlelength=1.8,
        columnspacing=1.6,
    )


def legend_inside(axes: Axes) -> None:
    """Put the legend into a free corner of an axes."""
    axes.legend(
        loc="best",
        fontsize=SMALL,
        frameon=True,
        framealpha=0.85,
        edgecolor="none",
        handlelength=1.4,
        borderaxespad=0.2,
    )


def label_once(axes: Axes, name: str) -> str:
    """Return a name for the legend of an axes, or what hides it where it is there already."""
    seen = _NAMED.setdefault(axes, set())
    if name not in seen and name in axes.get_legend_handles_labels()[1]:  # which looks at all that is drawn
        seen.add(name)
    return "_" if name in seen else name


_NAMED: WeakKeyDictionary[Axes, set[str]] = WeakKeyDictionary()
"""Names that are in the legends of axes."""


def heading(axes: Axes, text: str) -> None:
    """Put a short heading above an axes, flush left."""
    axes.set_title(text, loc="left", fontsize=TEXT, color=INK)


def scaled(unit: str, values: Any) -> tuple[float, str]:
    """Return a factor and the unit with its prefix in which the largest value is between about 1 and 1000.

    From 0.01 to 10000 the plain unit stays.
    """
    largest = float(np.max(np.abs(values), initial=0.0))
    if largest == 0.0 or 0.01 <= largest < 1e4:
        return 1.0, unit
    size, prefix = next((pair for pair in _PREFIXES if largest >= pair[0]), _PREFIXES[-1])
    return 1.0 / size, prefix + unit
