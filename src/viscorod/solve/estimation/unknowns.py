"""Unknown numbers: where they start, between which bounds they lie, and the scale on which they are sought."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.typing import Floats

__all__ = ["Unknown", "Unknowns"]

LARGEST = 690.0
"""Logarithm of the largest number."""
INSIDE = 1e-6
"""Part of the distance between bounds by which a start lies within them."""


@dataclass(frozen=True)
class Unknown:
    """One number that is sought.

    Attributes:
        name: its key in the case, or the name of the nuisance.
        start: where the search begins; low, high: bounds.
        logarithmic: whether it is sought by its logarithm, as positive numbers are.
        nuisance: whether it belongs to the measurement and not to the model.
        unit: of its values.
    """

    name: str
    start: float
    low: float = -np.inf
    high: float = np.inf
    logarithmic: bool = False
    nuisance: bool = False
    unit: str = ""

    @property
    def scale(self) -> float:
        """What a number that may have either sign is measured by."""
        if np.isfinite(self.high - self.low):
            return (self.high - self.low) / 2.0
        return abs(self.start) or 1.0


class Unknowns:
    """Several unknowns with their common coordinates z: logarithms, and numbers over their scale."""

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        self._all = tuple(unknowns)
        self._log = np.array([one.logarithmic for one in self._all], dtype=bool)
        self._scale = np.array([one.scale for one in self._all])

    def __getitem__(self, index: int) -> Unknown:
        return self._all[index]

    def __iter__(self) -> Iterator[Unknown]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    @property
    def names(self) -> tuple[str, ...]:
        """Names in order."""
        return tuple(one.name for one in self._all)

    def coordinates(self, values: Floats) -> Floats:
        """Return z of values."""
        positive = np.where(self._log, values, 1.0)
        return np.where(self._log, np.log(positive), values / self._scale)

    def values(self, z: Floats) -> Floats:
        """Return the values at z."""
        powers = np.clip(np.where(self._log, z, 0.0), -LARGEST, LARGEST)  # far beyond what any case takes
        found: Floats = np.where(self._log, np.exp(powers), z * self._scale)
        return found

    def slopes(self, z: Floats) -> Floats:
        """Return the derivatives of the values by z."""
        return np.where(self._log, self.values(z), self._scale)

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest z."""
        low, high = (
            np.array([self._bound(one, getattr(one, side), sign) for one in self._all])
            for side, sign in (("low", -1.0), ("high", 1.0))
        )
        return low, high

    @property
    def start(self) -> Floats:
        """Return z of the starts, a little inside the bounds."""
        low, high = self.bounds
        room = np.where(np.isfinite(high - low), INSIDE * (high - low), 0.0)
        inside: Floats = np.clip(
            self.coordinates(np.array([one.start for one in self._all])), low + room, high - room
        )
        return inside

    @staticmethod
    def _bound(one: Unknown, value: float, sign: float) -> float:
        if not one.logarithmic:
            return value / one.scale
        return float(np.log(value)) if 0.0 < value < np.inf else sign * np.inf
