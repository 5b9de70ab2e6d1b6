"""The picture of a sweep: numbers of its members over a parameter."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.model.fields.definition import did_you_mean
from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    ORANGE,
    OVER_COMMON,
    PURPLE,
    RED,
    SKY,
    SMALL,
    clean,
    columns_of,
    figure,
    has_common_number,
    headline,
    legend_above,
    with_unit_of,
    without_round_off,
)
from viscorod.results.sweep_figures import FIGURES, shown
from viscorod.units import si_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.sweep_result import Sweep

__all__ = ["draw_sweep"]

COLOURS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)
MOST = 4
"""Numbers in one picture."""
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*)$")
"""A number and a unit."""
COLUMNS, ROOM, ROW = 3, 2, 0.2
"""Columns of the legend, rows that it has room for, and the height [inches] of a further one."""
MOST_LINES = 6
"""Values of the other parameters that have a line each."""


def draw_sweep(sweep: Sweep, name: str | None = None, x: str | None = None, ax: Axes | None = None) -> Figure:
    """Return the figure of numbers over a parameter, a line for every combination of the others.

    Args:
        sweep: what is drawn.
        name: of the number that is drawn alone; x: the parameter, by default the first that varies.
        ax: axes for one number, by default for the first.

    Raises:
        InputError: there is no such number or parameter, or no member was computed to its end.
    """
    table = sweep.table(as_given=True)
    table = table[sweep.pictured & (table["outcome"] == "completed")]
    if not len(table):
        raise InputError("no member of this sweep was computed to its end; its report says why")
    table, units = _in_numbers(table, sweep.parameters)
    known_units = sweep.members.rows.units.items()
    units = {
        key: unit for key, unit in known_units if key in table and table[key].dtype.kind in "fiu"
    } | units
    listed = [key for key in sweep.parameters if table[key].dtype.kind not in "biuf"]
    table = table.assign(
        **{key: [_text(one) for one in table[key]] for key in listed}
    )  # a list sorts into no group
    # what all members share needs no line and no word
    varied = [key for key in sweep.parameters if table[key].nunique(dropna=False) > 1]
    x = _one_of("x", x, sweep.parameters) if x is not None or not varied else varied[0]
    known = _numbers(sweep, table)
    asked = [one for one in known if one in sweep.quantities]
    names = (asked or known)[:MOST] if name is None else [_one_of("name", name, known)]
    others = [key for key in varied if key != x]
    if ax is None:
        picture = figure(8.0, 1.0 + 3.1 * len(names))
        headline(picture, sweep.title)
        panels = list(picture.subplots(len(names), 1, squeeze=False)[:, 0])
    else:
        names, picture, panels = names[:1], within(ax), [ax]
    for axes, number in zip(panels, names, strict=True):
        _draw(axes, table, x, number, others, units, legend=axes is panels[0])
    if ax is not None:
        return within(panels[0])
    labels = panels[0].get_legend_handles_labels()[1]
    rows = -(-len(labels) // columns_of(panels[0], labels, COLUMNS))
    common = OVER_COMMON * SMALL / 72.0 if labels and has_common_number(panels[0]) else 0.0
    more = max(ROW * (rows - ROOM), 0.0) + common
    if more > 0.0:  # for the legend, below the title
        taller = picture.get_figheight() + more
        top = 1.0 - (picture.get_figheight() * (1.0 - picture.subplotpars.top) + more) / taller
        picture.set_figheight(taller)
        picture.subplots_adjust(top=top, bottom=0.6 / taller)
    return picture


def _in_numbers(table: pd.DataFrame, parameters: Sequence[str]) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return the table with quantities such as "0.8 MPa" as numbers in the unit of the first, and the units by key."""
    units: dict[str, str] = {}
    for key in parameters:
        found = [_QUANTITY.match(one) if isinstance(one, str) else None for one in table[key]]
        if not all(found):
            continue
        parts = [(float(one[1]), one[2].strip()) for one in found if one is not None]
        unit = parts[0][1]
        try:
            size = si_of(unit)
            numbers = [value if given == unit else value * si_of(given) / size for value, given in parts]
        except InputError:  # they are other words
            continue
        table, units[key] = table.assign(**{key: numbers}), unit
    return table, units


def _draw(
    axes: Axes,
    table: pd.DataFrame,
    x: str,
    name: str,
    others: list[str],
    units: Mapping[str, str],
    *,
    legend: bool,
) -> None:
    heading = FIGURES[name].heading if name in FIGURES else with_unit_of(name, units)
    clean(axes, with_unit_of(x, units), heading)
    groups: list[tuple[Any, pd.DataFrame]] = (
        list(table.groupby(others, sort=False)) if others else [((), table)]
    )
    if len(groups) > MOST_LINES:
        axes.plot(*_column(table, x, name), "o", color=BLUE, markersize=4.0)
        return
    for k, (values, rows) in enumerate(groups):
        label = ", ".join(
            f"{_short(key)} = {_text(one)} {units.get(key, '')}".rstrip()
            for key, one in zip(others, values, strict=True)
        )
        line = "-" if rows[x].dtype.kind in "fiu" else "none"
        at, number = _column(rows.sort_values(x) if line == "-" else rows, x, name)
        axes.plot(
            at, number, marker="o", markersize=4.5, linestyle=line, color=COLOURS[k], label=label or None
        )
    without_round_off(axes.set_ylim, table[name].dropna().to_numpy(dtype=float))
    if others and legend:
        legend_above(axes, COLUMNS, over_common=True)


def _column(rows: pd.DataFrame, x: str, name: str) -> tuple[Any, Any]:
    """Return the values of a parameter, texts where they are no numbers, and of a number."""
    at = rows[x].to_numpy()
    return at if at.dtype.kind in "fiu" else [_text(one) for one in at], rows[name].to_numpy(dtype=float)


def _numbers(sweep: Sweep, table: pd.DataFrame) -> list[str]:
    """Return the columns of numbers: the quantities that were asked for, else the figures that tell most."""
    asked = [name for name in sweep.quantities if name in table.columns]
    figures = shown([{name: 0.0 for name in FIGURES if name in table.columns}])
    found = [name for name in (*asked, *figures) if np.isfinite(table[name].to_numpy(dtype=float)).any()]
    if not found:
        raise InputError("the members of this sweep have no numbers; ask for quantities in vr.sweep")
    return found


def _one_of(key: str, given: str | None, known: Any) -> str:
    words = list(known)
    if given is None and words:
        return str(words[0])
    if given not in words:
        raise InputError(
            f"{key} = {given!r}: this sweep has nothing of this name; {did_you_mean(given, words)}"
            f"it has {', '.join(words) or 'no parameters'}"
        )
    return str(given)


def _short(key: str) -> str:
    return key.rpartition(".")[2]


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float | np.floating) else str(value)
