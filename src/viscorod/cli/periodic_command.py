"""``viscorod periodic``: periodic motions of a case over frequency or level."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from viscorod.cli.files import case_for, picture_at, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors
from viscorod.errors import SolveError

if TYPE_CHECKING:
    from viscorod.results.periodic import Periodic

__all__ = ["periodic"]


def periodic(case: CaseFile, output: ResultFolder = None) -> None:
    """Follow the periodic motions of a case with a table [periodic]: a report, data, a table and pictures."""
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case, run_case
        from viscorod.analyses.progress import reporting
        from viscorod.results.periodic import Periodic

        loaded = case_for("periodic", case)
        folder = writable(output or Path("out") / case.stem)
        try:
            with polite_stop() as stop, reporting(loaded.settings.course) as progress:
                result = run_case(loaded, discretised_case(loaded), progress=progress, stop=stop)
        except SolveError as error:
            if error.run is None:
                raise
            typer.echo(f"error: {error}", err=True)
            _write(error.run, folder)
            raise typer.Exit(1) from None
        assert isinstance(result, Periodic)
        _write(result, folder)


def _write(result: Periodic, folder: Path) -> None:
    """Write and report a curve of motions."""
    written = [result.save(folder / "periodic.nc"), result.save_csv(folder / "periodic.csv")]
    written.append(picture_at(result.plot, folder / "amplitude.png"))
    if result.multipliers.shape[1]:
        written.append(picture_at(result.plot, folder / "multipliers.png", "multipliers"))
    if result.has_loops:
        written.append(picture_at(result.plot, folder / "loops.png", "loops"))
    typer.echo(result.report())
    typer.echo(f"\nWritten: {', '.join(map(str, written))}")
