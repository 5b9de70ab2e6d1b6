"""Derivatives of a result in its file: a group for each number, ``derivative_0`` and so on.

A group has the derivatives of all variables that have any. Whatever follows from a result does so to first order from
results that differ by them, which are made again when the file is opened.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.derivative import Derivative, Part
from viscorod.results.files.storage import read

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["groups_of", "read_derivatives", "with_derivatives"]

NAMES = "derivatives"
"""Attribute of the data set of a result: the keys of the numbers, as JSON."""
RATE = "d_"
"""Begins the name of a derivative, behind which stands that of a variable or coordinate."""


def with_derivatives(result: Any) -> xr.Dataset:
    """Return the data set of a result as it is stored: its derivatives are named in it."""
    data: xr.Dataset = result.data
    if not result.derivatives:
        return data
    return data.assign_attrs({NAMES: json.dumps(list(result.derivatives))})


def groups_of(derivatives: Mapping[str, Derivative[Any]]) -> dict[str, xr.Dataset]:
    """Return the groups of a file."""
    return {_group(k): _stored(one) for k, one in enumerate(derivatives.values())}


def read_derivatives(result: Any, path: Path) -> dict[str, Derivative[Any]]:
    """Return the derivatives of a result from its file.

    Raises:
        InputError: it is damaged.
    """
    keys = json.loads(str(result.data.attrs.pop(NAMES)))
    found = {}
    for k, key in enumerate(keys):
        try:
            found[str(key)] = _restored(result, read(path, _group(k)))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"{path}: the derivatives by {key} are damaged: {error}") from None
    return found


def _group(number: int) -> str:
    return f"derivative_{number}"


def _stored(derivative: Derivative[Any]) -> xr.Dataset:
    """Return the group of one number."""
    import xarray as xr

    known = derivative.result.data.attrs
    own = [
        {name: value for name, value in part.result.data.attrs.items() if known.get(name) != value}
        for part in derivative.parts
    ]
    data = derivative.data
    rates = {f"{RATE}{name}": values.variable for name, values in data.data_vars.items()}
    for name, values in derivative.result.data.coords.items():
        if values.dtype.kind == "f":
            rate = sum(part.weight * part.result.data.coords[name].values for part in derivative.parts)
            rates[f"{RATE}{name}"] = xr.Variable(values.dims, np.asarray(rate))
    attrs = {
        "derivative_by": derivative.key,
        "value": derivative.value,
        "unit": derivative.unit,
        "notes": json.dumps(derivative.notes),
        "parts": json.dumps([[part.weight, part.change] for part in derivative.parts]),
        "attributes": json.dumps(own, default=float),
    }
    return xr.Dataset(rates, data.coords, attrs)


def _restored(result: Any, group: xr.Dataset) -> Derivative[Any]:
    """Return a derivative from its group."""
    attrs = group.attrs
    parts = []
    kind: Any = type(result)
    own = json.loads(str(attrs["attributes"]))
    for (weight, change), more in zip(json.loads(str(attrs["parts"])), own, strict=True):
        near = kind.__new__(kind)
        near.data = _moved(result.data, group, float(change)).assign_attrs(more)
        parts.append(Part(float(weight), float(change), near))
    notes = [str(note) for note in json.loads(str(attrs["notes"]))]
    return Derivative(
        str(attrs["derivative_by"]), float(attrs["value"]), str(attrs["unit"]), result, parts, notes
    )


def _moved(data: xr.Dataset, group: xr.Dataset, change: float) -> xr.Dataset:
    """Return a data set for another value of the number; what has no derivative is not a number in it."""
    variables: dict[Any, Any] = {}
    for name, values in data.data_vars.items():
        if values.dtype.kind in "fc" and name != "step_size":
            rate = group[f"{RATE}{name}"].values if f"{RATE}{name}" in group else np.nan
            variables[name] = values.copy(data=values.values + change * rate)
    coordinates = {
        name: values.copy(data=values.values + change * group[f"{RATE}{name}"].values)
        for name, values in data.coords.items()
        if f"{RATE}{name}" in group
    }
    return data.assign(variables).assign_coords(coordinates)
