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
from viscorod.cli.command_kind import HELP, add
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
from viscorod.cli.report_command import report
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
    context_settings=HELP,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
_WITH_NUMBERS = (
    *(check, run, resume, report, modes, response, buckling, campbell, stability, periodic),
    *(sweep, ensemble, identify),
)
for command in (
    example,
    check,
    run,
    resume,
    report,
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
    add(app, command, numbers=command in _WITH_NUMBERS)
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


def _collect_after_start() -> None:
    """Look for garbage after a million objects at first, for importing makes many and hardly any garbage.

    Those that are there then are not looked at again, and from then on it is looked for after a hundred thousand.
    """

    def settle(phase: str, _info: dict[str, int]) -> None:
        if phase == "stop":
            gc.freeze()
            gc.set_threshold(100_000)
            gc.callbacks.remove(settle)

    gc.callbacks.append(settle)
    gc.set_threshold(1_000_000)


def main() -> None:
    """Run the command line.

    The process ends at once: an orderly shutdown frees the compiled kernels one by one, which takes half a second.
    """
    _collect_after_start()
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
