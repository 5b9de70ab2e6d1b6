"""``viscorod buckling``: critical loads of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors
from viscorod.errors import SolveError

__all__ = ["buckling"]


def buckling(
    case: CaseFile,
    output: ResultFolder = None,
    count: Annotated[
        int | None,
        typer.Option(
            min=1, help="Number of critical loads [default: that of the case, or 3]", show_default=False
        ),
    ] = None,
    constant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Load or motion that acts in full throughout; several times",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Find critical loads of a case: a table, data and a picture of the shapes.

    Settings are those of its table [buckling], if it has one; options go before them.
    """
    with readable_errors():
        from viscorod.analyses.case_run import as_model
        from viscorod.analyses.progress import reporting
        from viscorod.casefile.case import load_case
        from viscorod.solve.settings.buckling import BucklingSettings

        loaded = load_case(existing(case))
        own = loaded.settings
        settings = (
            {name: getattr(own, name) for name in own.model_fields_set}
            if isinstance(own, BucklingSettings)
            else {}
        )
        given = {"count": count, "constant": constant or None}
        settings |= {name: value for name, value in given.items() if value is not None}
        folder = writable(output or Path("out") / case.stem)
        code = 0
        try:
            with polite_stop() as stop, reporting(BucklingSettings().course) as progress:
                found = as_model(loaded.description).buckling(
                    **settings, title=loaded.title, stop=stop, progress=progress
                )
        except SolveError as error:
            if error.run is None:
                raise
            typer.echo(f"error: {error}", err=True)
            found, code = error.run, 1
        written = [found.save(folder / "buckling.nc"), picture_at(found.plot, folder / "buckling.png")]
        typer.echo(found.report())
        typer.echo(f"\nWritten: {', '.join(map(str, written))}")
        if code:
            raise typer.Exit(code)
