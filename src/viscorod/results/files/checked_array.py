"""Arrays of a result file that are read when they are asked for, piece by piece, and checked then."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from xarray.backends import BackendArray
from xarray.core import indexing

from viscorod.errors import InputError, reading
from viscorod.results.files.checksums import Sums, checksum
from viscorod.results.files.pieces_of_arrays import piece_shape
from viscorod.results.soundness import require_possible

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["CheckedArray", "OpenFile", "checked"]


class OpenFile:
    """A file that is opened when it is first read, and again in another process."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: Any = None

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path, "_file": None}

    def array(self, name: str) -> Any:
        """Return an array of the file, whose values are not read yet."""
        import h5py

        if self._file is None:
            self._file = h5py.File(self.path, "r")
        return self._file[name]

    def close(self) -> None:
        """Close it; nothing is read from it any more."""
        if self._file is not None:
            self._file.close()


def checked(
    variable: xr.Variable, name: str, group: str | None, source: OpenFile, sums: Mapping[str, Any] | None
) -> xr.Variable:
    """Return a variable of a file whose numbers are read on access, in pieces that are checked; texts are read now."""
    import xarray as xr

    if variable.dtype.kind not in "fiub":
        return xr.Variable(variable.dims, variable.values, variable.attrs)
    where = f"/{group}/{name}" if group else f"/{name}"
    known = sums["values"].get(where) if sums else None
    array = CheckedArray(source, where, variable.shape, variable.dtype, known)
    return xr.Variable(variable.dims, indexing.LazilyIndexedArray(array), variable.attrs)


class CheckedArray(BackendArray):
    """An array of numbers in a file: every piece that is read is compared with its checksum, and looked at.

    Args:
        source: the file; name: of the array in it.
        shape, dtype: of the array as it is given.
        sums: checksums of its pieces, in the order of ``cuts``; None if the file has none.
    """

    def __init__(
        self, source: OpenFile, name: str, shape: tuple[int, ...], dtype: Any, sums: Sums | None
    ) -> None:
        self.source, self.name, self.shape, self.dtype, self.sums = source, name, shape, dtype, sums

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return a part of the array."""
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._part)

    def _part(self, key: tuple[Any, ...]) -> np.ndarray:
        wanted = [np.atleast_1d(np.arange(n)[k]) for n, k in zip(self.shape, key, strict=True)]
        found = np.empty([side.size for side in wanted], dtype=self.dtype)
        with reading(self.source.path, self.name[1:]):
            if found.size:
                self._fill(found, wanted)
        return found[tuple(0 if isinstance(k, int | np.integer) else slice(None) for k in key)]

    def _fill(self, found: np.ndarray, wanted: list[np.ndarray]) -> None:
        stored = self.source.array(self.name)
        piece = stored.chunks or piece_shape(self.shape, stored.dtype.itemsize)
        grid = [-(-size // step) for size, step in zip(self.shape, piece, strict=True)]
        sides = [
            [(number, np.flatnonzero(side // step == number)) for number in np.unique(side // step).tolist()]
            for side, step in zip(wanted, piece, strict=True)
        ]
        for chosen in itertools.product(*sides):
            numbers = tuple(number for number, _ in chosen)
            cut = tuple(
                slice(n * step, min((n + 1) * step, size))
                for n, step, size in zip(numbers, piece, self.shape, strict=True)
            )
            values = stored[cut]
            self._check(values, numbers, grid if stored.chunks else [])
            inside = [side[at] - c.start for side, (_, at), c in zip(wanted, chosen, cut, strict=True)]
            found[_box([at for _, at in chosen])] = values[_box(inside)]

    def _check(self, values: np.ndarray, numbers: tuple[int, ...], grid: list[int]) -> None:
        path = self.source.path
        known = (
            self.sums[int(np.ravel_multi_index(numbers, grid))] if self.sums is not None and grid else None
        )
        if known is not None and checksum(values) != known:
            raise InputError(
                f"{path} is damaged: values of {self.name[1:]} are not those that were written; "
                "take another copy of the file, or compute it again"
            )
        require_possible(self.name.rpartition("/")[2], values, path)


def _box(sides: list[np.ndarray]) -> tuple[Any, ...]:
    """Return an index of a box of an array, by slices where places follow each other."""
    if all(side.size == 1 or (np.diff(side) == 1).all() for side in sides):
        return tuple(slice(int(side[0]), int(side[-1]) + 1) for side in sides)
    return np.ix_(*sides)
