"""``viscorod damping modes``: frequencies and damping ratios of measured frequency responses."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from viscorod.cli.options import output_option, pair_of
from viscorod.cli.terminal import readable_errors

if TYPE_CHECKING:
    from viscorod.records.response_record import ResponseRecord

__all__ = ["modes"]


def modes(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Table with frequencies and responses: text, UFF, MATLAB.")
    ],
    value: Annotated[
        list[str],
        typer.Option(
            help="Column of a complex response, or REAL,IMAGINARY; by name or number from 1. Several responses are one "
            "fit."
        ),
    ],
    frequency: Annotated[
        str, typer.Option(help="Column of the frequencies, by name or number from 1.")
    ] = "1",
    unit: Annotated[
        str | None,
        typer.Option(
            help="Of output over input, as in m/s^2/N, where the file does not say.", show_default=False
        ),
    ] = None,
    frequency_unit: Annotated[
        str | None,
        typer.Option(
            "--frequency-unit", help="Of the frequencies, where the file does not say.", show_default=False
        ),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="LOW,HIGH", help="Frequencies of the peaks, Hz [default: all]")
    ] = None,
    output: Annotated[
        Path | None, output_option("DIR", "Write modes.nc and modes.png there [default: print only]")
    ] = None,
) -> None:
    """Print frequencies and damping ratios that responses show, with 95 % intervals, and what is doubtful."""
    with readable_errors():
        from viscorod.records.pole_fit import modal_fit

        records = [_record(file, one, frequency, unit, frequency_unit) for one in value]
        limits = None if band is None else pair_of("--band", band)
        found = modal_fit(records, band=limits, title=file.name)
        typer.echo(found.report())
        if output is not None:
            written = [found.save(output / "modes.nc"), found.plot(output / "modes.png")]
            typer.echo("\nWritten: " + ", ".join(map(str, written)))


def _record(
    file: Path, value: str, frequency: str, unit: str | None, frequency_unit: str | None
) -> ResponseRecord:
    from viscorod.cli.damping_commands.decay_command import column
    from viscorod.records.response_record import ResponseRecord

    return ResponseRecord.read(
        file,
        [column(part.strip()) for part in value.split(",")],
        frequency=column(frequency),
        unit=unit,
        frequency_unit=frequency_unit,
        name=value,
    )
