"""Results on disk: one netCDF4 file, written and read through h5netcdf."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.limits import LARGEST_RESULT, MOST_DECLARED
from viscorod.results.files.hdf5_output import Hdf5Output, hdf5_output, uninterrupted
from viscorod.whole_files import make_durable, replacing

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady
    from viscorod.results.sweep_result import Sweep


LARGE = 2.5e8
"""Bytes from which on a file is not read into memory."""
PIECE = 16e6
"""Bytes that are written at once."""
IN_MEMORY = "the result is still in memory: make room, or save it to another place"


def write(
    data: xr.Dataset,
    path: str | Path,
    groups: Mapping[str, xr.Dataset] | None = None,
    *,
    instead: str = IN_MEMORY,
    before: Callable[[slice], None] | None = None,
    piece: float = PIECE,
) -> Path:
    """Write a data set to ``path`` as netCDF4, making its folder; returns the path.

    The file is written beside ``path`` and replaces it when it is whole and on the disk.

    Args:
        data: of the file.
        path: of the file.
        groups: more data sets, by the names of their groups in the file.
        instead: what to do if the place cannot be written.
        before: called with the rows that are written next, of arrays whose rows lie side by side.
        piece: bytes that are written at once.

    Raises:
        InputError: the place cannot be written; what was there is still there.
    """
    path, parts = Path(path), {"": data, **(groups or {})}
    needs = sum(part.nbytes for part in parts.values())
    with replacing(path, needs=needs, instead=instead) as new, hdf5_output(new) as output:
        uninterrupted(partial(_write_parts, output, parts, before, piece), output.abandon)
    make_durable(path.parent)
    return path


def packed(data: xr.Dataset) -> bytes:
    """Return a small data set as the content of a netCDF4 file."""
    file = io.BytesIO()
    uninterrupted(partial(_write_parts, file, {"": data}, None, PIECE), lambda: None)
    return file.getvalue()


def _write_parts(
    output: Hdf5Output | io.BytesIO,
    parts: Mapping[str, xr.Dataset],
    before: Callable[[slice], None] | None,
    piece: float,
) -> None:
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    check = output.require_written if isinstance(output, Hdf5Output) else None
    with h5netcdf.File(output, "w") as file:
        for group, data in parts.items():
            pieces = _Pieces(check, before, piece)
            # results hold no gaps to mark
            encoding: dict[Any, dict[str, Any]] = {name: {"_FillValue": None} for name in data.variables}
            store = H5NetCDFStore(file, group=group, mode="a")
            data.dump_to_store(store, writer=pieces, encoding=encoding)
            pieces.write_rows()


class _Pieces:
    """Writes arrays piece by piece, so that no more than a piece is held beside them.

    Arrays whose rows lie side by side, as those of a journal, are written together at the end, so that they are read
    once.
    """

    def __init__(
        self, check: Callable[[], None] | None, before: Callable[[slice], None] | None, piece: float
    ) -> None:
        self._check, self._before, self._piece = check, before, piece
        self._rows: list[tuple[np.ndarray, Any]] = []

    def add(self, source: np.ndarray, target: Any) -> None:
        """Write an array; xarray calls this for each."""
        if not source.ndim:
            target[...] = source
        elif source.flags.c_contiguous:
            self._write([(source, target)], None)
        else:
            self._rows.append((source, target))

    def write_rows(self) -> None:
        """Write what waits."""
        if self._rows:
            self._write(self._rows, self._before)

    def _write(self, pairs: Sequence[tuple[np.ndarray, Any]], before: Callable[[slice], None] | None) -> None:
        count = len(pairs[0][0])
        step = max(1, int(self._piece * count // max(1, sum(source.nbytes for source, _ in pairs))))
        for begin in range(0, count, step):
            part = slice(begin, min(begin + step, count))
            if before is not None:
                before(part)
            for source, target in pairs:
                target[part] = source[part]
            if self._check is not None:
                self._check()


def read(path: str | Path, group: str | None = None) -> xr.Dataset:
    """Read a data set (that of a group of the file): into memory, or piece by piece on access if it is large.

    Raises:
        InputError: no such file, or not a netCDF4 file.
    """
    import xarray as xr

    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path} is not a file; name a run.nc that viscorod wrote")
    try:
        _require_honest(path)
        if path.stat().st_size > LARGE:
            return xr.open_dataset(path, engine="h5netcdf", group=group, cache=False)
        return xr.load_dataset(path, engine="h5netcdf", group=group)
    except OSError as error:
        raise InputError(
            f"{path} cannot be read as netCDF4 ({error}); name a run.nc that viscorod wrote"
        ) from None


def _require_honest(path: Path) -> None:
    """Refuse a file whose arrays claim to be much larger than the file, before anything is made for them."""
    import h5py

    size = path.stat().st_size

    def judge(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset):
            return
        claimed = math.prod(item.shape or ()) * item.dtype.itemsize
        if claimed > min(LARGEST_RESULT, MOST_DECLARED * size):
            raise InputError(
                f"{path} cannot be trusted: {name} claims {claimed / 1e9:.3g} GB in a file of {size / 1e6:.3g} MB; "
                "name a run.nc that viscorod wrote"
            )

    with h5py.File(path, "r") as file:
        file.visititems(judge)


def load(path: str | Path) -> Run | Equilibrium | Steady | Sweep:
    """Open a saved run, equilibrium, steady rotation or sweep; it answers everything that a fresh one does.

    Args:
        path: a file written by ``save``, by ``viscorod run`` or by ``viscorod sweep``, or the folder of a run. While
            the run has not ended, the folder gives the states so far.

    Raises:
        InputError: no such file, or not a result of viscorod.
    """
    from viscorod.results.files.stopped_run import result_file, stopped_run
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady

    if Path(path).is_dir():
        path = result_file(Path(path))
        if path.is_dir():
            return Run(stopped_run(path))
    data = read(path)
    kinds: dict[str, type[Run | Equilibrium | Steady]] = {
        kind.kind: kind for kind in (Run, Equilibrium, Steady)
    }
    found = str(data.attrs.get("kind", ""))
    if found == "sweep":
        from viscorod.results.sweep_result import Sweep

        return Sweep.of(data, Path(path))
    if found not in kinds:
        raise InputError(f"{path} holds no viscorod result (kind = {found!r}; known: {', '.join(kinds)})")
    return kinds[found](data)
