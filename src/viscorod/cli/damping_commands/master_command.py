"""``viscorod damping master``: sweeps at several temperatures as one curve."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.files import picture_at
from viscorod.cli.options import OptionalNumber, output_option, pair_of
from viscorod.cli.terminal import readable_errors

__all__ = ["master"]


def master(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Tables of moduli, of one or several temperatures each."),
    ],
    reference: Annotated[
        OptionalNumber, typer.Option(help="Temperature of the curve, degrees C [default: that of most loss]")
    ] = None,
    vertical: Annotated[bool, typer.Option(help="Shift moduli too.")] = True,
    band: Annotated[str | None, typer.Option(metavar="LOW,HIGH", help="Frequencies that count, Hz.")] = None,
    law_range: Annotated[
        str | None,
        typer.Option("--law-range", metavar="LOW,HIGH", help="Temperatures that the laws are fitted to, C."),
    ] = None,
    output: Annotated[
        Path | None,
        output_option("DIR", "Write master.nc, master.csv and master.png there [default: print only]"),
    ] = None,
) -> None:
    """Lay measured moduli of several temperatures over each other: shift factors with intervals, WLF and Arrhenius."""
    with readable_errors():
        from viscorod.records.master_curve import master_curve

        found = master_curve(
            files,
            reference=reference,
            vertical=vertical,
            band=None if band is None else pair_of("--band", band),
            law_range=None if law_range is None else pair_of("--law-range", law_range),
        )
        typer.echo(found.report())
        typer.echo("\nFor a material of a case file, with temperature (degrees C):\n")
        lines = [f"{key} = {_written(value)}" for key, value in found.shift().items()]
        typer.echo("\n".join(["[materials.NAME.shift]", *lines]))
        if output is not None:
            written = [
                found.save(output / "master.nc"),
                found.write_table(output / "master.csv"),
                picture_at(found.plot, output / "master.png"),
            ]
            typer.echo("\nWritten: " + ", ".join(map(str, written)))


def _written(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(f"{one:.6g}" for one in value) + "]"
    return f'"{value}"' if isinstance(value, str) else f"{value:.6g}"
