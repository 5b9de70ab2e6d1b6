"""``viscorod campbell`` and ``stability``: modes of a case over the speed of its rotation, or over its load."""

from __future__ import annotations

from pathlib import Path

import typer

from viscorod.cli.files import case_for, picture_at, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors
from viscorod.errors import SolveError

__all__ = ["campbell", "stability"]


def campbell(case: CaseFile, output: ResultFolder = None) -> None:
    """Compute the Campbell diagram of a case with a table [campbell]: a report, data, a table and a picture."""
    _follow("campbell", case, output)


def stability(case: CaseFile, output: ResultFolder = None) -> None:
    """Follow the modes of a case with a table [stability] over its load: a report, data, a table and a picture."""
    _follow("stability", case, output)


def _follow(kind: str, path: Path, output: Path | None) -> None:
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case, run_case
        from viscorod.analyses.progress import reporting
        from viscorod.results.followed_modes import FollowedModes

        case = case_for(kind, path)
        folder = writable(output or Path("out") / path.stem)
        code = 0
        try:
            with polite_stop() as stop, reporting(case.settings.course) as progress:
                result = run_case(case, discretised_case(case), progress=progress, stop=stop)
        except SolveError as error:
            if error.run is None:
                raise
            typer.echo(f"error: {error}", err=True)
            result, code = error.run, 1
        assert isinstance(result, FollowedModes)
        written = [
            result.save(folder / f"{kind}.nc"),
            result.save_csv(folder / f"{kind}.csv"),
            picture_at(result.plot, folder / f"{kind}.png"),
        ]
        typer.echo(result.report())
        typer.echo(f"\nWritten: {', '.join(map(str, written))}")
        if code:
            raise typer.Exit(code)
