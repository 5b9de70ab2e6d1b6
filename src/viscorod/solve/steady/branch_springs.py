"""Maxwell branches in small motions: springs behind dashpots, one for each strain that relaxes.

With the strain operator B, a Gauss point of weight w and a branch of stiffness ``C_j = L L^T`` the branch exerts

    F^T (F d - z),    z' = (F d - z)/tau_j,    F = sqrt(w) L^T B

on the nodes: symmetric, without energy in rigid motions, and as many unknowns z as the branches have springs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.linearised import Operators
from viscorod.solve.formulations.system import System
from viscorod.typing import Floats

__all__ = ["BranchSprings", "branch_springs"]

NONE = 1e-12
"""Stiffness of a spring over the largest of its branch that is round-off."""


@dataclass(frozen=True)
class BranchSprings:
    """``F (m, 6 n)`` of all springs by body increments of the nodes, and their relaxation times ``(m,)`` [s]."""

    stretch: sparse.csr_array
    times: Floats

    def within(self, basis: sparse.csr_array) -> BranchSprings:
        """Return the same by motions that are columns of a basis ``(6 n, free)``."""
        return BranchSprings(sparse.csr_array(self.stretch @ basis), self.times)


def branch_springs(system: System, operators: Operators) -> BranchSprings | None:
    """Return the springs of all branches with the strain operators of a linearisation; None without branches."""
    memory = system.relaxation
    if memory is None:
        return None
    elements, rows, columns, values, times = system.elements(), [], [], [], []
    count = 0
    for branches, section in ((b, k) for k, b in enumerate(memory.branches)):
        factors = [_factor(C) for C in branches]
        for e, g in zip(*np.nonzero(elements.section == section), strict=True):
            order = int(elements.order[e])
            if g >= order:
                continue
            B = operators.strain[e, 6 * g : 6 * g + 6, : 6 * order + 6]
            at = (6 * elements.nodes[e, : order + 1, None] + np.arange(6)).ravel()
            root = np.sqrt(elements.weights[order, g] * elements.half_lengths[e])
            for factor, tau in zip(factors, memory.times, strict=True):
                F = root * factor @ B
                rows.append(np.repeat(count + np.arange(len(F)), len(at)))
                columns.append(np.tile(at, len(F)))
                values.append(F.ravel())
                times.append(np.full(len(F), tau))
                count += len(F)
    size = 6 * system.problem.size
    if not count:
        return None
    found = sparse.coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(count, size)
    )
    return BranchSprings(sparse.csr_array(found), np.concatenate(times))


def _factor(C: Floats) -> Floats:
    """Return ``L^T (r, 6)`` with ``L L^T`` equal to a stiffness of rank r."""
    value, vector = np.linalg.eigh(C)
    kept = value > NONE * max(float(value[-1]), 0.0)
    return np.asarray((vector[:, kept] * np.sqrt(value[kept])).T)
