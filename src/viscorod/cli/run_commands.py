"""``viscorod run`` and ``resume``: a case computed, a stopped run continued."""

from __future__ import annotations

import difflib
import json
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from viscorod.cli.command_kind import quiet
from viscorod.cli.files import existing, picture_at, writable
from viscorod.cli.key_values import SetValues, each_once, value_of
from viscorod.cli.options import CaseFile, ResultFolder
from viscorod.cli.polite_stop import polite_stop
from viscorod.cli.terminal import complain, readable_errors, replacing_note, told
from viscorod.errors import InputError, SolveError

if TYPE_CHECKING:
    from viscorod.analyses.discrete import DiscreteModel
    from viscorod.casefile.case import Case
    from viscorod.results.any_result import AnyResult

__all__ = ["resume", "run"]


def run(
    case: CaseFile,
    output: ResultFolder = None,
    anew: Annotated[
        bool, typer.Option("--anew", help="Remove a run that was stopped in the folder, and begin anew.")
    ] = False,
    values: SetValues = None,
) -> None:
    """Compute a case: print a report, write data and pictures."""
    with readable_errors():
        from viscorod.analyses.case_run import discretised_case
        from viscorod.analyses.check import doubts
        from viscorod.casefile.case import load_case
        from viscorod.casefile.set_values import with_values
        from viscorod.results.files.folder_lock import require_free

        loaded = with_values(load_case(existing(case)), each_once(map(value_of, values or []), "--set"))
        folder = writable(output or Path("out") / case.stem)
        require_free(folder, stopped=anew)
        discrete = discretised_case(loaded)
        warnings = doubts(discrete)
        replacing_note(folder / "run.nc")
        for warning in [] if quiet() else warnings:
            complain(f"warning: {warning}")
        _compute(loaded, folder, warnings, discrete, anew=anew)


def resume(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of the stopped run.")],
    case: Annotated[
        Path | None,
        typer.Option(
            "--case",
            metavar="CASE.toml",
            help="Case file to compare with, if it was moved",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Continue a stopped run from its last checkpoint; the result is that of an uninterrupted run."""
    with readable_errors():
        from viscorod.casefile.case import parse_case
        from viscorod.casefile.set_values import with_values
        from viscorod.results.files.folder_lock import require_free, require_stopped
        from viscorod.results.files.journal_folder import FOLDER
        from viscorod.results.files.stored_journal import about

        require_free(folder, stopped=True)
        require_stopped(folder)
        known = about(folder / FOLDER)
        text, source = str(known.get("case_text", "")), Path(str(known.get("case_file", "")))
        if not text:
            raise InputError(
                f"{folder}: the run did not come from a case file; go on with Model.simulate(..., resume=True)"
            )
        now = existing(case) if case is not None else source if source.is_file() else None
        if now is not None:
            _require_same(text, now)
        doubts = json.loads(str(known.get("doubts", "[]")))
        changes = json.loads(str(known.get("case_changes", "{}")))
        _compute(with_values(parse_case(text, source), changes), folder, doubts)


def _require_same(text: str, path: Path) -> None:
    """Refuse a case file that differs from the one the run began with."""
    present = path.read_text(encoding="utf-8-sig")
    if present == text:
        return
    lines = difflib.unified_diff(
        text.splitlines(), present.splitlines(), "as the run began", str(path), lineterm=""
    )
    raise InputError(
        f"{path} has changed since the run began, and the run cannot go on with it:\n"
        + "\n".join(f"  {line}" for line in lines)
        + "\nRestore it, name another file with --case, or run the case again"
    )


def _compute(
    case: Case,
    folder: Path,
    doubts: Sequence[str],
    discrete: DiscreteModel | None = None,
    *,
    anew: bool = False,
) -> None:
    """Run a case whose model has been discretised; without that, go on with the run that was stopped in the folder."""
    from viscorod.analyses.case_run import run_case
    from viscorod.analyses.progress import reporting
    from viscorod.results.files.folder_lock import claimed
    from viscorod.results.files.journal_folder import FOLDER
    from viscorod.results.files.journal_folder import empty as remove
    from viscorod.results.run import Run
    from viscorod.solve.settings.motion import SimulateSettings

    static = not isinstance(case.settings, SimulateSettings)
    result: AnyResult
    with claimed(folder, anew=anew) if static else nullcontext():  # motions do it themselves
        try:
            with polite_stop() as stop, reporting(case.settings.course, shown=not quiet()) as progress:
                result = run_case(
                    case,
                    discrete,
                    progress=progress,
                    folder=folder,
                    doubts=doubts,
                    resume=discrete is None,
                    anew=anew and not static,
                    stop=stop,
                )
        except SolveError as error:
            complain(f"error: {error}")
            if error.run is not None:
                if isinstance(error.run, Run) and error.run.outcome == "interrupted":
                    complain(f"go on with: viscorod resume {folder}")
                written = _write(error.run, folder)
                complain(f"written up to there: {', '.join(map(str, written))}")
            raise typer.Exit(1) from None
        if static and anew:
            remove(folder / FOLDER)
        written = _write(result, folder)
    told(result, written)


def _write(result: AnyResult, folder: Path) -> list[Path]:
    """Write pictures, and data unless it is there already; return the files."""
    from viscorod.results.run import Run

    if isinstance(result, Run):
        pictures = [
            picture_at(result.plot, folder / "motion.png"),
            picture_at(result.plot_energy, folder / "energy.png"),
        ]
        return [folder / "run.nc", *pictures]
    picture = picture_at(result.plot, folder / f"{result.picture}.png")
    return [result.save(folder / "run.nc"), picture]
