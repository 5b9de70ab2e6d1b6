"""``viscorod check``: a model validated, drawn and printed in tables."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from viscorod.cli.command_kind import wants_json
from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.options import CaseFile, output_option
from viscorod.cli.terminal import readable_errors, rows_text, say, terminal_width, written

if TYPE_CHECKING:
    from viscorod.results.reports.check_report import CheckReport

__all__ = ["check"]


def check(
    case: CaseFile,
    output: Annotated[Path | None, output_option("DIR", "Folder for the picture [default: out/CASE]")] = None,
) -> None:
    """Validate a case, draw its model and print it in tables."""
    with readable_errors():
        from viscorod.analyses.case_run import as_model
        from viscorod.analyses.check import check as check_model
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.casefile.case import load_case

        loaded = load_case(existing(case))
        folder = writable(output or Path("out") / case.stem)
        # before anything is solved: the picture shows why something may fail
        picture = picture_at(as_model(loaded.description).draw, folder / "assembly.png", loaded.title)
        try:
            discrete = DiscreteModel.of(loaded.description, validated=True)
            report = check_model(discrete, loaded.settings)
        except BaseException:
            written([picture])
            raise
        if wants_json():
            typer.echo(json.dumps(_numbers(report) | {"written": [str(picture)]}, indent=2, allow_nan=False))
            return
        units = [
            {"key": item.where, "as given": item.given, "in SI": f"{item.value!r} {item.unit}"}
            for item in loaded.conversions
        ]
        converted = rows_text("Units converted", units)
        say("\n\n".join(block for block in (converted, report.text(terminal_width())) if block))
        written([picture])


def _numbers(report: CheckReport) -> dict[str, Any]:
    """Return the tables as plain data."""
    from viscorod.results.result_numbers import plain

    found = {item.name: getattr(report, item.name) for item in dataclasses.fields(report)}
    found["validity"] = [dataclasses.asdict(condition) for condition in report.validity.conditions]
    numbers: dict[str, Any] = plain(found)
    return numbers
