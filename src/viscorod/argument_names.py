"""Arguments of public functions: whether all are there, each once, and none that the function does not have."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar

from viscorod.errors import Fault, InputError
from viscorod.wording import did_you_mean

__all__ = ["MISSING", "KnownArguments", "known_arguments", "require_known", "telling"]

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)

MISSING = "this argument is required and missing"
"""Why a call is refused that lacks one."""


def _called(function: Callable[..., Any]) -> str:
    """Return what a user wrote to call it: a class is called by its own name."""
    whole = function.__qualname__.split(".")
    return whole[-2] if whole[-1] == "__init__" else whole[-1]


def require_known(function: Callable[..., Any], given: Mapping[str, Any], listed: Sequence[Any] = ()) -> None:
    """Refuse arguments that a function does not have, that are given twice or are missing, and values beyond the last.

    Raises:
        InputError: there is one; the nearest name that it has is told.
    """
    code = function.__code__
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    if len(listed) > code.co_argcount and not code.co_flags & inspect.CO_VARARGS:
        first = [name for name in names[: code.co_argcount] if name not in ("self", "cls")]
        raise InputError(
            Fault(
                _called(function),
                f"{listed[code.co_argcount]!r:.60}",
                f"at most {len(first)} can be given without their names: {', '.join(first) or 'none'}",
                f"write the name before the others: {', '.join(f'{name} = ...' for name in names[code.co_argcount :])}"
                if code.co_kwonlyargcount
                else "leave the others out",
            )
        )
    if given.keys() <= set(names) or code.co_flags & inspect.CO_VARKEYWORDS:
        _require_once(function, names, given, listed)
        return
    wrong = next(name for name in given if name not in names)
    known = [name for name in names if name not in ("self", "cls")]
    advice = f"{did_you_mean(wrong, known, str)}the arguments are {', '.join(known)}"
    raise InputError(Fault(f"{_called(function)}: {wrong}", "", "there is no argument of this name", advice))


def _require_once(
    function: Callable[..., Any], names: Sequence[str], given: Mapping[str, Any], listed: Sequence[Any]
) -> None:
    """Refuse arguments that are given twice, without their name and with it, and those that are missing.

    What can be given by its place alone may stand beside a value of the same name for someone else.
    """
    count, by_place = function.__code__.co_argcount, function.__code__.co_posonlyargcount
    known = names[: min(len(listed), count)]
    named = set(names[by_place:]) & given.keys()
    faults = [
        Fault(
            f"{_called(function)}: {name}",
            f"{given[name]!r:.60}",
            f"it is given twice: {listed[names.index(name)]!r:.60} stands in its place without a name",
            "leave one of them out, or write the names of all",
        )
        for name in known
        if name in named
    ]
    free = names[count - len(function.__defaults__ or ()) : count]
    faults += [
        Fault(f"{_called(function)}: {name}", "", MISSING, f"give {name} = ...")
        for name in names
        if not (name in known or name in named or name in free or name in (function.__kwdefaults__ or {}))
    ]
    if faults:
        raise InputError(faults)


def known_arguments(kind: C) -> C:
    """Let a class, and all public methods that it defines, tell of arguments that are missing or not known.

    Static methods are left as they are: they are formulas of section laws, which compiled code calls.
    """
    for name, found in list(vars(kind).items()):
        plain = found.__func__ if isinstance(found, classmethod) else found
        if (name.startswith("_") and name != "__init__") or not inspect.isfunction(plain):
            continue
        told = telling(plain)
        setattr(kind, name, classmethod(told) if isinstance(found, classmethod) else told)
    return kind


class KnownArguments:
    """The base of classes all of whose subclasses tell of arguments that are missing or not known."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        known_arguments(cls)


def telling(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function tell of arguments that are missing or not known; nothing is checked of calls that succeed."""

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except TypeError as error:
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                raise  # by what the function does, not by its call
        require_known(inspect.unwrap(function), kwargs, args)
        return function(*args, **kwargs)

    return call
