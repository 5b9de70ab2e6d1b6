"""A sweep read from the zarr store of its members: arrays and whole results when they are asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscorod.errors import InputError, let_interrupts_through
from viscorod.results.files.parquet import read_parquet
from viscorod.results.files.storage import result_of
from viscorod.results.files.store_regions import APART, TABLE, quiet, require_zarr
from viscorod.results.files.sweep_table import ATTRIBUTES, sweep_of_table

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.any_result import AnyResult
    from viscorod.results.sweep_result import Sweep

__all__ = ["read_store"]


def read_store(path: str | Path) -> Sweep:
    """Return the sweep of a store; whole results are read when they are asked for.

    Raises:
        InputError: zarr or pyarrow are not installed, or the store is damaged.
    """
    require_zarr()
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
            with _unreadable(self.path), quiet():
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
