"""Members of a sweep through any executor of ``concurrent.futures``: threads, processes, Dask, MPI.

A task is a batch of members that takes about a second, so that an engine that hands out a thousand tasks a second has
no more to do than that. A member's failure is data; what fails here is a task, whose worker was lost: what its batch
left on disk is taken, and the others are tried again, each by itself.
"""

from __future__ import annotations

import asyncio
import importlib
import logging
import math
import os
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeAlias

from viscorod.analyses.sweeps.little_garbage import little_garbage
from viscorod.analyses.sweeps.process_start import context, one_thread_each, without_keyboard
from viscorod.analyses.sweeps.processes import TRIES, UNTOUCHED, Died, Work
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.one_thread import one_blas_thread
from viscorod.results.sweep_members import NOT_KEPT, Found

__all__ = ["Recover", "engine", "opened", "processes_of", "through"]

Recover: TypeAlias = Callable[[Sequence[int]], Mapping[int, Found]]
"""Returns what members left on disk before their worker was lost."""

BATCH = 1.0
"""Seconds that a task takes, about."""
PATIENCE = 5.0
"""Seconds in which a scheduler has to answer."""
AHEAD = 2
"""Tasks per worker that wait or run: one that runs, and one that is there when it ends."""
_POLL = 0.1
_KINDS = "give processes:8, threads:2, dask:ADDRESS, or an executor of concurrent.futures"


def processes_of(executor: Any, workers: int | None) -> int | None:
    """Return the number of this machine's processes that are asked for; None if that is not what is.

    Raises:
        InputError: it is no executor, or both are given.
    """
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(Fault("workers", show(workers), "a whole number of at least 1 is needed", "give 2"))
    if executor is None:
        return workers or os.cpu_count() or 1
    if workers is not None:
        raise InputError(
            Fault("workers", str(workers), "an executor has workers of its own", "leave one of them out")
        )
    if isinstance(executor, str):
        kind, _, count = executor.partition(":")
        if kind == "dask" or (kind == "threads" and _count(count)):
            return None
        if kind == "processes" and _count(count):
            return _count(count)
    elif isinstance(executor, Executor) or (hasattr(executor, "submit") and hasattr(executor, "shutdown")):
        return None
    raise InputError(Fault("executor", show(executor), "this computes nothing", _KINDS))


def _count(text: str) -> int | None:
    if not text:
        return os.cpu_count() or 1
    return int(text) if text.isdecimal() and int(text) > 0 else None


@contextmanager
def engine(executor: Any, workers: int | None) -> Iterator[Executor | None]:
    """Yield what computes the members of a sweep as an executor, for more work on them; None for this process alone.

    Raises:
        InputError: it is no executor.
    """
    count = processes_of(executor, workers)
    if count is None:
        with opened(executor) as found:
            yield found
    elif count == 1:
        yield None
    else:
        with one_thread_each(), ProcessPoolExecutor(count, mp_context=context()) as pool:
            yield pool


@contextmanager
def opened(executor: Any) -> Iterator[Executor]:
    """Yield the executor of a text, shut down at the end; one that is there already stays as it is.

    Raises:
        InputError: Dask is not installed, or its scheduler is not there.
    """
    if not isinstance(executor, str):
        yield executor
        return
    kind, _, rest = executor.partition(":")
    if kind == "threads":
        with one_blas_thread(), ThreadPoolExecutor(_count(rest)) as threads:
            yield threads
        return
    try:
        distributed: Any = importlib.import_module("distributed")  # untyped
    except ImportError:
        why = "Dask is not installed"
        raise InputError(Fault("executor", executor, why, "pip install 'viscorod[cluster]'")) from None
    if rest:
        _require_scheduler(distributed, rest)
    with without_keyboard():  # Ctrl-C is for the client; workers of this machine end with it
        client = distributed.Client(rest) if rest else distributed.Client()
    with client, client.get_executor() as found:
        if not client.nthreads():
            logging.getLogger("viscorod").warning(
                "viscorod: the scheduler %s has no workers yet; members wait for them", rest
            )
        yield found


def _require_scheduler(distributed: Any, address: str) -> None:
    """Refuse an address at which no scheduler answers within ``PATIENCE``.

    A client of Dask's tries for half a minute, and what is left of it then ends with tracebacks of its own.

    Raises:
        InputError: none does.
    """

    async def ask() -> None:
        async with distributed.rpc(address, timeout=PATIENCE) as there:
            await asyncio.wait_for(there.identity(), PATIENCE)

    try:
        with ThreadPoolExecutor(1) as beside:  # a notebook has a loop of events of its own
            beside.submit(asyncio.run, ask()).result()
    except Exception as error:  # another service answers with anything
        told = " ".join(str(error).split())[:160] or type(error).__name__
        if isinstance(error, TypeError | ValueError):
            why, instead = f"this is no address ({told})", "give one such as dask:tcp://host:8786"
        else:
            why = f"no scheduler answered within {PATIENCE:g} s ({told})"
            instead = "check the address that the scheduler prints, or start one with: dask scheduler"
        raise InputError(Fault("executor", f"dask:{address}", why, instead)) from None


