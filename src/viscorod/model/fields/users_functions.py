"""What the user's functions of place return, with one message where they fail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from viscorod.errors import InputError, let_interrupts_through
from viscorod.wording import RefusedError

__all__ = ["users_result"]


def users_result(
    function: Callable[..., Any],
    *arguments: float,
    of: str,
    where: str,
    instead: str,
    at: Sequence[str | int] = (),
) -> Any:
    """Return what a function of the user gives.

    Args:
        function: of the user; arguments: of the function.
        of: what it is a function of; where: the arguments as a message has them; instead: what it is to do.
        at: key path of the function.

    Raises:
        RefusedError: it raised an exception. What refuses a value, as a section that is made does, comes out as it is.
    """
    try:
        return function(*arguments)
    except InputError:
        raise
    except Exception as error:  # of any kind: it is the user's
        let_interrupts_through(error)
        raise RefusedError(
            f"the function of {of} failed at {where}: {type(error).__name__}: {error}",
            instead,
            found="",
            at=at,
        ) from error
