"""``viscorod probe``: everything at any places and times, as a table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.files import opened
from viscorod.cli.options import ResultFile, output_option, range_of
from viscorod.cli.terminal import readable_errors, written
from viscorod.errors import Fault, InputError

__all__ = ["probe"]


def probe(
    result: ResultFile,
    places: Annotated[
        list[str],
        typer.Argument(metavar="PLACE...", help="beam.end, beam@0.15, plate, plate.corner; a rod with --s."),
    ],
    times: Annotated[
        str | None,
        typer.Option(
            metavar="TIMES",
            help="0:1:0.01 (from, to, step), 0.1,0.25 or one time, s [default: all stored ones]",
            show_default=False,
        ),
    ] = None,
    s: Annotated[
        str | None,
        typer.Option("--s", metavar="LENGTHS", help="Arc lengths on the rod, written likewise, m."),
    ] = None,
    output: Annotated[Path | None, output_option("FILE.csv", "File to write [default: print]")] = None,
) -> None:
    """Print positions, frames, velocities, strains, section forces and dissipation at any places and times."""
    with readable_errors():
        from viscorod.results.files.csv_text import probe_columns, text, write
        from viscorod.results.run import Run

        found = opened(result)
        if s is not None and len(places) != 1:
            raise InputError(
                Fault("--s", ", ".join(places), "arc lengths go with one rod", "give the name of a rod alone")
            )
        chosen = places[0] if s is not None else places
        arc = None if s is None else range_of("--s", s, "m")
        if isinstance(found, Run):
            values = found.probe(chosen, None if times is None else range_of("--times", times, "s"), s=arc)
        elif times is not None:
            raise InputError(
                Fault("--times", times, f"{result} holds no motion over time", "leave --times out")
            )
        else:
            values = found.probe(chosen, s=arc)
        columns = probe_columns(values)
        if output is None:
            typer.echo(text(columns), nl=False)
        else:
            written([write(columns, output)], first=True)
