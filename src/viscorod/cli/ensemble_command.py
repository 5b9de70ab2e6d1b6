"""``viscorod ensemble``: a case computed many times with uncertain values."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.command_kind import quiet
from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.key_values import SetValues, drawn, each_once, named, part_of, value_of
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.sweep_command import (
    Errors,
    ExecutorOption,
    Members,
    QuantityOptions,
    Retry,
    Scheduler,
    Workers,
    executor_of,
    has_failed,
    write_csv,
)
from viscorod.cli.terminal import complain, readable_errors, told
from viscorod.errors import SolveError

__all__ = ["ensemble"]


def ensemble(
    case: CaseFile,
    draw: Annotated[
        list[str],
        typer.Option(
            "--draw",
            metavar="KEY=DISTRIBUTION",
            help="Key of the case file and its distribution, as SciPy calls it: norm(1e6, 5e4). Repeat it for more.",
        ),
    ],
    quantity: QuantityOptions = None,
    points: Annotated[int, typer.Option("--points", "-n", help="Number of points, a power of two.")] = 64,
    seed: Annotated[int, typer.Option("--seed", help="Of the points.")] = 0,
    indices: Annotated[
        bool, typer.Option("--indices", help="Compute Sobol' indices: points times (keys + 2) members.")
    ] = False,
    values: SetValues = None,
    output: ResultFolder = None,
    executor: ExecutorOption = None,
    scheduler: Scheduler = None,
    members: Members = None,
    workers: Workers = None,
    errors: Errors = None,
    retry: Retry = False,
) -> None:
    """Compute a case with uncertain values: print quantiles and Sobol' indices, write data and pictures."""
    with readable_errors():
        from viscorod.analyses.ensemble import ensemble as compute
        from viscorod.analyses.progress import counting
        from viscorod.casefile.case import load_case
        from viscorod.errors import InputError
        from viscorod.results.files.folder_lock import locked
        from viscorod.results.sweep_members import NOT_KEPT

        loaded = load_case(existing(case))
        folder = writable(output or Path("out") / case.stem)
        distributions = each_once(map(drawn, draw), "--draw")
        part = part_of(members)
        count = max(points * (len(distributions) + 2 if indices else 1), 1)
        asked = len(range(count)[part or slice(None)])
        failed = False
        with nullcontext() if part is not None else locked(folder):
            try:
                with counting(asked, "members", shown=not quiet()) as progress:
                    result = compute(
                        loaded,
                        distributions,
                        points,
                        quantities=each_once(map(named, quantity or []), "--quantity"),
                        seed=seed,
                        indices=indices,
                        constants=each_once(map(value_of, values or []), "--set") or None,
                        executor=executor_of(executor, scheduler),
                        workers=workers,
                        folder=folder / "ensemble",
                        members=part,
                        errors=errors,
                        retry=retry,
                        progress=progress,
                    )
            except SolveError as error:
                complain(f"error: {error}")
                failed, result = True, error.run
            written = [folder / "ensemble"]
            if part is None and result.members.found.first_of(NOT_KEPT) is None:
                written.append(write_csv(result, folder / "ensemble.csv"))
                try:
                    written.append(picture_at(result.plot, folder / "quantiles.png"))
                    if indices:
                        written.append(picture_at(result.plot_indices, folder / "indices.png"))
                except InputError as error:  # too few members for a picture are still data
                    complain(f"no picture: {error}")
                histories = result.members.found.histories
                for k, name in enumerate(histories, 1):
                    path = folder / ("fan.png" if len(histories) == 1 else f"fan_{k}.png")
                    written.append(picture_at(result.plot_fan, path, name))
            told(result, written)
        if failed or has_failed(result, part):
            raise typer.Exit(1)
