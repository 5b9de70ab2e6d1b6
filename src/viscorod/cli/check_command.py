"""``viscorod check``: a model validated, drawn and printed in tables."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from viscorod.cli.command_kind import wants_json
from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.options import CaseFile, output_option
from viscorod.cli.terminal import readable_errors, rows_text, say, written
from viscorod.results.text_table import listed

if TYPE_CHECKING:
    from viscorod.analyses.check import CheckReport
    from viscorod.units import Conversion

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
        say(_text(report, loaded.conversions))
        written([picture])


def _text(report: CheckReport, conversions: Sequence[Conversion]) -> str:
    modes = [
        {
            "mode": str(number),
            "name": name,
            "frequency [Hz]": frequency,
            "damping ratio": "overdamped" if ratio > 1.0 - 1e-9 else round(ratio, 10) + 0.0,
        }
        for number, (name, frequency, ratio) in enumerate(
            zip(report.mode_names, report.frequencies, report.damping_ratios, strict=True), 1
        )
    ]
    conditions = f", {report.conditions} conditions of joints and held strains" if report.conditions else ""
    units = [
        {"key": item.where, "as given": item.given, "in SI": f"{item.value!r} {item.unit}"}
        for item in conversions
    ]
    blocks = [
        rows_text("Units converted", units),
        rows_text("Rods", _alike(report.rods)),
        rows_text("Sections", _alike(report.sections)),
        rows_text("Materials", _alike(report.materials)),
        rows_text("Rigid bodies", report.bodies),
        rows_text("Joints", report.joints),
        rows_text("Springs", report.springs),
        rows_text("Drag and other loads that see motion", report.media),
        rows_text("Rest strains, at the start of the rod", report.rest_strains),
        rows_text("First natural modes about the reference shape (a quick estimate)", modes),
        listed(f"Rigid motions: {len(report.rigid_motions)}", report.rigid_motions)
        if report.rigid_motions
        else "",
        f"{report.nodes} nodes, {report.unknowns} unknowns{conditions}\nLinear systems: {report.linear_solver}",
        str(report.validity),
        listed("Assumptions about damping", report.assumptions) if report.assumptions else "",
        listed("Warnings", report.warnings) if report.warnings else "No warnings",
    ]
    return "\n\n".join(block for block in blocks if block)


def _alike(rows: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """Return rows of which those that differ in their first cell only are one."""
    names: dict[tuple[tuple[str, object], ...], list[str]] = {}
    for row in rows:
        (_, name), *rest = row.items()
        names.setdefault(tuple((key, str(value)) for key, value in rest), []).append(str(name))
    kept: dict[str, Mapping[str, object]] = {}
    for row in rows:
        kept.setdefault(str(next(iter(row.values()))), row)
    found = []
    for alike in names.values():
        row = dict(kept[alike[0]])
        key = next(iter(row))
        others = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
        found.append({**row, key: f"{alike[0]}{others}"})
    return found


def _numbers(report: CheckReport) -> dict[str, Any]:
    """Return the tables as plain data."""
    from viscorod.results.result_numbers import plain

    found = {item.name: getattr(report, item.name) for item in dataclasses.fields(report)}
    found["validity"] = [dataclasses.asdict(condition) for condition in report.validity.conditions]
    numbers: dict[str, Any] = plain(found)
    return numbers
