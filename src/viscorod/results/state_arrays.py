"""The arrays of a result with states, before they are a data set: numbers are read from them as from one, sooner."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.result_places import ResultPlaces

__all__ = ["Arranged", "PlainArray", "StateArrays", "Stored"]

Arranged: TypeAlias = dict[str, tuple[str | tuple[str, ...], np.ndarray | Callable[[], np.ndarray]]]
"""Arrays by name, or what makes them when they are asked for, each after its dimensions."""


class PlainArray(NamedTuple):
    """An array and its dimensions; what it has is what a variable of xarray has of the same name."""

    dims: tuple[str, ...]
    values: np.ndarray

    @property
    def sizes(self) -> dict[str, int]:
        """Length of every dimension."""
        return dict(zip(self.dims, self.values.shape, strict=True))

    @property
    def size(self) -> int:
        """Number of its numbers."""
        return int(self.values.size)

    @property
    def shape(self) -> tuple[int, ...]:
        """Its lengths."""
        return tuple(self.values.shape)

    @property
    def ndim(self) -> int:
        """Number of its dimensions."""
        return len(self.dims)

    @property
    def dtype(self) -> np.dtype[Any]:
        """The kind of its numbers."""
        return self.values.dtype

    @property
    def nbytes(self) -> int:
        """Its bytes."""
        return int(self.values.nbytes)

    def isel(self, chosen: Mapping[str, Any] | None = None, **named: Any) -> PlainArray:
        """Return a part: of one dimension or several a number, which leaves it out, a slice or numbers ``(k,)``.

        Raises:
            ValueError: there is no such dimension.
        """
        found, dims = self.values, self.dims
        for name, part in {**(chosen or {}), **named}.items():
            if name not in dims:
                raise ValueError(f"{name!r} is no dimension; there are {', '.join(dims)}")
            at = dims.index(name)
            found = found[(slice(None),) * at + (part,)]
            if found.ndim < len(dims):
                dims = dims[:at] + dims[at + 1 :]
        return PlainArray(dims, found)


class _Variables(Mapping[str, PlainArray]):
    """Arrays by name, made when they are asked for."""

    def __init__(self, given: Arranged) -> None:
        self._given = given
        self._made: dict[str, PlainArray] = {}

    def __getitem__(self, name: str) -> PlainArray:
        if name not in self._made:
            dims, values = self._given[name]
            found = np.asarray(values() if callable(values) else values)
            self._made[name] = PlainArray((dims,) if isinstance(dims, str) else dims, found)
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._given

    def __iter__(self) -> Iterator[str]:
        return iter(self._given)

    def __len__(self) -> int:
        return len(self._given)

    @property
    def there(self) -> Iterator[PlainArray]:
        """Those that need not be made."""
        return (self[name] for name, (_, values) in self._given.items() if not callable(values))


@dataclass
class StateArrays:
    """What the data set of a result is made of.

    Attributes:
        arrays: variables of the result; coordinates: along stations, points and others.
        places: names along dimensions that have some; levels: the dimension of the states, and where they are.
        attrs: attributes of the whole.
        sites: the stations, where they are known already.
    """

    arrays: Arranged
    coordinates: Arranged
    places: dict[str, tuple[str, ...]]
    levels: tuple[str, Floats]
    attrs: MutableMapping[str, Any] = field(default_factory=dict)
    sites: ResultPlaces | None = None

    @cached_property
    def variables(self) -> _Variables:
        """All arrays by name, coordinates too, in the order of the data set."""
        named: Arranged = {name: ((name,), np.array(names)) for name, names in self.places.items()}
        return _Variables(self.arrays | named | {self.levels[0]: self.levels} | self.coordinates)

    @property
    def coords(self) -> set[str]:
        """Names of the coordinates."""
        return {*self.coordinates, *self.places, self.levels[0]}

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __getitem__(self, name: str) -> PlainArray:
        return self.variables[name]

    @property
    def sizes(self) -> dict[str, int]:
        """Length of every dimension that some array has which need not be made."""
        return {name: size for array in self.variables.there for name, size in array.sizes.items()}

    @property
    def all_sizes(self) -> dict[str, int]:
        """Length of every dimension, in the order of the arrays, all of which are made."""
        return {name: size for array in self.variables.values() for name, size in array.sizes.items()}

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        return sum(array.nbytes for array in self.variables.values())

    def beside(self, arrays: Arranged, places: dict[str, tuple[str, ...]] | None = None) -> StateArrays:
        """Return the same with more arrays, and names along dimensions of theirs."""
        return replace(self, arrays=self.arrays | arrays, places=self.places | (places or {}))

    def data_set(self) -> xr.Dataset:
        """Return the data set, of the same arrays."""
        import xarray as xr

        arrays = {name: _variable(*self.variables[name]) for name in self.arrays}
        return xr.Dataset(arrays, self._indexed(), attrs=dict(self.attrs))

    def along(self, told: dict[str, str], *others: str) -> xr.Coordinates:
        """Return the coordinates of an array over the states and ``others``, which have names.

        ``told`` are attributes of that along the states.
        """
        import xarray as xr

        known = {name: _names(name, self.places[name]) for name in others}
        known[self.levels[0]] = _index(*self.levels)
        variables = {name: variable.copy(deep=False) for name, (_, variable) in known.items()}
        variables[self.levels[0]].attrs = told
        return xr.Coordinates(variables, {name: index for name, (index, _) in known.items()})

    def _indexed(self) -> xr.Coordinates:
        """Return all coordinates; the indexes of places that have names are made once for all results."""
        import xarray as xr

        known = {name: _names(name, names) for name, names in self.places.items()}
        known[self.levels[0]] = _index(*self.levels)
        variables: dict[str, Any] = {name: variable.copy(deep=False) for name, (_, variable) in known.items()}
        variables |= {name: _variable(*self.variables[name]) for name in self.coordinates}
        return xr.Coordinates(variables, {name: index for name, (index, _) in known.items()})


Stored: TypeAlias = "xr.Dataset | StateArrays"
"""What numbers of a result are read from."""


def _variable(dims: tuple[str, ...], values: np.ndarray) -> xr.Variable:
    """Return a variable of a plain array; of one that xarray does not know to be plain it would import Dask."""
    import xarray as xr

    return xr.Variable(dims, values, fastpath=True)


def _index(name: str, values: np.ndarray) -> tuple[Any, xr.Variable]:
    """Return the index of a dimension, and its coordinate."""
    import pandas as pd
    from xarray.indexes import (
        PandasIndex,  # a module that early versions of xarray do not import by themselves
    )

    # of an array xarray would look whether it is one of Pint's, and import that
    index = PandasIndex(pd.Index(values), name, coord_dtype=values.dtype)
    return index, index.create_variables()[name]


@lru_cache
def _names(dimension: str, names: tuple[str, ...]) -> tuple[Any, xr.Variable]:
    """Return the index of a dimension whose places have names, and its coordinate."""
    return _index(dimension, np.array(names))
