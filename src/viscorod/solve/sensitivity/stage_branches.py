"""Small changes of the Maxwell branches in a step: they couple the stages, and their dashpots are a part of the state.

The springs of a branch have the strains ``beta = F (eps - alpha_0)`` at the stages, ``F = (1 + h/tau A)^-1``, and the
section forces ``C beta``; the dashpots end with ``alpha = eps - beta`` of the last stage (see
``mechanics.elements.maxwell_branches``). All of it is linear in strains, and the strains follow from the increments of
poses by the operators ``B`` of the stages.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.transient.integrators.stage_dashpots import StageDashpots
from viscorod.typing import Floats

__all__ = ["BranchGradient", "StageBranches"]


class BranchGradient(NamedTuple):
    """Derivatives of a scalar through the branches of a step.

    Attributes:
        start: by the strains of the dashpots at its start ``(n, e, points, 6)``.
        branches: by their stiffnesses ``(sections, n, 6, 6)``; times: by those of relaxation ``(n,)``.
        reference: by the strains of the unstressed shape ``(e, points, 6)``.
    """

    start: Floats
    branches: Floats
    times: Floats
    reference: Floats


class StageBranches:
    """The branches of one step after the other.

    Args:
        dashpots: of an integrator; B: operators of the strains ``(s, e, 6 points, 6 nodes)``, which are written for
            every step; weights: of the Gauss points ``(e, points)`` [m].
    """

    def __init__(self, dashpots: StageDashpots, B: Floats, weights: Floats) -> None:
        self._B, self._weights = B, weights
        self.elements: Elements = dashpots.body.elements
        memory = dashpots.memory
        self.times, self._branches, self._A = memory.times, memory.branches, dashpots.tableau.matrix
        self._modulus = memory.branches[self.elements.section]  # (e, points, n, 6, 6)
        self._points = self.elements.reference.shape
        self._factor: Floats
        self._coupling: Floats
        self._h = 0.0

    def take(self, h: float) -> None:
        """Take a step of ``h`` [s], whose operators are written."""
        unit = np.eye(len(self._A))
        self._h = h
        self._factor = np.asarray(
            np.linalg.inv(unit + (h / self.times)[:, None, None] * self._A), dtype=float
        )
        coupling = np.einsum("nik,mnab->mikab", self._factor, self._branches)
        self._coupling = coupling[self.elements.section]  # (e, points, s, s, 6, 6)

    def strains(self, p: Floats) -> Floats:
        """Return the changes of the strains ``(s, e, points, 6)`` with increments of poses ``p (s, n, 6)``."""
        at = p[:, self.elements.nodes].reshape(*self._B.shape[:2], -1, 1)
        return np.asarray((self._B @ at).reshape(len(p), *self._points))

    def nodal(self, stress: Floats, nodes: int) -> Floats:
        """Return the transpose of :meth:`strains` times ``(s, e, points, 6)``, of so many nodes."""
        flat = stress.reshape(*self._B.shape[:2], 1, -1)
        pushed = (flat @ self._B).reshape(len(stress), *self.elements.nodes.shape, 6)
        found = np.zeros((len(stress), nodes, 6))
        for i, out in enumerate(found):
            np.add.at(out, self.elements.nodes, pushed[i])
        return found

    def forces(self, p: Floats) -> Floats:
        """Return the changes of the nodal forces ``(s, n, 6)`` with increments of poses ``(s, n, 6)``."""
        stress = np.einsum("egikab,kegb->iega", self._coupling, self.strains(p), optimize=True)
        return self.nodal(stress * self._weights[:, :, None], p.shape[1])

    def forces_back(self, weights: Floats) -> Floats:
        """Return the transpose of :meth:`forces` times ``weights (s, n, 6)``."""
        virtual = self.strains(weights) * self._weights[:, :, None]
        return self.nodal(
            np.einsum("egikab,iega->kegb", self._coupling, virtual, optimize=True), weights.shape[1]
        )

    def by_end(self, dashpot: Floats) -> Floats:
        """Return the derivatives by the strains of the stages ``(s, e, points, 6)`` through the dashpots at the end.

        Args:
            dashpot: derivatives by their strains there ``(n, e, points, 6)``.
        """
        found = -np.einsum("nk,nega->kega", self._factor[:, -1], dashpot)
        found[-1] += dashpot.sum(axis=0)
        return np.asarray(found)

    def gradient(self, weights: Floats, dashpot: Floats, strain: Floats, start: Floats) -> BranchGradient:
        """Return the derivatives of a scalar.

        Args:
            weights: by the nodal forces ``(s, n, 6)``; dashpot: by the dashpots at the end ``(n, e, points, 6)``.
            strain: of the stages ``(s, e, points, 6)``; start: of the dashpots at the start ``(n, e, points, 6)``.
        """
        virtual = self.strains(weights) * self._weights[:, :, None]
        F, A = self._factor, self._A
        spring = np.einsum("nik,nkega->niega", F, strain - start[:, None])
        pulled = np.einsum("egnab,iega->niegb", self._modulus, virtual)  # by the strains of the springs
        pulled[:, -1] -= dashpot
        back = np.einsum("nik,niega->nkega", F, pulled)
        by_branches = np.zeros_like(self._branches)
        np.add.at(by_branches, self.elements.section, np.einsum("iega,niegb->egnab", virtual, spring))
        slower = self._h / self.times**2
        by_times = slower * np.einsum("nkega,kl,nlega->n", back, A, spring)
        reference = -back.sum(axis=(0, 1)) - dashpot.sum(axis=0)
        return BranchGradient(-back.sum(axis=1), by_branches, by_times, reference)
