"""What is told of members, in few lines: those of whom the same is said share one, also where numbers in it differ."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

__all__ = ["told_members"]

_PIECES = 8
"""Of the numbers of members in a line."""
_NUMBER = re.compile(r"(?<![\w\[.])(?<!bend )(?<!shear )(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)(?![\w\]])")
"""A number that is no part of a name, such as loads[1] or bend 2."""
_PARTS = re.compile(r"; (?=warning: )")
"""Between the warnings in the message of a member."""


def told_members(messages: Mapping[int, str], most: int) -> list[str]:
    """Return lines "members 3, 5 to 9: why", in the order of the first of each.

    What is said of several members with other numbers is one line with their ranges: "off by 5.1 to 22 %".

    Args:
        messages: by member, in order; most: lines.
    """
    said: dict[str, dict[int, str]] = {}
    for number, message in messages.items():
        for part in _PARTS.split(message):
            said.setdefault(_NUMBER.sub("#", part), {})[number] = part
    lines = [f"{_named(list(texts))}: {_together(list(texts.values()))}" for texts in said.values()]
    more = len(lines) - most
    return lines[:most] + (
        [f"and {more} more {'messages' if more > 1 else 'message'} in the table"] * (more > 0)
    )


def _together(texts: Sequence[str]) -> str:
    """Return texts that differ in numbers at most as one, with the range of each number."""
    pieces = _NUMBER.split(texts[0])  # every second one is a number
    columns = zip(*(_NUMBER.findall(text) for text in texts), strict=True)
    for k, column in enumerate(columns):
        low, high = min(column, key=float), max(column, key=float)
        pieces[2 * k + 1] = low if float(low) == float(high) else f"{low} to {high}"
    return "".join(pieces)


def _named(numbers: list[int]) -> str:
    """Return "member 3" or "5 members (3, 5 to 8)"; of many pieces the first ones."""
    if len(numbers) == 1:
        return f"member {numbers[0]}"
    pieces: list[list[int]] = []
    for number in numbers:
        if pieces and number == pieces[-1][1] + 1:
            pieces[-1][1] = number
        else:
            pieces.append([number, number])
    words = [str(a) if a == b else f"{a} to {b}" if b > a + 1 else f"{a}, {b}" for a, b in pieces]
    more = ", ..." if len(words) > _PIECES else ""
    return f"{len(numbers)} members ({', '.join(words[:_PIECES])}{more})"
