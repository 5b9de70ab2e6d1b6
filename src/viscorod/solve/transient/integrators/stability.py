"""What a step of a collocation method makes of a vibration, and how much of its error two halves show."""

from __future__ import annotations

from functools import cache

import numpy as np

from viscorod.solve.transient.integrators.tableau import Tableau

__all__ = ["order", "seen_by_halving", "stability"]


def stability(tableau: Tableau, z: np.ndarray) -> np.ndarray:
    """Return ``R(z) = 1 + z b (1 - z A)^-1 1``, ``z (k,)`` complex (Hairer and Wanner 1996, IV.3.2)."""
    s = len(tableau.nodes)
    stages = np.linalg.solve(np.eye(s) - z[:, None, None] * tableau.matrix, np.ones((len(z), s, 1)))
    return np.asarray(1.0 + z * (stages[:, :, 0] @ tableau.weights))


def order(tableau: Tableau) -> int:
    """Return the order of a collocation method: that of its quadrature (Hairer and Wanner 1996, IV.5.2)."""
    return _order_of_quadrature(tuple(tableau.nodes.tolist()), tuple(tableau.weights.tolist()))


@cache
def _order_of_quadrature(nodes: tuple[float, ...], weights: tuple[float, ...]) -> int:
    c, found = np.array(nodes), 0
    while found < 2 * len(c) and abs(float(np.array(weights) @ c**found) - 1.0 / (found + 1)) < 1e-12:
        found += 1
    return found


def seen_by_halving(tableau: Tableau) -> float:
    """Return which part of the error of a step is its difference from two halves: ``1 - 2^-p``, of order p."""
    return 1.0 - 2.0 ** -order(tableau)
