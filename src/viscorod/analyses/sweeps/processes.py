"""Processes that compute the members of a sweep; one that is killed costs its own member a new try, and no other.

Every worker has a pipe of its own and does its members in order, so that the death of a process tells which member it
was at, and its exit code how it ended. Of short members it has the next ones already, so that it never waits, and
what it has found of them is taken together.
"""

from __future__ import annotations

import gc
import math
import os
import pickle
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import wait
from typing import Any, Protocol, TypeAlias

from viscorod.analyses.sweeps.process_start import context as processes
from viscorod.analyses.sweeps.process_start import one_thread_each
from viscorod.errors import InputError
from viscorod.one_thread import one_blas_thread
from viscorod.results.sweep_members import NOT_RUN, Found

__all__ = ["FAILED", "TRIES", "UNTOUCHED", "Crew", "Died", "Work", "hired"]

Work: TypeAlias = Callable[[Any, Callable[[float], None], Callable[[], bool]], Found]
"""Computes a job, tells which part of it is done and asks whether to stop."""


class LookingWork(Protocol):
    """Work that looks at values too, before any is computed with."""

    def __call__(self, job: Any, tell: Callable[[float], None], stopped: Callable[[], bool], /) -> Found: ...
    def look(self, rows: Mapping[int, Any], /) -> Any:
        """Return what is to be said of some values, by the numbers of their members."""


Died: TypeAlias = Callable[[int, str], Found]
"""Records that the workers of a job, by its number, died of it, and why."""

FAILED = "failed"
UNTOUCHED: Found = (None, "the sweep was stopped before it", NOT_RUN)
TRIES = 3
"""Processes that a member may lose before it counts as failed."""
_POLL = 0.1  # seconds between two looks at the workers
_SHORT = 0.5  # seconds of a member that is short
_AHEAD, _MOST_AHEAD = 0.2, 16  # seconds of short members, and members, that a worker has before it
_LIGHT = 4096  # bytes that a pipe takes although nobody reads
_LITTLE = 1024  # bytes of one member of whom only numbers are told
_SLICE = 100  # members that a worker looks at before the next ones are handed out
_READY = "ready"


@dataclass(frozen=True)
class _Look:
    """Values that a process is to look at, by the numbers of their members."""

    rows: Mapping[int, Any]


class _Worker:
    """A process that computes one member after the other."""

    def __init__(self, context: Any, work: LookingWork, cells: Any) -> None:
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

    def begin(self, waiting: deque[int], count: int, jobs: Sequence[Any]) -> None:
        """Give it so many members of those that wait, not beside others where both might wait for the other to read."""
        given = pickle.dumps([(waiting[k], jobs[waiting[k]]) for k in range(count)])
        if self.members and len(given) > _LIGHT:
            return
        if not self.members:
            self.began = time.perf_counter()
        self.members.extend(waiting.popleft() for _ in range(count))
        self.send(given)

    def send(self, what: bytes) -> None:
        """Send something; if it died meanwhile, the next look at it tells."""
        with suppress(OSError):
            self.connection.send_bytes(what)

    def end(self) -> None:
        """Let it go; one that computes is ended."""
        self.connection.close()
        if self.members or not self.ready:
            self.process.terminate()
        self.process.join()


@contextmanager
def hired(work: LookingWork, count: int, workers: int) -> Iterator[Crew]:
    """Yield processes with one thread each, which are ended at the end.

    Args:
        work: a function of a module, so that other processes find it.
        count: jobs that there are, done or not; workers: number of processes.
    """
    crew = Crew(work, count, workers)
    try:
        yield crew
    finally:
        crew.end()


class Crew:
    """Processes that do jobs, or look at what the jobs are; see `hired`."""

    def __init__(self, work: LookingWork, count: int, workers: int) -> None:
        context = processes()
        self._cells = context.Array("d", count + 1, lock=False)  # how far each job is; the last one stops all
        self._start: Callable[[], _Worker] = partial(_Worker, context, work, self._cells)
        self._workers = [self._start() for _ in range(workers)]

    def end(self) -> None:
        """Let all of them go."""
        for worker in self._workers:
            worker.end()

    def look(self, rows: Mapping[int, Any], stop: threading.Event) -> list[Any]:
        """Return what ``work.look`` says of some rows of values at a time, by their numbers, in no order.

        Of those whose worker died of them nothing is said; they are no mistake of the user's, or one that their
        computation will tell.
        """
        numbers = list(rows)
        waiting = [numbers[k : k + _SLICE] for k in range(0, len(numbers), _SLICE)][::-1]
        said: list[Any] = []
        idle, busy = list(self._workers), dict[Any, _Worker]()
        while busy or (idle and waiting and not stop.is_set()):
            for worker in idle:
                if waiting and not stop.is_set():
                    busy[worker.connection] = worker
                    worker.send(pickle.dumps(_Look({k: rows[k] for k in waiting.pop()})))
            idle = []
            for one in wait(busy, timeout=_POLL):
                try:
                    answer = busy[one].connection.recv()
                except (EOFError, OSError):  # it died
                    del busy[one]
                    continue
                if answer == _READY:
                    busy[one].ready = True
                else:
                    said.append(answer)
                    idle.append(busy.pop(one))
        return said

    def work(
        self,
        jobs: Sequence[Any],
        due: Sequence[int],
        found: MutableMapping[int, Found],
        stop: threading.Event,
        progress: Callable[[float], None] | None,
        died: Died,
    ) -> None:
        """Do jobs.

        Args:
            jobs: which can be pickled; due: numbers of those that are to be done.
            found: takes what is made of them.
            stop: set from outside; jobs that have not begun are left out then.
            progress: called with the number of jobs done, fractions included.
            died: says what is found of a job that ended its process ``TRIES`` times.

        Raises:
            InputError: no process could be started.
        """
        before, cells, crew = len(found), self._cells, self._workers
        waiting, lost, pace = deque(due), Counter[int | None](), _Pace()
        while len(found) < before + len(due):
            _look(crew, found, pace)
            for worker in [worker for worker in crew if not worker.process.is_alive()]:
                while _heard(worker, found, pace):  # what it said last
                    pass
                crew.remove(worker)
                lost[worker.member] += 1
                _after_death(worker, lost[worker.member], stop, found, waiting, died)
                if waiting:
                    crew.append(self._start())
            if stop.is_set():
                cells[len(cells) - 1] = 1.0
                found.update(dict.fromkeys(waiting, UNTOUCHED))
                waiting.clear()
            _hand_out(crew, jobs, waiting, pace.ahead)
            if progress is not None and not stop.is_set():
                under_way = sum(cells[worker.member] for worker in crew if worker.member is not None)
                progress(len(found) - before + under_way)


