"""Keys of a case file with values on the command line: ``--set``, ``--grid``, ``--quantity``."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from contextlib import suppress
from typing import Annotated, Any, TypeVar

import typer

from viscorod.errors import InputError

__all__ = ["SetValues", "column_of", "drawn", "each_once", "grid_of", "named", "part_of", "value_of"]

_RANGE = re.compile(r"\s*([^:,]+?)\s*:\s*([^:,]+?)\s*:\s*(\d+)\s*")
_NUMBER = r"((?>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))"
_QUANTITY = re.compile(rf"([\s\[]*){_NUMBER}\s*([^\W\d_][^,:\[\]\"']*?|[°%][^,:\[\]\"']*?)([\s\]]*)")
"""A number with a unit, perhaps the first or last one of a list."""
_CALL = re.compile(r"\s*([a-z_0-9]+)\s*\(([^()]*)\)\s*")
SetValues = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Key of the case file and another value: rods.beam.elements=4. Repeat it for more.",
        show_default=False,
    ),
]


T = TypeVar("T")


def each_once(pairs: Iterable[tuple[str, T]], flag: str) -> dict[str, T]:
    """Return what is given by key or name.

    Raises:
        InputError: one is given twice, of which only the last would count.
    """
    found: dict[str, T] = {}
    for key, given in pairs:
        if key in found:
            several = ", or give all its values at once: KEY=1,2" if flag in ("--set", "--grid") else ""
            raise InputError(f"{flag} {key}: it is given twice; leave one of them out{several}")
        found[key] = given
    return found


def column_of(text: str, flag: str = "--set") -> tuple[str, list[Any]]:
    """Return a key and its values from ``key=1,2,4``; values are written as in a case file.

    Raises:
        InputError: there is no key, or no value.
    """
    key, sign, values = text.partition("=")
    column: list[Any] = []
    for written in (values, _quoted(values)):
        with suppress(tomllib.TOMLDecodeError):
            column = tomllib.loads(f"values = [{written}]")["values"]
            break
    if not sign or not column:
        a_range = "a range such as 0.01:0.05:9 (first, last, number), or " if flag == "--grid" else ""
        raise InputError(
            f"{flag} {text}: give a key and {a_range}values as in a case file, separated by commas, such as "
            'rods.beam.elements=1,2,4 or rods.beam.section="thin","thick"'
        )
    if flag == "--grid" and len(column) == 1 and isinstance(column[0], list):
        raise InputError(
            f"{flag} {text}: this is one value, a list; leave out the brackets around several values, or give several "
            "lists: [0, 1, 0],[0, 0, 1]"
        )
    return key.strip(), column


def _quoted(values: str) -> str:
    """Return values with quantities such as 10 mm in quotes, which shells take away."""
    pieces = [(piece, _QUANTITY.fullmatch(piece)) for piece in values.split(",")]
    return ",".join(
        f'{found[1]}"{found[2]} {found[3]}"{found[4]}' if found else piece for piece, found in pieces
    )


def value_of(text: str) -> tuple[str, Any]:
    """Return a key and its one value.

    Raises:
        InputError: there is no key, or not one value.
    """
    key, sign, value = text.partition("=")
    if not (key.strip() and sign and value.strip()):
        what = (
            "the value is missing"
            if key.strip() and sign
            else "the key is missing"
            if sign
            else "there is no ="
        )
        raise InputError(
            f"--set {text}: {what}; write KEY=VALUE with a key of the case file and its value there, such as "
            "rods.beam.elements=4"
        )
    key, column = column_of(text)
    if len(column) > 1:
        raise InputError(
            f"--set {text}: one value is needed here; write a list in [brackets], or compute all with viscorod sweep"
        )
    return key, column[0]


def grid_of(text: str) -> tuple[str, list[Any]]:
    """Return a key and its values from ``key=first:last:number`` or ``key=1,2,4``.

    Raises:
        InputError: it is neither.
    """
    key, sign, values = text.partition("=")
    found = _RANGE.fullmatch(values)
    if not sign or found is None:
        return column_of(text, "--grid")
    (first, unit), (last, other), count = _parts(found[1]), _parts(found[2]), int(found[3])
    if first is None or last is None or unit != other or count < 2:
        raise InputError(
            f"--grid {text}: write KEY=FIRST:LAST:NUMBER with two numbers, of one unit if they have one, and a number "
            "of 2 or more"
        )
    numbers = [(first * (count - 1 - k) + last * k) / (count - 1) for k in range(count)]
    return key.strip(), [f"{number!r} {unit}" for number in numbers] if unit else numbers


def _parts(text: str) -> tuple[float | None, str]:
    """Return a number and its unit; None if there is no number."""
    found = _QUANTITY.fullmatch(text.strip("\"'"))
    number, unit = (found[2], found[3]) if found else (text, "")
    try:
        return float(number), unit
    except ValueError:
        return None, ""


def named(text: str) -> tuple[str, str]:
    """Return a name and its words from ``name=words``.

    Raises:
        InputError: one of them is missing.
    """
    name, sign, words = text.partition("=")
    if not sign or not name.strip() or not words.strip():
        raise InputError(f'--quantity {text}: write NAME=WORDS, such as "tip=displacement beam.end y max"')
    return name.strip(), words.strip()


def drawn(text: str) -> tuple[str, Any]:
    """Return a key and its distribution from ``key=norm(1e6, 5e4)``.

    Raises:
        InputError: there is no key, or no such distribution.
    """
    import scipy.stats

    key, sign, words = text.partition("=")
    found = _CALL.fullmatch(words)
    kind = getattr(scipy.stats, found[1], None) if found else None
    if not sign or found is None or not isinstance(kind, scipy.stats.rv_continuous | scipy.stats.rv_discrete):
        raise InputError(
            f"--draw {text}: write KEY=DISTRIBUTION as SciPy calls it, such as norm(1e6, 5e4) with mean and standard "
            "deviation, or uniform(0.9, 0.2) with the least value and the width"
        )
    places: list[float] = []
    names: dict[str, float] = {}
    for part in filter(str.strip, found[2].split(",")):
        name, equal, value = part.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            raise InputError(
                f"--draw {text}: {part.strip()} is no number; give numbers in SI, or their unit behind the key: "
                f'"{key.strip()} [mm]={found[1]}(...)"'
            ) from None
        if equal:
            names[name.strip()] = number
        else:
            places.append(number)
    try:
        return key.strip(), kind(*places, **names)
    except TypeError as error:
        raise InputError(f"--draw {text}: {error}") from None


def part_of(text: str | None) -> slice | None:
    """Return which members are meant by ``100:200``.

    Raises:
        InputError: it is no part.
    """
    if text is None:
        return None
    first, sign, last = text.partition(":")
    if not sign or not all(word.isdecimal() for word in (first or "0", last or "0")):
        raise InputError(f"--members {text}: write FIRST:END from 0, such as 100:200; the end does not count")
    return slice(int(first or 0), int(last) if last else None)
