"""The cases that come with the program."""

from __future__ import annotations

from pathlib import Path

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import did_you_mean

__all__ = ["shipped_case", "shipped_cases"]


def shipped_cases() -> dict[str, Path]:
    """Return the files of the shipped cases by name, sorted.

    They stand in the installed package, or in the folder `examples` of a source tree.
    """
    installed = Path(__file__).with_name("examples")
    source = Path(__file__).parents[3] / "examples"
    folder = installed if installed.is_dir() else source
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


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
