"""The matrices of small damped motions as a function of ``s``: ``s^2 M + s D + K + sum_j f_j(s) K_j``.

``f_j(s) = s tau_j/(1 + s tau_j)`` is the complex modulus of a Maxwell branch over its stiffness ``K_j``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.elements.maxwell_branches import add_section_stiffness
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.modes.linearisation import Linearisation, factored
from viscorod.typing import Floats

ITERATIONS = 12
CONVERGED = 1e-13
SURE = 1e-6
"""Last relative change of an eigenvalue by which it has converged at all."""
FAR = 0.1
"""Part of an eigenvalue by which its refinement may move it."""


@dataclass(frozen=True)
class Pencil:
    """Small motions with Maxwell branches as a function of ``s``, beside the conditions of the linearisation."""

    linear: Linearisation
    branches: tuple[sparse.csr_array, ...]
    times: Floats

    @classmethod
    def of(cls, system: System, state: State, linear: Linearisation) -> Pencil:
        """Return it with the branches of a system at ``state``."""
        if system.relaxation is None:
            return cls(linear, (), np.zeros(0))
        found = branch_stiffness(system, system.relaxation, state)
        basis = linear.basis
        return cls(
            linear, tuple(sparse.csr_array(basis.T @ b @ basis) for b in found), system.relaxation.times
        )

    def applied(self, s: complex | np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return what the motion ``x exp(s t)`` leaves of the balance of forces, or many, ``s (k,)``, do."""
        linear = self.linear
        total = linear.stiffness @ x + s * (linear.damping @ x) + s**2 * (linear.mass @ x)
        for branch, tau in zip(self.branches, self.times, strict=True):
            total = total + (s * tau / (1.0 + s * tau)) * (branch @ x)
        return np.asarray(total)

    def at(self, s: complex) -> sparse.csr_array:
        """Return the matrix at ``s`` [1/s]."""
        linear = self.linear
        total = linear.stiffness + s * linear.damping + s**2 * linear.mass
        for branch, tau in zip(self.branches, self.times, strict=True):
            total = total + (s * tau / (1.0 + s * tau)) * branch
        return sparse.csr_array(total)

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """Return its derivative by ``s``, applied to ``x``."""
        linear = self.linear
        total = linear.damping @ x + 2.0 * s * (linear.mass @ x)
        for branch, tau in zip(self.branches, self.times, strict=True):
            total = total + (tau / (1.0 + s * tau) ** 2) * (branch @ x)
        return np.asarray(total)

    def solver(self, s: complex) -> Callable[[np.ndarray], np.ndarray]:
        """Return the inverse of the matrix at ``s`` within the conditions.

        Raises:
            SolveError: it is singular.
        """
        matrix, held = self.at(s), self.linear.gradients
        if held is None:
            factor = factored(matrix)
            return lambda b: np.asarray(factor.solve(b))
        held = held * float(np.abs(matrix.diagonal()).mean())
        saddle = factored(sparse.block_array([[matrix, held.T], [held, None]]))
        none, size = np.zeros(held.shape[0]), matrix.shape[0]
        return lambda b: np.asarray(saddle.solve(np.concatenate([b, none]))[:size])

    def refined(self, s: complex, x: np.ndarray) -> tuple[complex, np.ndarray] | None:
        """Return the eigenvalue and the vector next to ``s`` and ``x`` by Newton's method (inverse iteration).

        None if there is none nearby.
        """
        start, against = s, x.conj() / np.vdot(x, x).real
        last = np.inf
        for _ in range(ITERATIONS):
            try:
                better = self.solver(s)(self.slope(s, x))
            except SolveError:  # exactly singular: this is the eigenvalue
                return s, x
            scale = against @ better
            if not np.isfinite(scale) or scale == 0.0:
                return None
            change = -1.0 / scale * (against @ x)
            x, s = better / scale, s + change
            if abs(s - start) > FAR * abs(start):
                return None
            size, last = last, float(abs(change)) / abs(s)
            if last <= CONVERGED or (size < 1e-6 and last > 0.1 * size):  # round-off
                break
        return (s, x) if last <= SURE else None


def branch_stiffness(system: System, memory: DashpotMemory, state: State) -> list[sparse.csr_array]:
    """Return the stiffness matrices of all branches in body increments of the nodes ``(6 n, 6 n)`` at ``state``."""
    operators, matrix = strain_operators(system, state), Matrix(system.problem.pattern)
    n, found = system.problem.size, []
    for j in range(len(memory.times)):
        matrix.clear()
        modulus = np.ascontiguousarray(memory.branches[:, j])
        add_section_stiffness(system.elements(), modulus, operators.strain, matrix.blocks)
        found.append(sparse.csr_array(matrix.sparse()[: 6 * n, : 6 * n]))
    return found


def strain_operators(system: System, state: State) -> Operators:
    """Return how strains vary with the motions of the nodes at ``state``."""
    n, elements = system.problem.size, system.elements()
    operators, unused = Operators.of(elements), np.zeros((2, *Matrix(system.problem.pattern).blocks.shape))
    system.linearise(state, np.zeros((n, 6, 6)), np.zeros(elements.reference.shape), operators, *unused)
    return operators
