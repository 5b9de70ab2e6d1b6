"""``viscorod campbell``: modes of a case over the speed of its rotation."""

from __future__ import annotations

from pathlib import Path

import typer

from viscorod.cli.files import existing, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors
from viscorod.errors import Fault, InputError

__all__ = ["campbell"]


def campbell(case: CaseFile, output: ResultFolder = None) -> None:
    """Compute the Campbell diagram of a case with a table [campbell]: a report, data, a table and a picture."""
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case, run_case
        from viscorod.casefile.case import load_case
        from viscorod.results.campbell import Campbell

        loaded = load_case(existing(case))
        if loaded.kind != "campbell":
            raise InputError(
                Fault(
                    loaded.kind,
                    "",
                    "the case asks for another analysis",
                    "give a table [campbell] in its place, with axis and band",
                )
            )
        folder = writable(output or Path("out") / case.stem)
        with polite_stop() as stop:
            result = run_case(loaded, discretised_case(loaded), stop=stop)
        assert isinstance(result, Campbell)
        written = [
            result.save(folder / "campbell.nc"),
            result.save_csv(folder / "campbell.csv"),
            result.plot(folder / "campbell.png"),
        ]
        typer.echo(result.report())
        typer.echo(f"\nWritten: {', '.join(map(str, written))}")
