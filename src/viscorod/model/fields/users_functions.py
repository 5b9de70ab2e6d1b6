"""Calls of Python functions that the user gave: whatever they raise or return instead of a number is refused alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from viscorod.errors import InputError, let_interrupts_through
from viscorod.wording import RefusedError, show

__all__ = ["returned"]

T = TypeVar("T")


def returned(
    function: Callable[..., Any],
    *values: float,
    check: Callable[[Any], T],
    name: str,
    where: str,
    instead: str,
    at: tuple[str | int, ...] = (),
) -> T:
    """Call a function of the user and return what it gives, checked.

    Args:
        function: of the user; values: it is called with.
        check: returns the result as it is needed, or raises `RefusedError`.
        name: of the function in messages, such as ``the function of the twist``.
        where: it was called, such as ``at s = 0.1``.
        instead: what to do; at: the key that holds the function.

    Raises:
        RefusedError: the function fails, or returns what is not allowed.
    """
    try:
        result = function(*values)
    except InputError:  # it has a message already
        raise
    except Exception as error:  # of any kind: it is the user's
        let_interrupts_through(error)
        why = f"{name} failed {where}: {type(error).__name__}: {error}"
        raise RefusedError(why, instead, found="", at=at) from error
    try:
        return check(result)
    except RefusedError as error:
        raise RefusedError(
            f"{name} gave this {where}: {error.why}", instead, found=show(result), at=at
        ) from None
