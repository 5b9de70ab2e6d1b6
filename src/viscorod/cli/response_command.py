"""``viscorod response``: harmonic responses of a case over frequency."""

from __future__ import annotations

from pathlib import Path

import typer

from viscorod.cli.files import case_for, picture_at, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors
from viscorod.errors import SolveError

__all__ = ["response"]


def response(case: CaseFile, output: ResultFolder = None) -> None:
    """Compute the frequency response of a case with a table [response]: a report, data and pictures."""
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case, run_case
        from viscorod.analyses.progress import reporting
        from viscorod.results.frequency_response import FrequencyResponse

        loaded = case_for("response", case)
        folder = writable(output or Path("out") / case.stem)
        code = 0
        try:
            with polite_stop() as stop, reporting(loaded.settings.course) as progress:
                result = run_case(loaded, discretised_case(loaded), progress=progress, stop=stop)
        except SolveError as error:
            if not isinstance(error.run, FrequencyResponse):
                raise
            typer.echo(f"error: {error}", err=True)
            result, code = error.run, 1
        assert isinstance(result, FrequencyResponse)
        written = [result.save(folder / "response.nc")]
        written += [picture_at(result.plot, folder / f"{kind}.png", kind) for kind in ("bode", "nyquist")]
        typer.echo(result.report())
        typer.echo(f"\nWritten: {', '.join(map(str, written))}")
        if code:
            raise typer.Exit(code)
