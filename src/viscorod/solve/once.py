"""Functions of an object that never changes, whose value is made once and kept with it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

__all__ = ["once"]

Given = TypeVar("Given")
Made = TypeVar("Made")


def once(make: Callable[[Given], Made]) -> Callable[[Given], Made]:
    """Let a function of a problem, or of another frozen object, keep what it returns with it, as cached properties do.

    Whoever reads it shares it, and changes nothing in it. Another object, be it a copy with one other array, has none.
    """
    name = f"{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def kept(given: Given) -> Made:
        known = vars(given)
        if name not in known:
            known[name] = make(given)
        found: Made = known[name]
        return found

    return kept
