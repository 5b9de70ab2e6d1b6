"""Sweeps: one case with other values, several independent runs at a time."""

from __future__ import annotations

import copy
import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

from viscorod.analyses.case_run import run_case
from viscorod.analyses.sweep_workers import FAILED, UNTOUCHED, Found, in_parallel
from viscorod.casefile.case import Case, case_from_dict, load_case
from viscorod.casefile.case_keys import put
from viscorod.checks import require_callback
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.fields.definition import show
from viscorod.results.sweep_result import Sweep, SweepRun
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.stability import StabilitySettings

__all__ = ["sweep"]

Values: TypeAlias = Mapping[str, Sequence[Any]] | Sequence[Mapping[str, Any]]
Progress: TypeAlias = Callable[[float], None]

OUTPUTS = 200
"""Stored states of a run whose case gives no output_interval."""


def sweep(
    case: Case | str | Path,
    values: Values,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Compute a case several times, each time with other values, in parallel processes.

    Runs are stored at common times: every ``output_interval`` of the case, or 200 times where it gives none. A member
    that fails does not stop the others. In a script with more than one worker the call must stand under
    ``if __name__ == "__main__":``, as processes that start import the script.

    Args:
        case: a case, or the path of its file; it must be right as it stands.
        values: key -> its values, one per member, such as ``{"rods.beam.elements": [1, 2, 4]}``; several keys vary
            together. Or a list of one mapping key -> value per member. Keys are those of the case file, with dots and
            ``[number]`` for the entries of lists: ``"loads[0].value"``.
        workers: number of processes; None takes one per processor, 1 computes in this process.
        progress: called with the number of members done, fractions included.

    Returns:
        The members with their results, in the order of their values.

    Raises:
        InputError: a key or value is wrong; nothing has been computed.
        SolveError: the sweep was interrupted; ``run`` holds the `Sweep` of what was computed.
    """
    if not isinstance(case, Case):
        case = load_case(case)
    if isinstance(case.settings, BucklingSettings | CampbellSettings | StabilitySettings | PeriodicSettings):
        why = "sweeps are of motions, equilibria, paths, steady rotations, modes and frequency responses"
        raise InputError(Fault(case.kind, "", why, "compute every case by itself, in a loop"))
    if progress is not None:
        require_callback("progress", progress, 0.0)
    rows = _rows(values)
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(Fault("workers", show(workers), "a whole number of at least 1 is needed", "give 2"))
    contents, notes = _contents(case, rows)
    jobs = [(content, case.title, case.source) for content in contents]
    count = min(workers or os.cpu_count() or 1, len(jobs))
    with _stopping() as stop:
        found = (
            _alone(jobs, stop, progress) if count == 1 else in_parallel(_compute, jobs, count, stop, progress)
        )
        stopped = stop.is_set()
    members = [SweepRun(k, row, *parts) for k, (row, parts) in enumerate(zip(rows, found, strict=True))]
    result = Sweep(members, case.title, notes)
    if stopped:
        raise SolveError(
            f"The sweep was stopped; {len(result.completed)} of {len(rows)} members are done", result
        )
    return result


def _rows(values: Values) -> list[dict[str, Any]]:
    """Return the values of every member, plain numbers, texts and lists."""
    advice = "give a key of the case file with a list of values: {'rods.beam.elements': [1, 2, 4]}"
    if isinstance(values, Mapping):
        columns = {str(key): _plain(column) for key, column in values.items()}
        for key, column in columns.items():
            if not isinstance(column, list | tuple) or not column:
                raise InputError(Fault(key, show(column), "a list of values is needed here", advice))
        lengths = {key: len(column) for key, column in columns.items()}
        first, count = next(iter(lengths.items()), ("", 0))
        for key, length in lengths.items():
            if length != count:
                found, why = f"{length} values", f"{first} has {count}; they vary together"
                raise InputError(Fault(key, found, why, "give every key one value per member"))
        rows = [{key: column[k] for key, column in columns.items()} for k in range(count)]
    else:
        if not isinstance(values, Sequence) or not all(isinstance(row, Mapping) for row in values):
            raise InputError(Fault("values", show(values), "keys with their values are needed here", advice))
        rows = [{str(key): _plain(value) for key, value in row.items()} for row in values]
        for k, row in enumerate(rows):
            if list(row) != list(rows[0]):
                found, why = f"the keys {', '.join(row)}", f"the first member has {', '.join(rows[0])}"
                raise InputError(Fault(f"values[{k}]", found, why, "give all members the same keys"))
    if not rows or not rows[0]:
        raise InputError(Fault("values", show(values), "there is nothing to vary", advice))
    return rows


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _contents(case: Case, rows: Sequence[Mapping[str, Any]]) -> tuple[list[dict[str, Any]], list[str]]:
    """Return the content of a case file for every member, checked, and what was chosen for all of them."""
    contents, notes = [], []
    problems: dict[tuple[str, str], Fault] = {}
    for row in rows:
        content = copy.deepcopy(dict(case.content))
        try:
            for key, value in row.items():
                put(content, key, value)
            member = case_from_dict(content, case.source)
        except InputError as error:
            for problem in error.problems:  # the same mistake in many members is reported once
                problems.setdefault((problem.where, problem.why), problem)
            continue
        settings = member.settings
        if isinstance(settings, SimulateSettings) and "output_interval" not in content["simulate"]:
            interval = settings.duration / OUTPUTS
            content["simulate"]["output_interval"] = interval
            notes.append(
                f"output_interval = {interval:g} s, a {OUTPUTS}th of the duration: the case gives none"
            )
        contents.append(content)
    if problems:
        raise InputError(problems.values(), heading=str(case.source) if case.source else "case")
    return contents, list(dict.fromkeys(notes))


Job: TypeAlias = tuple[Mapping[str, Any], str, Path | None]

STOPPED = "the sweep was stopped"


def _compute(job: Job, tell: Callable[[float], None], stopped: Callable[[], bool]) -> Found:
    """Do one member; whatever goes wrong is recorded, not raised."""
    content, title, source = job
    try:
        case = case_from_dict({"title": title, **content}, source)
        total = _total(case)

        def progress(reached: float, _step: float) -> None:
            tell(min(reached / total, 1.0))

        return (
            run_case(case, progress=progress, stop=lambda: STOPPED if stopped() else ""),
            "",
            "completed",
        )
    except SolveError as error:
        without = "interrupted" if stopped() else "failed"
        return error.run, str(error), without if error.run is None else error.run.outcome
    except InputError as error:
        return None, str(error), "refused"
    except KeyboardInterrupt:
        return None, "interrupted from the keyboard", "interrupted"
    except Exception as error:  # one member's defect must not cost the others their results
        return None, f"{type(error).__name__}: {error}", FAILED


def _total(case: Case) -> float:
    """Return the time [s], load factor or frequency [Hz] at which a member is done."""
    settings = case.settings
    if isinstance(settings, SimulateSettings):
        return settings.duration
    return settings.highest if isinstance(settings, ResponseSettings) else 1.0


def _alone(jobs: Sequence[Job], stop: threading.Event, progress: Progress | None) -> list[Found]:
    """Compute one member after the other, in this process."""
    found: list[Found] = []
    for k, job in enumerate(jobs):

        def tell(part: float, *, k: int = k) -> None:
            if progress is not None:
                progress(k + part)

        found.append(UNTOUCHED if stop.is_set() else _compute(job, tell, stop.is_set))
    return found


@contextmanager
def _stopping() -> Iterator[threading.Event]:
    """Yield an event that the first Ctrl-C sets; the second one does what it always does."""
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = signal.getsignal(signal.SIGINT)

    def on_interrupt(_number: int, _frame: Any) -> None:
        stop.set()
        signal.signal(signal.SIGINT, before)

    signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)
