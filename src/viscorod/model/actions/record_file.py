"""Records over time from files of columns: comma separated values, as instruments and programs write them.

Columns are separated by tabs, semicolons, commas or spaces; decimal commas are understood where commas do not separate.
Lines before the first line of numbers are a head, of which the last with as many columns has their names, with units in
brackets or after a slash. Empty lines and lines that begin with ``#`` or ``%`` are skipped.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viscorod.limits import LARGEST_TABLE
from viscorod.model.fields.definition import RefusedError, show
from viscorod.typing import Floats
from viscorod.wording import missing

__all__ = ["LENGTHS", "TIME_UNITS", "VALUE_UNITS", "Columns", "read_columns", "read_points", "read_record"]

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0}
"""Seconds of the unit."""

VALUE_UNITS = {
    "1": 1.0, "-": 1.0, "%": 1e-2,
    "m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "nm": 1e-9, "in": 0.0254, "ft": 0.3048,
    "rad": 1.0, "deg": np.pi / 180.0, "°": np.pi / 180.0,
    "N": 1.0, "mN": 1e-3, "uN": 1e-6, "µN": 1e-6, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605,
    "N m": 1.0, "Nm": 1.0, "N mm": 1e-3, "Nmm": 1e-3, "kN m": 1e3, "kNm": 1e3,
    "N/m": 1.0, "kN/m": 1e3, "N/mm": 1e3,
    "m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "rad/s": 1.0, "deg/s": np.pi / 180.0, "rpm": np.pi / 30.0,
    "m/s^2": 1.0, "m/s2": 1.0, "m/s²": 1.0, "cm/s^2": 1e-2, "cm/s2": 1e-2,
    "mm/s^2": 1e-3, "mm/s2": 1e-3, "gal": 1e-2, "g": 9.80665,
}  # fmt: skip
"""The unit in SI units; g is that of accelerations."""

LENGTHS = ("m", "mm", "cm", "um", "µm", "nm", "in", "ft")
"""Units of points."""
SEPARATORS = ("\t", ";", ",", " ")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?")
_UNIT = re.compile(r"^(.*?)\s*(?:\[(.*)\]|\((.*)\)|/\s*(\S+))\s*$")


@dataclass(frozen=True)
class _Lines:
    """The lines of a file, cut into cells: of the head, and the numbers with the lines where they stand, from 1."""

    head: list[list[str]]
    numbers: Floats
    at: list[int]


def read_record(
    path: str,
    *,
    time_column: str | int,
    value_column: str | int,
    time_unit: str | None,
    value_unit: str | None,
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return times [s] and values [SI] of a record.

    Args:
        path: of the file.
        time_column, value_column: by their name in the head (capitals and unit do not count) or number, from 1.
        time_unit, value_unit: where the head does not say.

    Raises:
        RefusedError: the file, a column or a unit cannot be read.
    """
    lines = _cut(_text(Path(path)))
    found = []
    for key, column, unit, units in (
        ("time", time_column, time_unit, TIME_UNITS),
        ("value", value_column, value_unit, VALUE_UNITS),
    ):
        k, written = _column(lines, column, f"{key}_column")
        if unit is not None and written is not None and units[unit] != units.get(written, units[unit]):
            raise RefusedError(
                f"the file says {written!r}", "leave it out", found=show(unit), at=(f"{key}_unit",)
            )
        name = unit or written or ("s" if key == "time" else "1")
        if name not in units:
            raise RefusedError(
                f"the unit {written!r} of the column is not known here",
                f"give {key}_unit, one of {', '.join(units)}",
                found=show(path),
                at=("file",),
            )
        found.append(lines.numbers[:, k] * units[name])
    return tuple(found[0].tolist()), tuple(found[1].tolist())


def read_points(path: str, columns: Sequence[str | int], unit: str | None) -> tuple[tuple[float, ...], ...]:
    """Return points [m] from the columns of a file.

    Args:
        path: of the file.
        columns: by their names in the head or numbers, from 1.
        unit: of length, where the head does not say.

    Raises:
        RefusedError: the file, a column or a unit cannot be read.
    """
    lines = _cut(_text(Path(path)))
    found = []
    for column in columns:
        k, written = _column(lines, column, "columns")
        name = unit or written or "m"
        if unit is not None and written is not None and VALUE_UNITS[unit] != VALUE_UNITS.get(written):
            raise RefusedError(f"the file says {written!r}", "leave it out", found=show(unit), at=("unit",))
        if name not in LENGTHS:
            raise RefusedError(
                f"the unit {written!r} of the column is no length",
                f"give unit, one of {', '.join(LENGTHS)}",
                found=show(path),
                at=("file",),
            )
        found.append(lines.numbers[:, k] * VALUE_UNITS[name])
    return tuple(map(tuple, np.stack(found, axis=-1).tolist()))


