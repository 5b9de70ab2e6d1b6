"""The command ``viscorod damping``: damping in other numbers, and as inputs of other programs."""

from __future__ import annotations

import typer

from viscorod.cli.damping_commands.blade_command import blade
from viscorod.cli.damping_commands.convert_command import convert
from viscorod.cli.damping_commands.decay_command import decay
from viscorod.cli.damping_commands.master_command import master
from viscorod.cli.damping_commands.modes_command import modes
from viscorod.cli.damping_commands.program_commands import from_program, programs

__all__ = ["app"]

app = typer.Typer(
    help="Convert damping into other numbers and into the inputs of other programs.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(convert)
app.command()(programs)
app.command("from")(from_program)
app.command()(blade)
app.command()(decay)
app.command()(master)
app.command()(modes)
