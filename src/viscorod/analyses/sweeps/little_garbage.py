"""A search for garbage that leaves out what was there before: that takes as long as some members of a sweep."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["little_garbage"]


@contextmanager
def little_garbage() -> Iterator[None]:
    """Let Python look for garbage among what is made within this context only; what is there already stays.

    Where something is left out of the search already, by another context or by the user, it stays as it is.
    """
    mine = not gc.get_freeze_count()
    if mine:
        gc.freeze()
    try:
        yield
    finally:
        if mine:
            gc.unfreeze()
