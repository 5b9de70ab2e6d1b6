"""The style of pictures: figures without global state, a palette for every eye, units in readable sizes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from viscorod.errors import InputError
from viscorod.results.text_numbers import scaled
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.ticker import Formatter

    from viscorod.results.result import Result
    from viscorod.typing import Floats

# Okabe and Ito's palette, told apart by readers with any kind of colour vision.
BLUE, ORANGE, GREEN, RED, SKY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#56B4E9"
PURPLE = "#CC79A7"
INK, GREY, LIGHT = "#222222", "#8a8a8a", "#d8d8d8"
TEXT, SMALL = 11.0, 9.5
MINUS = "\N{MINUS SIGN}"
_LETTER = 0.62
"""Width of a letter over its size, on average."""
_HANDLE = 4.8
"""Width of the sample line of a legend and of the gaps around it, over the size of the letters."""
_ROUND_OFF = 1e-9
"""Range of values over their size below which they differ by what solvers leave."""
_FEW_DECADES = 3.5
"""Of a logarithmic axis whose ticks are more than powers of ten."""
_PLAIN = 1e-3, 1e5
"""Numbers at ticks that are read at once without a power of ten."""
_UNITS = ("s", "m", "m/s", "Hz", "N", "N m", "Pa", "J", "W/m", "1/m")
"""Of the axes that get a prefix."""
DPI = 120


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


def legend_of_all(picture: Figure, height: float) -> int:
    """Put what the first panel names, without shadows, above all panels of a picture [inches]; returns its rows."""
    handles, labels = picture.axes[0].get_legend_handles_labels()
    wanted = [k for k, label in enumerate(labels) if "shadow" not in label]
    named = [labels[k] for k in wanted]
    columns = _columns_within(named, picture.get_figwidth())
    picture.legend(
        [handles[k] for k in wanted],
        named,
        loc="upper left",
        bbox_to_anchor=(0.005, 1.0 - 0.36 / height),
        ncols=columns,
        frameon=False,
        fontsize=SMALL,
    )
    return -(-len(named) // columns)


def panels_close(picture: Figure, rows: int, columns: int, *, labelled: bool) -> None:
    """Set panels as near to each other as their titles and the labels of their axes allow, below a legend of all."""
    width, height = picture.get_size_inches()
    above = 0.45 + 0.22 * legend_of_all(picture, height)
    lines = max(axes.get_title(loc="left").count("\n") + 1 for axes in picture.axes)
    title, below = (1.3 * lines * SMALL + 8.0) / 72.0, 0.6 if labelled else 0.1
    beside = 0.85 if labelled else 0.15
    top, bottom = height - above - title, below
    across = (width - 0.2 - beside * columns) / columns
    up = (top - bottom - (rows - 1) * (title + below)) / rows
    picture.subplots_adjust(
        left=beside / width,
        right=1.0 - 0.2 / width,
        bottom=bottom / height,
        top=top / height,
        wspace=beside / across,
        hspace=(title + below) / up,
    )


def _columns_within(labels: Sequence[str], width: float, most: int = 5) -> int:
    """Return in how many columns the entries of a legend fit into a width [inches]; they go down the columns.

    Of all that need as few rows it is the smallest number, so that no row has one entry alone beside a full one.
    """
    widths = np.array([_text_width(label) for label in labels])
    fitting = [
        columns
        for columns in range(1, min(most, len(labels)) + 1)
        if sum(part.max() + SMALL * _HANDLE for part in np.array_split(widths, columns)) <= 72.0 * width
    ]
    rows = -(-len(labels) // max(fitting, default=1))
    return min((columns for columns in fitting if -(-len(labels) // columns) == rows), default=1)


def _text_width(text: str) -> float:
    """Return the width of small letters [points]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    return float(
        text_to_path.get_text_width_height_descent(text, FontProperties(size=SMALL), ismath=False)[0]
    )


