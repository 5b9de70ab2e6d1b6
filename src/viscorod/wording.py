"""Words for messages: values in short, key paths, the nearest of the words that are known."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from viscorod.errors import Fault, InputError

__all__ = [
    "RefusedError",
    "did_you_mean",
    "missing",
    "nearest",
    "nearest_key",
    "path_text",
    "show",
    "some_of",
    "with_article",
]

_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother, _SHORT.maxlong = 3, 60, 60, 30
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = 8
_LONGEST, _MOST = 160, 12
LESS_ALIKE = 0.1
"""By how much a key that is not there yet may be less like an unknown one than a key that is."""


class RefusedError(InputError):
    """Raised inside a validator: why a value is refused and what to give instead.

    `found` replaces the text for the value, `at` extends the key path (for checks that compare several keys).
    """

    def __init__(
        self, why: str, instead: str = "", *, found: str | None = None, at: Sequence[str | int] = ()
    ) -> None:
        super().__init__(Fault(path_text(at), found or "", why, instead))
        self.why, self.instead, self.found, self.at = why, instead, found, tuple(at)


def nearest(word: str, allowed: Iterable[str]) -> str | None:
    """Return the allowed word most similar to `word`, or None if none is similar."""
    words = list(allowed)
    close = difflib.get_close_matches(word.lower(), [w.lower() for w in words], n=1, cutoff=0.6)
    return next((w for w in words if w.lower() == close[0]), None) if close else None


def nearest_key(key: str, allowed: Iterable[str], given: Iterable[str]) -> str | None:
    """Return the key that an unknown one was meant to be: rather one that is not given, unless that is less alike."""
    names, there = list(allowed), set(given)
    free, alike = nearest(key, [name for name in names if name not in there]), nearest(key, names)
    if free and alike and alike in there and _likeness(key, alike) > _likeness(key, free) + LESS_ALIKE:
        return alike
    return free or alike


def _likeness(word: str, other: str) -> float:
    return difflib.SequenceMatcher(None, other.lower(), word.lower()).ratio()


def did_you_mean(word: Any, allowed: Iterable[str], text: Callable[[str], str] = repr) -> str:
    """Return the beginning of an advice that names the allowed word nearest to `text`; empty without one."""
    close = nearest(word, allowed) if isinstance(word, str) else None
    return f"did you mean {text(close)}? " if close else ""


def some_of(names: Iterable[str]) -> str:
    """Return the names that a user gave, for a message; those after the first twelve are only counted."""
    words = list(names)
    rest = len(words) - _MOST
    return ", ".join(words[:_MOST]) + (f" and {rest} more" if rest > 0 else "")


def show(value: Any) -> str:
    """Return `value` as short text for a message."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and value.bit_length() > 1000:
        return "a whole number of more than 300 digits"
    if isinstance(value, float | str | int):
        return _SHORT.repr(_plain(value))
    if hasattr(type(value), "model_fields"):  # described by its name
        return type(value).__name__
    if hasattr(value, "magnitude") or hasattr(value, "to_value"):  # a quantity with a unit
        return _SHORT.repr(str(value))
    text = _SHORT.repr(_plain(value))
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def _plain(value: Any) -> Any:
    """Return NumPy scalars and arrays, and those in a list or tuple, as the numbers that they show."""
    if type(value) in (list, tuple):
        first = value[: _SHORT.maxlist + 1]
        return type(value)(one.tolist() if type(one).__module__ == "numpy" else one for one in first)
    return value.tolist() if hasattr(value, "tolist") else value


def missing(path: Path) -> str:
    """Return why a path that is no file cannot be read."""
    return "this is a folder" if path.is_dir() else "there is no such file"


def path_text(loc: Iterable[str | int]) -> str:
    """Return a key path as text: ``("loads", 0, "value")`` -> ``loads[0].value``."""
    text = ""
    for part in loc:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            word = part if re.fullmatch(r"[\w-]{1,60}", part) else _SHORT.repr(part)
            text += f".{word}" if text else word
    return text


def with_article(noun: str) -> str:
    """Return a noun behind "a" or "an"."""
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"
