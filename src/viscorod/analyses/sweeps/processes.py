"""Processes that compute the members of a sweep; one that is killed costs its own member a new try, and no other.

Every worker has a pipe of its own and does its members in order, so that the death of a process tells which member it
was at, and its exit code how it ended. Of short members it has the next one already, so that it never waits.
"""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, MutableMapping, Sequence
from contextlib import suppress
from multiprocessing.connection import wait
from typing import Any, TypeAlias

from viscorod.analyses.sweeps.process_start import context as processes
from viscorod.analyses.sweeps.process_start import one_thread_each
from viscorod.errors import InputError
from viscorod.one_thread import one_blas_thread
from viscorod.results.sweep_members import NOT_RUN, Found

__all__ = ["FAILED", "TRIES", "UNTOUCHED", "Died", "Work", "in_parallel"]

Work: TypeAlias = Callable[[Any, Callable[[float], None], Callable[[], bool]], Found]
"""Computes a job, tells which part of it is done and asks whether to stop."""
Died: TypeAlias = Callable[[int, str], Found]
"""Records that the workers of a job, by its number, died of it, and why."""

FAILED = "failed"
UNTOUCHED: Found = (None, "the sweep was stopped before it", NOT_RUN)
TRIES = 3
"""Processes that a member may lose before it counts as failed."""
_POLL = 0.1  # seconds between two looks at the workers
_SHORT = 0.5  # seconds of a member that is short
_READY = "ready"


class _Worker:
    """A process that computes one member after the other."""

    def __init__(self, context: Any, work: Work, cells: Any) -> None:
        self.connection: Any
        self.connection, end = context.Pipe()
        with one_thread_each():
            given = end, work, cells, dict(os.environ)
            self.process = context.Process(target=_serve, args=given, daemon=True)
            self.process.start()
        end.close()
        self.ready = False
        self.members = deque[int]()
        self.began = 0.0

    @property
    def member(self) -> int | None:
        """The one that it is at."""
        return self.members[0] if self.members else None

    def begin(self, member: int, job: Any) -> None:
        """Give it a member; if it died meanwhile, the next look at it tells."""
        if not self.members:
            self.began = time.perf_counter()
        self.members.append(member)
        with suppress(OSError):
            self.connection.send((member, job))

    def end(self) -> None:
        """Let it go; one that computes is ended."""
        self.connection.close()
        if self.members or not self.ready:
            self.process.terminate()
        self.process.join()


def in_parallel(
    work: Work,
    jobs: Sequence[Any],
    due: Sequence[int],
    found: MutableMapping[int, Found],
    workers: int,
    stop: threading.Event,
    progress: Callable[[float], None] | None,
    died: Died,
) -> None:
    """Do jobs on several processes with one thread each.

    Args:
        work: a function of a module, so that other processes find it.
        jobs: which can be pickled; due: numbers of those that are to be done.
        found: takes what ``work`` makes of them.
        workers: number of processes.
        stop: set from outside; jobs that have not begun are left out then.
        progress: called with the number of jobs done, fractions included.
        died: says what is found of a job that ended its process ``TRIES`` times.

    Raises:
        InputError: no process could be started.
    """
    context = processes()
    cells = context.Array("d", len(jobs) + 1, lock=False)  # how far each job is; the last one stops all
    before = len(found)
    waiting, lost = deque(due), Counter[int | None]()
    crew = [_Worker(context, work, cells) for _ in range(workers)]
    pace = _Pace()
    try:
        while len(found) < before + len(due):
            _look(crew, found, pace)
            for worker in [worker for worker in crew if not worker.process.is_alive()]:
                while _heard(worker, found, pace):  # what it said last
                    pass
                crew.remove(worker)
                lost[worker.member] += 1
                _after_death(worker, lost[worker.member], stop, found, waiting, died)
                if waiting:
                    crew.append(_Worker(context, work, cells))
            if stop.is_set():
                cells[len(jobs)] = 1.0
                found.update(dict.fromkeys(waiting, UNTOUCHED))
                waiting.clear()
            for ahead in (False, True) if pace.short else (False,):
                least = len(crew) if ahead else 1  # the last ones go to whoever is done first
                for worker in crew:
                    if worker.ready and len(worker.members) <= ahead and len(waiting) >= least:
                        number = waiting.popleft()
                        cells[number] = 0.0
                        worker.begin(number, jobs[number])
            if progress is not None and not stop.is_set():
                progress(len(found) - before + sum(cells[w.member] for w in crew if w.member is not None))
    finally:
        for worker in crew:
            worker.end()


