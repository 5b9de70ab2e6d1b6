"""Argument types of the model's methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from viscorod.given_as import Amount, Amounts
from viscorod.model.actions.time_function import TimeFunction

__all__ = ["Motion", "Time", "Vector", "given"]

Time: TypeAlias = TimeFunction | Callable[[float], float] | Amount | None
"""A function of time as an argument: one of the kinds, a Python function, a number."""
Motion: TypeAlias = Mapping[str, TimeFunction | Callable[[float], float] | Amount]
Vector: TypeAlias = Amounts


def given(**arguments: Any) -> dict[str, Any]:
    """Return the arguments that are not None."""
    return {name: value for name, value in arguments.items() if value is not None}
