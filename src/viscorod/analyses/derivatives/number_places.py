"""Where in the content of a part a number stands: at one place, or at several that are one number.

A section's matrices are written as diagonals or by the names of their stiffnesses, a matrix that is symmetric has each
number beside its diagonal twice, and a plain number in the place of a function of time is a constant one.
"""

from __future__ import annotations

import math
from typing import Any

from viscorod.model.sections.named_numbers import INERTIA_NAMES, STIFFNESS_NAMES

__all__ = ["places_of"]

Way = list[str | int]

MATRICES = ("stiffness", "damping", "inertia")
"""Words of symmetric matrices."""


def places_of(content: dict[str, Any], within: Way) -> list[Way]:
    """Return the ways to all places of a number, the first one that of its value; as it is where it leads nowhere."""
    *before, last = within
    around, before = _around(content, before)
    if isinstance(last, str) and isinstance(around, list):
        return [[*before, *more] for more in _named(around, str(before[-1]), last)] or [within]
    if isinstance(around, dict) and isinstance(last, str):
        found = around.get(last)
        constant = isinstance(found, dict) and found.get("kind") == "constant" and "level" in found
        return [[*within, "level"]] if constant else [within]
    if not isinstance(last, int) or not before:
        return [within]
    if before[-1] in MATRICES and _diagonal(around) and 0 <= last < len(around):
        return [[*within, last]]
    outer, way = _around(content, before[:-1])
    row = before[-1]
    if isinstance(row, int) and way and way[-1] in MATRICES and _symmetric(outer) and row != last:
        return [within, [*way, last, row]]
    return [within]


def _around(content: Any, way: Way) -> tuple[Any, Way]:
    """Return what stands at the end of a way; None if it leads nowhere."""
    place = content
    for word in way:
        try:
            place = place[word]
        except (KeyError, IndexError, TypeError):
            return None, way
    return place, way


def _named(values: list[Any], field: str, name: str) -> list[Way]:
    """Return the ways within a matrix, or a list of six numbers, to one of them by its name."""
    if len(values) != 6:
        return []
    matrix = _square(values)
    if field == "inertia" and matrix and name in INERTIA_NAMES:
        if name == "mass":
            return [[k, k] for k in range(3)]
        k = 2 + INERTIA_NAMES.index(name)
        first, second, both = (values[i][i] for i in (3, 4, 5))
        along = k < 5 and math.isclose(both, first + second, rel_tol=1e-12)
        return [[k, k], [5, 5]] if along else [[k, k]]
    if field != "inertia" and name in STIFFNESS_NAMES:
        k = STIFFNESS_NAMES.index(name)
        return [[k, k]] if matrix else [[k]]
    return []


def _square(values: Any) -> bool:
    return isinstance(values, list) and all(
        isinstance(row, list) and len(row) == len(values) for row in values
    )


def _diagonal(values: Any) -> bool:
    return _square(values) and not any(
        x != 0.0 for i, row in enumerate(values) for j, x in enumerate(row) if i != j
    )


def _symmetric(values: Any) -> bool:
    return _square(values) and all(values[i][j] == values[j][i] for i in range(len(values)) for j in range(i))
