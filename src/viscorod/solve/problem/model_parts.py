"""What stands for the parts of a model where something is found again that was made of the same ones.

Parts are frozen, so that it is enough to compare whether they are the same objects; numbers are compared by their bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.model.rod import Rod

__all__ = ["Alike", "Same", "computed", "part_token", "shape_token", "token"]


class Alike:
    """A model, equal to all that have the same parts.

    Args:
        given: what something is made of; parts: all that it depends on.
    """

    def __init__(self, given: Any, parts: list[Any]) -> None:
        self._given, self._parts = given, parts
        self._number = hash(tuple(parts))

    def taken(self) -> Any:
        """Return what was given, once: what else there is of a model, such as its loads, is not kept."""
        given, self._given = self._given, None
        assert given is not None
        return given

    def __hash__(self) -> int:
        return self._number

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Alike) and self._parts == other._parts


class Same:
    """An object, equal to itself alone; it is kept, so that no other one takes its place."""

    def __init__(self, part: Any) -> None:
        self.part = part

    def __hash__(self) -> int:
        return id(self.part)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.part is other.part


def part_token(part: Any) -> Any:
    """Return what stands for a part of a model: itself, and what its tables hold now, which its user may change."""
    tables = [value for value in getattr(part, "__dict__", {}).values() if isinstance(value, dict)]
    return Same(part), *((key, token(value)) for table in tables for key, value in table.items())


def shape_token(rod: Rod) -> tuple[Any, ...]:
    """Return what of a rod its nodes depend on, and which strains it holds."""
    return rod.centreline, rod.d1, rod.turn, rod.tilt, rod.constrained_strains, rod.elements


def computed(rod: Rod) -> bool:
    """Return whether the shape of a rod comes from functions of its user, who may want other values the next time."""
    return any(map(callable, (rod.turn, rod.tilt, *(value for _, value in rod.centreline))))


def token(value: Any) -> Any:
    """Return what stands for a value: numbers to the last bit, other objects themselves."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if value is None or isinstance(value, bool | int | float | str):
        return repr(value)
    if isinstance(value, tuple):
        return tuple(map(token, value))
    return Same(value)
