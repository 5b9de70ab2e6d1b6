"""Whether a data set can be a result: everything that the package relies on when it reads one is looked at once.

``require_sound`` looks at names, dimensions, types, units, labels, attributes and what is small;
``require_possible`` at the numbers of one array, or of a part of it, which a large file gives when they are read.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.results.data_schema import (
    DIMENSION,
    DIMENSIONS,
    FLAGS,
    INTEGERS,
    LABELS,
    REQUIRED,
    STATES,
    TEXTS,
    VARIABLES,
)
from viscorod.results.result_attributes import faults_of_attributes

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["require_possible", "require_sound"]

_UNIT = 1e-6
"""Largest departure of a quaternion's length from one."""
_POSITIVE = {"relaxation_time"}
_NOT_NEGATIVE = {"station_s", "point_s", "point_weight", "half_width", "step_size", "kinetic"}
_FROM = {"station_order": 0, "connection_station": -1, "iterations": 0, "negative_eigenvalues": 0}
_OF_POINTS = ("point_rod", "point_s", "point_weight")
_TOGETHER = {
    "strain": ("section_force", *_OF_POINTS),
    "section_force": ("strain",),
    "dissipation": ("strain",),
    "half_width": ("strain",),
    "branch_loss": ("relaxation_time",),
    "branch_strain": ("relaxation_time", "strain"),
    "mode_shape": ("mode_rotation", "mode_residual", "mode_name", "mode_share"),
    "linear_momentum": ("angular_momentum",),
    "velocity": ("angular_velocity",),
}
"""Variable -> others that are there with it."""
_MOST_TOLD = 8


def require_possible(name: str, values: np.ndarray, path: Path) -> None:
    """Refuse numbers of a variable, or of a piece of it, that no result has.

    Raises:
        InputError: a number is not finite, a quaternion not of unit length, a length negative.
    """
    why = _impossible(name, values)
    if why:
        raise _unsound(path, [f"{name} {why}"])


def require_sound(data: xr.Dataset, path: Path) -> None:
    """Refuse a data set of a file that is no result.

    Args:
        data: with its attribute ``kind``; large arrays are not read.
        path: of its file.

    Raises:
        InputError: with all that is wrong.
    """
    kind = data.attrs["kind"]
    along = DIMENSION[kind]
    missing = [name for name in (along, *REQUIRED[kind]) if name not in data.variables]
    if missing:
        raise _unsound(path, [f"{name} is missing" for name in missing])
    faults = [*_of_variables(data, along), *faults_of_attributes(data.attrs, data.sizes.get(along, 0))]
    if not faults:
        faults = [*_of_states(data, along), *_of_places(data), *_of_connections(data)]
    if faults:
        raise _unsound(path, faults)


def _unsound(path: Path, faults: list[str]) -> InputError:
    more = f" and {len(faults) - _MOST_TOLD} more" if len(faults) > _MOST_TOLD else ""
    return InputError(
        Fault(
            str(path),
            "",
            f"this is no result of viscorod: {'; '.join(faults[:_MOST_TOLD])}{more}",
            "take another copy of the file, or compute it again",
        )
    )


def _impossible(name: str, values: np.ndarray) -> str:
    """Return why no result has these numbers; empty where it can."""
    if name in _FROM and values.size and values.min() < _FROM[name]:
        return f"holds {values.min()}, below {_FROM[name]}"
    if name not in VARIABLES or values.dtype.kind != "f" or not values.size:
        return ""
    if not np.isfinite(values).all():
        return f"holds {values[~np.isfinite(values)][0]}, where all numbers are finite"
    if name in ("rotation", "reference_rotation") and values.shape[-1] == 4:
        off = float(np.abs(np.linalg.norm(values, axis=-1) - 1.0).max())
        if off > _UNIT:
            return f"holds a quaternion whose length differs from 1 by {off:.3g}"
    if name in _NOT_NEGATIVE and values.min() < 0.0:
        return f"holds {values.min():g}, below 0"
    if name in _POSITIVE and values.min() <= 0.0:
        return f"holds {values.min():g}, not above 0"
    return ""


def _of_variables(data: xr.Dataset, along: str) -> Iterator[str]:
    """Yield what is wrong with dimensions, types, units and labels."""
    for key, variable in data.variables.items():
        name = str(key)
        if name in LABELS and variable.dims == (name,):
            if tuple(str(word) for word in variable.values.tolist()) != LABELS[name]:
                yield f"{name} is not {', '.join(LABELS[name])}"
            continue
        if name not in VARIABLES:
            continue
        dims = tuple(along if dim == STATES else dim for dim in DIMENSIONS[name])
        if variable.dims != dims:
            yield f"{name} has the dimensions {_list(variable.dims)}, where {_list(dims)} are needed"
            continue
        kind, needed = variable.dtype.kind, _kinds(name)
        if kind not in needed:
            yield f"{name} holds {variable.dtype}, where {_WORDS[needed]} are needed"
        unit = VARIABLES[name][0]
        found = variable.attrs.get("units", unit)
        if not isinstance(found, str) or found != unit:
            yield f"{name} is in {found!r}, where {unit!r} is needed"
    for dimension, words in LABELS.items():
        size = data.sizes.get(dimension, len(words))
        if size != len(words):
            yield f"{dimension} has {size} places, where {len(words)} are needed"
    for dimension, size in (("side", 2), ("part", 2)):
        if data.sizes.get(dimension, size) != size:
            yield f"{dimension} has {data.sizes[dimension]} places, where {size} are needed"
    for name, others in _TOGETHER.items():
        yield from (
            f"{other} is missing, which belongs to {name}"
            for other in others
            if name in data and other not in data
        )
    if "support" in data.dims and "support" not in data.coords:
        yield "the names of the supports are missing"


