"""Small motions in which parts move as rigid ones, carried along with the parts as these turn against each other."""

from __future__ import annotations

import numpy as np

from viscorod.solve.constraints.parts import Parts, count_of_parts, held_motions, many_parts
from viscorod.solve.constraints.rigid_motions import motions_of_parts, rigid_share
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.typing import Floats

__all__ = ["CarriedModes"]

WHOLE = 0.999
"""Part of the kinetic energy of a shape in rigid motions of parts from which on it is one of these."""
OPEN = 1e-2
"""How much supports and joints may resist a motion that strains of the parts have bent away from what they allow."""
HEAVY = 1e-12


class CarriedModes:
    """The shapes of small motions about a start, in later states.

    Body increments of a single part that turns stay as they are. Where parts turn against each other, as the links of
    a mechanism do, joints allow others: the nearest of them, by the mass, take the place of those of the start. Shapes
    that strain the parts are left as they are.

    Args:
        modes: about the start; problem: that they are of; start: the state.
    """

    def __init__(self, modes: StartModes, problem: Problem, start: State) -> None:
        self.modes, self.problem = modes, problem
        both = np.hstack([modes.shapes, modes.rigid])
        self._whole = np.zeros(both.shape[1], dtype=bool)
        self._free = 0
        if both.shape[1] and count_of_parts(problem) > 1 and not many_parts(problem):
            self._whole = rigid_share(problem, start.r, start.q, both) > WHOLE
            held, gradients = self._conditions(start, Parts.of(problem, start.r, start.q))
            self._free = len(motions_of_parts(problem, start.r, start.q, held, gradients).found)
        if self._carries:
            self._momenta = block_diagonal(problem.mass) @ both[:, self._whole]

    @property
    def _carries(self) -> bool:
        """Whether any motions are others in other states."""
        return self._free > 0 and bool(self._whole.any())

    def at(self, state: State) -> tuple[Floats, Floats]:
        """Return the shapes of vibrations ``(6 n, k)`` and those of rigid motions ``(6 n, m)`` in a state."""
        modes = self.modes
        if not self._carries:
            return modes.shapes, modes.rigid
        allowed = self._allowed(state)
        left, _, right = np.linalg.svd(allowed.T @ self._momenta, full_matrices=False)
        both = np.hstack([modes.shapes, modes.rigid])
        both[:, self._whole] = allowed @ (left @ right)
        k = modes.shapes.shape[1]
        return both[:, :k], both[:, k:]

    def _allowed(self, state: State) -> Floats:
        """Return the rigid motions of parts that supports and joints allow, orthonormal by the mass ``(6 n, m)``."""
        problem, parts = self.problem, Parts.of(self.problem, state.r, state.q)
        counted = problem.joints.arrays.place >= 0
        A = parts.condition_matrix(parts.conditions(*self._conditions(state, parts), counted)).toarray()
        # all of them: LAPACK's methods for some eigenvalues may fail where many are zero but for round-off
        values, motions = np.linalg.eigh(A.T @ A)
        motions = motions[:, : self._free][:, values[: self._free] < OPEN**2]
        found = parts.increments(motions.T.reshape(-1, parts.count, 6)).reshape(motions.shape[1], -1).T
        inertia, turn = np.linalg.eigh(found.T @ (block_diagonal(problem.mass) @ found))
        heavy = inertia > HEAVY * inertia.max(initial=0.0)
        return np.asarray(found @ turn[:, heavy] / np.sqrt(inertia[heavy]))

    def _conditions(self, state: State, parts: Parts) -> tuple[list[Floats], Floats]:
        """Return the derivatives of the motions of supports and of the coordinates of joints in a state."""
        still = np.zeros((self.problem.size, 6))
        gradients = self.problem.joints.measure(state.r, state.q, still)[2]
        return held_motions(self.problem, parts.R), gradients
