"""Pictures of an ensemble: distributions with quantiles, fans of histories, Sobol' indices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    SMALL,
    caption,
    clean,
    figure,
    headline,
    legend_above,
    with_unit_of,
    without_round_off,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.ensemble import Ensemble

__all__ = ["draw_fan", "draw_indices", "draw_quantiles"]

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
MOST = 6
"""Quantities in one picture."""


def draw_quantiles(found: Ensemble, alone: str | None = None, ax: Axes | None = None) -> Figure:
    """Draw the part of the members below every value, with quantiles and their 95 % intervals.

    Args:
        found: the ensemble.
        alone: the quantity that is drawn alone; ax: axes for it, by default for the first.

    Raises:
        InputError: there are too few members.
    """
    names = _names(found, alone, ax)
    table = found.quantiles(LEVELS)
    columns = min(2, len(names))
    if ax is None:
        picture = _titled(found, 5.2 * columns + 0.6, 3.6 * -(-len(names) // columns) + 0.6)
        panels = list(picture.subplots(-(-len(names) // columns), columns, squeeze=False).flat)
    else:
        picture, panels = within(ax), [ax]
    unbounded = False
    for axes, name in zip(panels, names, strict=False):
        values = np.sort(found.values(name))
        missing = len(values) < found.samples
        which = f"part of the {len(values)} members that have it" if missing else "part of the members below"
        clean(axes, with_unit_of(name, found.members.rows.units), which)
        axes.step(
            values, np.arange(1, len(values) + 1) / len(values), where="post", color=BLUE, linewidth=1.6
        )
        span = values[-1] - values[0]
        for level in LEVELS:
            row = table.loc[(name, level)]
            ends = [row["lower"], row["upper"]]
            for k, (beyond, mark) in enumerate(
                ((values[0] - 0.06 * span, "<"), (values[-1] + 0.06 * span, ">"))
            ):
                if np.isinf(ends[k]):  # members too few for a bound
                    ends[k], unbounded = beyond, True
                    axes.plot([beyond], [level], mark, color=ORANGE, markersize=7.0)
            axes.plot(ends, [level, level], color=ORANGE, linewidth=3.0, solid_capstyle="butt")
            axes.plot([row["value"]], [level], "o", color=INK, markersize=4.5)
        axes.set_ylim(-0.02, 1.02)
        without_round_off(axes.set_xlim, values)
        _few_ticks(axes)
    if ax is not None:
        return picture
    for axes in list(picture.axes)[len(names) :]:
        axes.set_visible(False)
    bounds = "; arrows: too few members for a bound" if unbounded else ""
    caption(
        picture,
        f"{found.samples} members; their 5, 25, 50, 75, 95 % quantiles, 95 % intervals (bars{bounds})",
    )
    return picture


def draw_fan(found: Ensemble, name: str | None = None, ax: Axes | None = None) -> Figure:
    """Draw median and bands of a history over time, by default of the first one, into ``ax`` if it is given.

    Raises:
        InputError: there is no such history.
    """
    known = found.members.found
    name = next(iter(known.histories), "no quantity") if name is None else name
    histories = [known.history(k, name) for k in np.flatnonzero(found.pictured).tolist()]
    values = np.array([history for history in histories if history is not None])
    if not len(values):
        raise InputError(
            f'{name} is no history; ask for one with ("displacement", "beam.end", "y", "history")'
        )
    low, inner_low, middle, inner_high, high = np.quantile(values, LEVELS, axis=0)
    reached = known.measured.get("time_reached", np.zeros(len(found.members)))[known.completed()]
    end = float(reached[0]) if len(reached) and (reached == reached[0]).all() else 0.0
    part = np.linspace(0.0, end or 1.0, values.shape[1])
    picture = _titled(found, 10.0, 4.8) if ax is None else within(ax)
    axes = ax or picture.add_subplot()
    clean(axes, "time [s]" if end else "time over duration", with_unit_of(name, found.members.rows.units))
    axes.fill_between(part, low, high, color=BLUE, alpha=0.18, linewidth=0, label="5 to 95 %")
    axes.fill_between(part, inner_low, inner_high, color=BLUE, alpha=0.35, linewidth=0, label="25 to 75 %")
    axes.plot(part, middle, color=BLUE, linewidth=1.8, label="median")
    axes.plot(part, values[0], color=GREY, linewidth=0.9, label="one member")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlim(0.0, part[-1])
    legend_above(axes, 4)
    return picture if ax is None else within(ax)


def draw_indices(found: Ensemble, alone: str | None = None, ax: Axes | None = None) -> Figure:
    """Draw first and total Sobol' indices of every quantity with their 95 % intervals, the largest on top.

    Args:
        found: the ensemble.
        alone: the quantity that is drawn alone; ax: axes for it, by default for the first.

    Raises:
        InputError: the ensemble has no indices.
    """
    table = found.indices()
    known = {str(name) for name in table.index.unique(level="quantity")}
    names = _names(found, alone, ax)
    if alone is not None and alone not in known:
        raise InputError("; ".join(told for told in found.without_indices if told.startswith(alone)))
    names = tuple(name for name in names if name in known) or tuple(sorted(known)[:1])
    keys = list(found.design.keys)
    if ax is None:
        height = (0.5 * len(keys) + 1.1) * len(names) + 0.6
        picture = _titled(found, 9.0, height)
        picture.subplots_adjust(left=min(0.6, 0.0092 * max(map(len, keys)) + 0.03), hspace=0.42)
        panels = list(picture.subplots(len(names), 1, squeeze=False).flat)
    else:
        picture, panels = within(ax), [ax]
    ends = table.loc[list(names)].to_numpy()
    for axes, name in zip(panels, names, strict=True):
        rows = table.loc[name]
        order = [str(key) for key in rows["total"].sort_values().index]
        clean(axes, f"part of the variance of the {name.partition(' [')[0]}", "")
        for k, key in enumerate(order):
            for kind, colour, shift in (("first", BLUE, 0.18), ("total", ORANGE, -0.18)):
                row: Any = rows.loc[key]
                label = _legend(kind) if k == 0 else None
                axes.barh(k + shift, row[kind], height=0.34, color=colour, label=label)
                interval = [row[f"{kind}_lower"], row[f"{kind}_upper"]]
                words = "95 % intervals" if k == 0 and kind == "total" else None
                axes.plot(interval, [k + shift] * 2, color=INK, linewidth=1.2, label=words)
        axes.set_yticks(range(len(order)), order, fontsize=SMALL)
        axes.axvline(0.0, color=INK, linewidth=0.8)
        axes.set_xlim(min(0.0, ends.min()) - 0.02, max(1.0, ends.max()) + 0.02)  # bars of all panels compare
        axes.grid(axis="y", visible=False)
        if name == names[0]:
            legend_above(axes, 3)
    return picture if ax is None else within(ax)


def _legend(kind: str) -> str:
    return "together with others" if kind == "total" else "alone"


def _names(found: Ensemble, name: str | None, ax: Axes | None) -> tuple[str, ...]:
    names = found.numbers[:MOST]
    if not names:
        raise InputError("; ".join(found.scarce) or "no member has a quantity that is a number")
    if name is not None and name not in found.numbers:
        raise InputError(f"name = {name!r}: no quantity is called so; give one of {', '.join(found.numbers)}")
    return (name,) if name is not None else names if ax is None else names[:1]


def _titled(found: Ensemble, width: float, height: float) -> Figure:
    picture = figure(width, height)
    headline(picture, found.title)
    return picture


def _few_ticks(axes: Any) -> None:
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(5, steps=(1, 2, 2.5, 5, 10)))
