"""The command line, assembled from its commands.

Heavy packages are imported inside the commands, so that ``--help`` and ``--version`` answer at once.
"""

from __future__ import annotations

import gc
import logging
import os
import sys
import warnings
from typing import Annotated

import typer

from viscorod.analyses.compilation_line import CompilationLine, end_compilation_line
from viscorod.cli.animate_command import animate
from viscorod.cli.buckling_command import buckling
from viscorod.cli.check_command import check
from viscorod.cli.damping_commands import app as damping
from viscorod.cli.ensemble_command import ensemble
from viscorod.cli.example_command import example
from viscorod.cli.export_command import export
from viscorod.cli.followed_commands import campbell, stability
from viscorod.cli.identify_command import identify
from viscorod.cli.modes_command import modes
from viscorod.cli.periodic_command import periodic
from viscorod.cli.plot_command import plot
from viscorod.cli.probe_command import probe
from viscorod.cli.response_command import response
from viscorod.cli.run_commands import resume, run
from viscorod.cli.schema_command import schema
from viscorod.cli.sweep_command import sweep
from viscorod.cli.theories_command import theories
from viscorod.cli.view_command import view
from viscorod.cli.warmup_command import warmup

app = typer.Typer(
    name="viscorod",
    help="Compute the large motion of slender rods with material damping, and account for all energy.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for command in (
    example,
    check,
    run,
    resume,
    modes,
    response,
    buckling,
    campbell,
    stability,
    periodic,
    sweep,
    ensemble,
    identify,
    theories,
    view,
    plot,
    probe,
    export,
    animate,
    schema,
    warmup,
):
    app.command()(command)
app.add_typer(damping, name="damping")


@app.callback(invoke_without_command=True)
def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", is_eager=True)
    ] = False,
) -> None:
    if version:
        from viscorod import __version__

        typer.echo(f"viscorod {__version__}")
        raise typer.Exit


def main() -> None:
    """Run the command line.

    The process ends at once: an orderly shutdown frees the compiled kernels one by one, which takes half a second.
    """
    gc.set_threshold(100_000)  # importing makes many objects and little garbage
    # Python hides these warnings outside of scripts; whoever writes a case file is to see a former name of a key
    warnings.filterwarnings("default", message=r"\w+ is now \w+$", category=DeprecationWarning)
    warnings.showwarning = lambda message, *_, **__: typer.echo(f"warning: {message}", err=True)
    logging.getLogger("viscorod").addHandler(CompilationLine())
    try:
        app()
    except SystemExit as end:
        end_compilation_line()
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
