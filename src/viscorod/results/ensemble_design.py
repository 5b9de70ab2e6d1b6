"""How the members of an ensemble were chosen."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from viscorod.errors import InputError

__all__ = ["Design"]


@dataclass(frozen=True)
class Design:
    """How the members of an ensemble were chosen.

    Attributes:
        keys: that are uncertain.
        distributions: theirs, in words.
        n: number of points.
        seed: of the sequence.
        indices: whether every point has rows for Sobol' indices: A, B and one per key.
        correlation: matrix of the correlations, in the order of the keys; empty if they are independent.
    """

    keys: tuple[str, ...]
    distributions: tuple[str, ...]
    n: int
    seed: int
    indices: bool
    correlation: tuple[tuple[float, ...], ...] = ()

    @property
    def rows(self) -> int:
        """How many members every point has."""
        return len(self.keys) + 2 if self.indices else 1

    @property
    def samples(self) -> int:
        """How many of these, the first ones, are samples of the distributions: A and B of those for indices."""
        return 2 if self.indices else 1

    @property
    def members(self) -> int:
        """How many members it has."""
        return self.n * self.rows

    @property
    def record(self) -> str:
        """The design as JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def of_record(cls, text: str, where: str) -> Design:
        """Return the design that was recorded.

        Raises:
            InputError: the record is damaged.
        """
        try:
            found = json.loads(text)
            return cls(
                tuple(map(str, found["keys"])),
                tuple(map(str, found["distributions"])),
                int(found["n"]),
                int(found["seed"]),
                bool(found["indices"]),
                tuple(tuple(map(float, row)) for row in found.get("correlation", ())),
            )
        except (KeyError, TypeError, ValueError):
            raise InputError(f"{where} is damaged: it does not say how its members were chosen") from None
