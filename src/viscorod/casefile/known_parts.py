"""Parts of cases that were read before: members of a sweep differ in a few numbers, the rest is not read again.

Parts are frozen, so that cases may share them, with all that has been found out of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

__all__ = ["KnownParts", "same"]


class KnownParts:
    """What was made of each place of a case, as it was read last.

    Several parsers read the same place: that of the centre line of a rod, and that of the rod.
    """

    def __init__(self) -> None:
        self._made: dict[tuple[str, Callable[[Any], Any]], tuple[Any, Any]] = {}
        self._judged: tuple[Any, bool] = (None, False)

    def __reduce__(self) -> tuple[type[KnownParts], tuple[()]]:
        """Another process reads parts of its own: to send them takes as long."""
        return KnownParts, ()

    def find(self, path: str, parse: Callable[[Any], Any], content: Any) -> Any:
        """Return what ``parse`` made of the same content at a place; None if it was not the same, or nothing."""
        content_before, part = self._made.get((path, parse), (None, None))
        return part if part is not None and same(content, content_before) else None

    def keep(self, path: str, parse: Callable[[Any], Any], content: Any, part: Any) -> None:
        """Keep what was made of a content, which is not changed from here on."""
        self._made[path, parse] = content, part

    def judge(self, content: Any, question: Callable[[Any], bool]) -> bool:
        """Return what a question about the content that all cases come from is answered with; it is asked once."""
        if self._judged[0] is not content:
            self._judged = content, question(content)
        return self._judged[1]


def same(one: Any, other: Any) -> bool:
    """Return whether two contents are the same: plain values and types of everything, and identical objects."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, float):
        return bool(one == other) and math.copysign(1.0, one) == math.copysign(1.0, other)
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(map(same, one.values(), other.values()))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return isinstance(one, str | int) and bool(one == other)
