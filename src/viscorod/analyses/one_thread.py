"""One thread of linear algebra while something is computed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

__all__ = ["one_blas_thread"]

BRING_BLAS = ("numpy.linalg", "scipy.linalg")
"""Modules with which the process loads libraries for linear algebra."""


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let BLAS use one thread in what is computed meanwhile, and as many as before afterwards.

    The matrices of rods are small blocks and narrow bands: further threads take processor time to wait for each other.
    """
    with _libraries(tuple(name in sys.modules for name in BRING_BLAS)).limit(limits=1, user_api="blas"):
        yield


@lru_cache
def _libraries(loaded: tuple[bool, ...]) -> Any:
    """Return the control of all libraries; they are sought once, as the search takes milliseconds."""
    from threadpoolctl import ThreadpoolController

    del loaded
    return ThreadpoolController()
