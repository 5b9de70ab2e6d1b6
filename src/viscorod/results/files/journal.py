"""The journal of a run on disk: states are appended as they come, so that memory stays bounded and nothing is lost.

A journal is a folder with

* ``layout.nc``: the data set without its states: coordinates, constants, attributes;
* ``states.bin``: one record of fixed size for every state, in the order of ``states.json``;
* ``layout.twin.nc`` and ``states.twin.json``: the two small files once more, since nothing can be read without them;
* ``checkpoint.npz``: from what the run can go on (see ``solve.transient.saved_state``), with the number of
  states at that time, and ``before.npz``, the checkpoint before it;
* ``lock``: locked while a run writes here (see ``folder_lock``).

Everything carries checksums and the identity of the journal: what is not as it was written is not read. A record is
written at its place in one go; what a killed process or a full disk leaves behind the last whole one is written again.
The other files replace their predecessors at once. When the run ends, everything becomes one netCDF4 file and the
journal is removed.
"""

from __future__ import annotations

import io
import json
import os
import secrets
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.checkpoint_file import Checkpoint, packed_checkpoint, plain, read_checkpoint
from viscorod.results.files.records import Layout, RecordFile, octets
from viscorod.results.files.sealed_file import (
    IDENTITY,
    mend_twins,
    read_twins,
    twin,
    write_sealed,
    write_twins,
)
from viscorod.results.files.storage import packed, write
from viscorod.whole_files import make_durable, system_errors

if TYPE_CHECKING:
    import xarray as xr

FOLDER = "run.partial"
"""Name of a journal beside the file ``run.nc`` that it becomes."""
LOCK = "lock"
"""Name of the file in it that is locked."""

_LAYOUT, _RECORDS, _FIELDS = "layout.nc", "states.bin", "states.json"
_CHECKPOINT, _BEFORE = "checkpoint.npz", "before.npz"
_OVER = "over.json"  # what states.json becomes before a journal is removed
CHUNK = 16e6
"""Bytes of states that are in memory at once."""


class Journal:
    """A journal that is being written.

    Args:
        folder: of the journal; it is made.
        along: the dimension of the states, "time".
        keep: go on after so many states of the journal that is there; None begins a new one, which takes the place of
            another that was stopped there with its first state.

    Attributes:
        count: states so far; the next ones get the numbers from there on.

    Raises:
        InputError: the place cannot be written.
    """

    def __init__(self, folder: Path, along: str = "time", keep: int | None = None) -> None:
        self.folder, self.along = folder, along
        self._layout: Layout | None = None
        self._file: FileIO | None = None
        with system_errors(folder):
            if keep is None:
                folder.mkdir(parents=True, exist_ok=True)
                self._identity = secrets.token_bytes(IDENTITY)
                if not holds_run(folder):
                    self._open()
            else:
                self._layout, self._identity, _ = _described(folder)
                self._file = (folder / _RECORDS).open("r+b", buffering=0)
        self.count = self._checked = keep or 0

    def append(self, data: xr.Dataset) -> None:
        """Append the states of a data set, all of which have the same variables.

        Raises:
            OSError: the disk is full, or gone.
        """
        if self._layout is None:
            self._begin(data)
        assert self._layout is not None
        rows = self._layout.records(data, self.count)
        content = octets(rows)
        file = self._open()
        file.seek(self.count * self._layout.dtype.itemsize)
        while content:
            content = content[file.write(content) :]
        self.count += len(rows)

    def _open(self) -> FileIO:
        """Return the file of states; a run that was stopped here is removed when that of another one is made."""
        if self._file is None:
            empty(self.folder)
            self._file = (self.folder / _RECORDS).open("xb", buffering=0)
        return self._file

    def _begin(self, data: xr.Dataset) -> None:
        self._open()
        first = {str(n): v for n, v in data.variables.items() if self.along in v.dims}
        fields = [(name, v.dtype.str, v.shape[1:]) for name, v in first.items()]
        described = {
            name: {"dims": v.dims, "attrs": v.attrs, "coordinate": name in data.coords}
            for name, v in first.items()
        }
        text = json.dumps({"fields": fields, "variables": described}, default=plain)
        static = data.drop_vars(list(first))
        write_twins(self.folder / _LAYOUT, packed(static), self._identity)
        write_twins(self.folder / _FIELDS, text.encode(), self._identity)
        for folder in (
            self.folder,
            *self.folder.absolute().parents[:2],
        ):  # which may have been made for this run
            make_durable(folder)
        self._layout = Layout(fields, self._identity)

    def checkpoint(self, state: Any, about: Mapping[str, Any]) -> None:
        """Write from what the run can go on, after the present number of states; ``about`` goes with it.

        Raises:
            OSError: the disk is full, or gone.
        """
        os.fsync(self._open().fileno())  # the states that it counts are on the disk before it is
        content = packed_checkpoint(state, self.count, about)
        before = self.folder / _BEFORE if self.count > self._checked else None
        write_sealed(self.folder / _CHECKPOINT, content, self._identity, before)
        self._checked = self.count
        make_durable(self.folder)

    def contents(self) -> xr.Dataset:
        """Return the data set of all states so far."""
        return contents(self.folder, self.count)

    def forget_last_checkpoint(self) -> None:
        """Remove the last checkpoint, which is damaged, so that it does not take the place of the one before."""
        (self.folder / _CHECKPOINT).unlink(missing_ok=True)

    def remove(self) -> None:
        """Write no more, and remove what is there, be it of a run that was stopped here before."""
        if self._file is not None:
            self._file.close()
        with suppress(OSError):
            empty(self.folder)

    def close(self) -> None:
        """Write no more; a journal in which no state was written is removed."""
        if self._file is not None:
            self._file.close()
            if self._layout is None:
                empty(self.folder)


