"""The two errors that viscorod raises on purpose, and its warning.

All carry a message for the person who typed the input: what was found, why it is a problem, what to type
instead.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

__all__ = [
    "AccuracyWarning",
    "Fault",
    "InputError",
    "SolveError",
    "last_warnings",
    "problems_text",
    "reading",
    "users_level",
    "warn",
]


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong in what the user described.

    `where` is the key's path in the words of the case file (``loads[0].value``), `found` the value there,
    `why` the reason why it cannot be used, and `instead` what to type.
    """

    where: str
    found: str
    why: str
    instead: str

    def __str__(self) -> str:
        head = f"{self.where}: " if self.where else ""
        found = f"{self.found}: " if self.found else ""
        tail = f"; {self.instead}" if self.instead else ""
        return f"{head}{found}{self.why}{tail}"

    def within(self, prefix: str) -> Fault:
        """Return the same problem with `prefix` put before its path."""
        return replace(self, where=join_path(prefix, self.where))


class InputError(ValueError):
    """The model, the case file or a setting cannot be used as it was given.

    `problems` lists everything that was found in one go; the message holds one line for each of them.
    """

    def __init__(self, problems: str | Fault | Iterable[Fault], *, heading: str = "") -> None:
        if isinstance(problems, str):
            self._problems: tuple[Fault, ...] = (Fault("", "", problems, ""),)
        elif isinstance(problems, Fault):
            self._problems = (problems,)
        else:
            self._problems = tuple(problems)
        self.heading = heading
        super().__init__(problems_text(self._problems, heading))

    @property
    def problems(self) -> tuple[Fault, ...]:
        """Everything that was found."""
        return self._problems


class SolveError(RuntimeError):
    """A solution could not be found; the message says where it stopped, at which load, and what to try.

    `run` holds the results up to there (a `Run` or an `Equilibrium`), or None if there are none. `coarse` tells that
    only a finer mesh helps; where the program chooses the mesh, it takes one.
    """

    def __init__(self, message: str, run: Any = None, *, coarse: bool = False) -> None:
        super().__init__(message)
        self.run = run
        self.coarse = coarse


class AccuracyWarning(UserWarning):
    """Something is less accurate than one would expect of it; the message says what, by how much, and what to do."""


INSIDE = ("viscorod.", "pydantic.", "contextlib")
"""Modules whose lines are not the user's."""
_kept: ContextVar[list[str] | None] = ContextVar("warnings kept until an analysis is done", default=None)


def warn(text: str, at_once: bool = False) -> None:
    """Show an `AccuracyWarning` at the user's own line: at once, or when the analysis that is under way is done."""
    kept = None if at_once else _kept.get()
    if kept is None:
        warnings.warn(text, AccuracyWarning, stacklevel=users_level())
    else:
        kept.append(text)


@contextmanager
def last_warnings() -> Iterator[list[str]]:
    """Keep warnings until the end, in a list to be cleared when what they speak of is thrown away and done again."""
    kept: list[str] = []
    token = _kept.set(kept)
    try:
        yield kept
    finally:
        _kept.reset(token)
        for text in kept:
            warn(text)


def users_level() -> int:
    """Return the stack level, for a warning of the caller, of the line outside this package that led to it.

    Python shows a `DeprecationWarning` only where it is the user's own line.
    """
    level, frame = 1, inspect.currentframe()
    while frame is not None and str(frame.f_globals.get("__name__")).startswith(INSIDE):
        level, frame = level + 1, frame.f_back
    return level - 1


def came_of_interrupt(error: BaseException) -> bool:
    """Return whether an error is Ctrl-C that met compiled code of a library: Python speaks of a `SystemError` then."""
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt):
        cause = cause.__cause__ or cause.__context__
    return cause is not None


def let_interrupts_through(error: BaseException) -> None:
    """Raise the interrupt of which a library made an error of its own; of other errors nothing comes.

    Raises:
        KeyboardInterrupt: it led to the error.
    """
    if came_of_interrupt(error):
        raise KeyboardInterrupt("stopped from the keyboard") from error


@contextmanager
def reading(path: Path, what: str = "") -> Iterator[None]:
    """Turn whatever HDF5 and the libraries above it say of a damaged result into one message.

    Args:
        path: of the file; what: the part of it that is read.

    Raises:
        InputError: the file cannot be read.
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # a damaged file brings out errors of every kind
        let_interrupts_through(error)
        part = f"; {what}" if what else ""
        if path.suffix == ".toml":
            raise InputError(f"{path} is no result; compute it first, with: viscorod run {path}") from None
        text = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"{path} cannot be read as netCDF4{part}: it is damaged, or another kind of file ({text[:200]}); "
            "name a run.nc that viscorod wrote, or take another copy of it"
        ) from None


def join_path(prefix: str, path: str) -> str:
    """Return `prefix` and `path` as one key path: ``rods.beam`` + ``section`` -> ``rods.beam.section``."""
    if not prefix or not path:
        return prefix or path
    return prefix + path if path.startswith("[") else f"{prefix}.{path}"


def problems_text(problems: tuple[Fault, ...], heading: str) -> str:
    """Return problems as the message of an error, one line for each."""
    if len(problems) == 1:
        text = f"{heading}: {problems[0]}" if heading else str(problems[0])
    else:
        lines = "".join(f"\n  - {problem}" for problem in problems)
        text = f"{heading + ': ' if heading else ''}{len(problems)} problems{lines}"
    # what a user gave may be no text that can be printed: lone surrogates
    return text.encode("utf-8", "backslashreplace").decode("utf-8")
