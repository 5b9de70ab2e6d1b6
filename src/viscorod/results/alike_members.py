"""Which members of a sweep have results that differ in numbers only, without reading more of them than is needed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from viscorod.results.files.packed_results import PackedResult
from viscorod.results.stacked_members import difference

if TYPE_CHECKING:
    from viscorod.results.sweep_members import SweepMembers

__all__ = ["differing"]


def differing(members: SweepMembers) -> dict[int, str]:
    """Return what keeps completed members from being stacked on the first one, by their numbers; nothing of others.

    Results in the folder of a sweep know their layout: of each layout one is read, where there are several.
    """
    completed = members.found.completed()
    kept = [k for k in members.found.with_results() if completed[k]]
    layouts = [stored.layout if isinstance(stored := members.stored(k), PackedResult) else "" for k in kept]
    if len(set(layouts)) <= 1 and all(layouts):
        return {}
    known = {layouts[0]: ""} if layouts[0] else {}
    found: dict[int, str] = {}
    first = None
    for k, layout in zip(kept[1:], layouts[1:], strict=True):
        if not layout or layout not in known:
            first = members.data(kept[0]) if first is None else first
            why = difference(first, members.data(k))
        else:
            why = known[layout]
        if layout:
            known[layout] = why
        if why:
            found[k] = why
    return found
