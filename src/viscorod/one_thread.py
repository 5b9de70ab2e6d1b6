"""One thread of linear algebra while something is computed."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from importlib import import_module
from typing import Any

__all__ = ["one_blas_thread"]

_LOCK = threading.Lock()
_in_use: list[None] = []
"""An entry for each computation that goes on within the limit, in whatever thread."""
_limits = ExitStack()

BRING_BLAS = ("numpy.linalg", "scipy.linalg")
"""Modules with which the process loads libraries for linear algebra: what is computed needs them all the same, and
those loaded meanwhile would take as many threads as there are."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let BLAS use one thread in what is computed meanwhile, and as many as before afterwards.

    The matrices of rods are small blocks and narrow bands: further threads take processor time to wait for each other.
    """
    # to look at all libraries and to set them takes a fiftieth of a small equilibrium; and of two threads that do it,
    # the first to end would give the other one all threads again
    with _LOCK:
        if not _in_use:
            _limits.enter_context(_libraries().limit(limits=1, user_api="blas"))
        _in_use.append(None)
    try:
        yield
    finally:
        with _LOCK:
            _in_use.pop()
            if not _in_use:
                _limits.close()


@lru_cache
def _libraries() -> Any:
    """Return the control of all libraries; they are sought once, as the search takes milliseconds."""
    from threadpoolctl import ThreadpoolController

    for name in BRING_BLAS:
        import_module(name)
    return ThreadpoolController()
