"""``viscorod view``: a result as one HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.files import motion
from viscorod.cli.options import output_option
from viscorod.cli.terminal import readable_errors, written

__all__ = ["view"]


def view(
    result: Annotated[Path, typer.Argument(metavar="RUN.nc", help="Written by viscorod run or modes.")],
    output: Annotated[
        Path | None,
        output_option("FILE.html", "File to write [default: beside the result]"),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(
            "--frames", min=2, metavar="N", help="Frames at most [default: 1500]", show_default=False
        ),
    ] = None,
    beside: Annotated[
        list[Path] | None,
        typer.Option(
            "--beside",
            metavar="OTHER.nc",
            help="Another motion that is shown beside it, such as one before a change; may be repeated.",
            show_default=False,
        ),
    ] = None,
    open_: Annotated[bool, typer.Option("--open", help="Show it in the browser.")] = False,
) -> None:
    """Make one HTML file that plays a motion in 3D beside its histories, energy account and damping ratios.

    Modes, and the small motions of a steady rotation, swing beside a table of them. It needs no server and no network.
    Long runs are shown with fewer times and stations; the page says so.
    """
    with readable_errors():
        from viscorod.pictures.viewer import view as write
        from viscorod.pictures.viewer.writing import FRAMES
        from viscorod.results.files.storage import load
        from viscorod.results.text_numbers import quantity

        others = {str(path): motion(path, "--beside") for path in beside or []}
        target = output or result.with_suffix(".html")
        page = write(load(result), target, frames=frames or FRAMES, beside=others)
        written([page], f" ({quantity(page.stat().st_size, 'B', 2)})", first=True)
        if open_:
            import webbrowser

            webbrowser.open(page.resolve().as_uri())
