"""Arguments of public functions: what a value of each name may be, checked before anything is done with it.

A name means the same everywhere: a ``path`` is a path, a ``place`` a place. ``checked`` looks at those arguments of a
function that are in ``KINDS``; what goes beyond the kind of value, such as that a place exists, is up to the function.
"""

from __future__ import annotations

import functools
import inspect
import math
import os
import reprlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numpy as np

from viscorod.argument_names import require_known
from viscorod.errors import Fault, InputError
from viscorod.limits import MOST_CHOSEN
from viscorod.units import is_quantity, si_quantity, si_value
from viscorod.wording import RefusedError

__all__ = [
    "KINDS",
    "checked",
    "checked_with",
    "file_path",
    "flag",
    "matrix",
    "number",
    "number_of_parts",
    "numbers",
    "of_class",
    "require_callback",
    "text",
]

P = ParamSpec("P")
R = TypeVar("R")
Kind: TypeAlias = Callable[[str, Any], Any]
"""Name and value of an argument -> the value that is used; raises ``InputError``."""

_SHORT = reprlib.Repr()
_SHORT.maxstring, _SHORT.maxother, _SHORT.maxlong = 60, 60, 30


def _refused(name: str, value: Any, why: str, instead: str) -> InputError:
    return InputError(Fault(name, _SHORT.repr(value), why, instead))


def text(name: str, value: Any) -> str:
    """Return a text that can be written."""
    if not isinstance(value, str):
        raise _refused(name, value, "a text is needed here", "give it in quotes")
    if any(c == "\0" or "\ud800" <= c <= "\udfff" for c in value):
        raise _refused(
            name, value, "the text has characters that cannot be written", "leave out NUL and lone surrogates"
        )
    return value


def file_path(name: str, value: Any) -> Path:
    """Return a path that the system can have."""
    if not isinstance(value, str | os.PathLike) or not isinstance(os.fspath(value), str):
        raise _refused(name, value, "a path is needed here", "give a text in quotes, or a pathlib.Path")
    given = os.fspath(value)
    if not given:
        raise _refused(name, value, "the path is empty", "name a file or folder")
    try:
        possible = "\0" not in given and bool(os.fsencode(given))
    except UnicodeEncodeError:
        possible = False
    if not possible:
        raise _refused(
            name, value, "no file can have this name", "leave out NUL and characters that are no text"
        )
    return Path(given)


UNITS = {"time": "s", "times": "s", "duration": "s", "s": "m", "rest": "m"}
"""Names of arguments whose numbers may have a unit, and the one that they are in."""


def _in_si(name: str, value: Any) -> Any:
    """Return a quantity, a text such as "3 ms" or an object of a library of units, in SI; anything else as it is."""
    if isinstance(value, list | tuple) and any(isinstance(item, str) or is_quantity(item) for item in value):
        return [_in_si(name, item) for item in value]
    if name not in UNITS or not (isinstance(value, str) or is_quantity(value)):
        return value
    try:
        return (
            si_value(value, UNITS[name], name)
            if isinstance(value, str)
            else si_quantity(value, UNITS[name], name)
        )
    except RefusedError as error:
        raise _refused(name, value, error.why, error.instead) from None


def number(name: str, value: Any) -> float:
    """Return a finite number."""
    found = _number(_in_si(name, value))
    if found is None:
        raise _refused(name, value, "a finite number is needed here", "give a plain number such as 0.25")
    return found


def _number(value: Any) -> float | None:
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        return None
    try:
        found = float(value)
    except OverflowError:
        return None
    return found if math.isfinite(found) else None


def numbers(name: str, value: Any) -> Any:
    """Return a finite number, or a list of them, as it was given."""
    value = _in_si(name, value)
    if (
        isinstance(value, np.ndarray)
        and value.ndim == 1
        and value.dtype.kind in "iuf"
        and np.isfinite(value).all()
    ):
        return value
    items = np.asarray(value).tolist() if hasattr(value, "__array__") else value
    if isinstance(items, str | bytes) or not isinstance(items, Sequence):
        return number(name, items)
    for k, item in enumerate(items):
        if _number(item) is None:
            raise _refused(f"{name}[{k}]", item, "a finite number is needed here", "give plain numbers")
    return value


