"""How far wrong velocities take a model: as far as the vibrations of its present shape go, not those of its start.

Of a rod that has bent far, what is wrong of its velocities along itself looks like one of slow motions about the start,
and would be told to take nodes as far as those go. With ``A = M^-1 K`` of the present shape velocities ``v`` go
``A^-1/2 v``, vibration by vibration. That is a function of a matrix times a vector: of the projection on the Krylov
space of ``(A + s)^-1`` and ``v``, orthonormal by the mass (Ericsson and Ruhe 1980; Higham 2008, section 13.2).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.sparse_lu import solver_within
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["ReachOfVelocities"]

SPACE = 12
"""Vectors of the Krylov space: slow vibrations are exact after fewer, fast ones stay together."""
NOTHING = 1e-14
"""Part of a vector, or of the largest inverse square of a frequency, that is round-off."""


class ReachOfVelocities:
    """Tells how far velocities go in given motions, in the vibrations of a present shape.

    Forces and stiffness are those of statics, so that rods that relax are as soft as they come to be: velocities are
    then told to go farther than they do.

    Args:
        problem: that is solved; modes: small motions about its start.
    """

    def __init__(self, problem: Problem, modes: StartModes) -> None:
        self.problem, self.modes = problem, modes
        self._slowest = float(modes.omega.min(initial=np.inf))
        self._known: _Inertia | None = None

    @cached_property
    def _static(self) -> StaticSolver:
        """A solver with a system of its own: the run goes on with its own one."""
        return StaticSolver(GeometricSystem(self.problem), SupportState(self.problem))

    @cached_property
    def _mass(self) -> sparse.csr_array:
        return block_diagonal(self.problem.mass)

    def _inertia_in(self, basis: sparse.csc_array) -> _Inertia:
        """Return the inertia of motions: where supports do not turn what they leave free, it is found once."""
        if self._known is None or self._known.basis is not basis:
            lengths = np.asarray(basis.multiply(basis).sum(axis=0)).ravel()
            self._known = _Inertia(basis, sparse.csc_array(basis.T @ (self._mass @ basis)), lengths)
        return self._known

    def along(self, shapes: Floats, state: State, t: float, twist: Floats) -> Floats:
        """Return how far body velocities ``twist (n, 6)`` go along each shape, where they go farthest ``(k,)``.

        Each vibration takes them as far as it does, but none farther than that of the shape about the start would.

        Args:
            shapes: vibrations about the start, in the state ``(6 n, k)``; state: at ``t`` [s].

        Where the stiffness cannot be factorised nothing is found, and what the shapes about the start tell is returned.
        """
        tangent = self._static.tangent(state, t)
        basis, mass, lengths = self._inertia_in(tangent.basis)
        shift = self._slowest**2
        stiffness = sparse.csc_array(tangent.stiffness)  # no equilibrium: its symmetric part
        try:
            solve = solver_within(0.5 * (stiffness + stiffness.T) + shift * mass, tangent.gradients)
        except RuntimeError:
            return np.asarray(shapes.T @ (self._mass @ twist.ravel()) / self.modes.omega)
        rates, parts, motions = _vibrations(mass, solve, (basis.T @ twist.ravel()) / lengths, shift)
        seen = shapes.T @ (self._mass @ (basis @ motions))
        return np.asarray((seen / np.maximum(rates, self.modes.omega[:, None])) @ parts)


class _Inertia(NamedTuple):
    """The inertia of the motions that supports leave free.

    Attributes:
        basis: their body increments ``(6 n, free)``, orthogonal; mass: ``(free, free)``; lengths: squared ``(free,)``.
    """

    basis: sparse.csc_array
    mass: sparse.csc_array
    lengths: Floats


def _vibrations(
    mass: sparse.csc_array, solve: Callable[[Floats], Floats], velocity: Floats, shift: float
) -> tuple[Floats, Floats, Floats]:
    """Return frequencies ``(m,)`` [rad/s], parts of a velocity ``(m,)``, and motions ``(n, m)`` that it is made of.

    Args:
        mass: ``(n, n)``; solve: solves systems of the stiffness with ``shift`` times the mass.
        velocity: ``(n,)``.
    """
    basis = np.zeros((len(velocity), SPACE))
    momenta, projected = np.zeros_like(basis), np.zeros((SPACE, SPACE))
    count, vector, momentum = 0, velocity, mass @ velocity
    size = norm = _norm(vector, momentum)
    least = 0.0
    while count < SPACE and norm > least:
        basis[:, count], momenta[:, count] = vector / norm, momentum / norm
        vector = solve(momenta[:, count])
        count += 1
        known, of_known = basis[:, :count], momenta[:, :count]
        along = of_known.T @ vector
        projected[:count, count - 1] = projected[count - 1, :count] = along
        vector = vector - known @ along
        vector = vector - known @ (
            of_known.T @ vector
        )  # the first time leaves round-off of what was taken away
        momentum = mass @ vector
        norm, least = _norm(vector, momentum), NOTHING * float(np.linalg.norm(along))
    inverse, turns = np.linalg.eigh(projected[:count, :count])
    slow = np.abs(inverse) > NOTHING * np.abs(inverse).max(initial=0.0)
    squares = np.full(count, np.inf)
    squares[slow] = 1.0 / inverse[slow] - shift
    parts = size * turns[0] if count else np.zeros(0)
    return np.sqrt(np.maximum(squares, 0.0)), parts, basis[:, :count] @ turns


def _norm(vector: Floats, momentum: Floats) -> float:
    """Return the size of a vector by the mass."""
    return float(np.sqrt(max(float(vector @ momentum), 0.0)))
