"""Members with the same values, as discrete distributions and joined tables have them: one of them is computed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice

import numpy as np

from viscorod.results.sweep_members import Rows

__all__ = ["alike", "alike_note"]

NAMED = 5
"""Members that a note names."""


def alike(rows: Rows, numbers: Sequence[int]) -> dict[int, int]:
    """Return those of some members whose values an earlier one of them has, each with the first such member.

    Values are the same that are written the same: 1 and 1.0 are not.
    """
    for column in rows.columns.values():
        some = [column[k] for k in numbers]
        if set(map(type, some)) <= {int, float} and len(np.unique(some)) == len(some):
            return {}
    first, found = dict[int, int](), dict[int, int]()
    for k in numbers:
        text = _text(rows, k)
        before = first.setdefault(hash(text), k)  # the texts of a million members take much memory
        if before != k and _text(rows, before) == text:
            found[k] = before
    return found


def _text(rows: Rows, number: int) -> str:
    return repr([column[number] for column in rows.columns.values()])


def alike_note(found: Mapping[int, int]) -> list[str]:
    """Return what is said of members with the values of others."""
    if not found:
        return []
    few = ", ".join(f"{k} is {one}" for k, one in islice(found.items(), NAMED))
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return [f"members with the same values are computed once: {few}{more}"]