def titled(result: Result, width: float, height: float) -> Figure:
    """Return an empty figure [inches] with the title of the case, if it has one."""
    picture = figure(width, height)
    headline(picture, result.title)
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
        like_a_place = path.suffix in ("", ".start", ".end") or "@" in path.name
        raise InputError(
            f"{path}: the suffix {path.suffix!r} is not a picture format; use .{', .'.join(known)}"
            + (
                ". The first argument is the file; a place is given by its name, place = ..."
                if like_a_place
                else ""
            )
        )
    with replacing(path) as new:
        picture.savefig(new)
    return path


def with_unit_of(name: str, units: Mapping[str, str]) -> str:
    """Return the label of an axis: a name with its unit, unless the user gave it one."""
    return f"{name} [{units[name]}]" if name in units and " [" not in name else name


def clean(axes: Axes, xlabel: str, ylabel: str) -> None:
    """Label an axes, at readable sizes, with a light grid and no box."""
    axes.set_xlabel(xlabel, fontsize=TEXT)
    axes.set_ylabel(ylabel, fontsize=TEXT)
    axes.tick_params(labelsize=SMALL, colors=INK)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def caption(picture: Figure, text: str) -> None:
    """Put a sentence below the title of a picture, in as many lines as it needs."""
    room = int(72.0 * 0.98 * picture.get_figwidth() / (_LETTER * SMALL))
    lines = "\n".join(wrap(text, room))
    place = 1.0 - 0.5 / picture.get_figheight()
    picture.text(0.01, place, lines, fontsize=SMALL, color=INK, va="center", linespacing=1.1)


def headline(picture: Figure, text: str) -> None:
    """Put the title of a case above a picture, flush left; one that is too long ends with dots."""
    room = int(72.0 * picture.get_figwidth() / (_LETTER * (TEXT + 2.0)))
    shown = text if len(text) <= room else f"{text[: room - 1].rstrip()}…"
    if shown:
        picture.suptitle(shown, fontsize=TEXT + 2.0, x=0.01, ha="left")


OVER_COMMON = 1.6
"""Heights of letters that the number above a vertical axis takes."""