_NUMBERS, _WHOLE, _TEXT, _FLAG = "f", "iu", "UTO", "b"
_WORDS = {_NUMBERS: "real numbers", _WHOLE: "whole numbers", _TEXT: "texts", _FLAG: "truth values"}


def _kinds(name: str) -> str:
    if name in TEXTS:
        return _TEXT
    if name in INTEGERS:
        return _WHOLE
    return _FLAG if name in FLAGS else _NUMBERS


def _of_states(data: xr.Dataset, along: str) -> Iterator[str]:
    """Yield what is wrong with the levels at which states are stored."""
    levels = np.asarray(data[along].values, dtype=float)
    if not levels.size:
        yield f"it holds no state along {along}"
    elif not np.isfinite(levels).all():
        yield f"{along} holds {levels[~np.isfinite(levels)][0]}"
    elif along == "time" and (np.diff(levels) <= 0.0).any():
        k = int(np.argmax(np.diff(levels) <= 0.0))
        yield f"time does not increase: {levels[k]:.9g} s is followed by {levels[k + 1]:.9g} s"
    elif along == "spin" and levels.size != 1:
        yield f"a steady rotation has one state, and there are {levels.size}"
    if "limit_points" in data.attrs and "negative_eigenvalues" not in data:
        yield "negative_eigenvalues is missing, which a path has"


def _of_places(data: xr.Dataset) -> Iterator[str]:
    """Yield what is wrong with stations and Gauss points."""
    rods = data["station_rod"].values.astype(str)
    s, order = np.asarray(data["station_s"].values, dtype=float), np.asarray(data["station_order"].values)
    if not rods.size:
        yield "it has no stations"
    for name in ("station_s", "station_order", "reference_position", "reference_rotation"):
        why = _impossible(name, data[name].values)
        if why:
            yield f"{name} {why}"
    points = "point_rod" in data.coords and "point_s" in data.coords
    if ("point" in data.dims) and not points:
        yield "point_rod or point_s is missing"
    point_rods = data["point_rod"].values.astype(str) if points else np.array([], dtype=str)
    unknown = sorted(set(point_rods.tolist()) - set(rods[order > 0].tolist()))
    if unknown:
        yield f"Gauss points are on {unknown[0]!r}, which has no stations"
    for rod in dict.fromkeys(rods.tolist()):
        mine = rods == rod
        orders = set(order[mine].tolist())
        if orders == {0}:
            if int(mine.sum()) > 1:
                yield f"{rod!r} is a place on a body with {int(mine.sum())} stations"
            continue
        if len(orders) > 1:
            yield f"{rod!r} has elements of the orders {_list(sorted(orders))}"
            continue
        (p,) = orders
        count, known = int(mine.sum()), np.sort(s[mine])
        elements = (count - 1) // p
        if count < p + 1 or (count - 1) % p:
            yield f"{rod!r} has {count} stations, which make no elements of order {p}"
        elif (np.diff(known) <= 0.0).any():
            yield f"stations of {rod!r} are at the same arc length"
        elif points and int((point_rods == rod).sum()) != elements * p:
            yield f"{rod!r} has {int((point_rods == rod).sum())} Gauss points in {elements} elements of order {p}"
        elif points:
            at = np.sort(np.asarray(data["point_s"].values, dtype=float)[point_rods == rod])
            element = np.searchsorted(known[::p], at, side="right") - 1
            if (np.diff(at) <= 0.0).any() or not np.array_equal(element, np.repeat(np.arange(elements), p)):
                yield f"Gauss points of {rod!r} are not within its elements"


def _of_connections(data: xr.Dataset) -> Iterator[str]:
    """Yield what is wrong with joints, springs and supports."""
    if "connection_station" in data:
        stations = data["connection_station"].values
        if stations.size and not (stations.min() >= -1 and stations.max() < data.sizes["station"]):
            yield f"connection_station names station {stations.max()} of {data.sizes['station']}"
        for name in ("connection", "connection_kind", "connection_arm"):
            if name not in data:
                yield f"{name} is missing, which belongs to connection_station"
        kinds = set(data["connection_kind"].values.tolist()) if "connection_kind" in data else set()
        if kinds - {"joint", "spring"}:
            yield f"connection_kind holds {sorted(kinds - {'joint', 'spring'})[0]!r}, neither joint nor spring"
    joints = ("joint", "joint_motion", "joint_held", "joint_value", "joint_rate", "joint_force")
    there = [name for name in joints if name in data]
    if there and len(there) < len(joints):
        yield f"{next(name for name in joints if name not in data)} is missing, which belongs to {there[0]}"


def _list(words: Any) -> str:
    return "(" + ", ".join(str(word) for word in words) + ")"
