"""Arrays of a result as netCDF4, before they are a data set: the file that xarray writes of that, bit for bit.

To import xarray, which needs pandas, and to make a data set takes as long as the motion of a short run, and few of
those who run a case ask for one. What stands here is what xarray adds to h5netcdf: units and long names, which
coordinates belong to an array (the attribute ``coordinates`` of the CF conventions, section 5), texts of any length,
and truth values as numbers of one byte.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from viscorod.results.data_schema import VARIABLES
from viscorod.results.state_arrays import StateArrays

__all__ = ["write_arrays"]

_COORDINATES = "coordinates"


def write_arrays(
    file: Any,
    arrays: StateArrays,
    stored_as: Mapping[Any, Mapping[str, Any]],
    add: Callable[[np.ndarray, Any], None],
) -> None:
    """Write arrays and attributes into an open, empty file of h5netcdf.

    Args:
        file: of h5netcdf; arrays: of a result.
        stored_as: what HDF5 does with each array: its pieces, checksums, compression.
        add: called with every array and the variable that it is written to.
    """
    import h5py

    known, apart = _coordinates_of(arrays)
    about = file.attrs
    for name, value in (dict(arrays.attrs) | apart).items():
        about[name] = value
    for name, size in arrays.all_sizes.items():
        file.dimensions[name] = size
    for name, variable in arrays.variables.items():
        values, told = variable.values, _about(name) | known.get(name, {})
        kind: Any = values.dtype
        if kind.kind == "U":
            kind = h5py.string_dtype()
        elif kind.kind == "b":
            told["dtype"], values = "bool", values.astype(np.int8)
            kind = values.dtype
        made = file.create_variable(name, variable.dims, kind, **stored_as[name])
        noted = made.attrs
        for key, text in told.items():
            noted[key] = text
        add(values, made)


def _about(name: str) -> dict[str, str]:
    """Return the unit and the long name of an array, as far as it has them."""
    return {
        key: text for key, text in zip(("units", "long_name"), VARIABLES.get(name, ()), strict=False) if text
    }


def _coordinates_of(arrays: StateArrays) -> tuple[dict[str, dict[str, str]], dict[str, str]]:
    """Return the coordinates of every array that has some beside those along its dimensions, and those of none.

    Both are attributes: of arrays by name, and of the file.
    """
    beside = sorted(arrays.coords - arrays.all_sizes.keys())
    dims = {name: set(variable.dims) for name, variable in arrays.variables.items()}
    found: dict[str, dict[str, str]] = {}
    without = set(beside)
    for name, mine in dims.items():
        if name in beside or name in mine:
            continue
        own = [one for one in beside if dims[one] <= mine]
        if own:
            found[name] = {_COORDINATES: " ".join(own)}
            without.difference_update(own)
    return found, {_COORDINATES: " ".join(sorted(without))} if without else {}