def _hand_out(crew: Sequence[_Worker], jobs: Sequence[Any], waiting: deque[int], ahead: int) -> None:
    """Give every worker that has nothing to do a member, and so many more that it does not wait for the next ones."""
    for worker in crew:
        if worker.ready and not worker.members and waiting:
            worker.begin(waiting, 1, jobs)
    for worker in crew:
        fair = len(waiting) // len(crew)  # the last ones go to whoever is done first
        more = min(ahead + 1 - len(worker.members), fair)
        if worker.members and 2 * more > min(ahead, fair):
            worker.begin(waiting, more, jobs)


class _Pace:
    """How long members take, on average, and how much is told of them."""

    def __init__(self) -> None:
        self._seconds, self._count, self._largest = 0.0, 0, 0

    def add(self, seconds: float, size: int) -> None:
        """Count one that is done, of which so many bytes are told."""
        self._seconds, self._count = self._seconds + seconds, self._count + 1
        self._largest = max(self._largest, size)

    @property
    def ahead(self) -> int:
        """Members that a worker has beside the one that it is at: none of those that others would wait behind."""
        if not 0 < self._count or self._seconds >= _SHORT * self._count:
            return 0
        return min(math.ceil(_AHEAD * self._count / max(self._seconds, 1e-9)), _MOST_AHEAD)

    def rest(self, members: int) -> float:
        """Return for how long [s] what is found may gather while every worker has so many members."""
        if not self._count or self._largest > _LITTLE:
            return 0.0
        return min(0.5 * (members - 1) * self._seconds / self._count, _POLL)


def _look(crew: Sequence[_Worker], found: MutableMapping[int, Found], pace: _Pace) -> None:
    """Take what workers have to say, or wait a little for it."""
    by_connection: dict[Any, _Worker] = {worker.connection: worker for worker in crew}
    sentinels = [worker.process.sentinel for worker in crew]
    least = min((len(worker.members) for worker in crew), default=0)
    if least > 2:
        time.sleep(pace.rest(least))
    for one in wait([*by_connection, *sentinels], timeout=_POLL):
        worker = by_connection.get(one)
        if worker is None:
            continue
        while _heard(worker, found, pace):
            pass


def _heard(worker: _Worker, found: MutableMapping[int, Found], pace: _Pace) -> bool:
    """Take one thing that a worker has said; returns False if there is none."""
    try:
        if not worker.connection.poll():
            return False
        told = worker.connection.recv_bytes()
    except (EOFError, OSError):  # it died
        return False
    said = pickle.loads(told)
    if said == _READY:
        worker.ready = True
        return True
    number, result = said
    found[number] = result
    worker.members.popleft()
    now = time.perf_counter()
    pace.add(now - worker.began, len(told))
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


def _serve(connection: Any, work: LookingWork, cells: Any, environment: dict[str, str]) -> None:
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
                given = connection.recv()
                if isinstance(given, _Look):
                    connection.send(work.look(given.rows))
                    continue
            except (EOFError, OSError):  # the parent is done, or gone
                return
            for number, job in given:

                def tell(part: float, *, number: int = number) -> None:
                    cells[number] = part

                tell(0.0)
                result = UNTOUCHED if stopped() else work(job, tell, stopped)
                if not frozen:
                    gc.freeze()  # what the first member has loaded stays; to count it takes as long as a member
                    frozen = True
                try:
                    connection.send((number, result))
                except OSError:
                    return
                except Exception as error:  # what cannot be sent must not cost the others their results
                    text = f"its result could not be handed over ({type(error).__name__}: {error})"
                    connection.send((number, (None, text, FAILED)))
