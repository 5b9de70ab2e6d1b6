"""Commands on results that are there: values at places and times, tables, pictures, films, files for other programs."""

from __future__ import annotations

import typer

from viscorod.export_commands.animate import animate
from viscorod.export_commands.export import export
from viscorod.export_commands.plot import plot
from viscorod.export_commands.probe import probe

__all__ = ["register"]


def register(app: typer.Typer) -> None:
    """Add the commands to the program."""
    for command in (probe, export, plot, animate):
        app.command()(command)
