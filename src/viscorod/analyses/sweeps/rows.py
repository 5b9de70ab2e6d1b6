"""The values of all members of a sweep, from columns, a product, constants, a table or a file of one."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.results.sweep_members import Rows

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Columns", "Row", "Values", "key_and_unit", "rows_of"]

Row: TypeAlias = dict[str, Any]
Columns: TypeAlias = Mapping[str, Sequence[Any]]
if TYPE_CHECKING:
    Values: TypeAlias = Columns | Sequence[Mapping[str, Any]] | pd.DataFrame | str | Path
else:
    Values = Any

_UNIT = re.compile(r"(.*\S)\s+\[([^\[\]]+)\]")
_ADVICE = "give a key of the case file with a list of values: {'rods.beam.elements': [1, 2, 4]}"


def rows_of(
    values: Values | None, grid: Columns | None = None, constants: Mapping[str, Any] | None = None
) -> Rows:
    """Return the values of every member, plain numbers, texts and lists.

    Args:
        values: columns that vary together, a list of rows, a table of pandas, or the path of a CSV file.
        grid: columns of which every combination is taken, beside each row of ``values``; the last varies fastest.
        constants: key -> value, the same in all members.

    Raises:
        InputError: they are no values, or a key stands in two of them.
    """
    if values is None and grid is None:
        raise InputError(Fault("values", "", "there is nothing to vary", _ADVICE))
    varied, count = ({}, 1) if values is None else _varied(values)
    crossed = {} if grid is None else _columns(grid)
    alone = {} if constants is None else {str(key): [_plain(value)] for key, value in constants.items()}
    same = {key: column[0] for key, column in _in_units(alone).items()}
    keys = [*varied, *crossed, *same]
    for key in keys:
        if keys.count(key) > 1:
            why = "the key is given twice, among values, grid and constants"
            raise InputError(Fault(key, "", why, "leave one of them out"))
    if not keys:
        raise InputError(Fault("values", show(values), "there is nothing to vary", _ADVICE))
    inner = math.prod(map(len, crossed.values()))
    columns = {key: [value for value in column for _ in range(inner)] for key, column in varied.items()}
    each = inner
    for key, column in crossed.items():
        each //= len(column)
        times = count * inner // (each * len(column))
        columns[key] = [value for value in column for _ in range(each)] * times
    columns |= {key: [value] * (count * inner) for key, value in same.items()}
    return Rows(columns, count * inner)


def _varied(values: Any) -> tuple[dict[str, Sequence[Any]], int]:
    """Return columns that vary together, and how long they are."""
    if isinstance(values, str | Path):
        values = _table(Path(values))
    if hasattr(values, "to_dict") and isinstance(getattr(values, "columns", None), list):  # of Polars
        values = {str(key): list(values[key]) for key in values.columns}
    if hasattr(values, "to_dict") and hasattr(values, "columns"):
        if not values.columns.is_unique:
            twice = str(values.columns[values.columns.duplicated()][0])
            raise InputError(Fault(twice, "", "the table has this column twice", "leave one of them out"))
        gaps = [
            f"{key} in row {values[key].isna().tolist().index(True)}"
            for key in values
            if values[key].isna().any()
        ]
        if gaps:
            why = "the table has no value there"
            raise InputError(Fault("values", "; ".join(gaps), why, "give every member a value of every key"))
        if not len(values.index):
            raise InputError(Fault("values", "", "the table has no rows", "give every member a row"))
        values = {str(key): values[key].tolist() for key in values.columns}
    if isinstance(values, Mapping):
        columns = _columns(values)
        lengths = {key: len(column) for key, column in columns.items()}
        first, count = next(iter(lengths.items()), ("", 0))
        for key, length in lengths.items():
            if length != count:
                found, why = f"{length} values", f"{first} has {count}; they vary together"
                instead = "give every key one value per member, or every combination with grid"
                raise InputError(Fault(key, found, why, instead))
    else:
        if isinstance(values, Sequence) and not isinstance(values, str):  # rows of a table of pandas
            values = [row.to_dict() if hasattr(row, "to_dict") else row for row in values]
        if not isinstance(values, Sequence) or not all(isinstance(row, Mapping) for row in values):
            raise InputError(Fault("values", show(values), "keys with their values are needed here", _ADVICE))
        for k, row in enumerate(values):
            if row.keys() != values[0].keys():
                found = f"the keys {', '.join(map(str, row))}"
                why = f"the first member has {', '.join(map(str, values[0]))}"
                raise InputError(Fault(f"values[{k}]", found, why, "give all members the same keys"))
        count = len(values)
        heads = values[0] if values else ()
        columns = _in_units({str(key): [_plain(row[key]) for row in values] for key in heads})
    if not columns or not count:
        raise InputError(Fault("values", show(values), "there is nothing to vary", _ADVICE))
    return columns, count


def _columns(values: Any) -> dict[str, Sequence[Any]]:
    if not isinstance(values, Mapping):
        raise InputError(Fault("values", show(values), "keys with their values are needed here", _ADVICE))
    columns = {str(key): _plain(column) for key, column in values.items()}
    for key, column in columns.items():
        if isinstance(column, str | int | float):
            advice = "one value for all members goes into constants; else give a list"
            raise InputError(Fault(key, show(column), "a list of values is needed here", advice))
        if not isinstance(column, list | tuple | range) or not len(column):
            raise InputError(Fault(key, show(column), "a list of values is needed here", _ADVICE))
    return _in_units(columns)


def _in_units(columns: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
    """Return columns by key, with the units of their heads at their values: of "rods.beam.length [mm]", "300 mm"."""
    found: dict[str, Sequence[Any]] = {}
    for head, column in columns.items():
        key, unit = key_and_unit(head)
        if key in found:
            raise InputError(Fault(key, "", "two columns have this key", "leave one of them out"))
        found[key] = [_measured(value, unit) for value in column] if unit else column
    return found


def key_and_unit(head: str) -> tuple[str, str]:
    """Return the key and the unit of "rods.beam.length [mm]"; no unit where there is none."""
    named = _UNIT.fullmatch(head)
    return (named[1], named[2]) if named else (head, "")


def _measured(value: Any, unit: str) -> Any:
    """Return a value with its unit, each of a list."""
    return [_measured(one, unit) for one in value] if isinstance(value, list | tuple) else f"{value} {unit}"


def _plain(value: Any) -> Any:
    if hasattr(value, "to_numpy") and not hasattr(value, "tolist"):  # of xarray and Polars
        value = value.to_numpy()
    return value.tolist() if hasattr(value, "tolist") else value


def _table(path: Path) -> dict[str, Sequence[Any]]:
    """Read a table whose heads are keys, with a unit if they have one: "rods.beam.length [mm]".

    Cells in [brackets] are lists as in a case file; lines that begin with # are comments.
    """
    import pandas as pd

    def read(lines: int | None) -> pd.DataFrame:
        return pd.read_csv(
            path,
            comment="#",
            header=None,
            dtype=str,
            skipinitialspace=True,
            encoding="utf-8-sig",
            nrows=lines,
        )

    try:
        # first: commas in the numbers below would make it a table of lines of all lengths
        heads = [str(head).strip() for head in read(1).iloc[0].fillna("")]
        if len(heads) == 1 and (other := next((mark for mark in (";", "\t") if mark in heads[0]), "")):
            named = "semicolons" if other == ";" else "tabs"
            raise ValueError(f"there are {named} between its cells, where commas are read")
        table = read(None).iloc[1:]
    except (OSError, ValueError, IndexError) as error:
        why = f"it cannot be read as a table ({' '.join(str(error).split())[:120]})"
        instead = (
            "give a CSV file whose first line has keys of the case file, with commas between its cells, points in its "
            'numbers and quotation marks around lists ("[0, 0.02, 0]")'
        )
        raise InputError(Fault("values", str(path), why, instead)) from None
    if "" in heads:
        why = f"column {heads.index('') + 1} has no head; it may be the index that pandas writes"
        raise InputError(Fault("values", str(path), why, "write it with to_csv(path, index=False)"))
    keys = [key_and_unit(head)[0] for head in heads]
    for key in keys:
        if keys.count(key) > 1:
            why = f"two columns are called {key}"
            raise InputError(Fault("values", str(path), why, "leave one of them out"))
    table.columns = pd.Index(heads)
    gaps = [
        f"{name} (first in row {table[name].isna().tolist().index(True)})"
        for name in heads
        if table[name].isna().any()
    ]
    if gaps or not len(table):
        why = f"cells of {', '.join(gaps)} are empty or nan" if gaps else "the table has no rows"
        raise InputError(Fault("values", str(path), why, "give every member a value of every key"))
    return {head: _numbers(table[head].tolist()) for head in heads}


def _numbers(texts: Sequence[str]) -> Sequence[Any]:
    """Return the cells of a column: whole numbers if all are, numbers if all are, else each as it may be read."""
    for kind in (int, float):
        try:
            return [kind(text) for text in texts]
        except ValueError:
            continue
    return [_cell(text.strip()) for text in texts]


def _cell(text: str) -> Any:
    with suppress(ValueError):
        return float(text)
    if text.startswith("[") or text in ("true", "false"):
        try:
            return tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            return text
    return text
