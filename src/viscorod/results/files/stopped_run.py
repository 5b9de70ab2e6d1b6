"""The states of a run that was stopped, or is still computed, as a result: what is whole of them."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from viscorod.errors import InputError, warn
from viscorod.results.files.journal_folder import FOLDER, holds_run
from viscorod.results.files.stored_journal import checkpoint, contents, damaged

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["result_file", "stopped_run"]


def result_file(folder: Path) -> Path:
    """Return the file that a folder was named for: the journal of a run that has not ended, else its result.

    Raises:
        InputError: the folder holds neither.
    """
    journal = folder / FOLDER
    if holds_run(journal):
        return journal
    # a journal without a run may be what an interrupt left of one that is complete
    for path in (folder / "run.nc", folder / "sweep.nc", journal):
        if path.exists():
            return path
    if folder.name == FOLDER:
        return folder
    raise InputError(f"{folder} holds no result; name a folder that viscorod run wrote to, or a run.nc")


def stopped_run(journal: Path) -> xr.Dataset:
    """Return the states of a journal so far; doubts say what is damaged.

    Raises:
        InputError: nothing was written yet, or it is damaged.
    """
    data = contents(journal)
    time = data["time"].values
    if not time.size:
        raise InputError(f"{journal} is damaged: not one of its states is whole")
    reached = f"t = {float(time[-1]):.6g} s"
    attrs = {
        "outcome": "interrupted",
        "message": f"These are the states until {reached}, of a run that has not ended",
        "warnings": data.attrs.get("doubts", "[]"),
    }
    doubts, counted = damaged(journal), 0
    with suppress(InputError):
        counted = checkpoint(journal)[1]
    if time.size < counted:
        doubts.append(f"{journal} is damaged: {time.size} of {counted} states are whole, until {reached}")
    for doubt in doubts:
        warn(doubt)
    attrs["warnings"] = json.dumps([*json.loads(attrs["warnings"]), *doubts])
    return data.assign_attrs(attrs)