def legend_above(axes: Axes, columns: int, *, over_common: bool = False) -> int:
    """Put the legend above an axes, where it hides nothing, in so many columns, or in fewer where they have no room.

    ``over_common``: above the number that all ticks of the vertical axis have in common, if there is one. Returns the
    number of rows.
    """
    names = axes.get_legend_handles_labels()[1]
    taken = columns_of(axes, names, columns)
    raised = OVER_COMMON if over_common and has_common_number(axes) else 0.0
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=taken,
        frameon=False,
        fontsize=SMALL,
        borderaxespad=0.2 + raised,
        handlelength=1.8,
        columnspacing=1.6,
    )
    return -(-len(names) // taken)


def has_common_number(axes: Axes) -> bool:
    """Return whether a number stands above the vertical axis, as all ticks differ little from it: "1e-8+0.3"."""
    ticks = axes.yaxis.get_major_formatter()
    ticks.set_locs(axes.get_yticks().tolist())
    return bool(ticks.get_offset())


def columns_of(axes: Axes, names: Sequence[str], most: int) -> int:
    """Return in how many columns a legend above an axes does not run out of the picture."""
    picture = axes.get_figure(root=True)
    if picture is None or not names:
        return most
    return _columns_within(names, picture.get_figwidth() * (1.0 - axes.get_position().x0), most)


def without_round_off(limit: Callable[[float, float], object], values: Floats) -> None:
    """Set the limits of an axis where its values differ by rounding alone, which would be drawn as if it were much."""
    size = float(np.abs(values).max(initial=0.0))
    if 0.0 < size and float(np.ptp(values)) <= _ROUND_OFF * size:
        middle = float(values.mean())
        limit(middle - 0.1 * size, middle + 0.1 * size)


def legend_over(axes: Axes, columns: int) -> None:
    """Put the legend between an axes and its heading, where it hides nothing."""
    names = axes.get_legend_handles_labels()[1]
    if not names:
        return
    rows = legend_above(axes, columns)
    title = axes.get_title(loc="left")
    pad = 8.0 + 1.45 * SMALL * rows
    axes.set_title(title, loc="left", fontsize=TEXT, color=INK, pad=pad)
    _keep_within(axes, pad + 1.3 * TEXT)


def _keep_within(axes: Axes, above: float) -> None:
    """Lower the panels of a picture of ours until ``above`` [points] fit between the axes and its title or its edge."""
    from viscorod.pictures.picture import Picture

    picture = axes.figure
    if isinstance(picture, Picture):  # a figure of the user's stays as it is
        needed = above + (2.2 * (TEXT + 2.0) if picture.get_suptitle() else 4.0)
        top = 1.0 - needed / (72.0 * picture.get_figheight())
        if axes.get_position().y1 > top:
            picture.subplots_adjust(top=top)


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


def with_prefixes(picture: Figure) -> None:
    """Give every linear axis whose label ends with a unit, "time [s]", the prefix of what it shows, "time [µs]".

    Logarithmic axes, too, where decades are few: "20 kHz" is read at once, 2 x 10^4 Hz is not.

    What is drawn stays as it is; ticks and label tell it in the other unit.
    """
    for axes in picture.axes:
        if axes.get_aspect() != "auto":  # of both axes alike, which the view chose
            continue
        for axis in (axes.xaxis, axes.yaxis):
            words, bracket, unit = axis.get_label_text().rpartition(" [")
            known = bool(bracket) and unit[:-1] in _UNITS
            if axis.get_scale() == "log":
                _plain_decades(axis, words if known else None, unit[:-1])
            if axis.get_scale() != "linear" or not known:
                continue
            factor, name = scaled(unit[:-1], axis.get_view_interval())
            if factor != 1.0:
                axis.set_major_formatter(_prefixed(factor))
                axis.set_label_text(f"{words} [{name}]")


def _plain_decades(axis: Axis, words: str | None, unit: str) -> None:
    """Write the ticks of a logarithmic axis as plain numbers, 2 and 5 too, where decades are few.

    A unit that takes prefixes gets that of the middle; ``words`` are what stands before it.
    """
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    if not 0.0 < low < high < 10.0**_FEW_DECADES * low:
        return
    factor, name = scaled(unit, np.sqrt(low * high)) if words is not None else (1.0, "")
    if not _PLAIN[0] <= factor * low < factor * high <= _PLAIN[1]:
        return
    subs = (1.0, 2.0, 5.0) if high >= 10.0 * low else (1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_major_formatter(_times(factor))
    axis.set_minor_formatter(NullFormatter())
    if words is not None:
        axis.set_label_text(f"{words} [{name}]")


def _times(factor: float) -> Callable[[float, object], str]:
    """Return what writes the number of a tick in another unit."""

    def shown(value: float, place: object = None) -> str:
        del place
        return f"{factor * value:g}".replace("-", MINUS)

    return shown


def _prefixed(factor: float) -> Formatter:
    """Return what writes the numbers of ticks in another unit, all with the same number of decimals."""
    from matplotlib.ticker import FuncFormatter

    class Prefixed(FuncFormatter):
        def format_ticks(self, values: Sequence[float]) -> list[str]:
            texts = [self(value) for value in values]
            if any("e" in text for text in texts):
                return texts
            decimals = max((len(text.partition(".")[2]) for text in texts), default=0)
            return [f"{float(text.replace(MINUS, '-')):.{decimals}f}".replace("-", MINUS) for text in texts]

    return Prefixed(_times(factor))


def heading(axes: Axes, text: str) -> None:
    """Put a short heading above an axes, flush left."""
    axes.set_title(text, loc="left", fontsize=TEXT, color=INK)
