"""Arguments and options that several commands share, and numbers written in them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.typing import Floats

__all__ = [
    "CaseFile",
    "Frequency",
    "OptionalNumber",
    "ResultFile",
    "ResultFolder",
    "RodName",
    "SegmentLength",
    "Station",
    "numbers_of",
    "output_option",
    "pair_of",
    "range_of",
]

_MOST = 10_000_000


def output_option(metavar: str, text: str) -> Any:
    """Return the option ``--output`` with its metavar and its help."""
    return typer.Option("--output", "-o", metavar=metavar, help=text, show_default=False)


OptionalNumber = float | None
CaseFile = Annotated[
    Path, typer.Argument(metavar="CASE.toml", help="Case file; `viscorod example` lists some.")
]
ResultFolder = Annotated[Path | None, output_option("DIR", "Folder for results [default: out/CASE]")]
ResultFile = Annotated[
    Path, typer.Argument(metavar="RUN.nc", help="File that `viscorod run` or `save` wrote.")
]
RodName = Annotated[
    str | None, typer.Option("--rod", metavar="NAME", help="Rod of the case; needed where it has several.")
]
SegmentLength = Annotated[
    OptionalNumber,
    typer.Option("--segment-length", metavar="M", help="Of the rigid segments of MuJoCo and Newton, m."),
]
Frequency = Annotated[
    OptionalNumber, typer.Option("--frequency", metavar="HZ", help="Undamped frequency of a mode, Hz.")
]
Station = Annotated[
    float, typer.Option("--at", metavar="S", help="Arc length of the section that is translated, m.")
]


def numbers_of(flag: str, text: str) -> list[float]:
    """Return numbers separated by commas.

    Raises:
        InputError: a part is not a number.
    """
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(
            Fault(flag, text, "numbers are needed here", "separate them by commas: 0.01,0.02")
        ) from None


def pair_of(flag: str, text: str) -> tuple[float, float]:
    """Return two increasing numbers separated by a comma.

    Raises:
        InputError: they are none.
    """
    values = numbers_of(flag, text)
    if len(values) != 2 or not values[0] < values[1]:
        raise InputError(Fault(flag, text, "two increasing numbers are needed", f"give {flag} 0.1,10"))
    return values[0], values[1]


def range_of(flag: str, text: str, unit: str) -> Floats:
    """Return the numbers of "0:1:0.01" (from, to, step; the end counts), of "0.1,0.25", or one number.

    Raises:
        InputError: it is none of these.
    """
    import numpy as np  # here, so that help is instant

    try:
        if ":" in text:
            first, last, step = map(float, text.split(":"))
            count = (last - first) / step
            if not (np.isfinite([first, last, step]).all() and 0.0 <= count < _MOST):
                raise ValueError
            return np.asarray(first + step * np.arange(int(np.floor(count + 1e-9)) + 1))
        found = np.array([float(word) for word in text.split(",")])
        if np.isfinite(found).all():
            return found
    except (ValueError, ZeroDivisionError):
        pass
    raise InputError(
        Fault(
            flag,
            text,
            f"these are not numbers in {unit}",
            "write FROM:TO:STEP such as 0:1:0.01, or numbers such as 0.1,0.25",
        )
    )
