"""What validators found wrong, as faults in the words of the user, with the paths of their keys."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pydantic import ValidationError

from viscorod.errors import Fault, InputError
from viscorod.model.fields.faulty_value import FaultyValue
from viscorod.wording import RefusedError, path_text, show

__all__ = ["at_key", "problems_from", "problems_of"]


@contextmanager
def at_key(key: str | int, value: Any) -> Iterator[None]:
    """Prefix the paths of errors about `value` with its `key`."""
    try:
        yield
    except RefusedError as error:
        if isinstance(value, FaultyValue) and not value.reported:
            raise RefusedError(value.why, value.instead, found=show(value.value), at=(key,)) from None
        found = show(value) if error.found is None else error.found
        raise RefusedError(error.why, error.instead, found=found, at=(key, *error.at)) from None
    except (ValidationError, InputError) as error:
        problems = problems_of(error, value)
        raise InputError(problem.within(path_text((key,))) for problem in problems) from None


def problems_from(error: ValidationError) -> list[Fault]:
    """Return pydantic's errors in the user's words; the missing key that a misspelt one explains is left out."""
    details = error.errors(include_url=False)
    explained = {
        (*item["loc"][:-1], item["input"].replaces)
        for item in details
        if item["type"] == "extra_forbidden" and isinstance(item["input"], FaultyValue)
    }
    found: list[Fault] = []
    for item in details:
        value, loc = item["input"], item["loc"]
        cause = item.get("ctx", {}).get("error")
        if isinstance(value, FaultyValue) and (
            value.reported or (item["type"] != "extra_forbidden" and loc in explained)
        ):
            continue
        if isinstance(cause, InputError) and not isinstance(cause, RefusedError):
            found.extend(problem.within(path_text(loc)) for problem in cause.problems)
        else:
            found.append(_problem(item["type"], loc, value, item["msg"], cause))
    return list(dict.fromkeys(found))


def problems_of(error: ValidationError | InputError, value: Any) -> list[Fault]:
    """Return the faults that a parser raised when it was given `value`, in the user's words."""
    if isinstance(error, ValidationError):
        return problems_from(error)
    if isinstance(value, FaultyValue):
        return [] if value.reported else [_problem("", (), value, "", None)]
    if isinstance(error, RefusedError):
        return [_problem("", (), value, "", error)]
    return list(error.problems)


def _problem(kind: str, loc: tuple[str | int, ...], value: Any, message: str, cause: Any) -> Fault:
    if isinstance(value, FaultyValue):
        found = "" if value.value is None else show(value.value)
        return Fault(path_text(loc), found, value.why, value.instead)
    if isinstance(cause, RefusedError):
        found = show(value) if cause.found is None else cause.found
        return Fault(path_text((*loc, *cause.at)), found, cause.why, cause.instead)
    return Fault(path_text(loc), show(value), f"not allowed ({kind.replace('_', ' ')})", message)
