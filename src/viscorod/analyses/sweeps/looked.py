"""What there is to say of the values of members before any is computed, wherever they are looked at."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from viscorod.errors import Fault, InputError

__all__ = ["Looked"]


@dataclass
class Looked:
    """What there is to say of the values of members.

    Attributes:
        chosen: what was chosen for members, by their numbers.
        problems: what is wrong, by place and reason, and the numbers of the members of which it is.
    """

    chosen: dict[int, str] = field(default_factory=dict)
    problems: dict[tuple[str, str], tuple[Fault, list[int]]] = field(default_factory=dict)

    def refuse(self, error: InputError, number: int) -> None:
        """Count what is wrong with a member; the same mistake in many members is reported once."""
        for fault in error.problems:
            self.problems.setdefault((fault.where, fault.why), (fault, []))[1].append(number)

    def add(self, others: Iterable[Looked]) -> None:
        """Count what was said of other members, by several that looked at them."""
        for other in others:
            self.chosen |= other.chosen
            for key, (fault, numbers) in other.problems.items():
                first, known = self.problems.get(key, (fault, []))
                # the value that is told is that of the first of them, in whatever order they were looked at
                told = fault if known and min(numbers) < min(known) else first
                self.problems[key] = told, [*known, *numbers]

    @property
    def notes(self) -> list[str]:
        """What was chosen, in the order of members, each once."""
        return list(dict.fromkeys(note for _, note in sorted(self.chosen.items())))
