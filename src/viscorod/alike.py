"""Equality by content, for objects that hold arrays and data sets."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

__all__ = ["Alike", "same_content"]


class Alike:
    """What makes objects equal whose contents are: copies, and what was saved and loaded."""

    def _content(self) -> Any:
        """Return what is compared: the fields of a data class."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Alike):
            return NotImplemented
        return self is other or (
            type(self) is type(other) and same_content(self._content(), other._content())
        )

    def __hash__(self) -> int:
        return hash((type(self), _outline(self._content())))


def same_content(one: Any, other: Any) -> bool:
    """Say whether two values are the same in type and content; what is not a number equals what is not a number."""
    if one is other:
        return True
    if hasattr(one, "data_vars") and hasattr(other, "data_vars"):
        return bool(one.equals(other)) and same_content(
            _without_times(one.attrs), _without_times(other.attrs)
        )
    if hasattr(one, "tocoo") and hasattr(other, "tocoo"):
        return bool(one.shape == other.shape and (one != other).nnz == 0)
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return _same_arrays(np.asarray(one), np.asarray(other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same_content(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(same_content, one, other))
    if dataclasses.is_dataclass(one) and type(one) is type(other):
        return all(
            same_content(getattr(one, field.name), getattr(other, field.name))
            for field in dataclasses.fields(one)
        )
    if isinstance(one, float) and isinstance(other, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


def _without_times(attributes: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return attributes without how long it took to compute them."""
    return {key: value for key, value in attributes.items() if not str(key).endswith("time_s")}


def _same_arrays(one: np.ndarray, other: np.ndarray) -> bool:
    numeric = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return np.array_equal(one, other, equal_nan=numeric)


def _outline(value: Any) -> Any:
    """Return something to hash: texts and sizes, which equal contents share."""
    if hasattr(value, "data_vars"):
        return tuple(sorted((str(name), size) for name, size in value.sizes.items()))
    if hasattr(value, "shape"):
        return tuple(value.shape)
    if isinstance(value, Mapping):
        return tuple(sorted((str(key), _outline(item)) for key, item in value.items()))
    if isinstance(value, list | tuple):
        return len(value)
    return value if isinstance(value, str | int | bool) else None
