"""Commands on results that are there: values at places and times, tables, pictures, films, files for other programs."""

from __future__ import annotations

import typer

from viscorod.cli.result_commands.animate_command import animate
from viscorod.cli.result_commands.export_command import export
from viscorod.cli.result_commands.plot_command import plot
from viscorod.cli.result_commands.probe_command import probe

__all__ = ["register"]


def register(app: typer.Typer) -> None:
    """Add the commands to the program."""
    for command in (probe, export, plot, animate):
        app.command()(command)
