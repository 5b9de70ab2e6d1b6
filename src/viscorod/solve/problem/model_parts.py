"""What stands for the parts of a model where something is found again that was made of the same ones.

Parts that consist of numbers and words are compared by these, numbers by their bits: a model that is written anew has
them again. Others, such as functions and what was read from a file, are compared as objects, for parts are frozen.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from viscorod.model.fields.definition import Definition
from viscorod.model.rod import Rod

__all__ = ["Alike", "Same", "computed", "part_token", "shape_token", "token"]

NAME = "_content"
"""Under which parts keep what stands for them."""
OURS = f"{__name__.partition('.')[0]}."


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
    """Return what stands for a part of a model, and for what its tables hold now, which its user may change."""
    own = token(part)
    if not isinstance(own, Same):
        return own
    tables = [value for value in getattr(part, "__dict__", {}).values() if isinstance(value, dict)]
    return own, *((key, token(value)) for table in tables for key, value in table.items())


def shape_token(rod: Rod) -> tuple[Any, ...]:
    """Return what of a rod its nodes depend on, and which strains it holds."""
    return rod.centreline, rod.d1, rod.turn, rod.tilt, rod.constrained_strains, rod.elements


def computed(rod: Rod) -> bool:
    """Return whether the shape of a rod comes from functions of its user, who may want other values the next time."""
    return any(map(callable, (rod.turn, rod.tilt, *(value for _, value in rod.centreline))))


def token(value: Any) -> Any:
    """Return what stands for a value: numbers to the last bit, what consists of them, and other objects themselves."""
    found = _content(value)
    return Same(value) if found is None else found


def _content(value: Any) -> Any:
    """Return what stands for a value that consists of numbers and words; None if it holds anything else."""
    if value is None or isinstance(value, bool | int | float | str):
        return repr(value)
    if isinstance(value, np.ndarray):
        return None if value.dtype.hasobject else (value.shape, value.dtype.str, value.tobytes())
    if isinstance(value, tuple):
        return _all_of(tuple, value)
    if isinstance(value, dict):
        return _all_of(dict, (part for pair in value.items() for part in pair))
    if isinstance(value, Definition):
        return _definition(value)
    return None


def _all_of(kind: type, values: Iterable[Any]) -> tuple[Any, ...] | None:
    """Return what stands for values that belong together; None if one of them is not of numbers and words."""
    found: list[Any] = [kind]
    for value in values:
        content = _content(value)
        if content is None:
            return None
        found.append(content)
    return tuple(found)


def _definition(part: Definition) -> Any:
    """Return what stands for a part of a model by its fields, and keeps it with a part that never changes."""
    kind = type(part)
    known = vars(part).get(NAME)
    if known is not None:
        return known
    fields = kind.model_fields
    # files may hold something else by now, and classes of the user know more than their fields
    if part.__pydantic_private__ or "file" in fields or not kind.__module__.startswith(OURS):
        return None
    values = [getattr(part, name) for name in fields]
    found = _all_of(kind, values)
    if found is not None and all(map(_lasts, values)):
        vars(part)[NAME] = found
    return found


def _lasts(value: Any) -> bool:
    """Return whether nobody can change what a value consists of."""
    if isinstance(value, tuple):
        return all(map(_lasts, value))
    if isinstance(value, Definition):
        return NAME in vars(value)
    return not isinstance(value, dict | np.ndarray)
