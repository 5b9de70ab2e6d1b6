"""Fields of results read in pieces: a large file stays on disk, and no field is held whole."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.recorded_states import RecordedStates

__all__ = ["blocks", "extremes", "in_states", "largest"]

_BLOCK = 2_000_000  # numbers that are read at once
_GAP = 16  # states between two that are wanted which are read with them


def extremes(result: RecordedStates, quantity: str) -> tuple[Floats, Floats]:
    """Return the least and the largest value over all states everywhere, such as ``(points, 6)``, read in pieces."""
    low = high = None
    for block in blocks(result, quantity):
        first, last = block.min(axis=0), block.max(axis=0)
        low = first if low is None else np.minimum(low, first)
        high = last if high is None else np.maximum(high, last)
    assert low is not None
    assert high is not None
    return low, high


def largest(result: RecordedStates, quantity: str) -> Floats:
    """Return the largest size of every component along the rods in every state ``(states, 6)``, read in pieces."""
    return np.concatenate([np.max(np.abs(block), axis=1) for block in blocks(result, quantity)])


def in_states(variable: xr.DataArray | xr.Variable, along: str, states: Integers) -> Floats:
    """Return a variable in some states ``(states, ...)``, in increasing order, states first; few others are read."""
    most = max(1, _BLOCK // max(1, variable.size // variable.sizes[along]))
    found = np.empty((states.size, *variable.isel({along: 0}).shape))
    begin = 0
    while begin < states.size:
        part = states[begin : begin + most]
        apart = (np.diff(part) > _GAP) | (part[1:] - part[0] >= most)
        part = part[: int(np.argmax(apart)) + 1] if apart.any() else part
        block = variable.isel({along: slice(int(part[0]), int(part[-1]) + 1)}).values
        found[begin : begin + part.size] = block[part - part[0]]
        begin += part.size
    return found


def blocks(result: RecordedStates, quantity: str) -> Iterator[Floats]:
    """Yield a quantity at the Gauss points or stations in pieces, states first."""
    variable = result.stored[quantity]
    states = variable.sizes[result.dimension]
    step = max(1, _BLOCK // max(1, variable.size // states))
    for first in range(0, states, step):
        yield np.asarray(variable.isel({result.dimension: slice(first, first + step)}).values, dtype=float)
