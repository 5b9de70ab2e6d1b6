"""Results of several members as one data set with a dimension ``member``, where they differ in numbers only."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.results.data_schema import DIMENSION

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ALONG", "along_members", "difference", "layout_of", "plain", "stacked", "unstacked"]

ALONG = DIMENSION | {
    "response": "frequency",
    "campbell": "speed",
    "stability": "load_factor",
    "periodic": "point",
}
"""Kind of a result -> dimension of its states."""
_LEVELS = {
    "time": "stored times",
    "load_factor": "load steps",
    "spin": "angular speeds",
    "speed": "angular speeds",
    "point": "motions",
    "frequency": "frequencies",
}


def difference(one: xr.Dataset, other: xr.Dataset) -> str:
    """Say what keeps two results from being stacked; empty if nothing does."""
    if one.attrs["kind"] != other.attrs["kind"] or set(one.variables) != set(other.variables):
        return "they hold different quantities"
    along = ALONG[one.attrs["kind"]]
    for name in one.dims:
        if one.sizes[name] != other.sizes[name] and name != along:
            return f"their numbers of {name}s differ ({one.sizes[name]} and {other.sizes[name]})"
    for name in one.variables:
        first = one.variables[name]  # arrays of a data set have coordinates, which take longer to find
        a, b = first.values, other.variables[name].values
        if a.shape != b.shape or (_fixed(one, name, a) and not np.array_equal(a, b)):
            return f"their {_LEVELS.get(along if along in first.dims else '', f'values of {name}')} differ"
    return ""


def _fixed(data: xr.Dataset, name: Any, values: np.ndarray) -> bool:
    """Return whether a variable is the same in all results that are stacked: axes and words are."""
    return name in data.dims or values.dtype.kind not in "fi"


def layout_of(data: xr.Dataset) -> str:
    """Return sixteen letters that results share between which there is no `difference`."""
    digest = hashlib.blake2b(str(data.attrs["kind"]).encode(), digest_size=8)
    for name in sorted(map(str, data.variables)):
        values = data.variables[name].values
        digest.update(f"\n{name} {values.shape}".encode())
        if not _fixed(data, name, values):
            continue
        numbers = values.dtype.kind in "fiub"
        digest.update((values + 0.0).tobytes() if numbers else "\0".join(map(str, values.flat)).encode())
    return digest.hexdigest()


def stacked(results: Sequence[xr.Dataset]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates of results that differ in values only; what is equal in all is kept once."""
    first = results[0]
    along = ALONG[first.attrs["kind"]]
    fields: dict[str, Any] = {}
    axes: dict[str, Any] = {}
    for name, variable in first.variables.items():
        columns = [result.variables[name].values for result in results]
        states = along in variable.dims and name not in first.dims
        if states or not all(np.array_equal(columns[0], column) for column in columns[1:]):
            built = (("member", *variable.dims), np.stack(columns), dict(variable.attrs))
        else:
            built = (variable.dims, columns[0], dict(variable.attrs))
        (axes if name in first.coords else fields)[str(name)] = built
    return fields, axes


def unstacked(data: xr.Dataset, number: int) -> xr.Dataset:
    """Return the fields of one member, as its own result holds them."""
    return data.sel(member=number, drop=True)


def along_members(values: Sequence[Any]) -> np.ndarray:
    """Return values along ``member``: numbers or texts as they are, anything else as JSON."""
    if all(isinstance(value, str) for value in values):
        return np.array(values, dtype=str)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values)
    return np.array([json.dumps(value, default=plain) for value in values], dtype=str)


def plain(value: Any) -> Any:
    """Return what JSON can hold: numbers of NumPy as those of Python, anything else that it cannot as text."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
