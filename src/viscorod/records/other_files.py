"""Columns from UFF, C3D, MATLAB and netCDF files, and from objects of xarray and pandas."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError, let_interrupts_through
from viscorod.records.clock_times import since_first
from viscorod.records.column_units import is_unit, name_and_unit
from viscorod.records.columns import Columns, stacked
from viscorod.records.matlab_file import columns_of_matlab
from viscorod.records.text_file import columns_of_text
from viscorod.records.uff_file import columns_of_uff
from viscorod.wording import missing

__all__ = ["columns_of"]

UNIVERSAL = (".uff", ".unv", ".uf", ".bunv", ".ufb")
"""Suffixes of universal files."""


def columns_of(source: Any, wanted: Any = None) -> Columns:
    """Return the columns of a file, by its suffix, or of an object of xarray or pandas.

    Args:
        source: path or object.
        wanted: a column, of sources that hold several tables.

    Raises:
        InputError: it cannot be read, or the package that reads it is not there.
    """
    if isinstance(source, Columns):
        return source
    if hasattr(source, "dims") and hasattr(source, "coords"):
        return _of_xarray(source)
    if hasattr(source, "columns") and hasattr(source, "to_numpy"):
        return _of_frame(source)
    if hasattr(source, "index") and hasattr(source, "to_numpy"):
        return _of_frame(source.to_frame())
    if not isinstance(source, str | Path):
        raise InputError(
            Fault("source", type(source).__name__, "no record can be read from it",
                  "give a path, or a DataArray, DataFrame or Series")
        )  # fmt: skip
    path = Path(source)
    readers = {
        ".c3d": _of_c3d,
        ".mat": columns_of_matlab,
        ".nc": _of_netcdf,
    }
    suffix = path.suffix.lower()
    if not path.is_file():
        raise InputError(Fault(str(path), "", missing(path), "give the path of a file of measured values"))
    if suffix in UNIVERSAL or (suffix == ".txt" and _is_universal(path)):
        return columns_of_uff(path, _library("pyuff", path), wanted if isinstance(wanted, str) else None)
    reader = readers.get(suffix, columns_of_text)
    return reader(path)


def _is_universal(path: Path) -> bool:
    """Return whether a text begins as universal files do: a line of -1, then the number of a data set."""
    with path.open("rb") as file:
        lines = file.read(400).split(b"\n")
    return len(lines) > 2 and lines[0].strip() == b"-1" and lines[1].strip().isdigit()


def _library(name: str, path: Path) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise InputError(
            Fault(
                str(path),
                path.suffix,
                f"it is read by the package {name}",
                "install it: pip install viscorod[records]",
            )
        ) from None


def _of_xarray(source: Any) -> Columns:
    """Return a DataArray of one dimension, or the variables of a Dataset along one."""
    arrays = (
        {str(source.name or "value"): source}
        if hasattr(source, "name")
        else {str(k): v for k, v in source.items()}
    )
    dims = {dim for array in arrays.values() for dim in array.dims}
    if len(dims) != 1:
        raise InputError(
            Fault(
                "source",
                f"dimensions {', '.join(map(str, sorted(dims)))}",
                "a record has one",
                "choose by .sel or .isel",
            )
        )
    (dim,) = dims
    if dim not in source.coords:
        raise InputError(
            Fault("source", str(dim), "this dimension has no coordinate", "give it times or frequencies")
        )
    names, columns, units = [], [], []
    for name, array in {str(dim): source[dim], **arrays}.items():
        seconds = since_first(array.values)
        if seconds is None and np.asarray(array.values).dtype.kind not in "fiuc":
            continue  # remarks
        names.append(name)
        columns.append(np.asarray(array.values) if seconds is None else seconds)
        units.append(array.attrs.get("units") if seconds is None else "s")
    return stacked("xarray", names, columns, units)


def _of_netcdf(path: Path) -> Columns:
    """Return the variables of a netCDF file along its one dimension."""
    import xarray as xr

    try:
        found = xr.load_dataset(path)
    except Exception as error:  # the readers fail in many ways on what is no netCDF
        let_interrupts_through(error)
        raise InputError(
            Fault(str(path), "", f"it cannot be read as netCDF ({error})", "check the file")
        ) from None
    return _of_xarray(found)


def _of_frame(frame: Any) -> Columns:
    """Return a DataFrame with units in the names of its columns, or in ``frame.attrs["units"]``; its index is first."""
    told = dict(frame.attrs.get("units", {}))
    names: list[str] = []
    columns: list[np.ndarray] = []
    units: list[str | None] = []
    parts = [(str(frame.index.name or "index"), frame.index.to_numpy())]
    parts += [(_label(name), frame.iloc[:, k].to_numpy()) for k, name in enumerate(frame.columns)]
    for label, values in parts:
        name, unit = name_and_unit(label)
        seconds = since_first(values)
        if seconds is not None:
            names.append(name)
            columns.append(seconds)
            units.append("s")
            continue
        try:
            columns.append(np.asarray(values, dtype=complex if np.iscomplexobj(values) else float))
        except (TypeError, ValueError):
            continue  # remarks
        names.append(name)
        units.append(told.get(label, told.get(name, unit)))
    return stacked("pandas", names, columns, units)


def _label(name: Any) -> str:
    """Return the heading of a column; of several levels the last may be its unit."""
    if not isinstance(name, tuple):
        return str(name)
    words = [str(word) for word in name if str(word)]
    if len(words) > 1 and is_unit(words[-1].strip("[]() ")):
        return f"{' '.join(words[:-1])} [{words[-1].strip('[]() ')}]"
    return " ".join(words)


def _of_c3d(path: Path) -> Columns:
    """Return the markers of a C3D file, "label x", "label y", "label z" of each, over time from the first frame."""
    library = _library("ezc3d", path)
    try:
        file = library.c3d(str(path))
        point = file["parameters"]["POINT"]
        rate = float(point["RATE"]["value"][0])
        unit = str((point["UNITS"]["value"] or [""])[0]) or None
        labels = [str(text).strip() for text in point["LABELS"]["value"]]
        places = np.asarray(file["data"]["points"], dtype=float)[:3]
    except Exception as error:  # the reader fails in many ways on what is no C3D
        let_interrupts_through(error)
        raise InputError(
            Fault(str(path), "", f"it cannot be read as C3D ({error})", "check the file")
        ) from None
    places[:, (places == 0.0).all(axis=0)] = np.nan  # what a camera did not see stands at the origin
    count = places.shape[2]
    names, columns, units = ["time"], [np.arange(count) / rate], ["s"]
    for k in range(places.shape[1]):
        label = labels[k] if k < len(labels) and labels[k] else f"point {k + 1}"
        for axis, values in zip("xyz", places[:, k], strict=True):
            names.append(f"{label} {axis}")
            columns.append(values)
            units.append(unit or "")
    return stacked(str(path), names, columns, [one or None for one in units])
