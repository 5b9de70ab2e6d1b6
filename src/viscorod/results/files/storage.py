"""Results on disk: one netCDF4 file, written and read through h5netcdf."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from viscorod.errors import InputError, writing
from viscorod.limits import LARGEST_RESULT, MOST_DECLARED

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
    group: str | None = None,
    *,
    unlimited: str | None = None,
    chunk: int = 0,
) -> Path:
    """Write a data set to ``path`` as netCDF4, making its folder; returns the path.

    A ``group`` is added to the file that is there. The dimension ``unlimited`` can grow afterwards and is stored in
    pieces of ``chunk`` places.

    Raises:
        InputError: the place cannot be written.
    """
    path = Path(path)
    # results hold no gaps to mark
    encoding: dict[Any, dict[str, Any]] = {name: {"_FillValue": None} for name in data.variables}
    for name, variable in data.variables.items():
        if unlimited in variable.dims:
            encoding[name]["chunksizes"] = (chunk, *variable.shape[1:])
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        mode: Literal["a", "w"] = "a" if group else "w"
        growing = [unlimited] if unlimited else None
        data.to_netcdf(
            path, engine="h5netcdf", encoding=encoding, group=group, mode=mode, unlimited_dims=growing
        )
    return path


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
        path: a file written by ``save``, by ``viscorod run`` or by ``viscorod sweep``.

    Raises:
        InputError: no such file, or not a result of viscorod.
    """
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady

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
