"""One thread of linear algebra while something is computed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from typing import Any

__all__ = ["one_blas_thread"]

BRING_BLAS = ("numpy.linalg", "scipy.linalg")
"""Modules with which the process loads libraries for linear algebra: what is computed needs them all the same, and
those loaded meanwhile would take as many threads as there are."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let BLAS use one thread in what is computed meanwhile, and as many as before afterwards.

    The matrices of rods are small blocks and narrow bands: further threads take processor time to wait for each other.
    """
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@lru_cache
def _libraries() -> Any:
    """Return the control of all libraries; they are sought once, as the search takes milliseconds."""
    from threadpoolctl import ThreadpoolController

    for name in BRING_BLAS:
        import_module(name)
    return ThreadpoolController()