def whole(name: str, value: Any) -> int:
    """Return a whole number."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise _refused(name, value, "a whole number is needed here", "give one such as 20")
    return int(value)


def number_of_parts(name: str, value: Any) -> int:
    """Return a number of parts, at least 1."""
    found = whole(name, value)
    if not 1 <= found <= MOST_CHOSEN:
        raise _refused(name, value, "outside what is allowed", f"give a number from 1 to {MOST_CHOSEN}")
    return found


def flag(name: str, value: Any) -> bool:
    """Return a truth value."""
    if not isinstance(value, bool | np.bool_):
        raise _refused(name, value, "neither True nor False", "give True or False")
    return bool(value)


def place(name: str, value: Any) -> str | int:
    """Return the word for a place, or the number of a station."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise _refused(
            name,
            value,
            "this is no place",
            "give one such as 'beam.end', 'beam@0.15' or the number of a station",
        )
    return int(value)


def places(name: str, value: Any) -> Any:
    """Return a place or a list of places."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [place(f"{name}[{k}]", item) for k, item in enumerate(value)]
    return place(name, value)


def word(name: str, value: Any) -> str:
    """Return a word; which ones are known the function says."""
    if not isinstance(value, str):
        raise _refused(
            name, value, "a word in quotes is needed here", "see the documentation for those there are"
        )
    return value


def require_callback(name: str, value: Any, *arguments: Any) -> None:
    """Refuse what cannot be called with such arguments.

    Raises:
        InputError: it is no function, or takes other arguments.
    """
    if not callable(value):
        raise _refused(
            name, value, "a function is needed here", f"give one that takes {len(arguments)} arguments"
        )
    try:
        signature = inspect.signature(value)
    except (TypeError, ValueError):  # functions of C may not tell
        return
    try:
        signature.bind(*arguments)
    except TypeError as error:
        raise _refused(
            name,
            value,
            f"the function cannot be called with {len(arguments)} arguments ({error})",
            "give one that takes them",
        ) from None


def matrix(name: str, value: Any) -> np.ndarray:
    """Return a matrix (6, 6) of finite numbers."""
    try:
        found = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        found = np.zeros(0)
    if found.shape != (6, 6) or not np.isfinite(found).all():
        raise _refused(name, value, "six rows of six finite numbers are needed here", "give a 6x6 matrix")
    return found


def of_class(*kinds: type) -> Kind:
    """Return what lets objects of some classes through."""

    def check(name: str, value: Any) -> Any:
        if not isinstance(value, kinds):
            words = " or ".join(kind.__name__ for kind in kinds)
            raise _refused(name, value, f"this is no {words}", f"give a {words}")
        return value

    return check


def axes(name: str, value: Any) -> Any:
    """Return axes of Matplotlib."""
    if not all(hasattr(value, word) for word in ("plot", "get_legend", "figure")):
        raise _refused(
            name, value, "Matplotlib's axes are needed here", "give one panel, as plt.subplots() returns it"
        )
    return value


KINDS: dict[str, Kind] = {
    "ax": axes,
    "path": file_path,
    "folder": file_path,
    "title": text,
    "place": place,
    "places": places,
    "axis": word,
    "quantity": word,
    "component": word,
    "rod": word,
    "x": word,
    "kind": word,
    "name": word,
    "port": word,
    "frequency_unit": word,
    "modulus_unit": word,
    "temperature": number,
    "time": number,
    "duration": number,
    "level": number,
    "times": numbers,
    "s": numbers,
    "rest": number,
    "below": flag,
    "sections": flag,
    "strain": word,
    "fit": word,
    "keep_modulus": flag,
    "tolerance": number,
    "fps": number,
    "speed": number,
    "frames": whole,
    "count": number_of_parts,
    "number": number_of_parts,
    "megabytes": number,
}
"""Name of an argument -> what checks and converts its values."""


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Check the arguments of a function whose names are in ``KINDS``; None is let through where its type has it.

    Raises:
        InputError: an argument has a value of another kind.
    """
    return checked_with()(function)


def checked_with(**more: Kind) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Do what ``checked`` does, with kinds for more arguments, or others."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        kinds = KINDS | more
        parameters = inspect.signature(function).parameters
        order = list(parameters)
        free = {name for name in order if "None" in str(parameters[name].annotation)}

        def converted(name: str, value: Any) -> Any:
            return (
                kinds[name](name, value) if name in kinds and not (value is None and name in free) else value
            )

        @functools.wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            run: Any = function
            require_known(run, kwargs, args)
            listed = [converted(name, value) for name, value in zip(order, args, strict=False)]
            named = {name: converted(name, value) for name, value in kwargs.items()}
            result: R = run(*listed, *args[len(listed) :], **named)
            return result

        return call

    return decorate
