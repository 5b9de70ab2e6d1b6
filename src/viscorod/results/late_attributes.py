"""Attributes of a result, of which some are made when they are asked for: where a result comes from, for one.

A member of a sweep of which a number is asked has no use for its case as text, nor for the laws of its materials; to
make them takes as long as a tenth of a small equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, MutableMapping
from typing import Any, NamedTuple

__all__ = ["LateAttributes", "Later"]


class Later(NamedTuple):
    """What makes some attributes: their names, and the function; without names it may make any."""

    names: tuple[str, ...]
    make: Callable[[], Mapping[str, Any]]

    def made(self) -> dict[str, Any]:
        """Make them."""
        found = self.make()
        return {name: value for name, value in found.items() if not self.names or name in self.names}

    def without(self, others: Collection[str]) -> Later:
        """Return the same without some of its names, of which it has more, or none at all."""
        return Later(tuple(name for name in self.names if name not in others), self.make)


class LateAttributes(MutableMapping[str, Any]):
    """Attributes of which some are made when one of them is asked for, or all are.

    Joined with others by ``|`` as dictionaries are: of two of one name the right one counts.

    Args:
        known: those that are there.
        later: what makes others, or a function that may make any. A name that nothing else has asks the latter.
    """

    def __init__(self, known: Mapping[str, Any], *later: Later | Callable[[], Mapping[str, Any]]) -> None:
        self._known = dict(known)
        self._later = [one if isinstance(one, Later) else Later((), one) for one in later]

    def __getitem__(self, name: str) -> Any:
        if name not in self._known:
            self._make([one for one in self._later if name in one.names])
        if name not in self._known:
            self._make([one for one in self._later if not one.names])
        return self._known[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self._known[name] = value

    def __delitem__(self, name: str) -> None:
        self._make(list(self._later))
        del self._known[name]

    def __iter__(self) -> Iterator[str]:
        self._make(list(self._later))
        return iter(self._known)

    def __len__(self) -> int:
        self._make(list(self._later))
        return len(self._known)

    def __or__(self, other: Mapping[str, Any]) -> LateAttributes:
        late = other if isinstance(other, LateAttributes) else LateAttributes(other)
        if not late._later:
            return LateAttributes(self._known | late._known, *self._later)
        # what the right one makes later replaces what the left one knows, or would make
        coming = {name for one in late._later for name in one.names}
        known = {name: value for name, value in self._known.items() if name not in coming} | late._known
        mine = [
            one.without(coming) for one in self._later if not one.names or not coming.issuperset(one.names)
        ]
        return LateAttributes(known, *mine, *late._later)

    def __ror__(self, other: Mapping[str, Any]) -> LateAttributes:
        return LateAttributes(other) | self

    def copy(self) -> LateAttributes:
        """Return the same, to be changed."""
        return self | {}

    def _make(self, wanted: list[Later]) -> None:
        for one in reversed(wanted):  # of two that make one name the right one counts
            if one in self._later:
                self._known = {**one.made(), **self._known}
                self._later = [other for other in self._later if other is not one]
