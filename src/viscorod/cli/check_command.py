"""``viscorod check``: a model validated, drawn and printed in tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.options import CaseFile, output_option
from viscorod.cli.terminal import readable_errors, rows_text
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
            typer.echo(_text(report, loaded.conversions))
        finally:
            typer.echo(f"\nWritten: {picture}")


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
        rows_text("Rods", report.rods),
        rows_text("Sections", report.sections),
        rows_text("Materials", report.materials),
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
