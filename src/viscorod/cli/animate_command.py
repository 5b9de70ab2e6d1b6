"""``viscorod animate``: a film of a motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.files import motion
from viscorod.cli.options import ResultFile, output_option
from viscorod.cli.terminal import readable_errors

__all__ = ["animate"]


def animate(
    result: ResultFile,
    output: Annotated[
        Path | None,
        output_option("FILE", "Film, .mp4 or .gif [default: motion.gif beside the result]"),
    ] = None,
    fps: Annotated[float, typer.Option("--fps", help="Frames per second of the film.")] = 25.0,
    speed: Annotated[
        float | None,
        typer.Option(
            help="Seconds of motion in one second of film [default: 1, or what makes the film last about 10 s]",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Make a film of a motion."""
    with readable_errors():
        from viscorod.analyses.progress import counting
        from viscorod.pictures.animation import Pace, write_film

        run = motion(result, "a film")
        target = output or result.with_name("motion.gif")
        pace = Pace.of(run, fps, speed, hundredths=target.suffix.lower() == ".gif")
        with counting(pace.times.size, "frames") as progress:
            written = write_film(run, target, fps=fps, speed=speed, progress=progress)
        typer.echo(f"Written: {written}, {pace.times.size} frames, speed {pace.speed:g}")
