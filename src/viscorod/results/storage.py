"""Results on disk: one netCDF4 file, written and read through h5netcdf."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from viscorod.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady import Steady
    from viscorod.results.sweep import Sweep


def write(data: xr.Dataset, path: str | Path, group: str | None = None) -> Path:
    """Write a data set to ``path`` as netCDF4, making its folder; returns the path.

    A ``group`` is added to the file that is there.

    Raises:
        InputError: the place cannot be written.
    """
    path = Path(path)
    unfilled = {name: {"_FillValue": None} for name in data.variables}  # results hold no gaps to mark
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        mode: Literal["a", "w"] = "a" if group else "w"
        data.to_netcdf(path, engine="h5netcdf", encoding=unfilled, group=group, mode=mode)
    except OSError as error:
        raise InputError(
            f"{path} cannot be written ({error.strerror or error}); name another place"
        ) from None
    return path


def read(path: str | Path, group: str | None = None) -> xr.Dataset:
    """Read a data set (that of a group of the file) wholly into memory and close the file.

    Raises:
        InputError: no such file, or not a netCDF4 file.
    """
    import xarray as xr

    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path} is no file; name a run.nc that viscorod wrote")
    try:
        return xr.load_dataset(path, engine="h5netcdf", group=group)
    except OSError as error:
        raise InputError(
            f"{path} cannot be read as netCDF4 ({error}); name a run.nc that viscorod wrote"
        ) from None


def load(path: str | Path) -> Run | Equilibrium | Steady | Sweep:
    """Open a saved run, equilibrium, steady rotation or sweep; it answers everything that a fresh one does.

    Args:
        path: a file written by ``save``, by ``viscorod run`` or by ``viscorod sweep``.

    Raises:
        InputError: no such file, or not a result of viscorod.
    """
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady import Steady

    data = read(path)
    kinds: dict[str, type[Run | Equilibrium | Steady]] = {
        kind.kind: kind for kind in (Run, Equilibrium, Steady)
    }
    found = str(data.attrs.get("kind", ""))
    if found == "sweep":
        from viscorod.results.sweep import Sweep

        return Sweep.of(data, Path(path))
    if found not in kinds:
        raise InputError(f"{path} holds no viscorod result (kind = {found!r}; known: {', '.join(kinds)})")
    return kinds[found](data)
