"""Arrays of a data set that are computed when they are first read."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from xarray.backends import BackendArray
from xarray.core import indexing

from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["DeferredArray", "defer"]


class DeferredArray(BackendArray):
    """An array of real numbers of a known shape, computed once, when some of it is read.

    A pickled copy holds the numbers.

    Args:
        shape: of the array; make: returns it.
    """

    def __init__(self, shape: tuple[int, ...], make: Callable[[], Floats]) -> None:
        self.shape, self.dtype, self._make = shape, np.dtype(float), make

    @cached_property
    def values(self) -> Floats:
        """The numbers."""
        found = np.asarray(self._make(), dtype=float).reshape(self.shape)
        del self._make
        return found

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return a part of the array."""
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, self.values.__getitem__
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return indexing.NumpyIndexingAdapter, (self.values,)


def defer(variable: xr.Variable, make: Callable[[], Floats]) -> None:
    """Let a variable have other numbers, which ``make`` returns when they are first read."""
    given: Any = indexing.LazilyIndexedArray(DeferredArray(variable.shape, make))
    variable.data = given
