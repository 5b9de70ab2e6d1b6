"""What joints, springs and held strains remember from step to step, and polynomials through the stages of the last."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

__all__ = ["LinkMemory", "through_stages"]


class LinkMemory(NamedTuple):
    """Joints, springs and held strains at the present time, and in the last step.

    Attributes:
        multiplier: ``(places,)``; value, rate, force: of all coordinates ``(c,)``, at the present time.
        multipliers, forces: at the start and at the stages of the last step ``(s + 1, places)``, ``(s + 1, c)``.
        drift: largest gap of positions over the length (or in rad, or strain), and of recorded velocities over the
            fastest one, so far ``(2,)``.
    """

    multiplier: Floats
    value: Floats
    rate: Floats
    force: Floats
    multipliers: Floats
    forces: Floats
    drift: Floats

    @classmethod
    def of(cls, stages: int, places: int, coordinates: int) -> LinkMemory:
        """Allocate."""
        value, rate, force = np.zeros((3, coordinates))
        past = np.zeros((stages + 1, places)), np.zeros((stages + 1, coordinates))
        return cls(np.zeros(places), value, rate, force, *past, np.zeros(2))


def through_stages(method: Tableau, places: Floats, known: Floats) -> Floats:
    """Return the values ``(k, m)`` at ``places (k,)`` of polynomials through start and stages, ``known (s + 1, m)``.

    The compiled loop of steps sums in the same order, so that its numbers are the same, bit for bit.
    """
    weights, power = np.zeros((len(places), len(method.nodes))), places
    for values in method.values.T:
        weights += power[:, None] * values
        power = power * places
    total = np.zeros((len(places), known.shape[1]))
    for weight, stage in zip(weights.T, known[1:], strict=True):
        total += weight[:, None] * (stage - known[0])
    return np.asarray(known[0] + total)
