"""``viscorod stability``: modes of a case over its load factor."""

from __future__ import annotations

from pathlib import Path

import typer

from viscorod.cli.files import existing, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors
from viscorod.errors import Fault, InputError

__all__ = ["stability"]


def stability(case: CaseFile, output: ResultFolder = None) -> None:
    """Follow the modes of a case with a table [stability] over its load: a report, data, a table and a picture."""
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case, run_case
        from viscorod.casefile.case import load_case
        from viscorod.results.stability_result import Stability

        loaded = load_case(existing(case))
        if loaded.kind != "stability":
            raise InputError(
                Fault(
                    loaded.kind,
                    "",
                    "the case asks for another analysis",
                    "give a table [stability] in its place, with a band",
                )
            )
        folder = writable(output or Path("out") / case.stem)
        with polite_stop() as stop:
            result = run_case(loaded, discretised_case(loaded), stop=stop)
        assert isinstance(result, Stability)
        written = [
            result.save(folder / "stability.nc"),
            result.save_csv(folder / "stability.csv"),
            result.plot(folder / "stability.png"),
        ]
        typer.echo(result.report())
        typer.echo(f"\nWritten: {', '.join(map(str, written))}")
