"""Argument types of the methods of a model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from viscorod.model.actions.time_function import TimeFunction

__all__ = ["Motion", "Time", "Vector", "given"]

Time: TypeAlias = TimeFunction | Callable[[float], float] | float | None
"""A function of time: one of the kinds, a Python function, or a number."""
Motion: TypeAlias = Mapping[str, TimeFunction | Callable[[float], float] | float]
Vector: TypeAlias = Sequence[float]


def given(**arguments: Any) -> dict[str, Any]:
    """Return the arguments that are not None."""
    return {name: value for name, value in arguments.items() if value is not None}
