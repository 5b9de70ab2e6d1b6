"""Results on disk: one netCDF4 file, written and read through h5netcdf."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscorod.checks import checked
from viscorod.errors import InputError, reading, writing
from viscorod.results.files.checksums import FORMAT, require_unchanged, seal, stored_sums
from viscorod.results.files.checksums import NAME as CHECKSUMS
from viscorod.results.files.file_tail import require_tail_fits, write_tail
from viscorod.results.files.pieces_of_arrays import piece_shape
from viscorod.results.files.plain_file import require_levels_readable, require_plain, require_written

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady
    from viscorod.results.sweep_result import Sweep


LARGE = 2.5e8
"""Bytes from which on a file is not read into memory."""


def write(
    data: xr.Dataset,
    path: str | Path,
    groups: Mapping[str, xr.Dataset] | None = None,
    *,
    unlimited: str | None = None,
    chunk: int = 0,
) -> Path:
    """Write a data set to ``path`` as netCDF4, making its folder; returns the path.

    Every piece of an array has a checksum, and the file those of all (``checksums``).

    Args:
        data: the root of the file; groups: more data sets, by name.
        path: of the file.
        unlimited: a dimension that can grow afterwards, and is stored in pieces of ``chunk`` places; whoever lets it
            grow has to ``seal`` the file then.
        chunk: places in a piece.

    Raises:
        InputError: the place cannot be written.
    """
    import h5netcdf
    import h5py
    from xarray.backends import H5NetCDFStore

    path = Path(path)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with h5py.File(path, "w", libver=FORMAT, track_order=True) as stored:
            with h5netcdf.File(stored, "w") as file:
                for name, part in {"": data, **(groups or {})}.items():
                    store = H5NetCDFStore(file, group=name or None, mode="a")
                    part.dump_to_store(
                        store,
                        encoding=_encoding(part, unlimited, chunk),
                        unlimited_dims=[unlimited] if unlimited else None,
                    )
            seal(stored)
        write_tail(path)
    return path


def _encoding(data: xr.Dataset, unlimited: str | None, chunk: int) -> dict[Any, dict[str, Any]]:
    """Return how the variables of a data set are stored: numbers in pieces, each with a checksum."""
    found: dict[Any, dict[str, Any]] = {}
    for name, variable in data.variables.items():
        found[name] = {"_FillValue": None}  # results hold no gaps to mark
        if variable.size and variable.ndim and variable.dtype.kind in "fiub":
            piece = piece_shape(variable.shape, variable.dtype.itemsize)
            if unlimited in variable.dims:
                piece = (chunk, *variable.shape[1:])
            found[name] |= {"chunksizes": piece, "fletcher32": True}
    return found


def read(path: str | Path, group: str | None = None) -> xr.Dataset:
    """Read a data set (that of a group of the file): into memory, or piece by piece on access if it is large.

    What is damaged is refused when it is read, which for all but the numbers of a large file is now.

    Raises:
        InputError: no such file, not a netCDF4 file, or a damaged one.
    """
    import h5py
    import xarray as xr

    from viscorod.results.files.checked_array import OpenFile, checked

    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path} is not a file; name a run.nc that viscorod wrote")
    with reading(path):
        require_tail_fits(path)
        with h5py.File(path, "r") as file:
            size = require_plain(file, path)
            require_written(file, path)
            sums = stored_sums(file)
            if sums is not None:
                require_unchanged(file, sums, path)
            require_levels_readable(file if group is None else file[group], path)
        # numbers stand as they are: nothing in the file may scale them, or call them gaps or dates
        with xr.open_dataset(
            path, engine="h5netcdf", group=group, cache=False, mask_and_scale=False, decode_times=False
        ) as found:
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


@checked
def load(path: str | Path) -> Run | Equilibrium | Steady | Sweep:
    """Open a saved run, equilibrium, steady rotation or sweep; it answers everything that a fresh one does.

    Args:
        path: a file written by ``save``, by ``viscorod run`` or by ``viscorod sweep``.

    Raises:
        InputError: no such file, or not a result of viscorod.
    """
    data = read(path)
    if data.attrs.get("kind") == "sweep":
        from viscorod.results.sweep_result import Sweep

        return Sweep.of(data, Path(path))
    return result_of(data, Path(path))


def result_of(data: xr.Dataset, path: Path) -> Run | Equilibrium | Steady:
    """Return the result whose data set was read from a file, after looking at all of it.

    Raises:
        InputError: it is no result, or a damaged one.
    """
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.soundness import require_sound
    from viscorod.results.steady_result import Steady

    kinds: dict[Any, type[Run | Equilibrium | Steady]] = {
        kind.kind: kind for kind in (Run, Equilibrium, Steady)
    }
    found = str(data.attrs.get("kind", ""))
    if found not in kinds:
        raise InputError(
            f"{path} holds no viscorod result (kind = {found[:60]!r}; known: {', '.join(kinds)}, sweep)"
        )
    require_sound(data, path)
    return kinds[found](data)
