"""Regions of a zarr store of members: blocks of results that whoever has a worker writes, each into pieces of its own.

The store is laid out once, for all members, with the first block in it. A region is a block of members that lie in the
same pieces of every array, so that those who write regions share nothing.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.packed_results import PackedResult
from viscorod.results.files.storage import result_of
from viscorod.results.stacked_members import plain
from viscorod.results.sweep_members import opened

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.sweep_members import Stored

__all__ = ["APART", "TABLE", "Region", "RegionWork", "begin", "data_of", "quiet", "require_zarr"]

TABLE = "sweep.parquet"
APART = "apart"
_MISSING = "zarr stores need zarr, which is not there; type: pip install 'viscorod[store]'"


class Region(NamedTuple):
    """A block of members that is written by one.

    Attributes:
        members: numbers and where their results are; row: of the first in the arrays, None if each is a file apart.
    """

    members: tuple[tuple[int, Stored], ...]
    row: int | None

    @property
    def on_disk(self) -> bool:
        """Whether another process reads the results by itself."""
        return all(isinstance(stored, PackedResult | Path) for _, stored in self.members)


@dataclass(frozen=True)
class RegionWork:
    """Writes regions of a store.

    Attributes:
        folder: of the store.
        arrays: names of those along the members.
        common: attributes of the first result.
    """

    folder: Path
    arrays: tuple[str, ...]
    common: Mapping[str, Any]

    def __call__(self, region: Region) -> list[str]:
        """Write a region; returns of every member the attributes in which it differs, as JSON; null where it has none.

        Raises:
            InputError: a result cannot be read; OSError: the region cannot be written.
        """
        results = [data_of(stored) for _, stored in region.members]
        if region.row is None:
            for (number, _), data in zip(region.members, results, strict=True):
                result_of(data, self.folder).save(self.folder / APART / f"{number}.nc")
        else:
            self._write(results, region.row)
        return [self.changed(data) for data in results]

    def changed(self, data: xr.Dataset) -> str:
        """Return the attributes in which a result differs, as JSON; null where it has none."""
        found = {key: value for key, value in data.attrs.items() if self.common.get(key, self) != value}
        return json.dumps(found | {key: None for key in self.common if key not in data.attrs}, default=plain)

    def _write(self, results: Sequence[xr.Dataset], row: int) -> None:
        import zarr

        for name in self.arrays:
            # a piece that is missing is told when the store is read, so one of zeros is written, too
            array: Any = zarr.open_array(
                self.folder, path=name, mode="r+", config={"write_empty_chunks": True}
            )
            array[row : row + len(results)] = np.stack([data.variables[name].values for data in results])


def begin(folder: Path, first: Sequence[xr.Dataset], numbers: Sequence[int], size: int) -> tuple[str, ...]:
    """Lay out a store with its first region; returns the names of the arrays along the members.

    Args:
        folder: of the store; first: results of its first region.
        numbers: of all members that it is to have; size: members of a region.
    """
    import xarray as xr
    import zarr

    data = first[0]
    variables: dict[Any, Any] = {"member": ("member", list(numbers[: len(first)]))}
    encoding: dict[Any, Any] = {"member": {"chunks": (len(numbers),)}}
    for name, variable in data.variables.items():
        if _alike(data, name):
            variables[name] = (variable.dims, variable.values, variable.attrs)
            encoding[name] = {"_FillValue": None}
            continue
        values = np.stack([one.variables[name].values for one in first])
        variables[name] = (("member", *variable.dims), values, variable.attrs)
        pieces = {"chunks": (size, *values.shape[1:]), "compressors": _compressors()}
        encoding[name] = {"_FillValue": None, **pieces}  # results hold no gaps to mark
    laid = xr.Dataset(variables).set_coords([name for name in data.coords if name in variables])
    with quiet():
        laid.to_zarr(
            folder, mode="a", zarr_format=3, encoding=encoding, consolidated=False, write_empty_chunks=True
        )
        along = [str(name) for name, variable in laid.variables.items() if variable.dims[:1] == ("member",)]
        for name in along:
            array: Any = zarr.open_array(folder, path=name, mode="r+")
            array.resize((len(numbers), *array.shape[1:]))
            if name == "member":
                array[:] = np.asarray(numbers)
    return tuple(name for name in along if name != "member")


def data_of(stored: Stored) -> xr.Dataset:
    """Return the data set of a result, from where it is."""
    if isinstance(stored, PackedResult):
        return stored.data()
    result = opened(stored)
    assert result is not None
    return result.data


def _alike(data: xr.Dataset, name: Any) -> bool:
    """Return whether a variable is the same in all results that are stacked: axes and words are."""
    return name in data.dims or data.variables[name].dtype.kind not in "fiub"


def require_zarr() -> None:
    """Refuse stores where zarr is not installed.

    Raises:
        InputError: it is not.
    """
    if find_spec("zarr") is None:
        raise InputError(_MISSING)


def _compressors() -> list[Any]:
    from zarr.codecs import BloscCodec, Crc32cCodec

    return [BloscCodec(cname="zstd", clevel=1, shuffle="shuffle"), Crc32cCodec()]


@contextmanager
def quiet() -> Iterator[None]:
    """Leave out what zarr says of texts, whose form its third version has not settled yet."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
