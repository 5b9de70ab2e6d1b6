"""The cases that come with viscorod: where they are, what they are called, copying them."""

from __future__ import annotations

import tomllib
from pathlib import Path

from viscorod.errors import InputError, Problem

_INSTALLED = Path(__file__).parent / "examples"
_REPOSITORY = Path(__file__).parents[3] / "examples"


def shipped() -> dict[str, Path]:
    """Return the shipped cases: name -> file, by name."""
    folder = (
        _INSTALLED if _INSTALLED.is_dir() else _REPOSITORY
    )  # a development install reads the repository's own
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def title(path: Path) -> str:
    """Return the title that a case file gives itself, empty if it has none."""
    with path.open("rb") as file:
        return str(tomllib.load(file).get("title", ""))


def copy(name: str, folder: Path) -> Path:
    """Copy a shipped case into a folder, which is made if needed; returns the new file.

    Raises:
        InputError: no such case, or the file is there already.
    """
    cases = shipped()
    if name not in cases:
        raise InputError(
            Problem("", repr(name), "no case of this name is shipped", f"the names are {', '.join(cases)}")
        )
    target = folder / cases[name].name
    if target.exists():
        raise InputError(
            Problem("", str(target), "this file is there already", "move it, or name another folder with -o")
        )
    folder.mkdir(parents=True, exist_ok=True)
    target.write_bytes(cases[name].read_bytes())
    return target
