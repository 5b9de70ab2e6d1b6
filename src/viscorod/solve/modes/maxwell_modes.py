"""Small vibrations of rods with Maxwell branches: roots of ``(s^2 M + s D + K + sum_j f_j(s) K_j) x = 0``.

``f_j(s) = s tau_j/(1 + s tau_j)`` is the complex modulus of a branch over its stiffness. Each vibration of the relaxed
rods is followed while the branches grow from nothing to what they are; the real roots by which branches creep, of
which there are as many as branches and strains, are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.elements.maxwell_branches import add_section_stiffness
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.typing import Floats

ITERATIONS = 12
CONVERGED = 1e-13
SHORTEST = 1e-4
"""Part of the branches below which following is given up."""


@dataclass(frozen=True)
class Pencil:
    """The matrices of small motions with Maxwell branches as a function of ``s``."""

    stiffness: sparse.csr_array
    damping: sparse.csr_array
    mass: sparse.csr_array
    branches: tuple[sparse.csr_array, ...]
    times: Floats

    def at(self, s: complex, part: float) -> sparse.csc_array:
        """Return the matrix at ``s`` [1/s] with a ``part`` of the branches."""
        total = self.stiffness + s * self.damping + s**2 * self.mass
        for branch, tau in zip(self.branches, self.times, strict=True):
            total = total + (part * s * tau / (1.0 + s * tau)) * branch
        return sparse.csc_array(total)

    def slope(self, s: complex, part: float) -> sparse.csr_array:
        """Return its derivative by ``s``."""
        total = self.damping + 2.0 * s * self.mass
        for branch, tau in zip(self.branches, self.times, strict=True):
            total = total + (part * tau / (1.0 + s * tau) ** 2) * branch
        return sparse.csr_array(total)


def branch_stiffness(system: System, memory: DashpotMemory, state: State) -> list[sparse.csr_array]:
    """Return the stiffness matrices of all branches in body increments of the nodes ``(6 n, 6 n)`` at ``state``."""
    n, elements = system.problem.size, system.elements()
    operators, matrix = Operators.of(elements), Matrix(system.problem.pattern)
    unused = np.zeros_like(matrix.blocks)
    unstressed = np.zeros(elements.reference.shape)
    system.linearise(state, np.zeros((n, 6, 6)), unstressed, operators, matrix.blocks, unused)
    found = []
    for j in range(len(memory.times)):
        matrix.clear()
        modulus = np.ascontiguousarray(memory.branches[:, j])
        add_section_stiffness(elements, modulus, operators.strain, matrix.blocks)
        found.append(sparse.csr_array(matrix.sparse()[: 6 * n, : 6 * n]))
    return found


def follow_mode(pencil: Pencil, s: complex, vector: np.ndarray) -> tuple[complex, np.ndarray]:
    """Return the eigenvalue [1/s] and the eigenvector that ``s`` and ``vector`` of the relaxed rods become.

    NaN if it is lost: where a vibration is overdamped by its branches, it ends among their real roots.
    """
    part, step = 0.0, 0.5
    while part < 1.0:
        aim = min(1.0, part + step)
        found = _refine(pencil, s, vector, aim)
        if found is None:
            step *= 0.5
            if step < SHORTEST:
                return complex(np.nan, np.nan), vector
            continue
        s, vector = found
        part, step = aim, 2.0 * step
    return s, vector


def _refine(pencil: Pencil, s: complex, vector: np.ndarray, part: float) -> tuple[complex, np.ndarray] | None:
    """Find eigenvalue and vector by Newton's method (inverse iteration); None if it does not converge nearby."""
    import scipy.sparse.linalg as spla

    start = s
    against = vector.conj() / np.vdot(vector, vector).real
    for _ in range(ITERATIONS):
        try:
            factor = spla.splu(pencil.at(s, part))
        except RuntimeError:  # exactly singular: this is the eigenvalue
            return s, vector
        better = factor.solve(pencil.slope(s, part) @ vector)
        scale = against @ better
        if not np.isfinite(scale) or scale == 0.0:
            return None
        change = -1.0 / scale * (against @ vector)
        vector = better / scale
        s = s + change
        if abs(s - start) > 0.5 * abs(start):
            return None
        if abs(change) <= CONVERGED * abs(s):
            return s, vector
    return (s, vector) if abs(change) <= 1e-10 * abs(s) else None
