"""One thread of linear algebra while something is computed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["one_blas_thread"]


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let BLAS use one thread in what is computed meanwhile, and as many as before afterwards.

    The matrices of rods are small blocks and narrow bands: further threads take processor time to wait for each other.
    """
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1, user_api="blas"):
        yield
