"""How processes of a sweep start: on Linux as copies of one that has loaded everything, elsewhere each by itself.

Loading the package and its machine code takes seconds, as much as dozens of short motions. The process that is copied
(Python's fork server) has one thread, loads while the values of the sweep are looked at, and stays for the next sweep
of the same script.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

__all__ = ["context", "one_thread_each", "prepare", "without_keyboard"]

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
COPIED = sys.platform == "linux"
"""Whether processes start as copies: other systems have libraries that do not stand it, or no such copies."""
LOADED = ["viscorod.analyses.sweeps.loaded"]


def context() -> Any:
    """Return how processes start here, as ``multiprocessing`` calls it."""
    return multiprocessing.get_context("forkserver" if COPIED else "spawn")


def prepare() -> None:
    """Let the process that others are copies of load, where there is such a one, without waiting for it."""
    if not COPIED:
        return
    from multiprocessing import forkserver, resource_tracker

    context().set_forkserver_preload(LOADED)  # it has no effect on one that runs already
    resource_tracker.ensure_running()  # it lets Ctrl-C through again when it has started, so it starts before
    with one_thread_each(), without_keyboard():
        forkserver.ensure_running()


@contextmanager
def without_keyboard() -> Iterator[None]:
    """Let processes and threads that start here take no notice of Ctrl-C, which reaches all of a terminal."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Let processes that start here use one thread each: there are as many of them as processors."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        restore(before)


def restore(variables: Mapping[str, str | None]) -> None:
    """Set variables of the environment, or take those away that are None."""
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