def through(
    executor: Executor,
    work: Work,
    jobs: Sequence[Any],
    due: Sequence[int],
    found: MutableMapping[int, Found],
    stop: threading.Event,
    progress: Callable[[float], None] | None,
    recover: Recover,
    died: Died,
) -> str:
    """Do jobs on an executor; returns why it gave up, empty if it did not.

    Args:
        executor: whose workers can import this package.
        work: that can be sent to them.
        jobs: likewise; due: numbers of those that are to be done.
        found: takes what ``work`` makes of them.
        stop: set from outside; what has not begun is left out then.
        progress: called with the number of jobs done.
        recover: returns what jobs left on disk.
        died: says what is found of a job whose worker was lost ``TRIES`` times.
    """
    before = len(found)
    task = _Tasks(executor, work, jobs, stop, (recover, died), deque(due), found)
    try:
        while len(found) < before + len(due):
            if stop.is_set():
                task.cancel()
                if not task.running:
                    break
            else:
                task.submit()
            task.collect()
            if progress is not None:
                progress(float(len(found) - before))
    except BrokenExecutor as error:
        task.take_from_disk()
        why = f"the executor gave up ({type(error).__name__}: {str(error)[:200]})"
    except BaseException:
        task.cancel()
        raise
    else:
        why = ""
    for number in due:
        if number not in found:
            found[number] = UNTOUCHED
    return why


class _Tasks:
    """Batches of members that run, wait, and are done."""

    def __init__(
        self,
        executor: Executor,
        work: Work,
        jobs: Sequence[Any],
        stop: threading.Event,
        after: tuple[Recover, Died],
        waiting: deque[int],
        found: MutableMapping[int, Found],
    ) -> None:
        self._executor, self._jobs, (self._recover, self._died) = executor, jobs, after
        # a thread sees the event itself; other processes end the batch that they are at
        stopped = stop.is_set if isinstance(executor, ThreadPoolExecutor) else _never
        self._batch = partial(_compute_batch, work, stopped)
        self.found = found
        self.running: dict[Future[Any], list[int]] = {}
        self._waiting, self._apart = waiting, deque[int]()
        self._tries = Counter[int]()
        self._slots = _workers_of(executor)
        self._seconds, self._done = 0.0, 0

    def submit(self) -> None:
        """Hand out as many batches as keep all workers busy."""
        while len(self.running) < AHEAD * self._slots and (self._apart or self._waiting):
            if self._apart:
                batch = [self._apart.popleft()]
            else:
                batch = [self._waiting.popleft() for _ in range(min(self._size, len(self._waiting)))]
            try:
                future = self._executor.submit(self._batch, [self._jobs[k] for k in batch])
            except BaseException as error:
                self._waiting.extendleft(batch)
                if type(error) is RuntimeError:  # it was shut down
                    raise BrokenExecutor(str(error)) from error
                raise
            self.running[future] = batch

    @property
    def _size(self) -> int:
        if not self._done:
            return 1
        worth = math.ceil(BATCH * self._done / max(self._seconds, 1e-9))
        return max(1, min(worth, len(self._waiting) // (AHEAD * self._slots)))

    def collect(self) -> None:
        """Take what is done, or wait a little for it."""
        done, _ = wait(self.running, timeout=_POLL, return_when=FIRST_COMPLETED)
        for future in done:
            batch = self.running[future]
            if future.cancelled():
                del self.running[future]
                continue
            try:
                seconds, results = future.result()
            except BrokenExecutor:
                raise
            except Exception as error:  # a worker was lost, or what it sent cannot be read
                # Dask has tried a task on several workers before it says so
                tried = TRIES if type(error).__name__ == "KilledWorker" and len(batch) == 1 else 1
                self._lost(batch, f"{type(error).__name__}: {' '.join(str(error).split())[:200]}", tried)
            else:
                self.found.update(zip(batch, results, strict=True))
                self._seconds, self._done = self._seconds + seconds, self._done + len(batch)
            del self.running[future]

    def _lost(self, batch: Sequence[int], why: str, tried: int) -> None:
        """Take what a batch left on disk, and try its other members again, by themselves, unless that was enough."""
        self.found.update(self._recover(batch))
        for member in batch:
            if member in self.found:
                continue
            self._tries[member] += tried
            if self._tries[member] < TRIES:
                self._apart.append(member)
            else:
                self.found[member] = self._died(
                    member, f"its worker was lost {self._tries[member]} times ({why})"
                )

    def cancel(self) -> None:
        """Take back what has not begun."""
        self._waiting.clear()
        self._apart.clear()
        for future in list(self.running):
            if future.cancel():
                del self.running[future]

    def take_from_disk(self) -> None:
        """Take what members left on disk that were under way."""
        self.found.update(self._recover([k for batch in self.running.values() for k in batch]))
        self.running.clear()


def _never() -> bool:
    return False


def _nowhere(_part: float) -> None:
    return


def _compute_batch(work: Work, stopped: Callable[[], bool], jobs: Sequence[Any]) -> tuple[float, list[Found]]:
    """Compute a batch of members where a worker is; returns the time [s] it took, and what was found."""
    began = time.perf_counter()
    results: list[Found] = []
    full = False
    with little_garbage(), one_blas_thread():
        for job in jobs:
            results.append(UNTOUCHED if full or stopped() else work(job, _nowhere, stopped))
            full = full or results[-1][2] == NOT_KEPT  # a disk that is full takes no other either
    return time.perf_counter() - began, results


def _workers_of(executor: Any) -> int:
    """Return how many workers an executor has, as far as it tells."""
    for name in ("num_workers", "_max_workers"):
        count = getattr(executor, name, None)
        if isinstance(count, int) and count > 0:
            return count
    client = getattr(executor, "_client", None)
    if client is not None:
        return max(1, sum(map(int, client.nthreads().values())))
    return os.cpu_count() or 1
