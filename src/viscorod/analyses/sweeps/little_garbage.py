"""A search for garbage that leaves out what was there before: that takes as long as some members of a sweep."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["little_garbage"]


@contextmanager
def little_garbage() -> Iterator[None]:
    """Let Python look for garbage among what is made within this context only; what is there already stays."""
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
