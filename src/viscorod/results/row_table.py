"""Tables of rows, each a mapping from columns to values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from viscorod.results.text_numbers import prefixed
from viscorod.results.text_table import WIDTH, Column, fits, table

__all__ = ["cell", "row_table"]


def row_table(
    title: str, rows: Sequence[Mapping[str, object]], *, prefixes: bool = True, width: int = WIDTH
) -> str:
    """Return a table of rows, transposed where they would not fit beside each other.

    Numbers whose key ends with a unit, "length [m]", get a prefix, unless they are to be copied into other programs.
    """
    if not rows:
        return ""
    keys = list(dict.fromkeys(key for row in rows for key in row))
    columns = [_column(key, [row.get(key, "") for row in rows], prefixes) for key in keys]
    header = [name for name, _ in columns]
    cells = list(zip(*(column for _, column in columns), strict=True))
    if not fits(header, cells, width):
        turned = [[name, *column] for name, column in columns]
        if fits(turned[0], turned[1:], width):
            return table(title, turned[0], turned[1:], width=width)
    return table(title, header, cells, width=width)


def _column(key: str, values: Sequence[object], prefixes: bool) -> Column:
    """Return the header and the cells of a column."""
    floats = [value for value in values if isinstance(value, float)]
    name, factor = prefixed(key, floats) if prefixes and floats else (key, 1.0)
    return name, [cell(factor * value if isinstance(value, float) else value) for value in values]


def cell(value: object) -> str:
    """Return a value as text for a table."""
    if isinstance(value, tuple):  # a place or a direction
        return f"({', '.join(f'{part + 0.0:.4g}' for part in value)})"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
