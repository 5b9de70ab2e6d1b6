"""A sweep as a table in a Parquet file: values, quantities, histories, figures and outcome of every member.

Any reader of Parquet finds the columns of ``Sweep.table``; histories are columns of lists. ``viscorod.load`` makes the
sweep of it again, without whole results.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.ensemble import Ensemble
from viscorod.results.ensemble_design import Design
from viscorod.results.files.parquet import read_parquet, write_parquet
from viscorod.results.stacked_members import plain
from viscorod.results.sweep_figures import FIGURES
from viscorod.results.sweep_members import FoundMembers, Rows, SweepMembers
from viscorod.results.sweep_result import KIND, Sweep

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["ATTRIBUTES", "read_table", "sweep_of_table", "write_table"]

ATTRIBUTES = "result/attributes"
"""Column of the attributes of whole results; no quantity has a slash in its name."""
_PLAIN = (bool, int, float, str)
_WHOLE = 2**63


def write_table(
    sweep: Sweep,
    path: str | Path,
    columns: Mapping[str, Any] | None = None,
    about: Mapping[str, Any] | None = None,
) -> Path:
    """Write a sweep without its whole results; returns the path.

    Args:
        sweep: of which it is the table.
        path: of the file.
        columns: more of them, about: more that the file says of itself.

    Raises:
        InputError: pyarrow is not installed, or the place cannot be written.
    """
    table, found = sweep.table(as_given=True), sweep.members.found
    texts = [key for key in sweep.parameters if not _of_one_type(sweep.members.rows.columns[key])]
    for key in texts:
        table[key] = [json.dumps(value, default=plain) for value in sweep.members.rows.columns[key]]
    for name in found.histories:
        table[name] = [found.history(k, name) for k in range(len(table))]
    for name, column in (columns or {}).items():
        table[name] = column
    told = {
        "kind": KIND,
        "title": sweep.title,
        "notes": list(sweep.notes),
        "parameters": list(sweep.parameters),
        "units": sweep.members.rows.units,
        "as_json": texts,
        "quantities": list(sweep.quantities),
        **sweep.attributes(),
        **(about or {}),
    }
    return write_parquet(table, told, path)


def read_table(path: str | Path) -> Sweep:
    """Return the sweep of a table.

    Raises:
        InputError: pyarrow is not installed, or the file is none or a damaged one.
    """
    return sweep_of_table(*read_parquet(path), path)


def sweep_of_table(
    table: pd.DataFrame,
    about: Mapping[str, Any],
    path: str | Path,
    stored: Callable[[int], Any] | None = None,
) -> Sweep:
    """Return the sweep of a table that was read.

    Args:
        table, about: of the file ``path``.
        stored: what there is of a member's whole result, by its number.

    Raises:
        InputError: the file is damaged.
    """
    try:
        if about["kind"] != KIND:
            raise ValueError(f"it holds a {about['kind']}")
        texts, count = about["as_json"], len(table)
        rows = Rows(
            {
                key: list(map(json.loads, table[key])) if key in texts else table[key].tolist()
                for key in about["parameters"]
            },
            count,
            about.get("units"),
        )
        quantities = _columns(table, about["quantities"])
        figures = _columns(table, [name for name in FIGURES if name in table])
        lists = [name for name, column in quantities.items() if any(map(_is_list, column))]
        found = FoundMembers(count, [name for name in quantities if name not in lists])
        for k, (outcome, message) in enumerate(zip(table["outcome"], table["message"], strict=True)):
            found[k] = (
                None if stored is None else stored(k),
                str(message),
                str(outcome),
                _of_member(quantities, k),
                _of_member(figures, k),
            )
        sweep = Sweep(SweepMembers(rows, found), str(about["title"]), [str(note) for note in about["notes"]])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path} is damaged ({type(error).__name__}: {error}); take another copy of it"
        ) from None
    if "ensemble" not in about:
        return sweep
    return Ensemble.of_sweep(sweep, Design.of_record(str(about["ensemble"]), str(path)))


def _columns(table: pd.DataFrame, names: Sequence[str]) -> dict[str, list[Any]]:
    return {name: table[name].tolist() for name in names}


def _of_member(columns: Mapping[str, Sequence[Any]], k: int) -> dict[str, Any]:
    """Return what a member has of some columns: numbers and histories."""
    found = {name: column[k] for name, column in columns.items()}
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in found.items()
        if _is_list(value) or (value is not None and not np.isnan(value))
    }


def _is_list(value: Any) -> bool:
    return isinstance(value, np.ndarray | list)


def _of_one_type(column: Sequence[Any]) -> bool:
    """Return whether a column holds what a Parquet file does: numbers or texts, all of one type."""
    kinds = set(map(type, column))
    return len(kinds) == 1 and kinds <= set(_PLAIN) and (kinds != {int} or max(map(abs, column)) < _WHOLE)