class _Pace:
    """How long members take, on average."""

    def __init__(self) -> None:
        self._seconds, self._count = 0.0, 0

    def add(self, seconds: float) -> None:
        """Count one that is done."""
        self._seconds, self._count = self._seconds + seconds, self._count + 1

    @property
    def short(self) -> bool:
        """Whether the time that a worker waits for its next member counts, and none would wait behind a long one."""
        return 0 < self._count and self._seconds < _SHORT * self._count


def _look(crew: Sequence[_Worker], found: MutableMapping[int, Found], pace: _Pace) -> None:
    """Take what workers have to say, or wait a little for it."""
    by_connection: dict[Any, _Worker] = {worker.connection: worker for worker in crew}
    sentinels = [worker.process.sentinel for worker in crew]
    for one in wait([*by_connection, *sentinels], timeout=_POLL):
        worker = by_connection.get(one)
        if worker is None:
            continue
        _heard(worker, found, pace)


def _heard(worker: _Worker, found: MutableMapping[int, Found], pace: _Pace) -> bool:
    """Take one thing that a worker has said; returns False if there is none."""
    try:
        if not worker.connection.poll():
            return False
        said = worker.connection.recv()
    except (EOFError, OSError):  # it died
        return False
    if said == _READY:
        worker.ready = True
        return True
    number, result = said
    found[number] = result
    worker.members.popleft()
    now = time.perf_counter()
    pace.add(now - worker.began)
    worker.began = now
    return True


def _after_death(
    worker: _Worker,
    count: int,
    stop: threading.Event,
    found: MutableMapping[int, Found],
    waiting: deque[int],
    died: Died,
) -> None:
    """Decide what becomes of the member of a process that ended by itself, for the time ``count``."""
    worker.process.join()
    how, member = _ended(worker.process.exitcode), worker.member
    waiting.extendleft(reversed(list(worker.members)[1:]))  # those that it had not begun
    if member is None:
        at_start = not worker.ready and (worker.process.exitcode or 0) >= 0
        if not stop.is_set() and (at_start or count == TRIES):
            raise InputError(
                f"sweep: no worker process could be started ({how}); in a script, call it under "
                'if __name__ == "__main__":, or compute in one process with workers = 1'
            )
    elif member not in found:
        if stop.is_set():
            found[member] = None, f"the sweep was stopped, and its process {how}", "interrupted"
        elif count < TRIES:
            waiting.append(member)
        else:
            found[member] = died(member, f"its process {how}; it was tried {count} times")


def _ended(code: int | None) -> str:
    """Say how a process ended, by its exit code."""
    if code is None or code >= 0:
        return f"ended with exit code {code}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    if name == "SIGKILL":
        return "was killed (SIGKILL; the system does this where memory runs out)"
    return f"was ended by {name}"


def _serve(connection: Any, work: Work, cells: Any, environment: dict[str, str]) -> None:
    """Compute what comes through the pipe, in a process of its own; the parent alone answers the keyboard."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.update(
        environment
    )  # of the parent now, which may have started the process that this one is a copy of
    connection.send(_READY)

    def stopped() -> bool:
        return bool(cells[len(cells) - 1])

    with one_blas_thread():
        frozen = False
        while True:
            try:
                number, job = connection.recv()
            except (EOFError, OSError):  # the parent is done, or gone
                return

            def tell(part: float, *, number: int = number) -> None:
                cells[number] = part

            result = UNTOUCHED if stopped() else work(job, tell, stopped)
            if not frozen:
                gc.freeze()  # what the first member has loaded stays; to count what is frozen takes as long as a member
                frozen = True
            try:
                connection.send((number, result))
            except OSError:
                return
            except Exception as error:  # what cannot be sent must not cost the others their results
                text = f"its result could not be handed over ({type(error).__name__}: {error})"
                connection.send((number, (None, text, FAILED)))
