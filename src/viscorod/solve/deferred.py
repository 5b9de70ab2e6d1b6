"""Entries of a registry that are imported when they are first called: importing them loads all kernels, in seconds."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pkgutil import resolve_name
from typing import Any


def deferred(place: str) -> Callable[..., Any]:
    """Return a function that calls the one at ``place`` ("module:name" in this package), imported at its first call."""

    def call(*arguments: Any, **given: Any) -> Any:
        return _found(place)(*arguments, **given)

    return call


@cache
def _found(place: str) -> Callable[..., Any]:
    """Return the function itself; to look a name up takes a hundredth of a small equilibrium."""
    found: Callable[..., Any] = resolve_name(f"{__package__}.{place}")
    return found
