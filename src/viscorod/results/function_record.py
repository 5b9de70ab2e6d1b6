"""What a function of the user computes, in words by which another one is told from it."""

from __future__ import annotations

import functools
import hashlib
import inspect
import pickle
from collections.abc import Callable
from typing import Any

__all__ = ["function_record"]

DEEPEST = 4
"""Functions that call others are followed so far."""


def function_record(function: Callable[..., Any], depth: int = 0) -> str:
    """Return the source of a function with all that it takes from around it.

    These are defaults, values of the functions that it stands in, numbers and texts of its module, the functions of it
    that it calls, and arguments that ``functools.partial`` has given already. What an object does whose class has
    changed is not seen.
    """
    if isinstance(function, functools.partial):
        given = ", ".join(map(_value, (*function.args, *sorted(function.keywords.items()))))
        return f"partial({function_record(function.func, depth)}, {given})"
    try:
        source = inspect.getsource(function)
    except (OSError, TypeError):
        source = repr(getattr(function, "__code__", function))
    parts = [f"{getattr(function, '__qualname__', '')}: {source}"]
    if inspect.isfunction(function) and depth < DEEPEST:
        around = inspect.getclosurevars(function)
        taken = {**around.globals, **around.nonlocals}
        parts += [f"{name} = {_taken(value, depth)}" for name, value in sorted(taken.items())]
        parts += [_value(function.__defaults__), _value(function.__kwdefaults__)]
    return "\n".join(parts)


def _taken(value: Any, depth: int) -> str:
    if inspect.ismodule(value) or inspect.isclass(value):
        return f"{getattr(value, '__module__', '')} {value.__name__}"
    if inspect.isfunction(value) and not value.__module__.startswith(("numpy", "scipy", "viscorod")):
        return function_record(value, depth + 1)
    return _value(value)


def _value(value: Any) -> str:
    """Return a value in few letters that are others for another value."""
    try:
        return hashlib.sha256(pickle.dumps(value)).hexdigest()[:16]
    except Exception:  # what cannot be pickled is told by its words
        return repr(value)
