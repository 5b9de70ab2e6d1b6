"""Results on disk: one netCDF4 file, written and read through h5netcdf."""

from __future__ import annotations

import io
import zlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np

from viscorod.checks import checked
from viscorod.errors import InputError, reading
from viscorod.results.files.checksums import FORMAT, require_unchanged, seal, stored_sums
from viscorod.results.files.checksums import NAME as CHECKSUMS
from viscorod.results.files.file_tail import require_tail_fits, write_tail
from viscorod.results.files.hdf5_output import Hdf5Output, hdf5_output, uninterrupted
from viscorod.results.files.netcdf_arrays import write_arrays
from viscorod.results.files.pieces_of_arrays import piece_shape
from viscorod.results.files.plain_file import require_levels_readable, require_plain, require_written
from viscorod.results.state_arrays import PlainArray, StateArrays, Stored
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.any_result import AnyResult
    from viscorod.results.sweep_result import Sweep


R = TypeVar("R")

LARGE = 2.5e8
"""Bytes from which on a file is not read into memory."""
PIECE = 16e6
"""Bytes that are written at once."""
SAMPLED, WORTH = 16_384, 0.75
"""Bytes of an array that are compressed to see whether it pays, and what they must shrink to."""
_TABLE = "Tables are written by pandas: table() of sweeps, probe(...).to_dataframe() of runs, then to_csv or to_excel"
_PICTURE = "Pictures are written by the methods plot..., such as plot(path)"
OTHERS = (
    dict.fromkeys((".csv", ".tsv", ".txt", ".xlsx", ".json"), _TABLE)
    | dict.fromkeys((".png", ".pdf", ".svg", ".jpg"), _PICTURE)
    | dict.fromkeys((".vtk", ".vtu", ".vtkhdf"), "ParaView reads what save_paraview writes")
    | dict.fromkeys((".mat", ".npz"), "xarray.open_dataset reads it; linear systems alone are saved so")
    | {".parquet": "Sweeps alone are saved as Parquet", ".zarr": "Sweeps alone are saved as stores"}
)
"""Suffixes of other formats, and what writes these."""
IN_MEMORY = "the result is still in memory: make room, or save it to another place"


def write(
    data: Stored,
    path: str | Path,
    groups: Mapping[str, xr.Dataset] | None = None,
    *,
    instead: str = IN_MEMORY,
    before: Callable[[slice], None] | None = None,
    piece: float = PIECE,
) -> Path:
    """Write a data set, or the arrays of one, to ``path`` as netCDF4, making its folder; returns the path.

    The file is written beside ``path`` and replaces it when it is whole and on the disk. Every piece of an array has a
    checksum, and the file those of all (see ``checksums`` and ``file_tail``).

    Args:
        data: of the file.
        path: of the file.
        groups: more data sets, by the names of their groups in the file.
        instead: what to do if the place cannot be written.
        before: called with the rows that are written next, of arrays whose rows lie side by side.
        piece: bytes that are written at once.

    Raises:
        InputError: the place cannot be written, or its name is that of another format; what was there is still there.
    """
    path = Path(path)
    parts: dict[str, Stored] = {"": data, **(groups or {})}
    if path.suffix.lower() in OTHERS:
        raise InputError(
            f"{path}: a result is saved as netCDF4, in one file with all of its numbers; end the name in .nc. "
            f"{OTHERS[path.suffix.lower()]}"
        )
    needs = sum(part.nbytes for part in parts.values())
    with replacing(path, needs=needs, instead=instead) as new:
        with hdf5_output(new) as output:
            uninterrupted(partial(_write_parts, output, parts, before, piece), output.abandon)
        if new.is_file():  # and no device
            write_tail(new)
    return path


def packed(data: xr.Dataset) -> bytes:
    """Return a small data set as the content of a netCDF4 file, without checksums."""
    file = io.BytesIO()
    uninterrupted(partial(_write_parts, file, {"": data}, None, PIECE), lambda: None)
    return file.getvalue()


def _write_parts(
    output: Hdf5Output | io.BytesIO,
    parts: Mapping[str, Stored],
    before: Callable[[slice], None] | None,
    piece: float,
) -> None:
    import h5netcdf

    from viscorod.results.files.known_items import FileOfKnownItems

    check = output.require_written if isinstance(output, Hdf5Output) else None
    with FileOfKnownItems(output, "w", libver=FORMAT, track_order=True) as stored:
        with h5netcdf.File(stored, "w") as file:
            for group, data in parts.items():
                pieces = _Pieces(check, before, piece)
                if isinstance(data, StateArrays):
                    write_arrays(file, data, _stored_as(data), pieces.add)
                else:
                    _write_data_set(file, data, group, pieces)
                pieces.write_rows()
        stored.forget()
        if check is not None:
            check()
            seal(stored)


def _write_data_set(file: Any, data: xr.Dataset, group: str, pieces: _Pieces) -> None:
    """Write a data set, in which a user may have put whatever xarray knows to store, into an open file."""
    from xarray.backends import H5NetCDFStore

    encoding = {
        name: {"chunksizes" if key == "chunks" else key: value for key, value in how.items()}
        | {"_FillValue": None}  # results hold no gaps to mark
        for name, how in _stored_as(data).items()
    }
    store = H5NetCDFStore(file, group=group or None, mode="a")
    data.dump_to_store(store, writer=pieces, encoding=encoding)


