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

import json
import os
import secrets
from collections.abc import Mapping
from contextlib import suppress
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscorod.results.files.checkpoint_file import packed_checkpoint, plain
from viscorod.results.files.journal_folder import (
    BEFORE,
    CHECKPOINT,
    FIELDS,
    LAYOUT,
    RECORDS,
    empty,
    holds_run,
)
from viscorod.results.files.records import Layout, octets
from viscorod.results.files.sealed_file import IDENTITY, write_sealed, write_twins
from viscorod.results.files.storage import packed
from viscorod.results.files.stored_journal import contents, described
from viscorod.whole_files import make_durable, system_errors

if TYPE_CHECKING:
    import xarray as xr


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
                self._layout, self._identity, _ = described(folder)
                self._file = (folder / RECORDS).open("r+b", buffering=0)
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
            self._file = (self.folder / RECORDS).open("xb", buffering=0)
        return self._file

    def _begin(self, data: xr.Dataset) -> None:
        self._open()
        first = {str(n): v for n, v in data.variables.items() if self.along in v.dims}
        fields = [(name, v.dtype.str, v.shape[1:]) for name, v in first.items()]
        variables = {
            name: {"dims": v.dims, "attrs": v.attrs, "coordinate": name in data.coords}
            for name, v in first.items()
        }
        text = json.dumps({"fields": fields, "variables": variables}, default=plain)
        static = data.drop_vars(list(first))
        write_twins(self.folder / LAYOUT, packed(static), self._identity)
        write_twins(self.folder / FIELDS, text.encode(), self._identity)
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
        before = self.folder / BEFORE if self.count > self._checked else None
        write_sealed(self.folder / CHECKPOINT, content, self._identity, before)
        self._checked = self.count
        make_durable(self.folder)

    def contents(self) -> xr.Dataset:
        """Return the data set of all states so far."""
        return contents(self.folder, self.count)

    def forget_last_checkpoint(self) -> None:
        """Remove the last checkpoint, which is damaged, so that it does not take the place of the one before."""
        (self.folder / CHECKPOINT).unlink(missing_ok=True)

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
