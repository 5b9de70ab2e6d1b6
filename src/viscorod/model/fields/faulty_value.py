"""A mark in place of a value that is known to be wrong."""

from __future__ import annotations

from typing import Any

__all__ = ["FaultyValue"]


class FaultyValue:
    """Placeholder for a value that is known to be wrong (a misspelt or missing key, an unknown name).

    Whatever the validators say of it, the problem reported is the one given here; `replaces` names the
    missing key that a misspelt one explains; `reported` leaves the problem out because it has been reported
    elsewhere.
    """

    def __init__(
        self, value: Any, why: str = "", instead: str = "", *, replaces: str = "", reported: bool = False
    ) -> None:
        self.value, self.why, self.instead = value, why, instead
        self.replaces, self.reported = replaces, reported

    def __repr__(self) -> str:
        return repr(self.value)
