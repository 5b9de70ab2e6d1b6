"""``viscorod theories``: a planar straight beam by several beam theories, and which of them is enough."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from viscorod.cli.completion import words
from viscorod.cli.files import existing, picture_at
from viscorod.cli.options import CaseFile, OptionalNumber, output_option
from viscorod.cli.terminal import readable_errors, say, written
from viscorod.errors import Fault, InputError

__all__ = ["theories"]


def theories(
    case: CaseFile,
    duration: Annotated[
        OptionalNumber,
        typer.Option(
            metavar="S", help="Of the motion, s [default: that of the case; an equilibrium if it has none]"
        ),
    ] = None,
    output: Annotated[Path | None, output_option("FILE.png", "Picture to draw")] = None,
    theory: Annotated[
        list[str] | None,
        typer.Option(
            metavar="WORD",
            help="euler_bernoulli, timoshenko or von_karman; may be repeated [default: all]",
            autocompletion=words("euler_bernoulli", "timoshenko", "von_karman"),
        ),
    ] = None,
    within: Annotated[
        OptionalNumber,
        typer.Option(metavar="PART", help="What a theory may err by to be enough [default: 0.05]"),
    ] = None,
) -> None:
    """Compute a planar straight beam by simpler theories beside the exact one, and say which is enough."""
    with readable_errors():
        from viscorod.analyses.case_run import as_model
        from viscorod.casefile.case import load_case
        from viscorod.solve.settings.motion import SimulateSettings

        loaded = load_case(existing(case))
        settings = loaded.settings
        given: dict[str, Any] = {"duration": duration, "within": within, "theory": theory or None}
        if isinstance(settings, SimulateSettings):
            if settings.initial != "equilibrium" or settings.start is not None:
                raise InputError(
                    Fault(
                        "simulate.initial",
                        "another start",
                        "theories are compared from the equilibrium at t = 0- on",
                        'leave it out, or give initial = "equilibrium"',
                    )
                )
            if duration is None:
                given["duration"] = settings.duration
        found = as_model(loaded.description).compare_theories(
            **{name: value for name, value in given.items() if value is not None}
        )
        say(f"{loaded.title}\n{found}" if loaded.title else str(found))
        if output is not None:
            written([picture_at(found.plot, output)])
