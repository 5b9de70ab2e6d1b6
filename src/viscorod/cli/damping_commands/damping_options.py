"""What the commands on damping share: options, the rod of a case, numbers written with commas."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from viscorod.cli.terminal import existing
from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.model.rod import Rod
    from viscorod.programs.inputs.program_inputs import SectionData

__all__ = [
    "Frequency",
    "OptionalNumber",
    "RodName",
    "SegmentLength",
    "Station",
    "needed",
    "notes",
    "numbers_of",
    "options_of",
    "pair_of",
    "rod_of",
    "section_of",
]

T = TypeVar("T")

OptionalNumber = float | None
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


def rod_of(case: Path, name: str | None) -> tuple[str, Rod]:
    """A rod of a case file, with its name."""
    from viscorod.casefile.case import load_case
    from viscorod.model.fields.definition import did_you_mean, some_of

    rods = load_case(existing(case)).description.rods
    if name is None and len(rods) == 1:
        return next(iter(rods.items()))
    if name in rods:
        return name, rods[name]
    names = some_of(rods)
    if name is None:
        raise InputError(Fault("--rod", "", f"the case has {len(rods)} rods", f"give one of {names}"))
    advice = did_you_mean(name, rods, str)
    raise InputError(Fault("--rod", name, "the case has no such rod", f"{advice}It has {names}"))


def section_of(rod: Rod, at: float) -> SectionData:
    """The section of a rod at an arc length, m."""
    from viscorod.programs.inputs.program_inputs import SectionData

    if not 0.0 <= at <= rod.length:
        raise InputError(
            Fault("--at", f"{at:g}", "outside the rod", f"give an arc length from 0 to {rod.length:g} m")
        )
    return SectionData.of(rod, at)


def options_of(segment_length: float | None, frequency: float | None) -> dict[str, float]:
    """The options of programs that were given."""
    given = {"segment_length": segment_length, "frequency": frequency}
    return {key: value for key, value in given.items() if value is not None}


def notes(sentences: tuple[str, ...]) -> None:
    """Print sentences as notes."""
    if sentences:
        typer.echo("\n".join(["", *(f"Note: {sentence}" for sentence in sentences)]))


def numbers_of(flag: str, text: str) -> list[float]:
    """Numbers separated by commas."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(
            Fault(flag, text, "numbers are needed here", "separate them by commas: 0.01,0.02")
        ) from None


def pair_of(flag: str, text: str) -> tuple[float, float]:
    """Two numbers separated by a comma."""
    values = numbers_of(flag, text)
    if len(values) != 2:
        raise InputError(Fault(flag, text, "two numbers are needed here", f"give {flag} 0.1,10"))
    return values[0], values[1]


def needed(flag: str, value: T | None, what: str) -> T:
    """A value that must be given here."""
    if value is None:
        raise InputError(Fault(flag, "", "it is needed here", f"give {flag} ({what})"))
    return value
