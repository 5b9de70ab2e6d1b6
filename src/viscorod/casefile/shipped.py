"""The cases that come with the program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import did_you_mean

__all__ = ["needed_extra", "shipped_case", "shipped_cases"]

_MESHED = ("composite", "outline")
"""Shapes of sections that finite elements compute."""


def shipped_cases() -> dict[str, Path]:
    """Return the files of the shipped cases by name, sorted.

    They stand in the installed package, or in the folder `examples` of a source tree.
    """
    installed = Path(__file__).with_name("examples")
    source = Path(__file__).parents[3] / "examples"
    folder = installed if installed.is_dir() else source
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def needed_extra(content: Mapping[str, Any]) -> str:
    """Return the extra of the package that a case needs, "sections", or an empty text."""
    shapes = [table.get("shape") for table in _tables(content)]
    return "sections" if any(shape in _MESHED for shape in shapes) else ""


def _tables(value: Any) -> Iterator[Mapping[str, Any]]:
    """Yield all tables of a case file."""
    if isinstance(value, Mapping):
        yield value
    for item in value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ():
        yield from _tables(item)


def shipped_case(name: str) -> Path:
    """Return the file of the shipped case called `name`.

    Raises:
        InputError: there is none; the nearest name is suggested.
    """
    cases = shipped_cases()
    if name in cases:
        return cases[name]
    hint = did_you_mean(name, cases)
    raise InputError(
        Fault("example", repr(name), "there is no such case", f"{hint}the cases are {', '.join(cases)}")
    )
