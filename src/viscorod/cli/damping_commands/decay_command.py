"""``viscorod damping decay``: frequencies and damping ratios of a measured free decay."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.completion import words
from viscorod.cli.files import picture_at
from viscorod.cli.options import OptionalNumber, output_option
from viscorod.cli.terminal import readable_errors, told
from viscorod.records.read_off import QUANTITIES

__all__ = ["column", "decay"]


def decay(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Table with times and values: text, UFF, C3D, MATLAB.")
    ],
    value: Annotated[str, typer.Option(help="Column of the values, by name or number from 1.")] = "2",
    time: Annotated[str, typer.Option(help="Column of the times, by name or number from 1.")] = "1",
    quantity: Annotated[
        str,
        typer.Option(
            help=f"{', '.join(QUANTITIES)}.",
            autocompletion=words(*QUANTITIES),
        ),
    ] = "displacement",
    unit: Annotated[
        str | None, typer.Option(help="Of the values, where the file does not say.", show_default=False)
    ] = None,
    time_unit: Annotated[
        str | None,
        typer.Option("--time-unit", help="Of the times, where the file does not say.", show_default=False),
    ] = None,
    start: Annotated[OptionalNumber, typer.Option(help="Of the decay, s [default: found]")] = None,
    end: Annotated[OptionalNumber, typer.Option(help="Of the decay, s [default: found]")] = None,
    modes: Annotated[
        int | None, typer.Option(help="Number of modes [default: as many as there are]", show_default=False)
    ] = None,
    cycles: Annotated[
        int | None,
        typer.Option(help="Per piece of the table by amplitude [default: 2 or more]", show_default=False),
    ] = None,
    window_time: Annotated[
        OptionalNumber,
        typer.Option(
            "--window-time",
            help="Time constant of an exponential window on the record, s [default: none]",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        Path | None, output_option("DIR", "Write decay.nc and decay.png there [default: print only]")
    ] = None,
) -> None:
    """Print frequencies and damping ratios of a free decay with 95 % intervals, by amplitude, and what is doubtful."""
    with readable_errors():
        from viscorod.records.free_decay import decay as taken_apart
        from viscorod.records.motion_record import Record

        record = Record.read(
            file,
            column(value),
            time=column(time),
            quantity=quantity,
            unit=unit,
            time_unit=time_unit,
            place="record",
            direction="stretch" if quantity == "strain" else "x",
            name=f"{file.name}, {value}",
        )
        found = taken_apart(record, start=start, end=end, modes=modes, cycles=cycles, window_time=window_time)
        if output is None:
            told(found)
            return
        told(found, [found.save(output / "decay.nc"), picture_at(found.plot, output / "decay.png")])


def column(text: str) -> str | int:
    """Return the number or the name of a column."""
    return int(text) if text.isdecimal() else text
