"""Text that terminals, logs and documents all show alike: tables, lists and sentences no wider than 80 letters."""

from __future__ import annotations

import itertools
import re
import textwrap
from collections.abc import Iterable, Sequence

import numpy as np

from viscorod.results.text_numbers import ROUND_OFF, even, number, scaled
from viscorod.typing import Floats

__all__ = ["WIDTH", "Column", "fits", "listed", "numbers", "page", "table", "tabulated", "words", "wrapped"]

WIDTH = 80
"""Letters of a line."""

_NARROWEST = 20
"""Letters of a line of a column of long texts."""
Column = tuple[str, list[str]]
"""Header and cells."""


def table(
    title: str,
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    groups: Sequence[int] = (),
    width: int = WIDTH,
) -> str:
    """Return a table: the title, then indented columns, names to the left and numbers to the right.

    Where the columns do not fit the width they stand in several parts below each other, each beginning with the names;
    names longer than half of the width, such as keys of a case, have lines of their own, each above its row.

    Args:
        title: above it; header: of the columns; rows: of cells.
        groups: sizes of the groups of columns that stay together if they can; by default each is alone.
        width: letters of a line.
    """
    first, *others = zip(header, *rows, strict=True)
    columns = [_left(first), *map(_justified, others)]
    above = len(columns[0][0]) > width // 2 and not fits(header, rows, width)
    names, room = (["  "] * len(first), width - 4) if above else (columns[0], width - 2 - len(columns[0][0]))
    lines = [wrapped(title, "")]
    for part in _parts([len(column[0]) for column in columns[1:]], groups, room):
        chosen = [columns[1 + k] for k in part]
        if len(chosen) == 1 and len(chosen[0][0]) + 2 > room:
            found = _filled(names, chosen[0], room - 2)
        else:
            found = [["  " + "  ".join(row).rstrip()] for row in zip(names, *chosen, strict=True)]
        named = [[wrapped(f"  {name.strip()}")] if above and name.strip() else [] for name in columns[0]]
        lines += itertools.chain.from_iterable(itertools.chain(*zip(named, found, strict=True)))
    return "\n".join(lines)


def fits(header: Sequence[str], rows: Sequence[Sequence[str]], width: int = WIDTH) -> bool:
    """Return whether the columns of a table fit beside each other."""
    return sum(2 + max(map(len, column)) for column in zip(header, *rows, strict=True)) <= width


def _justified(column: Sequence[str]) -> list[str]:
    """Return the cells of a column, its header first, with one width: numbers to the right."""
    number = any(cell[:1].isdigit() or (cell[:1] in "+-." and cell[1:2].isdigit()) for cell in column[1:])
    width = max(map(len, column))
    return [cell.rjust(width) for cell in column] if number else _left(column)


def _left(column: Sequence[str]) -> list[str]:
    width = max(map(len, column))
    return [cell.ljust(width) for cell in column]


def _parts(widths: Sequence[int], groups: Sequence[int], room: int) -> list[list[int]]:
    """Return the numbers of the columns that stand beside each other, part by part."""
    sizes = groups or [1] * len(widths)
    starts = np.cumsum([0, *sizes])
    parts: list[list[int]] = [[]]
    left = room
    for first, end in itertools.pairwise(starts.tolist()):
        whole = sum(2 + widths[k] for k in range(first, end))
        for k in range(first, end):
            if parts[-1] and (2 + widths[k] > left or (k == first and left < whole <= room)):
                parts.append([])
                left = room
            parts[-1].append(k)
            left -= 2 + widths[k]
    return parts


def _filled(names: Sequence[str], column: Sequence[str], room: int) -> list[list[str]]:
    """Return the lines of each cell of a column of long texts beside the names, wrapped at words."""
    found = []
    for name, cell in zip(names, column, strict=True):
        text = _NUMBER_UNIT.sub(_GLUE, cell.strip())
        parts = textwrap.wrap(text, max(room, _NARROWEST), break_long_words=False, break_on_hyphens=False)
        first, *more = [part.replace(_GLUE, " ") for part in parts] or [""]
        lines = [f"  {name}  {first}".rstrip()]
        found.append(lines + [f"  {' ' * len(name)}  {text}" for text in more])
    return found


def words(name: str, cells: Iterable[str]) -> list[Column]:
    """Return a column of texts for :func:`tabulated`."""
    return [(name, list(cells))]


def numbers(
    names: Sequence[str],
    unit: str,
    values: Floats | Sequence[float],
    *,
    size: float | None = None,
    digits: int = 6,
    aligned: bool = False,
) -> list[Column]:
    """Return columns of one quantity for :func:`tabulated`, with one unit and its prefix.

    Args:
        names: of the columns; unit: of all, may be empty.
        values: ``(rows, columns)``, or ``(rows,)`` of one column.
        size: against which round-off reads 0; the largest of all by default.
        digits: significant ones.
        aligned: whether all numbers of a column have as many decimals.
    """
    cells = np.asarray(values, dtype=float).reshape(-1, len(names))
    size = float(np.max(np.abs(cells), initial=0.0)) if size is None else size
    seen = np.where(np.abs(cells) < ROUND_OFF * size, 0.0, cells)  # round-off has no prefix of its own
    factor, name = scaled(unit, seen) if unit else (1.0, "")
    texts = (
        even(factor * column, digits)
        if aligned
        else [number(factor * value, digits, size=factor * size) for value in column]
        for column in cells.T
    )
    return [
        (f"{word} [{name}]" if name else word, list(text)) for word, text in zip(names, texts, strict=True)
    ]


def tabulated(title: str, *columns: list[Column]) -> str:
    """Return a table of columns, those of :func:`words` and :func:`numbers`."""
    header, cells = zip(*(column for part in columns for column in part), strict=True)
    groups = [len(part) for part in columns]
    groups[0] -= 1  # the names are in every part
    return table(title, header, list(zip(*cells, strict=True)), [size for size in groups if size])


def listed(heading: str, sentences: Iterable[str]) -> str:
    """Return sentences in a list below a heading."""
    return "\n".join([wrapped(heading), *(wrapped(f"  - {text}", "    ") for text in sentences)])


def page(blocks: Iterable[str]) -> str:
    """Return blocks of text with an empty line between them, without those that are empty; lines wrap at words."""
    return "\n\n".join("\n".join(map(wrapped, block.splitlines())) for block in blocks if block)


def wrapped(text: str, hanging: str | None = None) -> str:
    """Return a line wrapped at words, the lines that follow indented by two letters more, or by ``hanging``."""
    if len(text) <= WIDTH:
        return text
    indent = text[: len(text) - len(text.lstrip())]
    following = indent + "  " if hanging is None else hanging
    filled = textwrap.fill(
        _NUMBER_UNIT.sub(_GLUE, text.strip()),
        WIDTH,
        initial_indent=indent,
        subsequent_indent=following,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return filled.replace(_GLUE, " ")


_GLUE = "\0"
_NUMBER_UNIT = re.compile(r"(?<=\d) (?=(?:[yzafpnµmkMGTPEZY]?(?:m|s|N|J|Pa|Hz|g|rad|W|K)|%)(?![A-Za-z]))")
"""What is between a number and its unit, where no line ends."""
