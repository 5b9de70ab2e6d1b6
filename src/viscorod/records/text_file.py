"""Tables of records in text files: one line of names with units, then numbers, as instruments export them.

The rules are those of tables of moduli (`read_dma_table`): any encoding; columns divided by tabs, semicolons, commas,
bars or blanks; decimal commas where commas do not divide; lines above the names, empty ones and those that begin with
``#`` are skipped. Units stand beside the names, or in the line below them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.materials.table_text import MISSING, SEPARATORS, Numbers, lines_of, looks_like_a_number
from viscorod.records.clock_times import clock_seconds, is_clock_time, is_date
from viscorod.records.column_units import COUNTS, is_unit, name_and_unit
from viscorod.records.columns import Columns
from viscorod.records.complex_cells import (
    complex_of,
    complex_parts,
    is_phase_without_unit,
    with_complex_in_one,
)
from viscorod.records.labview_text import labview_table
from viscorod.wording import missing

__all__ = ["columns_of_text"]

_BARE = ("", "-", "1", "C", "°C", "K", "F", "°F")
"""Units that are none beside a name."""
_COUNTED = ("sequence", "samples", "points")
"""What stands for the unit of a column that counts samples."""
SEEN = 20
"""Lines of numbers that tell how a table is divided."""
_ONE = re.compile(r"[-+\N{MINUS SIGN}]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][-+]?\d+)?")
"""A line of one number; with a comma it may be two."""
_REMARK = re.compile(r"\s*(#|%|//)")


def columns_of_text(path: Path) -> Columns:
    """Return the table of a text file.

    Raises:
        InputError: it cannot be read; the message names the line.
    """
    if not path.is_file():
        raise InputError(Fault(str(path), "", missing(path), "give the path of a file of measured values"))
    try:
        return _table(str(path), labview_table(lines_of(path)))
    except RefusedError as error:
        raise InputError(Fault(str(path), error.found or "", error.why, error.instead)) from None


def _table(source: str, written: list[str]) -> Columns:
    lines = [with_complex_in_one(line) for line in written]
    divide, first, width = _layout(lines)
    first = _with_settings_beside(lines, first, divide, width)
    first = _with_gaps_above(lines, first, divide, width)
    names, units, heading = _heads(lines, first, divide, width)
    rows: list[tuple[int, list[str]]] = []
    for number in range(first, len(lines) + 1):
        line = lines[number - 1]
        if (not line.strip() and width > 1) or _REMARK.match(line):
            continue  # in a single column an empty line is a sample without a number
        cells = _cells(line, divide, width)
        if len(cells) != width or not any(map(_measured, cells)):
            below = (_cells(text, divide, width) for text in lines[number:])
            if not _numeric(cells) and not any(len(other) == width and _numeric(other) for other in below):
                break  # a remark at the end
            if cells == heading:
                raise RefusedError(
                    f"line {number} has the names of the columns once more: a second table begins there",
                    "write each table into a file of its own",
                    found=show(line[:60].strip()),
                )
        if len(cells) != width:
            raise RefusedError(
                f"line {number} has {len(cells)} cells, and the table {width} columns",
                "complete the line, or take it out; decimals with a point where commas divide",
                found=show(line[:60].strip()),
            )
        rows.append((number, cells))
    clocks = {
        k: found
        for k in range(width)
        if is_clock_time(rows[0][1][k]) and (found := clock_seconds([row[k] for _, row in rows])) is not None
    }
    for _, row in rows:
        for k in clocks:
            row[k] = ""
    numbers = Numbers(part for _, cells in rows for cell in cells for part in _numbers_in(cell))
    texts: dict[int, tuple[int, str]] = {}
    values = np.array([_row(number, cells, numbers, texts) for number, cells in rows])
    for k, found in clocks.items():
        values[:, k] = found
    units = tuple("s" if k in clocks else unit for k, unit in enumerate(units))
    return Columns(source, names, units, values, texts)


def _numbers_in(cell: str) -> tuple[str, ...]:
    """Return the texts of the real numbers in a cell."""
    parts = complex_parts(cell)
    return parts[:2] if parts else (cell,) if looks_like_a_number(cell) and not is_date(cell) else ()


def _row(
    number: int, cells: list[str], numbers: Numbers, texts: dict[int, tuple[int, str]]
) -> list[float | complex]:
    """Return the numbers of a line; of every column the first cell that is none is kept."""
    found: list[float | complex] = []
    for k, cell in enumerate(cells):
        parts = complex_parts(cell)
        value = complex_of(parts, numbers.of) if parts else None if is_date(cell) else numbers.of(cell)
        if value is None:
            texts.setdefault(k, (number, cell))
        found.append(np.nan if value is None else value)
    return found


def _with_settings_beside(
    lines: list[str], first: int, divide: Callable[[str], list[str]], width: int
) -> int:
    """Return the first line of numbers where settings stand beside the first samples, as oscilloscopes write them."""
    at = [k for k, cell in enumerate(_cells(lines[first - 1], divide, width)) if looks_like_a_number(cell)]
    while first > 1 and len(at) > 1:
        cells = _cells(lines[first - 2], divide, width)
        if len(cells) != width or not all(looks_like_a_number(cells[k]) for k in at):
            break
        first -= 1
    return first


def _with_gaps_above(lines: list[str], first: int, divide: Callable[[str], list[str]], width: int) -> int:
    """Return the first line of samples where those without a number stand above the first number, as of trackers."""
    while first > 1:
        cells = _cells(lines[first - 2], divide, width)
        if len(cells) != width or not any(cells) or not all(cell.lower() in MISSING for cell in cells):
            break
        first -= 1
    return first


def _layout(lines: list[str]) -> tuple[Callable[[str], list[str]], int, int]:
    """Return how lines are divided, the first line of numbers (from 1) and the number of columns.

    Of the ways to divide, that counts by which the first lines of numbers have the same number of cells, two or more.
    """
    at = [k for k, line in enumerate(lines, 1) if line.strip() and not _REMARK.match(line)]
    if (alone := _one_column(lines, at)) is not None:
        return _whole, alone, 1
    for _, below in SEPARATORS.values():
        for place, k in enumerate(at):
            cells = _cells(lines[k - 1], below)
            if len(cells) < 2 or not _numeric(cells):
                continue
            following = [_cells(lines[j - 1], below) for j in at[place + 1 : place + 4]]
            if following and not any(len(other) == len(cells) for other in following):
                continue
            counts = [len(cells), *(len(other) for other in following if _numeric(other))]
            usual = max(counts, key=lambda count: (counts.count(count), count))
            # cells at the end that are empty in the first lines, such as those of remarks, are told by their names
            named = next((len(below(lines[j - 1])) for j in reversed(at[:place])), 0)
            return below, k, named if usual < named == len(below(lines[k - 1])) else usual
    raise RefusedError(
        "there are no lines of numbers", "give a table in columns, with names and units above them"
    )


def _one_column(lines: list[str], at: list[int]) -> int | None:
    """Return the first line of numbers of a table of one column; None if it has several.

    Args:
        lines: of the file.
        at: the lines, from 1, that are neither empty nor remarks.

    Raises:
        RefusedError: nothing above the numbers says if their commas are those of decimals.
    """
    first = next((k for k in at if _is_one(lines[k - 1])), None)
    seen = [] if first is None else [lines[k - 1].strip() for k in at if first <= k < first + SEEN]
    if first is None or not all(_is_one(line) or line.lower() in MISSING for line in seen):
        return None
    if not any("," in line for line in seen if complex_parts(line) is None):
        return first
    above = [lines[k - 1] for k in range(1, first) if lines[k - 1].strip()]
    if above:
        return None if "," in above[-1] else first
    raise RefusedError(
        f"line {first} may be one number with a decimal comma, or two columns",
        "write the names of the columns above them",
        found=show(lines[first - 1].strip()),
    )


def _is_one(line: str) -> bool:
    """Return whether a line is one number, real or complex."""
    return _ONE.fullmatch(line.strip()) is not None or complex_parts(line) is not None


def _whole(line: str) -> list[str]:
    return [line.strip()]


def _cells(line: str, divide: Callable[[str], list[str]], width: int | None = None) -> list[str]:
    """Return the cells of a line, without an empty one that a mark at its end leaves."""
    cells = divide(line)
    return cells[:-1] if len(cells) > 1 and not cells[-1] and len(cells) - 1 >= (width or 0) else cells


def _measured(cell: str) -> bool:
    return (
        looks_like_a_number(cell)
        or is_date(cell)
        or is_clock_time(cell)
        or complex_parts(cell) is not None
        or is_phase_without_unit(cell)
    )


def _numeric(cells: list[str]) -> bool:
    return any(map(_measured, cells)) and all(_measured(cell) or cell.lower() in MISSING for cell in cells)


def _heads(
    lines: list[str], first: int, divide: Callable[[str], list[str]], width: int
) -> tuple[tuple[str, ...], tuple[str | None, ...], list[str]]:
    """Return names and units of the columns, and the cells of the line of the names."""
    # columns that end with the mark have an empty one behind them, which may have a name
    open_end = len(divide(lines[first - 1])) > width
    near = [
        cells[:width]
        for k in range(first - 1, max(first - 6, 0), -1)
        if (
            len(cells := _named_cells(lines[k - 1], divide, width)) == width
            or (open_end and len(cells) > width)
        )
        and not _numeric(cells)
    ]
    if len(near) > 2 and not all(near[0]) and all(near[1]) and _all_units(near[1]):
        near = near[1:]  # below the units stands what the channels are connected to
    if not near:
        return tuple("" for _ in range(width)), tuple(None for _ in range(width)), []
    heading = near[0]
    below: list[str | None] = [None] * width
    if len(near) > 1 and _all_units(near[0]):
        below = [None if cell.lower() in _COUNTED else cell.strip("[]() ") or None for cell in near[0]]
        below = [None if cell is None or looks_like_a_number(cell) else cell for cell in below]
        heading = near[1]
    pairs = [name_and_unit(cell) for cell in heading]
    units = tuple(unit if unit is not None else under for (_, unit), under in zip(pairs, below, strict=True))
    return tuple(name for name, _ in pairs), units, heading


def _named_cells(line: str, divide: Callable[[str], list[str]], width: int) -> list[str]:
    """Return the cells of a line of names; where blanks divide, names may have units in brackets after a blank."""
    text = re.sub(r"^\s*[#%]+\s*", "", line)
    cells = _cells(text, divide, width)
    if len(cells) != width:
        for above, below in SEPARATORS.values():
            if below is divide and len(found := _cells(text, above)) == width:
                return found
    return cells


def _all_units(cells: list[str]) -> bool:
    """Return whether a line below the names holds units: brackets, or texts that are units."""
    texts = [
        cell.strip()
        for cell in cells
        if cell.strip().lower() not in _COUNTED and (cell.strip() in _BARE or not looks_like_a_number(cell))
    ]
    bracketed = all(re.fullmatch(r"[\[(].*[\])]", text) for text in texts if text)
    return any(texts) and (
        bracketed or all(is_unit(text) or text in COUNTS for text in texts if text not in _BARE)
    )
