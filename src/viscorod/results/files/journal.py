"""The journal of a run on disk: states are appended as they come, so that memory stays bounded and nothing is lost.

A journal is a folder with

* ``layout.nc``: the data set without its states: coordinates, constants, attributes;
* ``states.bin``: one record of fixed size for every state, in the order of ``states.json``;
* ``checkpoint.npz``: from what the run can go on (see ``solve.transient.saved_state``), with the number of
  states at that time.

A record is complete once it is written: what a killed process or a full disk leaves is a whole number of records
and perhaps a part of one, which is not read. ``layout.nc`` and ``checkpoint.npz`` replace their predecessors at once.
When the run ends, everything becomes one netCDF4 file and the journal is removed.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError, writing
from viscorod.results.files.checksums import FORMAT, seal
from viscorod.results.files.file_tail import write_tail
from viscorod.results.files.storage import read, write

if TYPE_CHECKING:
    import xarray as xr

FOLDER = "run.partial"
"""Name of a journal beside the file ``run.nc`` that it becomes."""

_LAYOUT, _RECORDS, _FIELDS, _CHECKPOINT = "layout.nc", "states.bin", "states.json", "checkpoint.npz"
CHUNK = 16e6
"""Bytes that are copied at once."""
EDITION = 3
"""Edition of saved states, whose parts go by the names of attributes: it grows when one of them changes."""


class Journal:
    """A journal that is being written.

    Args:
        folder: of the journal; it is made.
        along: the dimension of the states, "time".
        keep: go on after so many states of the journal that is there; None begins a new one.

    Raises:
        InputError: the place cannot be written.
    """

    def __init__(self, folder: Path, along: str = "time", keep: int | None = None) -> None:
        self.folder, self.along = folder, along
        self._fields: np.dtype[Any] | None = None
        with writing(folder):
            if keep is None:
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir(parents=True)
                self._file = (folder / _RECORDS).open("wb", buffering=0)
            else:
                self._fields = fields_of(folder)
                os.truncate(folder / _RECORDS, keep * self._fields.itemsize)
                self._file = (folder / _RECORDS).open("ab", buffering=0)
        self.count = keep or 0

    def append(self, data: xr.Dataset) -> None:
        """Append the states of a data set, all of which have the same variables.

        Raises:
            OSError: the disk is full, or gone.
        """
        names = [str(name) for name, variable in data.variables.items() if self.along in variable.dims]
        if self._fields is None:
            self._begin(data, names)
        assert self._fields is not None
        rows = np.empty(data.sizes[self.along], dtype=self._fields)
        for name in names:
            rows[name] = data.variables[name].values
        content = memoryview(rows.tobytes())
        while content:
            content = content[self._file.write(content) :]
        self.count += len(rows)

    def _begin(self, data: xr.Dataset, names: list[str]) -> None:
        first = {name: data.variables[name] for name in names}
        fields = [(name, v.dtype.str, v.shape[1:]) for name, v in first.items()]
        described = {
            name: {"dims": v.dims, "attrs": v.attrs, "coordinate": name in data.coords}
            for name, v in first.items()
        }
        text = json.dumps({"fields": fields, "variables": described}, default=_plain)
        _replace(self.folder / _FIELDS, text.encode())
        self.describe(data)
        self._fields = fields_of(self.folder)

    def describe(self, data: xr.Dataset) -> None:
        """Write the constants and attributes of a data set, its states apart."""
        static = data.drop_vars([str(n) for n, v in data.variables.items() if self.along in v.dims])
        write(static, self.folder / f"new-{_LAYOUT}")
        (self.folder / f"new-{_LAYOUT}").replace(self.folder / _LAYOUT)

    def checkpoint(self, state: Any, about: Mapping[str, Any]) -> None:
        """Write from what the run can go on, after the present number of states; ``about`` goes with it.

        Raises:
            OSError: the disk is full, or gone.
        """
        arrays: dict[str, Any] = {}
        tree = _flattened(state, arrays)
        content = {"edition": EDITION, "tree": tree, "count": self.count, "about": dict(about)}
        text = json.dumps(content, default=_plain)
        os.fsync(self._file.fileno())
        new = self.folder / f"new-{_CHECKPOINT}"
        with new.open("wb") as file:
            np.savez(file, text=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)
        new.replace(self.folder / _CHECKPOINT)

    def close(self) -> None:
        """Write no more; a journal in which no state was written is removed."""
        self._file.close()
        if self._fields is None:
            shutil.rmtree(self.folder, ignore_errors=True)


def fields_of(folder: Path) -> np.dtype[Any]:
    """Return what a record of a journal holds."""
    try:
        fields = np.dtype([(n, t, tuple(shape)) for n, t, shape in _description(folder)["fields"]])
    except (KeyError, TypeError, ValueError):
        fields = np.dtype([])
    if fields.hasobject or not fields.itemsize:  # no pointers are read from a file
        raise InputError(f"{folder / _FIELDS} does not describe plain numbers; run the case again")
    return fields


def _description(folder: Path) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads((folder / _FIELDS).read_text())
    except (OSError, ValueError):
        raise InputError(f"{folder} holds no state of a run yet: nothing to read or to go on from") from None
    return found


def checkpoint(folder: Path) -> tuple[Any, int, dict[str, Any]]:
    """Return the last checkpoint of a journal: the saved state, the number of states then, and what was said about it.

    Raises:
        InputError: it does not exist, or cannot be read.
    """
    path = folder / _CHECKPOINT
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        content = json.loads(arrays.pop("text").tobytes())
        if content.get("edition") != EDITION:
            raise InputError(
                f"{folder}: the run was stopped by another version of viscorod, whose state this one would misread; "
                "go on with that version, or run the case again"
            )
        return _rebuilt(content["tree"], arrays), int(content["count"]), content["about"]
    except FileNotFoundError:
        raise InputError(
            f"{folder} holds no checkpoint: the run stopped before the first one; run it again"
        ) from None
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read ({error}); run the case again") from None


def contents(folder: Path) -> xr.Dataset:
    """Return the data set of a journal as far as it goes; states stay on disk until they are read.

    Raises:
        InputError: nothing was written yet.
    """
    import xarray as xr

    description, fields = _description(folder), fields_of(folder)
    count = (folder / _RECORDS).stat().st_size // fields.itemsize
    data = read(folder / _LAYOUT)
    rows = (
        np.memmap(folder / _RECORDS, dtype=fields, mode="r", shape=(count,)) if count else np.empty(0, fields)
    )
    variables: dict[str, xr.Variable] = {}
    coordinates: dict[str, xr.Variable] = {}
    for name, about in description["variables"].items():
        target = coordinates if about["coordinate"] else variables
        target[name] = xr.Variable(about["dims"], rows[name], about["attrs"])
    return data.assign(variables).assign_coords(coordinates)


def complete(folder: Path, path: Path, attrs: Mapping[str, Any] | None = None, *, keep: bool = False) -> Path:
    """Make the file ``path`` of a journal, with more attributes; memory does not depend on its length.

    The journal is removed unless it is to be kept.

    Raises:
        InputError: the file cannot be written; the journal stays.
    """
    import h5netcdf
    import h5py

    data = contents(folder).assign_attrs(attrs or {})
    along = next(iter(_description(folder)["variables"].values()))["dims"][0]
    row = fields_of(folder).itemsize
    count, step = data.sizes[along], max(1, int(CHUNK // row))
    new = path.with_name(f"new-{path.name}")
    if count <= step:
        write(data.load(), new)
    else:
        first = data.isel({along: slice(0, step)}).load()
        write(first, new, unlimited=along, chunk=step)
        with writing(path), h5netcdf.File(new, "a", libver=FORMAT) as file:
            file.resize_dimension(along, count)
            for begin in range(step, count, step):
                part = slice(begin, min(begin + step, count))
                for name in _description(folder)["variables"]:
                    file.variables[name][part] = data.variables[name][part].values
        with writing(path), h5py.File(new, "r+", libver=FORMAT) as stored:
            seal(stored)
        with writing(path):
            write_tail(new)
    new.replace(path)
    if not keep:
        shutil.rmtree(folder, ignore_errors=True)
    return path


def _replace(path: Path, content: bytes) -> None:
    new = path.with_name(f"new-{path.name}")
    new.write_bytes(content)
    new.replace(path)


def _flattened(tree: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return a tree with the numbers of its arrays in their places; the arrays go into ``arrays``."""
    if isinstance(tree, np.ndarray):
        arrays[f"a{len(arrays)}"] = tree
        return {"array": len(arrays) - 1}
    if isinstance(tree, dict):
        return {"dict": {key: _flattened(item, arrays) for key, item in tree.items()}}
    if isinstance(tree, list):
        return [_flattened(item, arrays) for item in tree]
    return tree


def _rebuilt(tree: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if isinstance(tree, dict):
        if "array" in tree:
            return arrays[f"a{tree['array']}"]
        return {key: _rebuilt(item, arrays) for key, item in tree["dict"].items()}
    return [_rebuilt(item, arrays) for item in tree] if isinstance(tree, list) else tree


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else list(value)
