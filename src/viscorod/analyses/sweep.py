"""Sweeps: one case with other values, several independent runs at a time."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, MutableMapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from viscorod.analyses.progress import counting
from viscorod.analyses.sweeps.before_computing import FEW, checked, require_right, require_sendable, units_of
from viscorod.analyses.sweeps.executors import opened, processes_of, through
from viscorod.analyses.sweeps.little_garbage import little_garbage
from viscorod.analyses.sweeps.member_names import member_names
from viscorod.analyses.sweeps.member_work import Job, MemberWork
from viscorod.analyses.sweeps.process_start import prepare
from viscorod.analyses.sweeps.processes import UNTOUCHED, hired
from viscorod.analyses.sweeps.rows import Columns, Values, rows_of
from viscorod.analyses.sweeps.same_values import alike, alike_note
from viscorod.analyses.sweeps.stopping import stopping
from viscorod.argument_names import telling
from viscorod.casefile.case import Case, load_case
from viscorod.checks import require_callback
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import show
from viscorod.one_thread import one_blas_thread
from viscorod.results.files.sweep_folder import SweepFolder
from viscorod.results.quantities import Quantities, quantities_of
from viscorod.results.sweep_members import NOT_KEPT, Found, FoundMembers, Rows, SweepMembers
from viscorod.results.sweep_result import Sweep
from viscorod.results.values_in_si import in_si

__all__ = ["sweep"]

Progress: TypeAlias = Callable[[float], None]

LOOKED_AT = 2000
"""Members that are looked at before any is computed."""
MOST_ERRORS = 64
"""Members whose errors are estimated unless told otherwise."""


@telling
def sweep(
    case: Case | str | Path,
    values: Values | None = None,
    *,
    grid: Columns | None = None,
    constants: Mapping[str, Any] | None = None,
    quantities: Quantities | None = None,
    fields: bool | None = None,
    executor: Any = None,
    workers: int | None = None,
    folder: str | Path | SweepFolder | None = None,
    members: slice | None = None,
    errors: int | None = None,
    retry: bool = False,
    progress: Progress | bool | None = None,
) -> Sweep:
    """Compute a case many times, each time with other values, and return a table of named numbers.

    Whole results are kept where no quantities are asked for. They are stored at common times then: every
    ``output_interval`` of the case, or 200 times where it gives none. A member that fails does not stop the others.
    Members with the same values are computed once.
    In a script with more than one process the call must stand under ``if __name__ == "__main__":``, as processes that
    start import the script.

    Args:
        case: a case, or the path of its file; it must be right as it stands.
        values: key -> its values, one per member, such as ``{"rods.beam.elements": [1, 2, 4]}``; several keys vary
            together. Or rows: a list of one mapping key -> value per member, a table of pandas, the path of a CSV file
            with keys in its first line. Keys are those of the case file, with dots and ``[number]`` for the entries of
            lists, ``"loads[0].value"``, and a unit behind them if their numbers have one: ``"rods.beam.end[0] [mm]"``.
        grid: key -> its values, of which every combination is computed (with every row of ``values``).
        constants: key -> one value for all members.
        quantities: name -> words such as ``("decrement", "beam.end", "y")``, or a function of the result that returns a
            number; the page on sweeps has all words.
        fields: keep the whole result of every member; by default only if there are no quantities.
        executor: what computes: "processes:8" of this machine (the default, one per processor), "threads:2", "dask" or
            "dask:ADDRESS" of a scheduler, or any executor of ``concurrent.futures`` such as that of ``mpi4py.futures``.
        workers: number of processes; 1 computes in this process.
        folder: keeps every member that is finished, on disk before it is reported. Members that are there already, of
            the same case, values, version and quantities, are not computed again, failed ones neither. It is to be seen
            by all workers.
        members: which of them this call computes, such as ``slice(100, 200)``.
        errors: for how many members, evenly chosen, the errors of mesh and steps are estimated. It changes no other
            number and takes half the time of short motions or more; by default for 64 at most, for all where whole
            results are kept. A member whose mesh the program chooses has it in any case.
        retry: compute those members of the folder again that failed, or whose workers were killed.
        progress: called with how many of these members are done, fractions included; True shows it.

    Returns:
        The members in the order of their values; ``table()`` has their numbers.

    Raises:
        InputError: a key, a value or a quantity is wrong; nothing has been computed. Of more than 2000 members only the
            first that are due and those with the least and the largest number of every key are looked at before; wrong
            ones among the others have the outcome "refused".
        SolveError: the sweep was interrupted, its executor broke, or its folder cannot take more members; ``run`` holds
            the `Sweep` of what was computed.
    """
    case = _as_case(case)
    if progress is not None and not isinstance(progress, bool):
        require_callback("progress", progress, 0.0)
    rows = rows_of(values, grid, constants)
    count = processes_of(executor, workers)
    if count is not None and min(count, len(rows)) > 1:
        prepare()
    wanted = quantities_of(quantities or {}, case.kind, rows[0])
    keep = not wanted if fields is None else bool(fields)
    looked = _estimated(len(rows), errors, keep)
    names: list[str] = []
    numbers = [quantity.name for quantity in wanted if not quantity.is_history]
    found = _Members(len(rows), numbers)
    store = SweepFolder(Path(folder).absolute()) if isinstance(folder, str | Path) else folder
    if store is not None:
        names = member_names(case, rows, wanted, keep)
        store.take(names, found)
    elif retry:
        why = "there is no folder with members that failed"
        raise InputError(Fault("retry", show(retry), why, "give folder, or leave it out"))
    chosen = _chosen(len(rows), members)
    for k in [k for k in chosen if retry and k in found and not found.is_completed(k)]:
        del found[k]
    same = alike(rows, chosen)
    due = [k for k in chosen if k not in found and k not in same]
    # what is there already was looked at before
    some = list(dict.fromkeys([0, *due[:LOOKED_AT], *_extremes(rows, due[LOOKED_AT:])]))
    work = MemberWork(case.content, case.title, case.source, wanted, keep, store)
    # members that are left over, or tried again, may be those that kill their process
    here = _in_this_process(executor, count, len(rows) if retry else len(chosen))
    alone = count is None or here or not due
    said, read = checked(work, {k: rows[k] for k in (some if alone else some[:FEW])})
    if said.problems and not alone:  # all that is wrong is told at once, and no process starts for it
        said, read = checked(work, {k: rows[k] for k in some})
    require_right(case, said, rows, some, same)
    rows.units = units_of(case, rows) | {one.name: one.unit for one in wanted if one.unit}
    few = [f"errors are estimated for {len(looked)} of {len(rows)} members (errors)"]
    jobs = _Jobs(rows, names, {same.get(k, k) for k in looked}, read if here else {})
    del read

    def recover(numbers: Sequence[int]) -> Mapping[int, Found]:
        if work.folder is None:
            return {}
        again = FoundMembers(len(rows))
        asked = set(numbers)
        work.folder.take([names[k] if k in asked else "" for k in range(len(rows))], again)
        return again

    def died(number: int, why: str) -> Found:
        return work.died(jobs[number], why)

    def told(done: float) -> None:
        if shown is not None:
            shown(len(chosen) - len(due) + done)

    def begin() -> None:
        """Say what is computed, when nothing can be refused any more."""
        estimated = few if errors is None and len(looked) < len(rows) else []
        notes.extend([*said.notes, *estimated, *alike_note(same)])
        if store is not None:
            store.begin(case.title, rows, names, notes, numbers)
        told(0.0)

    broken, notes = "", list[str]()
    showing = counting(len(chosen), "members") if progress is True else nullcontext(progress or None)
    with stopping() as stop, little_garbage(), showing as shown:
        found.stop = stop
        if not due:
            begin()
        elif count is None:
            with opened(executor) as engine:
                begin()
                broken = through(engine, work, jobs, due, found, stop, told, recover, died)
        elif here:
            begin()
            _alone(work, jobs, due, found, stop, told)
        else:
            require_sendable(work)
            with hired(work, len(rows), min(count, len(due))) as crew:
                said.add(crew.look({k: rows[k] for k in some[FEW:]}, stop))
                require_right(case, said, rows, some, same)
                begin()
                crew.work(jobs, due, found, stop, told, died)
        for k, one in same.items():
            if one in found:
                found[k] = found[one]
        stopped = stop.is_set()
    result = Sweep(SweepMembers(rows, found), case.title, notes)
    found.stop = None  # it is over, and a sweep can be copied
    lost = found.first_of(NOT_KEPT)
    if lost is not None:
        broken = f"The sweep was stopped at member {lost}: {found[lost][1]}; put that right and call again"
    if stopped or broken:
        why = broken or "The sweep was stopped"
        raise SolveError(f"{why}; {result.count_completed} of {len(rows)} members are done", result)
    return result


def _as_case(given: Any) -> Case:
    """Return a case, read if its path was given.

    Raises:
        InputError: it is neither.
    """
    if isinstance(given, Case):
        return given
    if isinstance(given, str | os.PathLike):
        return load_case(Path(given))
    if isinstance(given, ModelDescription):
        why = "this is a model, and the numbers of a case are varied"
        instead = 'write it as one: model.to_toml("case.toml", "simulate", duration=1.0)'
    elif isinstance(given, Mapping):
        why = "this is the content of a case file, and a case is needed here"
        instead = 'give the path of the file, or what viscorod.load_case("case.toml") returns'
    else:
        why = "a case is needed here, or the path of its file"
        instead = 'give "case.toml", or what viscorod.load_case("case.toml") returns'
    shown = type(given).__name__ if isinstance(given, Mapping) else show(given)
    raise InputError(Fault("case", shown, why, instead))


class _Members(FoundMembers):
    """The members of a sweep that runs; one that cannot be kept stops it, since others could not be kept either."""

    stop: threading.Event | None = None

    def __setitem__(self, number: int, found: Found) -> None:
        super().__setitem__(number, found)
        if found[2] == NOT_KEPT and self.stop is not None:
            self.stop.set()


def _in_this_process(executor: Any, count: int | None, members: int) -> bool:
    """Return whether this process computes the members, alone or with threads, of a ``count`` of processes."""
    if count is None:
        return isinstance(executor, ThreadPoolExecutor) or str(executor).startswith("threads")
    return min(count, members) == 1 and (executor is None or count == 1)


class _Jobs(Sequence[Job]):
    """What workers are told of each member; of those in ``read`` once the case that was read before."""

    def __init__(
        self, rows: Rows, names: Sequence[str], looked: set[int], read: MutableMapping[int, Case]
    ) -> None:
        self._rows, self._names, self._looked, self._read = rows, names, looked, read

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, at: Any) -> Any:
        name = self._names[at] if self._names else ""
        return self._rows[at], name, at in self._looked, self._read.pop(at, None)


def _extremes(rows: Rows, numbers: Sequence[int]) -> list[int]:
    """Return which of some members have the least and the largest number of a key: those are wrong where any is."""
    found = []
    for column in rows.columns.values() if numbers else ():
        of_some = in_si([column[k] for k in numbers])
        if {type(value) for value in of_some} <= {int, float}:
            found += [numbers[int(np.argmin(of_some))], numbers[int(np.argmax(of_some))]]
    return found


def _chosen(count: int, members: slice | None) -> range:
    """Return the numbers of the members that a call is to compute."""
    if members is None:
        return range(count)
    if not isinstance(members, slice):
        raise InputError(Fault("members", show(members), "a slice is needed here", "give slice(100, 200)"))
    try:
        chosen = range(count)[members]
    except (TypeError, ValueError):
        raise InputError(
            Fault("members", show(members), "no numbers of members", "give slice(100, 200)")
        ) from None
    if not chosen:
        why = f"none of the {count} members, which count from 0, is among them"
        first, last = (("" if end is None else str(end)) for end in (members.start, members.stop))
        raise InputError(Fault("members", f"{first}:{last}", why, f"count from 0 to {count - 1}"))
    return chosen


def _estimated(count: int, errors: int | None, keep: bool) -> set[int]:
    """Return the numbers of the members of ``count`` whose errors are estimated."""
    if errors is not None and (isinstance(errors, bool) or not isinstance(errors, int) or errors < 0):
        raise InputError(Fault("errors", show(errors), "a number of members is needed here", "give 16"))
    some = (count if keep else min(count, MOST_ERRORS)) if errors is None else errors
    return set(np.linspace(0, count - 1, some, dtype=int).tolist()) if some < count else set(range(count))


def _alone(
    work: MemberWork,
    jobs: Sequence[Any],
    due: Sequence[int],
    found: MutableMapping[int, Found],
    stop: threading.Event,
    progress: Progress,
) -> None:
    """Compute one member after the other, in this process."""
    # to look at all libraries for every member takes as long as a thirtieth of a small one
    with one_blas_thread():
        for k, number in enumerate(due):

            def tell(part: float, *, k: int = k) -> None:
                progress(k + part)

            found[number] = UNTOUCHED if stop.is_set() else work(jobs[number], tell, stop.is_set)
            if not stop.is_set():
                progress(k + 1.0)
