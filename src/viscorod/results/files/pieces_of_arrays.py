"""Arrays of files in pieces: what HDF5 calls chunks, each stored and checked by itself."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

__all__ = ["PIECE", "Cut", "cuts", "piece_shape"]

PIECE = 1_000_000
"""Bytes of a piece at most, unless one number has more."""

Cut = tuple[slice, ...]


def piece_shape(shape: Sequence[int], itemsize: int) -> tuple[int, ...]:
    """Return the shape of the pieces of an array: whole last dimensions as far as they fit."""
    left = max(1, PIECE // itemsize)
    found: list[int] = []
    for size in reversed(shape):
        parts = max(1, -(-size // max(1, left)))
        found.insert(
            0, max(1, -(-size // parts))
        )  # of one size, so that the last one is as full as the others
        left //= found[0]
    return tuple(found)


def cuts(shape: Sequence[int], piece: Sequence[int]) -> Iterator[Cut]:
    """Yield the places of all pieces of an array, the last dimension first."""
    if not math.prod(shape):
        return
    sides = [
        [slice(begin, min(begin + step, size)) for begin in range(0, size, step)]
        for size, step in zip(shape, piece, strict=True)
    ]
    yield from itertools.product(*sides)
