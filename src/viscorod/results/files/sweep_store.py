"""A large sweep with its whole results: one zarr store with a dimension ``member``, and its table beside the arrays.

Members are written block by block, so that no more than a block of them is in memory, and read when they are asked
for. Pieces of the arrays hold a block of members each, with a checksum. Results that differ from the first one in more
than numbers, and those of members that failed, are netCDF files in ``apart``.
"""

from __future__ import annotations

import json
import secrets
import shutil
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError, let_interrupts_through
from viscorod.results.files.parquet import read_parquet
from viscorod.results.files.storage import result_of
from viscorod.results.files.sweep_table import ATTRIBUTES, sweep_of_table, write_table
from viscorod.results.stacked_members import difference, plain
from viscorod.results.sweep_members import COMPLETED
from viscorod.whole_files import system_errors

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.any_result import AnyResult
    from viscorod.results.sweep_result import Sweep

__all__ = ["TABLE", "read_store", "write_store"]

TABLE = "sweep.parquet"
APART = "apart"
BLOCK, MEMBERS = 6.4e7, 64
"""Bytes of the members that are written at once, and how many these are at most."""
_MISSING = "zarr stores need zarr, which is not there; type: pip install 'viscorod[store]'"


def write_store(sweep: Sweep, path: str | Path) -> Path:
    """Write a sweep with its whole results as a zarr store, which replaces ``path`` when it is whole.

    Raises:
        InputError: zarr or pyarrow are not installed, or the place cannot be written or holds something else.
    """
    _require_zarr()
    path = Path(path)
    if path.exists() and not (path / TABLE).is_file():
        raise InputError(f"{path} is there and is no store of a sweep; name another place")
    new = path.with_name(f"new-{secrets.token_hex(4)}.zarr")
    with system_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            _write(sweep, new)
            _replace(path, new)
        except BaseException:
            shutil.rmtree(new, ignore_errors=True)
            raise
    return path


def _replace(path: Path, new: Path) -> None:
    """Put a folder in the place of another, if there is one; what comes between leaves the earlier one there."""
    if not path.exists():
        new.rename(path)
        return
    old = path.with_name(f"old-{new.name}")
    try:
        path.rename(old)
        new.rename(path)
    except BaseException:
        if old.exists() and not path.exists():
            old.rename(path)
        raise
    shutil.rmtree(old)


def _write(sweep: Sweep, folder: Path) -> None:
    stack = _Stack(folder)
    separate = ""
    attributes: list[str | None] = []
    for k in range(len(sweep.members)):
        result = sweep.members.result(k)
        if result is None:
            attributes.append(None)
            continue
        data, completed = result.data, sweep.members.found[k][2] == COMPLETED
        differs = stack.differs(data) if completed else "it failed"
        if differs:
            result.save(folder / APART / f"{k}.nc")
            separate = separate or (differs if completed else "")
        else:
            stack.add(k, data)
        attributes.append(stack.attributes_of(data))
    stack.write()
    about = {"attributes": stack.common, "stacked": stack.numbers, "separate": separate}
    write_table(sweep, folder / TABLE, {ATTRIBUTES: attributes}, json.loads(json.dumps(about, default=plain)))


