"""The command line: run, view, sweep, check and copy cases, compile kernels.

Heavy packages are imported inside the commands, so that ``--help`` and ``--version`` answer at once.
"""

from __future__ import annotations

import gc
import os
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from viscorod.cli.damping_commands import app as damping_app
from viscorod.cli.result_commands import register as register_exports
from viscorod.cli.run_commands import resume, run, writable
from viscorod.cli.terminal import existing, readable_errors, rows_text
from viscorod.cli.view_command import view
from viscorod.errors import InputError, SolveError, writing

if TYPE_CHECKING:
    from viscorod.analyses.check import CheckReport
    from viscorod.casefile.units import Conversion

app = typer.Typer(
    name="viscorod",
    help="Rods with viscous damping in large motion: hold, let go, watch, and see where every joule went.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

app.command()(run)
app.command()(resume)
app.add_typer(damping_app, name="damping")
app.command()(view)
register_exports(app)

CaseFile = Annotated[
    Path, typer.Argument(metavar="CASE.toml", help="Case file; `viscorod example` lists some.")
]


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


@app.command()
def check(
    case: CaseFile,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="DIR",
            help="Folder for the picture [default: out/CASE]",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Validate a case, draw its model and print it in tables."""
    with readable_errors():
        from viscorod.analyses.case_run import as_model
        from viscorod.analyses.check import check as check_model
        from viscorod.casefile.case import load_case

        loaded = load_case(existing(case))
        folder = output or Path("out") / case.stem
        writable(folder)
        # before anything is solved: the picture shows why something may fail
        picture = as_model(loaded.description).draw(folder / "assembly.png", loaded.title)
        try:
            report = check_model(loaded.description, loaded.settings)
            typer.echo(_check_text(report, loaded.conversions))
        finally:
            typer.echo(f"\nWritten: {picture}")


@app.command()
def sweep(
    case: CaseFile,
    values: Annotated[
        list[str],
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="Key of the case file and its values, one per member: rods.beam.elements=1,2,4. "
            "Repeat it for keys that vary together.",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="DIR", help="Folder for results [default: out/CASE]", show_default=False
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers", min=1, help="Number of processes [default: one per processor]", show_default=False
        ),
    ] = None,
) -> None:
    """Compute a case several times with other values, in parallel: print a table, write data."""
    with readable_errors():
        from viscorod.analyses.sweep import sweep as compute
        from viscorod.casefile.case import load_case
        from viscorod.cli.progress import counting

        loaded = load_case(existing(case))
        table = dict(map(_column, values))
        folder = output or Path("out") / case.stem
        writable(folder)
        count = max(map(len, table.values()), default=0)
        try:
            with counting(count, "members") as progress:
                result = compute(loaded, table, workers=workers, progress=progress)
        except SolveError as error:
            typer.echo(f"error: {error}", err=True)
            result = error.run
        typer.echo(result.report())
        typer.echo(f"\nWritten: {result.save(folder / 'sweep.nc')}")
        if result.failed:
            raise typer.Exit(1)


@app.command()
def schema(
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="File to write [default: print it]", show_default=False
        ),
    ] = None,
) -> None:
    """Write the JSON Schema of case files, for completion and checks in an editor."""
    with readable_errors():
        import json

        from viscorod.casefile.json_schema import case_schema

        text = json.dumps(case_schema(), indent=2, ensure_ascii=False) + "\n"
        if output is None:
            typer.echo(text, nl=False)
            return
        with writing(output):
            output.parent.mkdir(parents=True, exist_ok=True)
            output.write_text(text, encoding="utf-8")
        typer.echo(f"{output}: name it in a case file: #:schema {output}")


@app.command()
def warmup() -> None:
    """Compile all kernels now, so that later runs start at once."""
    from viscorod.analyses.warmup import kernels, warm_up
    from viscorod.cli.progress import counting

    count = len(kernels())
    if count == 0:
        typer.echo("nothing to compile: NUMBA_DISABLE_JIT is set, kernels are Python functions")
        return
    with counting(count, "kernels") as progress:
        done = warm_up(progress)
    folders = ", ".join(map(str, done.folders))
    if done.compiled:
        typer.echo(f"{count} kernels compiled in {done.seconds:.1f} s; machine code is in {folders}")
    else:
        typer.echo(f"all {count} kernels are there, in {folders}; loading them took {done.seconds:.1f} s")


@app.command()
def example(
    name: Annotated[
        str | None, typer.Argument(help="Case to copy; without it, all are listed.", show_default=False)
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder to copy into")
    ] = Path(),
) -> None:
    """List the cases that come with viscorod, or copy one."""
    with readable_errors():
        from viscorod.casefile.shipped import shipped_case, shipped_cases

        if name is not None:
            target = _copied(shipped_case(name), output)
            typer.echo(f"{target}: change it, then: viscorod run {target}")
            return
        cases = shipped_cases()
        width = max(map(len, cases), default=0)
        for word, path in cases.items():
            title = tomllib.loads(path.read_text(encoding="utf-8")).get("title", "")
            typer.echo(f"{word:<{width}}  {title}")


def main() -> None:
    """Run the command line.

    The process ends at once: an orderly shutdown frees the compiled kernels one by one, which takes half a second.
    """
    gc.set_threshold(100_000)  # importing makes many objects and little garbage
    try:
        app()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _column(text: str) -> tuple[str, list[Any]]:
    """A key and its values from ``key=1,2,4``; values are written as in a case file."""
    key, sign, values = text.partition("=")
    try:
        column = tomllib.loads(f"values = [{values}]")["values"]
    except tomllib.TOMLDecodeError:
        column = []
    if not sign or not column:
        raise InputError(
            f"--set {text}: give a key and values as in a case file, separated by commas, such as "
            'rods.beam.elements=1,2,4 or rods.beam.section="thin","thick"'
        )
    return key.strip(), column


def _copied(case: Path, folder: Path) -> Path:
    target = folder / case.name
    if target.exists():
        raise InputError(f"{target} is there already; move it, or name another folder with -o")
    with writing(target):
        folder.mkdir(parents=True, exist_ok=True)
        target.write_bytes(case.read_bytes())
    return target


def _check_text(report: CheckReport, conversions: Sequence[Conversion]) -> str:
    modes = [
        {
            "mode": str(number),
            "frequency [Hz]": frequency,
            "damping ratio": "overdamped" if ratio > 1.0 - 1e-9 else round(ratio, 10) + 0.0,
        }
        for number, (frequency, ratio) in enumerate(
            zip(report.frequencies, report.damping_ratios, strict=True), 1
        )
    ]
    conditions = f", {report.conditions} conditions of joints and held strains" if report.conditions else ""
    units = [
        {"key": item.where, "as given": item.given, "in SI": f"{item.value!r} {item.unit}"}
        for item in conversions
    ]
    blocks = [
        rows_text("Units converted", units),
        rows_text("Rods", report.rods),
        rows_text("Sections", report.sections),
        rows_text("Materials", report.materials),
        rows_text("Rigid bodies", report.bodies),
        rows_text("Joints", report.joints),
        rows_text("Springs", report.springs),
        rows_text("First natural modes about the reference shape (a quick estimate)", modes),
        f"{report.nodes} nodes, {report.unknowns} unknowns{conditions}\nLinear systems: {report.linear_solver}",
        "\n".join(["Assumptions about damping", *(f"  - {text}" for text in report.assumptions)])
        if report.assumptions
        else "",
        "\n".join(["Warnings", *(f"  - {text}" for text in report.warnings)])
        if report.warnings
        else "No warnings",
    ]
    return "\n\n".join(block for block in blocks if block)
