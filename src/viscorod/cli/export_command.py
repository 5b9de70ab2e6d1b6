"""``viscorod export``: a result for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.completion import quantities
from viscorod.cli.files import opened
from viscorod.cli.options import ResultFile, range_of
from viscorod.cli.terminal import readable_errors, written
from viscorod.errors import Fault, InputError

__all__ = ["export"]


def export(
    result: ResultFile,
    csv: Annotated[
        Path | None,
        typer.Option("--csv", metavar="FILE.csv", help="Table of histories; say which with the next four."),
    ] = None,
    history: Annotated[
        list[str] | None,
        typer.Option(metavar="PLACE", help="Histories at beam.end, beam@0.15, plate; may be repeated."),
    ] = None,
    quantity: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WORD",
            help="position (also by default), displacement, rotation, frame, velocity, angular_velocity, strain, "
            "section_force, dissipation; may be repeated.",
            autocompletion=quantities,
        ),
    ] = None,
    energy: Annotated[bool, typer.Option("--energy", help="The energy account.")] = False,
    joint: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Coordinates and forces of a joint or spring; may be repeated."),
    ] = None,
    vtk: Annotated[
        Path | None,
        typer.Option("--vtk", metavar="FILE.vtkhdf", help="All states for ParaView."),
    ] = None,
    times: Annotated[
        str | None,
        typer.Option(
            metavar="TIMES",
            help="For --vtk: 0:1:0.01 (from, to, step) or 0.1,0.25, s [default: all stored ones]",
            show_default=False,
        ),
    ] = None,
    sections: Annotated[
        bool,
        typer.Option(
            "--sections", help="For --vtk: also surfaces of rods with their true sections and stresses."
        ),
    ] = False,
) -> None:
    """Write histories as CSV, or the motion for ParaView.

    viscorod export run.nc --csv tip.csv --history beam.end --quantity velocity --energy
    """
    with readable_errors():
        named = bool(history or energy or joint)
        _require_targets(csv, vtk, named=named or bool(quantity))
        if quantity and not history:
            raise InputError(Fault("--quantity", "", "no place is named", "add --history PLACE"))
        if csv is not None and not named:
            why, instead = "nothing to write is named", "add --history PLACE, --energy or --joint NAME"
            raise InputError(Fault("--csv", str(csv), why, instead))
        if vtk is None and times is not None:
            why, instead = "goes with --vtk only", "use viscorod probe for a table"
            raise InputError(Fault("--times", times, why, instead))
        if vtk is None and sections:
            raise InputError(Fault("--sections", "", "goes with --vtk only", "add --vtk FILE.vtkhdf"))
        found = opened(result)
        if csv is not None:
            from viscorod.results.files import csv_text

            columns = csv_text.history_columns(found, history or (), quantity or ("position",))
            if energy:
                columns |= csv_text.energy_columns(found)
            columns |= csv_text.joint_columns(found, joint or ())
            written([csv_text.write(columns, csv)], first=True)
        if vtk is not None:
            from viscorod.results.files.paraview import write_paraview
            from viscorod.results.run import Run

            chosen = None if times is None else range_of("--times", times, "s")
            if chosen is not None and not isinstance(found, Run):
                raise InputError(
                    Fault("--times", str(times), f"{result} holds no motion over time", "leave --times out")
                )
            written([write_paraview(found, vtk, chosen, sections=sections)], first=True)


def _require_targets(csv: Path | None, vtk: Path | None, *, named: bool) -> None:
    """Refuse a command that says of no file to be written, or only what a table is to hold."""
    if csv is None and vtk is None:
        raise InputError(Fault("export", "", "nothing to write", "give --csv FILE.csv or --vtk FILE.vtkhdf"))
    if csv is None and named:
        why = "--history, --quantity, --energy and --joint go with --csv"
        raise InputError(Fault("export", "", why, "add --csv FILE.csv"))
