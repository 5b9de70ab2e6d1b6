"""Output of the commands: errors as one message, reports, notes, tables that fit the terminal."""

from __future__ import annotations

import json
import shutil
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from viscorod.cli.command_kind import quiet, wants_json
from viscorod.errors import InputError, SolveError

__all__ = [
    "complain",
    "notes",
    "readable_errors",
    "replacing_note",
    "rows_text",
    "say",
    "terminal_width",
    "told",
    "written",
]


@contextmanager
def readable_errors() -> Iterator[None]:
    """Turn wrong input into one message and exit code 2, a failed computation into one and exit code 1."""
    try:
        yield
    except InputError as error:
        complain(f"error: {error}")
        raise typer.Exit(2) from None
    except SolveError as error:
        complain(f"error: {error}")
        raise typer.Exit(1) from None


def complain(text: str) -> None:
    """Print a message for the user beside what the command prints, on a terminal wrapped at words."""
    typer.echo(_fitted(text) if sys.stderr.isatty() else text, err=True)


def _fitted(text: str) -> str:
    import textwrap  # here, so that help is instant

    width = shutil.get_terminal_size((80, 24)).columns
    return "\n".join(
        textwrap.fill(line, width, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
        for line in text.splitlines()
    )


def say(text: str) -> None:
    """Print text, unless the command was told to be quiet."""
    if not quiet():
        typer.echo(text)


def written(paths: Iterable[Path | str], more: str = "", *, first: bool = False) -> None:
    """Say which files were written, after an empty line unless it is the ``first`` that is said."""
    from viscorod.results.text_table import wrapped

    text = wrapped(f"Written: {', '.join(map(str, paths))}{more}")
    say(text if first else f"\n{text}")


def told(result: Any, paths: Iterable[Path | str] = ()) -> None:
    """Print the report of a result and the files that were written, or its numbers as JSON if asked to."""
    paths = list(paths)
    if wants_json():
        from viscorod.results.result_numbers import numbers_of

        data = {**numbers_of(result), "written": list(map(str, paths))}
        typer.echo(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))
        return
    say(result.report())
    if paths:
        written(paths)


def replacing_note(*paths: Path) -> None:
    """Say which result is about to be replaced, and from when it is."""
    for path in paths:
        if path.is_file() and not quiet():
            when = time.strftime("%Y-%m-%d %H:%M", time.localtime(path.stat().st_mtime))
            complain(
                f"note: {path} of {when} is replaced when this is done; name another folder with -o to keep it"
            )


def notes(sentences: Sequence[str]) -> None:
    """Print sentences as notes."""
    from viscorod.results.text_table import wrapped

    if sentences:
        say("\n".join(["", *(wrapped(f"Note: {sentence}") for sentence in sentences)]))


def rows_text(title: str, rows: Sequence[Mapping[str, object]], *, prefixes: bool = True) -> str:
    """Return a table of rows as wide as the terminal; see `viscorod.results.row_table`."""
    from viscorod.results.row_table import row_table

    return row_table(title, rows, prefixes=prefixes, width=terminal_width())


def terminal_width() -> int:
    """Return the letters of a line: those of the terminal, 80 at least."""
    from viscorod.results.text_table import WIDTH

    return max(shutil.get_terminal_size((WIDTH, 24)).columns, WIDTH)
