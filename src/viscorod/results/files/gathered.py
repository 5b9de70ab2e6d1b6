"""The states of a run in memory: arrays that grow, so that there is nothing beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Gathered"]

_MORE = 1.125  # by which an array grows that is too small


class Gathered:
    """States that come in pieces, as one data set in the end.

    Args:
        along: the dimension of the states, "time".

    Attributes:
        count: states so far; the next ones get the numbers from there on.
    """

    def __init__(self, along: str = "time") -> None:
        self.along, self.count = along, 0
        self._static: xr.Dataset | None = None
        self._about: dict[str, tuple[Any, Any, bool]] = {}
        self._values: dict[str, np.ndarray] = {}

    def append(self, data: xr.Dataset) -> None:
        """Append the states of a data set, all of which have the same variables."""
        if self._static is None:
            moving = {str(name): v for name, v in data.variables.items() if self.along in v.dims}
            self._about = {name: (v.dims, v.attrs, name in data.coords) for name, v in moving.items()}
            self._values = {name: np.empty((0, *v.shape[1:]), v.dtype) for name, v in moving.items()}
            self._static = data.drop_vars(list(moving))
        end = self.count + data.sizes[self.along]
        for name, values in self._values.items():
            if end > len(values):
                values.resize((max(end, int(_MORE * len(values))), *values.shape[1:]), refcheck=False)
            values[self.count : end] = data.variables[name].values
        self.count = end

    def contents(self) -> xr.Dataset:
        """Return all states as one data set; there will be no more."""
        import xarray as xr

        assert self._static is not None
        variables: dict[str, xr.Variable] = {}
        coordinates: dict[str, xr.Variable] = {}
        for name, (dims, attrs, coordinate) in self._about.items():
            values = self._values.pop(name)
            values.resize((self.count, *values.shape[1:]), refcheck=False)
            (coordinates if coordinate else variables)[name] = xr.Variable(dims, values, attrs)
        return self._static.assign(variables).assign_coords(coordinates)
