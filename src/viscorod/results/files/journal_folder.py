"""The folder of a journal: the names in it, whether it holds a run, and how it is emptied (see ``journal``)."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from viscorod.results.files.sealed_file import twin

FOLDER = "run.partial"
"""Name of a journal beside the file ``run.nc`` that it becomes."""
LOCK = "lock"
"""Name of the file in it that is locked."""

LAYOUT, RECORDS, FIELDS, OVER = "layout.nc", "states.bin", "states.json", "over.json"
CHECKPOINT, BEFORE = "checkpoint.npz", "before.npz"
"""Names of the other files; ``OVER`` is what ``FIELDS`` becomes before a journal is removed."""


def empty(folder: Path) -> None:
    """Remove what is in the folder of a journal, but its lock; from the first moment on it holds no run.

    Raises:
        OSError: something cannot be removed.
    """
    over = folder / OVER
    for name in (FIELDS, twin(folder / FIELDS).name):  # of which one may be missing
        with suppress(FileNotFoundError):
            (folder / name).replace(over)
    for path in folder.iterdir():
        if path.name not in (LOCK, OVER):
            path.unlink()
    over.unlink(missing_ok=True)


def holds_run(folder: Path) -> bool:
    """Return whether the folder of a journal holds states, or what is left of them."""
    if not folder.is_dir():
        return False
    there = {path.name for path in folder.iterdir()}
    described = {FIELDS, twin(folder / FIELDS).name, LAYOUT, twin(folder / LAYOUT).name}
    begun = there & (described | {CHECKPOINT, BEFORE})
    states = folder / RECORDS
    return OVER not in there and bool(begun or (RECORDS in there and states.stat().st_size))
