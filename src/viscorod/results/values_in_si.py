"""Values of a sweep that were given with units, as numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from viscorod.units import si_and_kind

__all__ = ["in_si"]


def in_si(column: Sequence[Any]) -> Sequence[Any]:
    """Return the values of a key as numbers in SI, if all are numbers or quantities of one kind; else as they are."""
    if not any(isinstance(value, str) for value in column):
        return column
    found: list[float] = []
    kinds = set()
    for value in column:
        read = si_and_kind(value) if isinstance(value, str) else None
        if read is not None:
            kinds.add(read[1])
            found.append(read[0])
        elif isinstance(value, int | float) and not isinstance(value, bool):
            found.append(float(value))
        else:
            return column
    return found if len(kinds) == 1 else column
