"""Maxwell branches in linear dynamics: the strains of their dashpots, ``alpha_j' = (B xi - alpha_j)/tau_j``.

They count from the state that the model is linear about, in which they are relaxed. At the stages of a collocation
step they follow from the strains there, point by point.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.typing import Floats

__all__ = ["LinearBranches"]


class LinearBranches:
    """Forces, energies and losses of branches for strains ``(m,)`` and dashpot strains ``(n, m)`` of all points.

    Args:
        memory: of the problem, relaxed at the base; elements: its elements.
        operator: strains by displacements ``(m, 6 n)``; basis: free displacements ``(6 n, free)``.

    Attributes:
        times: of relaxation ``(n,)`` [s]; stiffness: of each branch, in the free displacements.
    """

    def __init__(
        self, memory: DashpotMemory, elements: Elements, operator: sparse.csr_array, basis: sparse.csc_array
    ) -> None:
        self.memory, self.times, self._base = memory, memory.times, memory.dashpot.copy()
        weights = elements.half_lengths[:, None] * elements.weights[elements.order]
        self._weighted = [
            block_diagonal((weights[..., None, None] * branch[elements.section]).reshape(-1, 6, 6))
            for branch in np.moveaxis(memory.branches, 1, 0)
        ]
        free = sparse.csr_array(operator @ basis)
        self.stiffness = [sparse.csr_array(free.T @ (weighted @ free)) for weighted in self._weighted]
        self.size = int(operator.shape[0])

    def force(self, strain: Floats, dashpot: Floats) -> Floats:
        """Return the weighted section forces of all branches ``(m,)``."""
        return self._sum(strain - dashpot)

    def _sum(self, springs: Floats) -> Floats:
        total = np.zeros(self.size)
        for weighted, spring in zip(self._weighted, springs, strict=True):
            total += weighted @ spring
        return total

    def powers(self, strain: Floats, dashpot: Floats) -> Floats:
        """Return what each branch dissipates ``(n,)`` [W]."""
        springs = strain - dashpot
        products = [s @ (w @ s) for w, s in zip(self._weighted, springs, strict=True)]
        return np.array(products) / self.times

    def energy(self, strain: Floats, dashpot: Floats) -> float:
        """Return the energy of their springs [J]."""
        return 0.5 * float(self.powers(strain, dashpot) @ self.times)

    def at_stages(self, derivative: Floats, strains: Floats, start: Floats) -> Floats:
        """Return the dashpot strains ``(s, n, m)`` at the stages of a step from those at its start ``(n, m)``.

        Args:
            derivative: from stage values, over the step [1/s] ``(s, s)``; strains: at the stages ``(s, m)``.
        """
        one = np.eye(len(derivative))
        found = [
            first + np.linalg.solve(tau * derivative + one, strains - first)
            for tau, first in zip(self.times, start, strict=True)
        ]
        return np.stack(found, axis=1)

    def added(self, mu: complex) -> sparse.csr_array:
        """Return the stiffness of all branches at a rate ``mu`` [1/s], in the free displacements."""
        parts = [mu * tau / (1.0 + mu * tau) * K for tau, K in zip(self.times, self.stiffness, strict=True)]
        return sparse.csr_array(sum(parts[1:], parts[0]))

    def unfinished(self, mu: float, rates: Floats) -> Floats:
        """Return the weighted section forces by which errors of the dashpots' ``rates (n, m)`` count ``(m,)``."""
        return self._sum(rates / (mu + 1.0 / self.times)[:, None])

    def rates(self, strain: Floats, dashpot: Floats) -> Floats:
        """Return how fast the dashpots give way ``(n, m)`` [1/s]."""
        return (strain - dashpot) / self.times[:, None]

    def remember(self, dashpot: Floats) -> None:
        """Write the dashpot strains into the memory of the problem, from which section forces are found."""
        self.memory.dashpot[:] = self._base + dashpot.reshape(self._base.shape)
