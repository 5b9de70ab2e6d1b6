"""Functions of an object that never changes, whose value is made once and kept with it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from viscorod.solve.problem.problem import Problem

__all__ = ["once", "once_of_layout"]

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


def once_of_layout(make: Callable[[Problem], Made]) -> Callable[[Problem], Made]:
    """Let a function of where the nodes of a problem are, what couples them and what holds them keep what it returns.

    Problems that differ in materials, sections or loads share it, as members of a sweep do; ``make`` may read nothing
    of these. A problem that was made of another one by changing a field shares nothing with it.
    """
    name = f"{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def kept(problem: Problem) -> Made:
        known = problem.of_layout
        if name not in known:
            known[name] = make(problem)
        found: Made = known[name]
        return found

    return kept
