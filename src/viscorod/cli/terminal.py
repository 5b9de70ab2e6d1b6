"""Output of the commands: errors as one message, notes, tables that fit the terminal."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import typer

from viscorod.errors import InputError, SolveError

__all__ = ["cell", "notes", "readable_errors", "rows_text"]


@contextmanager
def readable_errors() -> Iterator[None]:
    """Turn wrong input into one message and exit code 2, a failed computation into one and exit code 1."""
    try:
        yield
    except InputError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from None
    except SolveError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(1) from None


def notes(sentences: Sequence[str]) -> None:
    """Print sentences as notes."""
    if sentences:
        typer.echo("\n".join(["", *(f"Note: {sentence}" for sentence in sentences)]))


def rows_text(title: str, rows: Sequence[Mapping[str, object]]) -> str:
    """Return a table of rows, transposed where it would be wider than the terminal."""
    from viscorod.results.text_table import table

    if not rows:
        return ""
    keys = list(dict.fromkeys(key for row in rows for key in row))
    cells = [[cell(row.get(key, "")) for key in keys] for row in rows]
    text = table(title, keys, cells)
    if max(map(len, text.splitlines())) <= shutil.get_terminal_size((100, 24)).columns:
        return text
    turned = [list(column) for column in zip(keys, *cells, strict=True)]
    return table(title, turned[0], turned[1:])


def cell(value: object) -> str:
    """Return a value as text for a table."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
