"""What a journal on disk holds: the states that are whole, and from where its run can go on (see ``journal``)."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.checkpoint_file import Checkpoint, read_checkpoint
from viscorod.results.files.journal_folder import (
    BEFORE,
    CHECKPOINT,
    FIELDS,
    LAYOUT,
    OVER,
    RECORDS,
    empty,
    holds_run,
)
from viscorod.results.files.records import Layout, RecordFile
from viscorod.results.files.sealed_file import mend_twins, read_twins
from viscorod.results.files.storage import write

if TYPE_CHECKING:
    import xarray as xr

CHUNK = 16e6
"""Bytes of states that are in memory at once."""


def about(folder: Path) -> dict[str, Any]:
    """Return the attributes of the run in a journal, as they were when it began.

    Raises:
        InputError: there is none, or it is damaged.
    """
    return dict(_static(folder, described(folder)[1]).attrs)


def last_checkpoint(folder: Path) -> Checkpoint:
    """Return the last checkpoint of a journal whose states are whole, the one before where it has to be.

    A run that was stopped before its first checkpoint goes on from its beginning.

    Raises:
        InputError: there are checkpoints, but from none of them the run can go on.
    """
    layout, identity, _ = described(folder)
    records = RecordFile(folder / RECORDS, layout)
    wrong: list[str] = []
    for name in (CHECKPOINT, BEFORE):
        try:
            found = read_checkpoint(folder / name, identity)
        except FileNotFoundError:
            continue
        except InputError as error:
            wrong.append(str(error))
            continue
        whole = records.whole(found.count)
        if whole < found.count:
            wrong.append(
                f"{records.path} is damaged: of the {found.count} states before {name} {whole} are whole"
            )
            continue
        if wrong:
            doubt = f"{'; '.join(wrong)}: the run went on from the state before, number {found.count}"
            return replace(found, doubt=doubt)
        return found
    if not wrong:
        return Checkpoint(None, 0, {})
    raise InputError(
        f"{'; '.join(wrong)}. There is no other checkpoint from which the run could go on. What is whole of it can be "
        f"read with viscorod.load({str(folder)!r}); begin anew with --anew (anew=True in Python)"
    )


def checkpoint(folder: Path) -> tuple[Any, int, dict[str, Any]]:
    """Return the last checkpoint of a journal: the saved state, the number of states then, and what was said about it.

    Raises:
        InputError: it does not exist, or cannot be read.
    """
    try:
        found = read_checkpoint(folder / CHECKPOINT, None)
    except FileNotFoundError:
        raise InputError(f"{folder} holds no checkpoint: the run stopped before the first one") from None
    return found.state, found.count, dict(found.about)


def contents(folder: Path, count: int | None = None) -> xr.Dataset:
    """Return the data set of a journal as far as its states are whole; of many states, they stay on disk until read.

    Args:
        folder: of the journal.
        count: how many states; None looks how many are whole.

    Raises:
        InputError: nothing was written yet, or something is damaged.
    """
    layout, identity, _ = described(folder)
    records = RecordFile(folder / RECORDS, layout)
    return _of_records(folder, identity, records, records.whole() if count is None else count)[0]


def _of_records(
    folder: Path, identity: bytes, records: RecordFile, count: int
) -> tuple[xr.Dataset, np.ndarray]:
    """Return the data set of so many states, and their records, of which its variables are parts."""
    import xarray as xr

    rows = records.rows(count, in_memory=count * records.layout.dtype.itemsize <= CHUNK)
    variables: dict[str, xr.Variable] = {}
    coordinates: dict[str, xr.Variable] = {}
    for name, told in described(folder)[2].items():
        target = coordinates if told["coordinate"] else variables
        target[name] = xr.Variable(told["dims"], rows[name], told["attrs"])
    return _static(folder, identity).assign(variables).assign_coords(coordinates), rows


def mended(folder: Path) -> list[str]:
    """Make what is damaged of the small files again from their twins; say what was, in sentences.

    Raises:
        InputError: of one of them neither is whole.
    """
    identity = described(folder)[1]
    pairs = (folder / FIELDS, folder / LAYOUT)
    return [told for told in (mend_twins(path, identity) for path in pairs) if told]


def damaged(folder: Path) -> list[str]:
    """Return which of the small files are damaged, so that their twins are read, in sentences."""
    layout = folder / LAYOUT
    found = [read_twins(folder / FIELDS)[2], read_twins(layout, described(folder)[1])[2]]
    return [told for told in found if told]


def described(folder: Path) -> tuple[Layout, bytes, dict[str, Any]]:
    """Return what a record of a journal holds, its identity, and dimensions and attributes of the variables."""
    path = folder / FIELDS
    try:
        if (folder / OVER).exists():  # it is being removed
            raise FileNotFoundError
        content, identity, _ = read_twins(path)
    except FileNotFoundError:
        told = f"is incomplete: {FIELDS} is missing" if holds_run(folder) else "holds no state of a run yet"
        raise InputError(f"{folder} {told}; nothing to read or to go on from") from None
    try:
        told = json.loads(content)
        layout = Layout([(n, t, tuple(shape)) for n, t, shape in told["fields"]], identity)
        variables: dict[str, Any] = told["variables"]
    except (KeyError, TypeError, ValueError):
        layout, variables = Layout([], identity), {}
    if layout.dtype.hasobject or not variables:  # no pointers are read from a file
        raise InputError(f"{path} does not describe plain numbers; run the case again")
    return layout, identity, variables


def _static(folder: Path, identity: bytes) -> xr.Dataset:
    path = folder / LAYOUT
    try:
        content, _, _ = read_twins(path, identity)
    except FileNotFoundError:
        raise InputError(f"{folder} is incomplete: {LAYOUT} is missing") from None
    try:
        return _data_set(content).copy(deep=True)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read ({error})") from None


@lru_cache(maxsize=1)
def _data_set(content: bytes) -> xr.Dataset:
    """Return the data set that a file holds; a run that goes on asks for it several times, which takes the longest."""
    import xarray as xr

    return xr.load_dataset(io.BytesIO(content), engine="h5netcdf")


def complete(
    folder: Path,
    path: Path,
    attrs: Mapping[str, Any] | None = None,
    *,
    keep: bool = False,
    count: int | None = None,
) -> Path:
    """Make the file ``path`` of a journal, with more attributes; memory does not depend on its length.

    The journal is removed unless it is to be kept.

    Args:
        folder: of the journal; path: of the file.
        attrs: attributes beside those that are there.
        keep: leave the journal.
        count: how many states; None takes all.

    Raises:
        InputError: the file cannot be written, or a state is not the one that was written; the journal stays.
    """
    layout, identity, _ = described(folder)
    records = RecordFile(folder / RECORDS, layout)
    count = records.count if count is None else count
    if count > records.count:
        raise InputError(f"{records.path} is damaged: {records.count} of {count} states are there")
    data, rows = _of_records(folder, identity, records, count)
    advice = f"all states stay in {folder}: make room, and go on with: viscorod resume {folder.parent} (resume=True)"
    look = partial(records.require_whole, rows)
    if not isinstance(rows, np.memmap):  # all of them are here already
        look(slice(0, count))
    write(data.assign_attrs(attrs or {}), path, instead=advice, before=look, piece=CHUNK)
    if not keep:
        with suppress(OSError):
            empty(folder)
    return path