def _stored_as(data: Stored) -> dict[Any, dict[str, Any]]:
    """Return how the variables of a data set are stored: numbers in pieces, each with a checksum."""
    found: dict[Any, dict[str, Any]] = {}
    for name, variable in data.variables.items():
        found[name] = {}
        if variable.size and variable.ndim and variable.dtype.kind in "fiub":
            piece = piece_shape(variable.shape, variable.dtype.itemsize)
            found[name] |= {"chunks": piece, "fletcher32": True}
            if _pays(variable):
                found[name] |= {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    return found


def _pays(variable: xr.Variable | PlainArray) -> bool:
    """Return whether compression makes a variable a quarter smaller or more, as a sample of its middle does.

    The last digits of computed numbers are noise that nothing compresses; what stays zero or repeats is compressed.
    """
    count = variable.shape[0]
    if variable.nbytes < SAMPLED:
        return False
    rows = max(1, SAMPLED * count // variable.nbytes)
    middle = max(0, (count - rows) // 2)
    part = variable.isel({str(variable.dims[0]): slice(middle, middle + rows)})
    sample = np.ascontiguousarray(part.values)
    shuffled = sample.view(np.uint8).reshape(-1, sample.dtype.itemsize).T.tobytes()
    return len(zlib.compress(shuffled, 1)) < WORTH * len(shuffled)


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
        """Write an array: called for each."""
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

    What is damaged is refused when it is read, which for all but the numbers of a large file is now.

    Raises:
        InputError: no such file, not a netCDF4 file, or a damaged one.
    """
    import h5netcdf
    import xarray as xr
    from xarray.backends import H5NetCDFStore

    from viscorod.results.files.checked_array import OpenFile, checked
    from viscorod.results.files.known_items import FileOfKnownItems

    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path} is not a file; name a run.nc that viscorod wrote")
    with reading(path):
        require_tail_fits(path)
        with FileOfKnownItems(path, "r") as file:
            size = require_plain(file, path)
            require_written(file, path)
            sums = stored_sums(file)
            if sums is not None:
                require_unchanged(file, sums, path)
            require_levels_readable(file if group is None else file[group], path)
            store = H5NetCDFStore(h5netcdf.File(file, "r", decode_vlen_strings=True), group=group or "/")
            # numbers stand as they are: nothing in the file may scale them, or call them gaps or dates
            found = xr.open_dataset(store, cache=False, mask_and_scale=False, decode_times=False)
            source = OpenFile(path)
            variables = {
                name: checked(variable, str(name), group, source, sums)
                for name, variable in found.variables.items()
            }
            coordinates = {name: variables.pop(name) for name in found.coords}
            attrs = {name: value for name, value in found.attrs.items() if name != CHECKSUMS}
            data = xr.Dataset(variables, coordinates, attrs)
        if size <= LARGE:
            data.load()
            source.close()
    return data


@overload
def load(path: str | Path) -> Any: ...


@overload
def load(path: str | Path, expected: type[R]) -> R: ...


@checked
def load(path: str | Path, expected: type[R] | None = None) -> Any:
    """Open a saved result: of a motion, an equilibrium, a steady rotation, modes, a response, a sweep, and all others.

    It answers everything that a fresh one does.

    Args:
        path: a file written by ``save``, by ``viscorod run`` or by ``viscorod sweep``, the folder of a run or of a
            sweep, or the zarr store of one. While that has not ended, the folder gives the states or members so far.
        expected: class of the result, such as ``viscorod.Run``; anything else is refused, and type checkers know it.

    Raises:
        InputError: no such file, not a result of viscorod, or one of another kind.
    """
    found = _opened(path)
    if expected is not None and not isinstance(found, expected):
        raise InputError(
            f"{path} holds a {type(found).__name__} and no {getattr(expected, '__name__', expected)}"
        )
    return found


def _opened(path: str | Path) -> AnyResult | Sweep:
    """Return the result in a file or folder, whatever it is."""
    if (Path(path) / "sweep.json").is_file():
        from viscorod.results.files.sweep_folder import SweepFolder

        return SweepFolder(Path(path)).load()
    if Path(path).suffix == ".parquet":
        from viscorod.results.files.sweep_table import read_table

        return read_table(path)
    if (Path(path) / "sweep.parquet").is_file():
        from viscorod.results.files.stored_sweep import read_store

        return read_store(path)
    if Path(path).is_dir():
        from viscorod.results.files.stopped_run import result_file, stopped_run
        from viscorod.results.run import Run

        path = result_file(Path(path))
        if path.is_dir():
            return Run(stopped_run(path))
    data = read(path)
    if str(data.attrs.get("kind")) == "sweep":  # a damaged one may be an array
        from viscorod.results.ensemble import Ensemble
        from viscorod.results.sweep_result import Sweep

        return (Ensemble if "ensemble" in data.attrs else Sweep).of(data, Path(path))
    result = result_of(data, Path(path))
    if "derivatives" in data.attrs:
        from viscorod.results.files.stored_derivatives import read_derivatives

        result.derivatives = read_derivatives(result, Path(path))
    return result


def result_of(data: xr.Dataset, path: Path) -> AnyResult:
    """Return the result whose data set was read from a file, after looking at all of it.

    Raises:
        InputError: it is no result, or a damaged one.
    """
    from viscorod.results.any_result import KINDS, result_class
    from viscorod.results.result import Result
    from viscorod.results.soundness import require_sound

    kind = str(data.attrs.get("kind", ""))
    found = result_class(kind)
    if found is None:
        raise InputError(
            f"{path} holds no viscorod result (kind = {kind[:60]!r}; known: {', '.join(KINDS)}, sweep)"
        )
    if issubclass(found, Result):
        require_sound(data, path)
    result: AnyResult = found(data)
    return result
