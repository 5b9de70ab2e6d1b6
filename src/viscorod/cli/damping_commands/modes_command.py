"""``viscorod damping modes``: frequencies and damping ratios of measured frequency responses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from viscorod.cli.completion import words
from viscorod.cli.files import picture_at
from viscorod.cli.options import OptionalNumber, output_option, pair_of
from viscorod.cli.terminal import readable_errors, told
from viscorod.errors import Fault, InputError

__all__ = ["modes"]


def modes(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="Tables with frequencies and responses: text, UFF, MATLAB. All responses are one fit.",
        ),
    ],
    value: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMNS",
            help="Column of a complex response, or REAL,IMAGINARY, or MAGNITUDE,PHASE; by name or number from 1. "
            "May be repeated [default: print the columns]",
            show_default=False,
        ),
    ] = None,
    frequency: Annotated[
        str, typer.Option(help="Column of the frequencies, by name or number from 1.")
    ] = "1",
    step: Annotated[
        OptionalNumber,
        typer.Option(help="Between lines, Hz, where there is no column of frequencies.", show_default=False),
    ] = None,
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
    phase_unit: Annotated[
        str | None,
        typer.Option(
            "--phase-unit", help="Of a phase, deg or rad, where the file does not say.", show_default=False
        ),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="LOW,HIGH", help="Frequencies of the peaks, Hz [default: all]")
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(
            help="Of the analyser: exponential (with --window-time) or hann.",
            show_default=False,
            autocompletion=words("exponential", "hann"),
        ),
    ] = None,
    window_time: Annotated[
        OptionalNumber,
        typer.Option("--window-time", help="Time constant of an exponential window, s.", show_default=False),
    ] = None,
    excitation: Annotated[
        str | None,
        typer.Option(
            help="blow (or periodic, or sines), or noise (H1 of a mean) [default: blow, intervals for either].",
            show_default=False,
            autocompletion=words("blow", "noise"),
        ),
    ] = None,
    output: Annotated[
        Path | None, output_option("DIR", "Write modes.nc and modes.png there [default: print only]")
    ] = None,
) -> None:
    """Print frequencies and damping ratios that responses show, with 95 % intervals, and what is doubtful."""
    with readable_errors():
        from viscorod.cli.damping_commands.decay_command import column
        from viscorod.records.pole_fit import modal_fit
        from viscorod.records.response_record import ResponseRecord

        if not value:
            raise _without_value(files[0])
        told_of_it: dict[str, Any] = {
            "frequency": column(frequency),
            "step": step,
            "unit": unit,
            "frequency_unit": frequency_unit,
            "phase_unit": phase_unit,
        }
        if window is not None:
            told_of_it["window"] = window
        if excitation is not None:
            told_of_it["excitation"] = excitation
        if window_time is not None:
            told_of_it["window_time"] = window_time
        records = [
            ResponseRecord.read(
                file,
                [column(part.strip()) for part in one.split(",")],
                name=one if len(files) == 1 else file.name if len(value) == 1 else f"{file.name}, {one}",
                **told_of_it,
            )
            for file in files
            for one in value
        ]
        limits = None if band is None else pair_of("--band", band)
        found = modal_fit(records, band=limits, title=", ".join(file.name for file in files))
        if output is None:
            told(found)
            return
        told(found, [found.save(output / "modes.nc"), picture_at(found.plot, output / "modes.png")])


def _without_value(file: Path) -> InputError:
    """Return what is said where no column is chosen: the columns of the file."""
    from viscorod.records.other_files import columns_of

    columns = columns_of(file)
    listed = ", ".join(
        f"{k} {name}{'' if unit is None else f' [{unit}]'}".rstrip()
        for k, (name, unit) in enumerate(zip(columns.names, columns.units, strict=True), 1)
    )
    return InputError(
        Fault(
            "--value", "", f"the columns of {file.name} are {listed}",
            "give that of a complex response, or two, such as --value 2,3 (real and imaginary part, or magnitude and "
            "phase)",
        )
    )  # fmt: skip
