"""``viscorod damping programs`` and ``from``: a rod's damping for other programs, and theirs for a rod."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from viscorod.cli.completion import program_names
from viscorod.cli.files import rod_of
from viscorod.cli.options import Frequency, OptionalNumber, RodName, SegmentLength, Station, numbers_of
from viscorod.cli.terminal import notes, readable_errors, rows_text, say
from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.model.rod import Rod
    from viscorod.programs.inputs import ProgramInputs, SectionData

__all__ = ["from_program", "programs"]


def programs(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file with the rod.")],
    rod: RodName = None,
    program: Annotated[
        list[str] | None,
        typer.Option(
            "--program",
            metavar="NAME",
            help="Only this one; may be repeated.",
            autocompletion=program_names,
        ),
    ] = None,
    segment_length: SegmentLength = None,
    frequency: Frequency = None,
    at: Station = 0.0,
) -> None:
    """Print the damping of a rod as inputs of other programs, ready to paste, and what is lost."""
    with readable_errors():
        from viscorod.programs.inputs import PROGRAMS
        from viscorod.programs.inputs import program as find

        name, chosen = rod_of(case, rod)
        data = _section(chosen, at)
        options = _given(segment_length, frequency)
        kinds = list(PROGRAMS.values()) if program is None else [find(word) for word in program]
        _refuse_unread(options, kinds)
        say(f"Rod {name}, section at {at:g} m")
        for kind in kinds:
            lacking = [word for word in kind.options if word not in options]
            if lacking and program is None:
                flag = lacking[0].replace("_", "-")
                say(f"\n{kind.title}: needs --{flag}; give it to see its inputs")
                continue
            try:
                inputs = kind.from_section(
                    data, **{word: value for word, value in options.items() if word in kind.options}
                )
            except InputError as error:
                if program is not None:
                    raise
                say(f"\n{kind.title}: {error}")
                continue
            say("\n" + _program_text(inputs, data))


def from_program(
    program: Annotated[
        str,
        typer.Argument(
            metavar="PROGRAM", help="As in: viscorod damping programs.", autocompletion=program_names
        ),
    ],
    numbers: Annotated[
        str, typer.Option("--numbers", metavar="N1,N2,..", help="The program's numbers, in its order.")
    ],
    case: Annotated[
        Path, typer.Option("--case", metavar="CASE.toml", help="Case file with the rod they belong to.")
    ],
    rod: RodName = None,
    poissons_ratio: Annotated[
        OptionalNumber, typer.Option(help="Of the material to find; by default the rod's.")
    ] = None,
    segment_length: SegmentLength = None,
    frequency: Frequency = None,
    at: Station = 0.0,
) -> None:
    """Print what another program's damping means for a rod: six times, and the closest material."""
    with readable_errors():
        from viscorod.model.sections.stiffness_section import STRAINS
        from viscorod.programs.inputs import program as find

        kind = find(program)
        name, chosen = rod_of(case, rod)
        data = _section(chosen, at)
        inputs = kind.from_numbers(
            numbers_of("--numbers", numbers), data, **_given(segment_length, frequency)
        )
        found = inputs.recovered(data, poissons_ratio)
        say(f"{kind.title}: {kind.meaning}\n")
        rows = []
        for k, word in enumerate(STRAINS):
            row: dict[str, object] = {"strain": word, "time [s]": float(found.times[k])}
            row["D_ii [SI]"] = float(found.damping[k, k])
            if found.material is not None:
                row["material off by"] = f"{found.material.deviations[k]:+.2%}"
            rows.append(row)
        say(rows_text(f"Rod {name}", rows, prefixes=False))
        if found.material is not None:
            fit = found.material
            say(
                "\nClosest material: damping = "
                f"{{ shear_time = {fit.shear_time:.10g}, bulk_time = {fit.bulk_time:.10g} }}"
            )
        notes(found.warnings)


def _section(rod: Rod, at: float) -> SectionData:
    """Return the section of a rod at an arc length, m."""
    from viscorod.programs.inputs import SectionData

    if not 0.0 <= at <= rod.length:
        raise InputError(
            Fault("--at", f"{at:g}", "outside the rod", f"give an arc length from 0 to {rod.length:g} m")
        )
    return SectionData.of(rod, at)


def _given(segment_length: float | None, frequency: float | None) -> dict[str, float]:
    """Return the options of programs that were given."""
    options = {"segment_length": segment_length, "frequency": frequency}
    return {word: value for word, value in options.items() if value is not None}


def _refuse_unread(options: dict[str, float], kinds: list[type[ProgramInputs]]) -> None:
    for word, value in options.items():
        if not any(word in kind.options for kind in kinds):
            titles = ", ".join(kind.title for kind in kinds)
            flag = f"--{word.replace('_', '-')}"
            raise InputError(Fault(flag, f"{value:g}", f"not used by {titles}", "leave it out"))


def _program_text(inputs: ProgramInputs, data: SectionData) -> str:
    lines = [f"{inputs.title} ({inputs.program}): {inputs.meaning}", ""]
    lines += [f"    {line}" for line in inputs.text().splitlines()]
    for title, sentences in (
        ("Lost", inputs.losses(data)),
        ("Note", inputs.warnings(data)),
        ("Read in", inputs.sources),
    ):
        if sentences:
            lines += ["", *(f"  {title}: {sentence}" for sentence in sentences)]
    return "\n".join(lines)