class _Stack:
    """Writes results that differ in numbers only, a block at a time.

    Attributes:
        numbers: of the members that are in it.
        common: attributes of the first one.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._first: xr.Dataset | None = None
        self._block: list[tuple[int, xr.Dataset]] = []
        self._size = 1
        self.numbers: list[int] = []
        self.common: dict[str, Any] = {}

    def differs(self, data: xr.Dataset) -> str:
        """Say what keeps a result from being stacked on the first; empty if nothing does."""
        return "" if self._first is None else difference(self._first, data)

    def attributes_of(self, data: xr.Dataset) -> str:
        """Return the attributes in which a result differs from the first, as JSON; null where it has none."""
        changed: dict[str, Any] = {
            key: value
            for key, value in data.attrs.items()
            if key not in self.common or self.common[key] != value
        }
        return json.dumps(
            changed | {key: None for key in self.common if key not in data.attrs}, default=plain
        )

    def add(self, number: int, data: xr.Dataset) -> None:
        """Take a result."""
        if self._first is None:
            self._first, self.common = data, dict(data.attrs)
            self._size = max(1, min(MEMBERS, int(BLOCK // max(1, data.nbytes))))
        self._block.append((number, data))
        self.numbers.append(number)
        if len(self._block) == self._size:
            self.write()

    def write(self) -> None:
        """Write the results that wait."""
        import xarray as xr

        if self._first is None or not self._block:
            return
        first = len(self.numbers) == len(self._block)
        variables: dict[Any, Any] = {"member": ("member", [number for number, _ in self._block])}
        encoding: dict[Any, Any] = {}
        for name, variable in self._first.variables.items():
            if _alike(self._first, name):
                if first:
                    variables[name] = (variable.dims, variable.values, variable.attrs)
                    encoding[name] = {"_FillValue": None}
                continue
            values = np.stack([data.variables[name].values for _, data in self._block])
            variables[name] = (("member", *variable.dims), values, variable.attrs)
            pieces = {"chunks": (self._size, *values.shape[1:]), "compressors": _compressors()}
            encoding[name] = {"_FillValue": None, **pieces}  # results hold no gaps to mark
        stored = xr.Dataset(variables).set_coords([name for name in self._first.coords if name in variables])
        with _quiet():
            how: Any = (
                {"mode": "a", "zarr_format": 3, "encoding": encoding} if first else {"append_dim": "member"}
            )
            stored.to_zarr(self._folder, consolidated=False, write_empty_chunks=True, **how)
        self._block = []


def _alike(data: xr.Dataset, name: Any) -> bool:
    """Return whether a variable is the same in all results that are stacked: axes and words are."""
    return name in data.dims or data.variables[name].dtype.kind not in "fiub"


def read_store(path: str | Path) -> Sweep:
    """Return the sweep of a store; whole results are read when they are asked for.

    Raises:
        InputError: zarr or pyarrow are not installed, or the store is damaged.
    """
    _require_zarr()
    path = Path(path)
    table, about = read_parquet(path / TABLE)
    given = table[ATTRIBUTES].tolist() if ATTRIBUTES in table else [None] * len(table)
    fields = _Fields(path, about)

    def stored(number: int) -> _Stored | None:
        changed = given[number]
        return None if changed is None else _Stored(fields, number, changed)

    sweep = sweep_of_table(table, about, path / TABLE, stored)
    sweep.members.stack = fields
    return sweep


class _Fields:
    """The arrays of a store.

    Attributes:
        separate: what keeps completed members from being one data set; empty if nothing does.
    """

    def __init__(self, path: Path, about: Mapping[str, Any]) -> None:
        self.path = path
        self.separate = str(about.get("separate", ""))
        self._common = dict(about.get("attributes", {}))
        self.rows = {int(number): row for row, number in enumerate(about.get("stacked", []))}
        self._data: xr.Dataset | None = None
        self._block: tuple[int, xr.Dataset] | None = None

    @property
    def data(self) -> xr.Dataset:
        """All of them, read on access.

        Raises:
            InputError: pieces of them are missing, or it cannot be read.
        """
        import xarray as xr

        if self._data is None:
            with _unreadable(self.path), _quiet():
                self._require_whole()
                found = xr.open_zarr(
                    self.path, chunks=None, consolidated=False, mask_and_scale=False, decode_times=False
                )
                words = {
                    name: found[name].astype(str)
                    for name in found.variables
                    if found[name].dtype.kind in "OT"
                }
                self._data = found.assign(
                    {k: v for k, v in words.items() if k not in found.coords}
                ).assign_coords({k: v for k, v in words.items() if k in found.coords})
        return self._data

    def _require_whole(self) -> None:
        """Refuse a store of which pieces are missing: zarr would read them as zeros."""
        import zarr

        for name, array in zarr.open_group(self.path, mode="r").arrays():
            if array.nchunks_initialized < array.nchunks:
                raise InputError(
                    f"{self.path} is damaged: {array.nchunks - array.nchunks_initialized} of {array.nchunks} pieces "
                    f"of {name} are missing; take another copy of it"
                )

    def result(self, number: int, attributes: str) -> AnyResult:
        """Return the whole result of a member."""
        changed = json.loads(attributes)
        with _unreadable(self.path):
            first, block = self._block_of(self.rows[number])
            whole = block.isel(member=self.rows[number] - first).drop_vars("member").copy(deep=True)
        whole.attrs = {k: v for k, v in (self._common | changed).items() if v is not None}
        return result_of(whole, self.path)

    def _block_of(self, row: int) -> tuple[int, xr.Dataset]:
        """Return the members that lie in one piece with that of a row, and the first row of these; the last is kept."""
        arrays = [v for v in self.data.variables.values() if v.ndim > 1 and v.dims[0] == "member"]
        size = max((int(v.encoding["chunks"][0]) for v in arrays), default=1)
        first = row - row % size
        if self._block is None or self._block[0] != first:
            self._block = None  # one is in memory at a time
            self._block = first, self.data.isel(member=slice(first, first + size)).load()
        return self._block

    def parts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return variables and coordinates of all members, read on access."""
        data = self.data
        return (
            {str(name): data[name].variable for name in data.data_vars},
            {str(name): data[name].variable for name in data.coords if name != "member"},
        )


class _Stored:
    """The whole result of one member, where it lies."""

    def __init__(self, fields: _Fields, number: int, attributes: str) -> None:
        self._fields, self._number, self._attributes = fields, number, attributes

    def __call__(self) -> AnyResult:
        """Read it."""
        if self._number in self._fields.rows:
            return self._fields.result(self._number, self._attributes)
        from viscorod.results.files.storage import load

        found: AnyResult = load(self._fields.path / APART / f"{self._number}.nc")
        return found


def _require_zarr() -> None:
    if find_spec("zarr") is None:
        raise InputError(_MISSING)


def _compressors() -> list[Any]:
    from zarr.codecs import BloscCodec, Crc32cCodec

    return [BloscCodec(cname="zstd", clevel=1, shuffle="shuffle"), Crc32cCodec()]


@contextmanager
def _quiet() -> Iterator[None]:
    """Leave out what zarr says of texts, whose form its third version has not settled yet."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def _unreadable(path: Path) -> Iterator[None]:
    """Turn what libraries say of a damaged store into one message."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # a damaged store brings out errors of every kind
        let_interrupts_through(error)
        why = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(f"{path} is damaged ({why}); take another copy of it") from None