def empty(folder: Path) -> None:
    """Remove what is in the folder of a journal, but its lock; from the first moment on it holds no run.

    Raises:
        OSError: something cannot be removed.
    """
    over = folder / _OVER
    for name in (_FIELDS, twin(folder / _FIELDS).name):  # of which one may be missing
        with suppress(FileNotFoundError):
            (folder / name).replace(over)
    for path in folder.iterdir():
        if path.name not in (LOCK, _OVER):
            path.unlink()
    over.unlink(missing_ok=True)


def holds_run(folder: Path) -> bool:
    """Return whether the folder of a journal holds states, or what is left of them."""
    if not folder.is_dir():
        return False
    there = {path.name for path in folder.iterdir()}
    described = {_FIELDS, twin(folder / _FIELDS).name, _LAYOUT, twin(folder / _LAYOUT).name}
    begun = there & (described | {_CHECKPOINT, _BEFORE})
    states = folder / _RECORDS
    return _OVER not in there and bool(begun or (_RECORDS in there and states.stat().st_size))


# --- reading


def about(folder: Path) -> dict[str, Any]:
    """Return the attributes of the run in a journal, as they were when it began.

    Raises:
        InputError: there is none, or it is damaged.
    """
    return dict(_static(folder, _described(folder)[1]).attrs)


def last_checkpoint(folder: Path) -> Checkpoint:
    """Return the last checkpoint of a journal whose states are whole, the one before where it has to be.

    A run that was stopped before its first checkpoint goes on from its beginning.

    Raises:
        InputError: there are checkpoints, but from none of them the run can go on.
    """
    layout, identity, _ = _described(folder)
    records = RecordFile(folder / _RECORDS, layout)
    wrong: list[str] = []
    for name in (_CHECKPOINT, _BEFORE):
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
        found = read_checkpoint(folder / _CHECKPOINT, None)
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
    layout, identity, _ = _described(folder)
    records = RecordFile(folder / _RECORDS, layout)
    return _of_records(folder, identity, records, records.whole() if count is None else count)[0]


def _of_records(
    folder: Path, identity: bytes, records: RecordFile, count: int
) -> tuple[xr.Dataset, np.ndarray]:
    """Return the data set of so many states, and their records, of which its variables are parts."""
    import xarray as xr

    rows = records.rows(count, in_memory=count * records.layout.dtype.itemsize <= CHUNK)
    variables: dict[str, xr.Variable] = {}
    coordinates: dict[str, xr.Variable] = {}
    for name, told in _described(folder)[2].items():
        target = coordinates if told["coordinate"] else variables
        target[name] = xr.Variable(told["dims"], rows[name], told["attrs"])
    return _static(folder, identity).assign(variables).assign_coords(coordinates), rows


def mended(folder: Path) -> list[str]:
    """Make what is damaged of the small files again from their twins; say what was, in sentences.

    Raises:
        InputError: of one of them neither is whole.
    """
    identity = _described(folder)[1]
    pairs = (folder / _FIELDS, folder / _LAYOUT)
    return [told for told in (mend_twins(path, identity) for path in pairs) if told]


def damaged(folder: Path) -> list[str]:
    """Return which of the small files are damaged, so that their twins are read, in sentences."""
    layout = folder / _LAYOUT
    found = [read_twins(folder / _FIELDS)[2], read_twins(layout, _described(folder)[1])[2]]
    return [told for told in found if told]


def _described(folder: Path) -> tuple[Layout, bytes, dict[str, Any]]:
    """Return what a record of a journal holds, its identity, and dimensions and attributes of the variables."""
    path = folder / _FIELDS
    try:
        if (folder / _OVER).exists():  # it is being removed
            raise FileNotFoundError
        content, identity, _ = read_twins(path)
    except FileNotFoundError:
        told = f"is incomplete: {_FIELDS} is missing" if holds_run(folder) else "holds no state of a run yet"
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
    import xarray as xr

    path = folder / _LAYOUT
    try:
        content, _, _ = read_twins(path, identity)
    except FileNotFoundError:
        raise InputError(f"{folder} is incomplete: {_LAYOUT} is missing") from None
    try:
        return xr.load_dataset(io.BytesIO(content), engine="h5netcdf")
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read ({error})") from None


# --- the end


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
    layout, identity, _ = _described(folder)
    records = RecordFile(folder / _RECORDS, layout)
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
