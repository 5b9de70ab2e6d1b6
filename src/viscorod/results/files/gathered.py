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
        self._whole: xr.Dataset | None = None
        self._static: xr.Dataset | None = None
        self._about: dict[str, tuple[Any, Any, bool]] = {}
        self._values: dict[str, np.ndarray] = {}

    def append(self, data: xr.Dataset) -> None:
        """Append the states of a data set, all of which have the same variables."""
        end = self.count + data.sizes[self.along]
        if not self.count:  # most often there are no others
            self._whole = data
        else:
            if self._whole is not None:
                self._take_apart(self._whole)
            for name, values in self._values.items():
                if end > len(values):
                    values.resize((max(end, int(_MORE * len(values))), *values.shape[1:]), refcheck=False)
                values[self.count : end] = data.variables[name].values
        self.count = end

    def _take_apart(self, data: xr.Dataset) -> None:
        """Make arrays of the first data set."""
        moving = {str(name): v for name, v in data.variables.items() if self.along in v.dims}
        about = {name: (v.dims, v.attrs, name in data.coords) for name, v in moving.items()}
        values = {name: v.values.copy() for name, v in moving.items()}
        # all at once: an interrupt comes before that or after it
        vars(self).update(_whole=None, _static=data.drop_vars(list(moving)), _about=about, _values=values)

    def contents(self) -> xr.Dataset:
        """Return all states as one data set; there will be no more."""
        import xarray as xr

        if self._whole is not None:
            return self._whole
        assert self._static is not None
        variables: dict[str, xr.Variable] = {}
        coordinates: dict[str, xr.Variable] = {}
        for name, (dims, attrs, coordinate) in self._about.items():
            values = self._values.pop(name)
            values.resize((self.count, *values.shape[1:]), refcheck=False)
            (coordinates if coordinate else variables)[name] = xr.Variable(dims, values, attrs)
        self._whole = self._static.assign(variables).assign_coords(coordinates)
        return self._whole
