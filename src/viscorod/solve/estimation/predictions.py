"""What is fitted: values that depend on unknowns, and their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from viscorod.typing import Floats

__all__ = ["Predictions", "central_differences"]


class Predictions(Protocol):
    """Values ``(n,)`` that depend on unknowns ``(p,)``."""

    def values(self, unknowns: Floats) -> Floats:
        """Return the values ``(n,)``."""

    def jacobian(self, unknowns: Floats, *, rough: bool = False) -> Floats:
        """Return the derivatives of the values by the unknowns ``(n, p)``; in a search, rough ones if cheaper."""

    def hold(self, unknowns: Floats) -> None:
        """Keep what a computation chooses for itself, such as steps of motions, as it is with these unknowns.

        Values are smooth functions of the unknowns then.

        Raises:
            SolveError: there is no solution with them; nothing has changed.
        """

    @property
    def accuracy(self) -> float:
        """Relative error of the derivatives: what they tell apart by less is not told."""


def central_differences(values: Callable[[Floats], Floats], unknowns: Floats, steps: Floats) -> Floats:
    """Return the derivatives of values ``(n, p)`` by differences to both sides.

    Args:
        values: function of the unknowns.
        unknowns: where; steps: to each side ``(p,)``.
    """
    columns = []
    for k, step in enumerate(steps):
        above, below = unknowns.copy(), unknowns.copy()
        above[k] += step
        below[k] -= step
        columns.append((values(above) - values(below)) / (above[k] - below[k]))
    return np.stack(columns, axis=1)
