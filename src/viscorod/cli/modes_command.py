"""``viscorod modes``: small vibrations of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.completion import words
from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.terminal import readable_errors, replacing_note, told

__all__ = ["modes"]


def modes(
    case: CaseFile,
    output: ResultFolder = None,
    count: Annotated[
        int | None,
        typer.Option(min=1, help="Number of modes [default: that of the case, or 6]", show_default=False),
    ] = None,
    about: Annotated[
        str | None,
        typer.Option(
            help="equilibrium (at t = 0-), released (just after t = 0) or reference [default: that of the case, or "
            "equilibrium]",
            show_default=False,
            autocompletion=words("equilibrium", "released", "reference"),
        ),
    ] = None,
    near: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="Those nearest to this frequency, Hz.", show_default=False),
    ] = None,
) -> None:
    """Find small vibrations of a case, loads included: a table, data, a picture and a page in which they swing.

    Settings are those of its table [modes], if it has one; options go before them.
    """
    with readable_errors():
        from viscorod.analyses.case_run import as_model
        from viscorod.casefile.case import load_case
        from viscorod.pictures.viewer import view
        from viscorod.solve.settings.modes import ModesSettings

        loaded = load_case(existing(case))
        own = loaded.settings
        settings = (
            {name: getattr(own, name) for name in own.model_fields_set}
            if isinstance(own, ModesSettings)
            else {}
        )
        given = {"count": count, "about": about, "near": near}
        settings |= {name: value for name, value in given.items() if value is not None}
        folder = writable(output or Path("out") / case.stem)
        replacing_note(folder / "modes.nc")
        found = as_model(loaded.description).modes(**settings, title=loaded.title)
        written = [found.save(folder / "modes.nc"), picture_at(found.plot, folder / "modes.png")]
        written.append(view(found, folder / "modes.html"))
        told(found, written)
