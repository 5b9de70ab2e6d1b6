"""``viscorod campbell`` and ``stability``: modes of a case over the speed of its rotation, or over its load."""

from __future__ import annotations

from pathlib import Path

import typer

from viscorod.cli.files import case_for, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import readable_errors

__all__ = ["campbell", "stability"]


def campbell(case: CaseFile, output: ResultFolder = None) -> None:
    """Compute the Campbell diagram of a case with a table [campbell]: a report, data, a table and a picture."""
    _follow("campbell", case, output, "axis and band")


def stability(case: CaseFile, output: ResultFolder = None) -> None:
    """Follow the modes of a case with a table [stability] over its load: a report, data, a table and a picture."""
    _follow("stability", case, output, "a band")


def _follow(kind: str, path: Path, output: Path | None, needs: str) -> None:
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case, run_case
        from viscorod.results.followed_modes import FollowedModes

        case = case_for(kind, path, needs)
        folder = writable(output or Path("out") / path.stem)
        with polite_stop() as stop:
            result = run_case(case, discretised_case(case), stop=stop)
        assert isinstance(result, FollowedModes)
        written = [
            result.save(folder / f"{kind}.nc"),
            result.save_csv(folder / f"{kind}.csv"),
            result.plot(folder / f"{kind}.png"),
        ]
        typer.echo(result.report())
        typer.echo(f"\nWritten: {', '.join(map(str, written))}")
