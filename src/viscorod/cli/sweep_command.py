"""``viscorod sweep``: a case computed several times with other values."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any

import typer

from viscorod.cli.files import existing, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.terminal import readable_errors
from viscorod.errors import InputError, SolveError

__all__ = ["sweep"]


def sweep(
    case: CaseFile,
    values: Annotated[
        list[str],
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="Key of the case file and its values, one per member: rods.beam.elements=1,2,4. "
            "Repeat it for keys that vary together.",
        ),
    ],
    output: ResultFolder = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", min=1, help="Number of processes [default: one per processor]", show_default=False
        ),
    ] = None,
) -> None:
    """Compute a case with several values, in parallel: print a table, write data."""
    with readable_errors():
        from viscorod.analyses.sweep import sweep as compute
        from viscorod.casefile.case import load_case
        from viscorod.cli.progress import counting
        from viscorod.results.files.folder_lock import locked

        loaded = load_case(existing(case))
        table = dict(map(_column, values))
        folder = writable(output or Path("out") / case.stem)
        count = max(map(len, table.values()), default=0)
        with locked(folder):
            try:
                with counting(count, "members") as progress:
                    result = compute(loaded, table, workers=workers, progress=progress)
            except SolveError as error:
                typer.echo(f"error: {error}", err=True)
                result = error.run
            typer.echo(result.report())
            typer.echo(f"\nWritten: {result.save(folder / 'sweep.nc')}")
        if result.failed:
            raise typer.Exit(1)


def _column(text: str) -> tuple[str, list[Any]]:
    """Return a key and its values from ``key=1,2,4``; values are written as in a case file."""
    key, sign, values = text.partition("=")
    try:
        column = tomllib.loads(f"values = [{values}]")["values"]
    except tomllib.TOMLDecodeError:
        column = []
    if not sign or not column:
        raise InputError(
            f"--set {text}: give a key and values as in a case file, separated by commas, such as "
            'rods.beam.elements=1,2,4 or rods.beam.section="thin","thick"'
        )
    return key.strip(), column
