"""``viscorod identify``: numbers of cases from records of measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.command_kind import quiet
from viscorod.cli.files import picture_at, writable
from viscorod.cli.options import ResultFolder
from viscorod.cli.terminal import complain, readable_errors, replacing_note, told

__all__ = ["identify"]


def identify(
    fit: Annotated[
        Path, typer.Argument(metavar="FIT.toml", help="What is identified: records, cases, parameters.")
    ],
    output: ResultFolder = None,
) -> None:
    """Find numbers of cases from records of measurements: a report, a page, data and the fitted cases."""
    with readable_errors():
        from viscorod.analyses.identification.fit_file import load_fit
        from viscorod.analyses.identify import identify as compute
        from viscorod.whole_files import replacing

        plan = load_fit(fit)
        folder = writable(output or Path("out") / fit.stem)
        replacing_note(folder / "fit.nc")
        result = compute(
            plan.pairs,
            parameters=plan.parameters,
            nuisances=plan.nuisances,
            left_out=plan.left_out,
            report=lambda text: None if quiet() else complain(text),
            **plan.options,
        )
        written = [
            result.save(folder / "fit.nc"),
            result.page(folder / "fit.html"),
            picture_at(result.plot, folder / "fit.png"),
        ]
        for number in range(len(result.words("cases"))):
            path = folder / ("case.toml" if number == 0 else f"case_{number + 1}.toml")
            text = result.to_toml(number).encode()
            with replacing(path, needs=len(text)) as new:
                new.write_bytes(text)
            written.append(path)
        told(result, written)
