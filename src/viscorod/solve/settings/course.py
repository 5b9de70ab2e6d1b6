"""What grows while an analysis goes on, and between which values: for whoever watches it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Course"]


@dataclass(frozen=True)
class Course:
    """What grows while an analysis goes on.

    Attributes:
        name, unit: of what grows, as a line of progress tells it.
        start, end: its values; the end may be less than the start, and is None where nobody knows it beforehand.
    """

    name: str
    unit: str
    start: float
    end: float | None

    def part(self, reached: float) -> float:
        """Return which part of it is done, 0 to 1, at a value that was reached; 0 where nobody knows."""
        if self.end is None or self.end == self.start:
            return 0.0
        return min(max((reached - self.start) / (self.end - self.start), 0.0), 1.0)