@dataclass(frozen=True)
class Columns:
    """The columns of a file.

    Attributes:
        names, units: of the columns, as the head says them; empty, and None, where it does not.
        numbers: by row and column; lines: where the rows stand in the file, from 1.
    """

    names: list[str]
    units: list[str | None]
    numbers: Floats
    lines: list[int]


def read_columns(path: str) -> Columns:
    """Return all columns of a file.

    Raises:
        RefusedError: it cannot be read.
    """
    lines = _cut(_text(Path(path)))
    _, names, units = _names(lines)
    return Columns(names, units, lines.numbers, lines.at)


def _text(path: Path) -> str:
    """Return the text of a file: UTF-8 with or without a byte order mark, or Latin-1."""
    try:
        if not path.is_file():
            raise RefusedError(missing(path), "give the path of a table", found=show(str(path)))
        if path.stat().st_size > LARGEST_TABLE:
            raise RefusedError(
                "the file is too large",
                f"give one of less than {LARGEST_TABLE // 1_000_000} MB",
                found=show(str(path)),
            )
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, RefusedError):
            raise
        raise RefusedError("the file cannot be read", "give another", found=show(str(path))) from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _cut(text: str) -> _Lines:
    lines = [
        (n, line)
        for n, line in enumerate(text.splitlines(), 1)
        if line.strip() and line.strip()[0] not in "#%"
    ]
    for separator in SEPARATORS:
        first = next((k for k, (_, line) in enumerate(lines) if _numeric(_cells(line, separator))), None)
        if first is not None:
            break
    else:
        raise RefusedError(
            "there are no lines with two numbers or more",
            "give a table of times and values in columns",
            at=("file",),
        )
    head, body = [_cells(line, separator) for _, line in lines[:first]], lines[first:]
    at = [n for n, _ in body]
    plain = [line if separator == "," else line.replace(",", ".") for _, line in body]
    try:
        delimiter = None if separator == " " else separator
        return _Lines(head, np.loadtxt(plain, delimiter=delimiter, ndmin=2), at)
    except ValueError:  # line by line: quotes, marks at the ends of lines, and what is wrong by its number
        return _Lines(head, _rows(body, separator), at)


def _rows(lines: list[tuple[int, str]], separator: str) -> Floats:
    width = len(_cells(lines[0][1], separator))
    rows = np.empty((len(lines), width))
    for row, (n, line) in zip(rows, lines, strict=True):
        cells = _cells(line, separator)
        if len(cells) != width or not _numeric(cells):
            wrong = next((k for k, cell in enumerate(cells, 1) if not _numeric(["0", cell])), None)
            why = f"{len(cells)} cells" if len(cells) != width else f"no number in column {wrong}"
            raise RefusedError(
                f"line {n} is not like the line of {width} numbers that the table begins with: {why}",
                "remove it, or complete it",
                found=show(line[:60]),
                at=("file",),
            )
        row[:] = [_value(cell) for cell in cells]
    return rows


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    return cells[:-1] if cells and not cells[-1] else cells


def _numeric(cells: list[str]) -> bool:
    return len(cells) > 1 and all(_NUMBER.fullmatch(cell.replace(",", ".")) for cell in cells)


def _value(cell: str) -> float:
    return float(cell.replace(",", ".").replace("d", "e").replace("D", "e"))


def _names(lines: _Lines) -> tuple[list[str], list[str], list[str | None]]:
    """Return the cells of the head over the columns, their names, and their units, where they say one."""
    width = lines.numbers.shape[1]
    head = next((cells for cells in reversed(lines.head) if len(cells) == width), [""] * width)
    named = [_UNIT.match(cell) for cell in head]
    names = [(found[1] if found else cell).strip() for cell, found in zip(head, named, strict=True)]
    units = [next((u.strip() for u in found.groups()[1:] if u), None) if found else None for found in named]
    return head, names, units


def _column(lines: _Lines, column: str | int, key: str) -> tuple[int, str | None]:
    """Return the index of a column and the unit that the head gives it, if any."""
    width = lines.numbers.shape[1]
    head, names, units = _names(lines)
    if isinstance(column, int):
        if not 1 <= column <= width:
            raise RefusedError(
                f"the table has {width} columns",
                f"give 1 to {width}, or a name",
                found=show(column),
                at=(key,),
            )
        return column - 1, units[column - 1]
    wanted = column.strip().casefold()
    fits = [
        k
        for k, (name, cell) in enumerate(zip(names, head, strict=True))
        if wanted in (name.casefold(), cell.casefold())
    ]
    if len(fits) != 1:
        known = ", ".join(show(name) for name in names if name) or "none has a name"
        raise RefusedError(
            "several columns have this name" if fits else "no column has this name",
            f"give its number, from 1, or one of the names there: {known}",
            found=show(column),
            at=(key,),
        )
    return fits[0], units[fits[0]]
