"""Registries name what they hold by its place: importing it loads all kernels, which takes a second or two."""

from __future__ import annotations

from collections.abc import Callable
from pkgutil import resolve_name
from typing import Any


def deferred(place: str) -> Callable[..., Any]:
    """Return a function that calls the one at ``place`` ("module:name" in this package), imported at its first call."""

    def call(*arguments: Any, **given: Any) -> Any:
        return resolve_name(f"{__package__}.{place}")(*arguments, **given)

    return call
