"""Derivatives of a result by one number of its case."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.checks import checked
from viscorod.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Derivative", "Part"]

R = TypeVar("R")


class Part(NamedTuple, Generic[R]):
    """A result for another value of the number.

    Attributes:
        weight: in the derivative; change: of the number; result: for it.
    """

    weight: float
    change: float
    result: R


@known_arguments
class Derivative(Generic[R]):
    """How everything in a result changes with one number of its case.

    It is a weighted sum of results that belong to values of the number close by: exact to first order, of what is
    stored and of whatever follows from it. Steps in time and the mesh are those of the result.

    Args:
        key: of the number; value: of it, in its ``unit``.
        result: whose derivative it is; parts: what it is the sum of.

    Attributes:
        notes: what is not there or not certain, in sentences.
        parts: what it is the sum of.
    """

    def __init__(
        self,
        key: str,
        value: float,
        unit: str,
        result: R,
        parts: Sequence[Part[R]],
        notes: Sequence[str] = (),
    ) -> None:
        self.key, self.value, self.unit = key, value, unit
        self.result, self.notes = result, list(notes)
        self.parts = list(parts)

    def of(self, function: Callable[[R], Any]) -> Any:
        """Return the derivative of what a function makes of the result: numbers, arrays, xarray objects.

        ``derivative.of(lambda run: run.decrement("beam.end", "z").damping_ratios)`` is that of damping ratios.

        Raises:
            InputError: it has none.
        """
        found = [(part.weight, function(part.result)) for part in self.parts]
        if hasattr(found[0][1], "dims"):
            return _of_data(self, function(self.result), found)
        kind = np.asarray(found[0][1]).dtype.kind
        if kind not in "fciub":
            raise InputError(
                f"derivatives are those of numbers, and this is of the kind {type(found[0][1]).__name__}; take numbers "
                "of it: derivative.of(lambda result: ...)"
            )
        total: Any = sum(weight * np.asarray(value) for weight, value in found)
        if not np.isfinite(total).all():
            raise InputError(
                f"this has no derivative by {self.key}: it is not finite, or follows from what has none (shapes of "
                f"modes and their shares){''.join('; ' + note for note in self.notes)}"
            )
        return total if np.ndim(total) else total.item() if hasattr(total, "item") else total

    @cached_property
    def data(self) -> xr.Dataset:
        """The derivatives of all variables of the result, with their units over that of the number."""
        found: xr.Dataset = self._each("data")
        return found

    def probe(self, *args: Any, **given: Any) -> xr.Dataset:
        """Return the derivatives of everything at any places (and times); see ``probe`` of the result."""
        found: xr.Dataset = self._each("probe")(*args, **given)
        return found

    def history(self, *args: Any, **given: Any) -> xr.DataArray:
        """Return the derivatives of a vector at a place; see ``history`` of the result."""
        found: xr.DataArray = self._each("history")(*args, **given)
        return found

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self._each(name)

    def _each(self, name: str) -> Any:
        """Return the derivative of what the result has under a name, or a method that returns those of a method."""
        value = getattr(self.result, name)  # tells what there is no such thing of
        if callable(value):
            return lambda *args, **given: self.of(lambda part: getattr(part, name)(*args, **given))
        return self.of(lambda part: getattr(part, name))

    @checked
    def save(self, path: str | Path) -> Path:
        """Write the derivatives of all variables to a netCDF4 file for xarray; returns the path."""
        from viscorod.results.files.storage import write

        return write(self.data, path)


def _of_data(about: Derivative[Any], base: Any, found: Sequence[tuple[float, Any]]) -> Any:
    """Return the weighted sum of data arrays or sets, with the coordinates of the first one."""
    import xarray as xr

    def combined(name: Any, variable: xr.DataArray) -> xr.DataArray:
        total = sum(
            weight * np.asarray((data if name is None else data[name]).values) for weight, data in found
        )
        unit = variable.attrs.get("units", "1")
        attrs = variable.attrs | {
            "units": _over(unit, about.unit),
            "long_name": f"derivative of {variable.attrs.get('long_name', name)} by {about.key}",
        }
        return variable.copy(data=total).assign_attrs(attrs)

    if isinstance(base, xr.DataArray):
        return combined(None, base)
    smooth = {
        name: combined(name, variable)
        for name, variable in base.data_vars.items()
        if variable.dtype.kind in "fc" and name != "step_size"
    }
    smooth = {name: values for name, values in smooth.items() if np.isfinite(values.values).all()}
    attrs = {"title": base.attrs.get("title", ""), "derivative_by": about.key, "value": about.value}
    return xr.Dataset(smooth, base.coords, attrs)


def _over(unit: str, by: str) -> str:
    """Return the unit of a derivative."""
    if not by or by == "1":
        return unit
    return f"({unit})/({by})"
