"""Keys of a case file with dots and [numbers], such as ``"rods.beam.elements"`` and ``"loads[0].value[1]"``."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from viscorod.casefile.case_reader import TABLES
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import did_you_mean, show, some_of

__all__ = ["keys_of", "parts_of", "put", "put_all"]

_KEY = re.compile(r"(?:^|\.)(?P<word>[\w-]+)|\[(?P<index>\d+)\]")


def keys_of(name: str) -> tuple[str, ...]:
    """Return the keys of a number: "a, b" are two that are equal."""
    return tuple(key.strip() for key in name.split(",") if key.strip())


@lru_cache
def parts_of(key: str) -> tuple[str | int, ...]:
    """Return the words and numbers of a key.

    Raises:
        InputError: it is not one.
    """
    parts: list[str | int] = [int(m["index"]) if m["index"] else m["word"] for m in _KEY.finditer(key)]
    if "".join(m[0] for m in _KEY.finditer(key)) != key or not parts:
        why, instead = "this is not a key of a case file", 'write "rods.beam.elements" or "loads[0].value"'
        raise InputError(Fault("values", show(key), why, instead))
    return tuple(parts)


def put_all(content: dict[str, Any], values: Mapping[str, Any]) -> None:
    """Set keys of a case file's content: whole tables and lists before what is within them, so that both count.

    The values stay as they are.

    Raises:
        InputError: something on the way to one is not there.
    """
    for key in sorted(values, key=lambda key: len(parts_of(key))):
        value = values[key]
        put(content, key, copy.deepcopy(value) if isinstance(value, list | dict) else value)


def put(content: dict[str, Any], key: str, value: Any) -> None:
    """Set one key of a case file's content; everything on the way to it must be there.

    Raises:
        InputError: something on the way is not there.
    """
    parts = parts_of(key)
    place: Any = content
    for k, part in enumerate(parts):
        where = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in parts[: k + 1])[1:]
        last = k + 1 == len(parts)
        if isinstance(part, int):
            if not isinstance(place, list) or part >= len(place):
                size = len(place) if isinstance(place, list) else 0
                found = f"a list of {size}" if isinstance(place, list) else show(place)
                instead = f"give a number from 0 to {size - 1}" if size else "leave [..] out"
                raise InputError(Fault(where, found, "there is no such entry", instead))
        elif not isinstance(place, dict):
            listed = (
                "name an entry, the first is [0]" if isinstance(place, list) else "give the key before it"
            )
            raise InputError(Fault(where, show(place), "this has no keys of its own", listed))
        elif part not in place and (not last or (k == 1 and parts[0] in TABLES)):
            hint = did_you_mean(part, place, str)
            raise InputError(
                Fault(
                    where,
                    "",
                    "no such key",
                    f"{hint}{'The' if hint else 'the'} keys here are {some_of(place)}",
                )
            )
        if last:
            place[part] = value
        else:
            place = place[part]
