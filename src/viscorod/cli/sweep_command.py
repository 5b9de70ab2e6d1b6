"""``viscorod sweep``: a case computed several times with other values."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from viscorod.cli.command_kind import quiet
from viscorod.cli.completion import words
from viscorod.cli.files import existing, writable
from viscorod.cli.key_values import column_of, each_once, grid_of, named, part_of
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.terminal import complain, readable_errors, replacing_note, told
from viscorod.errors import InputError, SolveError
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from viscorod.results.sweep_result import Sweep

__all__ = [
    "Errors",
    "ExecutorOption",
    "Members",
    "QuantityOptions",
    "Retry",
    "Scheduler",
    "Workers",
    "executor_of",
    "has_failed",
    "sweep",
    "write",
    "write_csv",
]

LARGEST_FILE = 2000
"""Members of a sweep that is written to one netCDF file; larger ones become a table or a store."""

QuantityOptions = Annotated[
    list[str] | None,
    typer.Option(
        "--quantity",
        metavar="NAME=WORDS",
        help='Number of each member, such as "tip=displacement beam.end y max". Repeat it for more.',
        show_default=False,
    ),
]
ExecutorOption = Annotated[
    str | None,
    typer.Option(
        "--executor",
        metavar="KIND",
        help="processes:8, threads:2 or dask [default: one process per processor]",
        show_default=False,
        autocompletion=words("processes:", "threads:", "dask"),
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option("--scheduler", metavar="ADDRESS", help="Of Dask, with --executor dask.", show_default=False),
]
Members = Annotated[
    str | None,
    typer.Option(
        "--members",
        metavar="FIRST:END",
        help="Compute these only, counted from 0, such as 100:200 in an array job.",
        show_default=False,
    ),
]
Workers = Annotated[
    int | None,
    typer.Option("--workers", min=1, help="Number of processes; 1 is this one.", show_default=False),
]

Errors = Annotated[
    int | None,
    typer.Option(
        "--errors",
        min=0,
        metavar="NUMBER",
        help="Members, evenly chosen, whose errors of mesh and steps are estimated "
        "[default: 64, all where whole results are kept]",
        show_default=False,
    ),
]
Retry = Annotated[
    bool,
    typer.Option("--retry", help="Compute members again that failed, or that killed their workers."),
]


def sweep(
    case: CaseFile,
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="Key of the case file and its values, one per member: rods.beam.elements=1,2,4. "
            "Repeat it for keys that vary together; one value beside more is that of all members.",
            show_default=False,
        ),
    ] = None,
    grid: Annotated[
        list[str] | None,
        typer.Option(
            "--grid",
            metavar="KEY=VALUES",
            help="Key of which every value is combined with all others: 0.01:0.05:9 (first, last, number) or a list.",
            show_default=False,
        ),
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option("--table", metavar="FILE.csv", help="Values of the members, keys in the first line."),
    ] = None,
    quantity: QuantityOptions = None,
    fields: Annotated[bool, typer.Option("--fields", help="Keep whole results beside quantities.")] = False,
    output: ResultFolder = None,
    executor: ExecutorOption = None,
    scheduler: Scheduler = None,
    members: Members = None,
    workers: Workers = None,
    errors: Errors = None,
    retry: Retry = False,
) -> None:
    """Compute a case with many values: print a table, write data."""
    with readable_errors():
        from viscorod.analyses.progress import counting
        from viscorod.analyses.sweep import sweep as compute
        from viscorod.analyses.sweeps.rows import rows_of
        from viscorod.casefile.case import load_case
        from viscorod.results.files.folder_lock import locked
        from viscorod.results.sweep_members import NOT_KEPT

        loaded = load_case(existing(case))
        columns = each_once(map(column_of, values or []), "--set")
        crossed = each_once(map(grid_of, grid or []), "--grid")
        folder = writable(output or Path("out") / case.stem)
        several = bool(crossed or table) or max(map(len, columns.values()), default=0) > 1
        constants = {key: column[0] for key, column in columns.items() if several and len(column) == 1}
        columns = {key: column for key, column in columns.items() if key not in constants}
        if table is not None and columns:
            raise InputError(
                "--set: a table has the columns that vary; give one value for all members, or --grid"
            )
        if not (values or grid or table):
            words = "--set KEY=VALUES, --grid KEY=VALUES or --table FILE.csv"
            raise InputError(f"nothing varies; give {words}, such as --set rods.beam.elements=1,2,4")
        given: dict[str, Any] = {
            "values": table or columns or None,
            "grid": crossed or None,
            "constants": constants or None,
        }
        count = len(rows_of(**given))
        part = part_of(members)
        asked = each_once(map(named, quantity or []), "--quantity")
        array_job = part is not None  # several of them share the folder
        failed, engine = False, (executor_of(executor, scheduler), workers)
        with nullcontext() if array_job else locked(folder):
            try:
                with counting(
                    len(range(count)[part or slice(None)]), "members", shown=not quiet()
                ) as progress:
                    result = compute(
                        loaded,
                        **given,
                        quantities=asked or None,
                        fields=True if fields or not asked else None,
                        executor=engine[0],
                        workers=workers,
                        folder=folder / "sweep",
                        members=part,
                        errors=errors,
                        retry=retry,
                        progress=progress if array_job else begun(folder / "sweep.nc", progress),
                    )
            except SolveError as error:
                complain(f"error: {error}")
                failed, result = True, error.run
            kept = array_job or result.members.found.first_of(NOT_KEPT) is not None
            told(result, [folder / "sweep"] if kept else write(result, folder, engine))
        if failed or has_failed(result, part):
            raise typer.Exit(1)


def begun(path: Path, progress: Callable[[float], None]) -> Callable[[float], None]:
    """Return a function that says, when it is called first, that a file will be replaced: nothing was refused then."""
    waiting = [path]

    def tell(done: float) -> None:
        while waiting:
            replacing_note(waiting.pop())
        progress(done)

    return tell


def has_failed(result: Sweep, part: slice | None) -> bool:
    """Return whether a member failed, or was left out though it was asked for."""
    from viscorod.results.sweep_members import COMPLETED, NOT_RUN

    outcomes = set(result.members.found.outcomes())
    return bool(outcomes - {COMPLETED} - ({NOT_RUN} if part is not None else set()))


def executor_of(executor: str | None, scheduler: str | None) -> str | None:
    """Return the executor in one text.

    Raises:
        InputError: there is a scheduler without Dask.
    """
    if scheduler is None:
        return executor
    if executor != "dask":
        raise InputError(f"--scheduler {scheduler}: only Dask has one; add --executor dask")
    return f"dask:{scheduler}"


def write_csv(result: Sweep, path: Path) -> Path:
    """Write the table of a sweep, which replaces an earlier one when it is whole."""
    with replacing(path) as new:
        result.table().to_csv(new)
    return path


def write(result: Sweep, folder: Path, engine: tuple[str | None, int | None]) -> list[Path]:
    """Write a sweep, and its table if it has quantities; a store is written by what computed the members.

    Args:
        result: with all members; folder: for the files.
        engine: executor and number of workers.
    """
    written = []
    if result.quantities:
        written.append(write_csv(result, folder / "sweep.csv"))
    if len(result.members) <= LARGEST_FILE:
        return [result.save(folder / "sweep.nc"), *written]
    if find_spec("pyarrow") is None or find_spec("zarr") is None:
        return [folder / "sweep", *written]
    if not result.members.kept():
        return [result.save(folder / "sweep.parquet"), *written]
    from viscorod.analyses.sweeps.executors import engine as opened

    with opened(*engine) as workers:
        return [result.save(folder / "sweep.zarr", executor=workers), *written]
