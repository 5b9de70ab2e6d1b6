"""Results as tables of comma-separated values: a header with units, one row for every state (and place)."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np

from viscorod.errors import InputError
from viscorod.results.recorded_states import Quantity
from viscorod.results.run import Run
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.result import Result

Columns = dict[str, np.ndarray]
"""Heading, with the unit in brackets -> values ``(rows,)``."""

QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
ENERGIES = ("kinetic", "elastic", "viscous", "outside", "external", "actuator", "numerical")

_STRAIN_UNITS = ("1", "1", "1", "1/m", "1/m", "1/m")
_FORCES = tuple(
    f"section {kind} {k} [{unit}]" for kind, unit in (("force", "N"), ("moment", "N m")) for k in "123"
)


def probe_columns(found: xr.Dataset) -> Columns:
    """Return what ``probe`` gave as one row for every state and place, places changing fastest."""
    along = str(next(iter(found.sizes)))
    level, places = found[along], found.sizes["place"]
    columns: Columns = {_heading(along, str(level.attrs.get("units", ""))): np.repeat(level.values, places)}
    for coordinate, heading in (("place", "place"), ("s", "s [m]")):
        columns[heading] = np.tile(found[coordinate].values, level.size)
    for name in found:
        headings, values = _components(found, str(name))
        rows = values.reshape(level.size * places, -1)
        columns |= dict(zip(headings, rows.T, strict=True))
    return columns


def history_columns(
    result: Result, places: Sequence[str] = (), quantities: Sequence[str] = ("position",)
) -> Columns:
    """Return histories at places, one row for every state.

    Args:
        result: of which the states are.
        places: "beam.end", "beam@0.15", "plate".
        quantities: of ``QUANTITIES``, as far as the result has them.

    Raises:
        InputError: no such place or quantity.
    """
    columns = _level(result)
    for place in places:
        found = result.probe(place)
        label = str(found["place"].values[0])
        for quantity in quantities:
            if quantity not in found:
                raise InputError(
                    f"quantity = {quantity!r} is not there at {place}; it can be {', '.join(map(str, found))}"
                )
            headings, values = _components(found, quantity)
            rows = values.reshape(len(values), -1)
            columns |= {f"{label} {text}": row for text, row in zip(headings, rows.T, strict=True)}
    return columns


def energy_columns(result: Result) -> Columns:
    """Return the energy account, as far as the result has it, one row for every state."""
    columns = _level(result)
    columns |= {f"{name} [J]": result.data[name].values for name in ENERGIES if name in result.data}
    if "branch_loss" in result.data:
        for time, loss in zip(
            result.data["relaxation_time"].values, result.data["branch_loss"].values.T, strict=True
        ):
            columns[f"lost by branches of {time:g} s [J]"] = loss
    return columns


def joint_columns(result: Result, names: Sequence[str]) -> Columns:
    """Return coordinates, rates and forces of joints and springs, one row for every state.

    Raises:
        InputError: no such joint or spring.
    """
    columns = _level(result)
    for name in names:
        found = result.joint(name)
        for k, word in enumerate(found["motion"].values):
            turns = not str(word).startswith("u")
            units = {"value": "rad", "rate": "rad/s", "force": "N m"}
            if not turns:
                units = {"value": "m", "rate": "m/s", "force": "N"}
            for key, unit in units.items():
                columns[f"{name} {word} {key} [{unit}]"] = found[key].values[:, k]
    return columns


def text(columns: Columns) -> str:
    """Return the table as text; numbers with the digits that give them back exactly."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(_plain(column) for column in columns.values()), strict=True))
    return file.getvalue()


def write(columns: Columns, path: str | Path) -> Path:
    """Write a table, making its folder; returns the path.

    Raises:
        InputError: the place cannot be written.
    """
    path = Path(path)
    with replacing(path) as new:
        new.write_text(text(columns), encoding="utf-8")
    return path


def _plain(column: np.ndarray) -> list[object]:
    values: list[object] = column.tolist()
    return [repr(value) if isinstance(value, float) else value for value in values]


def _level(result: Result) -> Columns:
    if isinstance(result, Run):
        return {"time [s]": result.time}
    level = result.data[result.dimension]
    return {_heading(result.dimension, str(level.attrs.get("units", ""))): level.values}


def _heading(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _components(found: xr.Dataset, name: str) -> tuple[list[str], np.ndarray]:
    """Return headings of the components of a variable, and its values."""
    variable = found[name]
    unit, word = str(variable.attrs["units"]), name.replace("_", " ")
    if name == "frame":
        values = variable.transpose(..., "director", "axis").values
        return [f"{d} {axis} [1]" for d in found["director"].values for axis in found["axis"].values], values
    if name == "section_force":
        return list(_FORCES), variable.values
    if name == "strain":
        labels = (str(label).replace("_", " ") for label in found["component"].values)
        return [
            f"strain {label} [{u}]" for label, u in zip(labels, _STRAIN_UNITS, strict=True)
        ], variable.values
    if variable.ndim == 2:
        return [_heading(word, unit)], variable.values
    words = [str(label) for label in found[variable.dims[-1]].values]
    return [_heading(f"{word} {label}", unit) for label in words], variable.values
