"""Names of the members of a sweep: what a member is, in twenty letters, so that it is known again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from viscorod.analyses.sweeps.rows import Row
from viscorod.casefile.case import Case
from viscorod.results.files.sweep_folder import plain
from viscorod.results.quantities import Quantity

__all__ = ["member_names"]

LETTERS = 20


def member_names(case: Case, rows: Sequence[Row], quantities: Sequence[Quantity], keep: bool) -> list[str]:
    """Return a name for every member, by its case, values, version, quantities and whether its result is kept.

    Files that the case names count by their content.
    """
    from viscorod import __version__

    about = {
        "case": case.content,
        "files": {str(path): _digest(path) for path in sorted(_files(case, [case.content, *rows]))},
        "version": __version__,
        "quantities": {quantity.name: quantity.record for quantity in quantities},
        "keep": keep,
    }
    base = _text(about)
    return [hashlib.sha256(f"{base}\n{_text(row)}".encode()).hexdigest()[:LETTERS] for row in rows]


def _text(value: Any) -> str:
    return json.dumps(value, sort_keys=True, default=plain)


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


def _files(case: Case, value: Any) -> set[Path]:
    """Return the files that a case or a row names."""
    folder = Path() if case.source is None else case.source.parent
    return {folder / text for text in _named(value)}


def _named(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key, item in value.items():
            if isinstance(item, str) and (key == "file" or str(key).endswith(".file")):
                yield item
            else:
                yield from _named(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _named(item)
