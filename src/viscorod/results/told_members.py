"""What is told of members, in few lines: those of whom the same is said share one."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["told_members"]

_PIECES = 8
"""Of the numbers of members in a line."""


def told_members(messages: Mapping[int, str], most: int) -> list[str]:
    """Return lines "members 3, 5 to 9: why", in the order of the first of each.

    Args:
        messages: by member, in order; most: lines.
    """
    who: dict[str, list[int]] = {}
    for number, message in messages.items():
        who.setdefault(message, []).append(number)
    lines = [f"{_named(numbers)}: {message}" for message, numbers in who.items()]
    more = sum(map(len, list(who.values())[most:]))
    return lines[:most] + ([f"and messages of {more} more members in the table"] if more else [])


def _named(numbers: list[int]) -> str:
    """Return "member 3" or "members 3, 5 to 9"; of many pieces the first ones and how many there are."""
    if len(numbers) == 1:
        return f"member {numbers[0]}"
    pieces: list[list[int]] = []
    for number in numbers:
        if pieces and number == pieces[-1][1] + 1:
            pieces[-1][1] = number
        else:
            pieces.append([number, number])
    words = [str(a) if a == b else f"{a} to {b}" if b > a + 1 else f"{a}, {b}" for a, b in pieces]
    if len(words) > _PIECES:
        return f"{len(numbers)} members ({', '.join(words[:_PIECES])}, ...)"
    return f"members {', '.join(words)}"
