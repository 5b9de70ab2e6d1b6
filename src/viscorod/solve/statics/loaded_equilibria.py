"""Equilibria of one model over its load factor, each found from the nearest known one, and their small motions."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.maxwell_modes import Pencil
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady.quadratic_pencil import QuadraticPencil
from viscorod.solve.tracking.moving_pencil import MovingPencil

__all__ = ["LoadedEquilibria"]

SMALLEST = 1.0 / 1024.0
"""Part of the way between two load factors below which no equilibrium is found in between."""


class LoadedEquilibria:
    """Finds equilibria under multiples of the loads that grow, and their small motions.

    Args:
        static: solver with the stage of the loads that grow; state: the equilibrium without them.
    """

    def __init__(self, static: StaticSolver, state: State) -> None:
        self._static = static
        self._known: dict[float, State] = {0.0: state}
        self.problem = static.system.problem
        self.mass = sparse.csr_array(block_diagonal(self.problem.mass))
        self.iterations = 0

    def state(self, factor: float) -> State:
        """Return the equilibrium at a load factor.

        Raises:
            SolveError: none was found.
        """
        if factor not in self._known:
            near = min(self._known, key=lambda known: abs(known - factor))
            self._known[factor] = self._reached(near, factor)
        return self._known[factor].copy()

    def pencil(self, factor: float) -> MovingPencil:
        """Return the small motions about the equilibrium at a load factor.

        Raises:
            SolveError: there is none.
        """
        state = self.state(factor)
        static = self._static
        static.restore(state, 0.0, before=True, scale=factor)
        linear = linearise(static, state, scale=factor).unconditional()
        found = Pencil.of(static.system, state, linear)
        size = int(linear.mass.shape[0])
        M, D, K = (sparse.csr_array(part) for part in (linear.mass, linear.damping, linear.stiffness))
        quadratic = QuadraticPencil(M, D, K, sparse.csr_array((size, size)), np.zeros((size, 0)))
        times = tuple(float(tau) for tau in found.times)
        return MovingPencil(quadratic, sparse.csr_array(linear.basis), found.branches, times)

    def idle(self, _: float, roots: np.ndarray) -> np.ndarray:
        """Return none of the roots."""
        return np.zeros(len(roots), dtype=bool)

    def principal(self, _: float, shapes: np.ndarray) -> np.ndarray:
        """Return the shapes themselves: any combination of those with one root is as good."""
        return shapes

    def _reached(self, known: float, factor: float) -> State:
        static, state = self._static, self._known[known].copy()
        done, step = 0.0, 1.0
        static.restore(state, 0.0, before=True, scale=known)
        while done < 1.0:
            step = min(step, 1.0 - done)
            trial = state.copy()
            reached = known + (done + step) * (factor - known)
            if done + step > 1.0 - 1e-12:
                reached = factor
            report = static.newton(trial, 0.0, before=True, scale=reached)
            self.iterations += report.iterations
            if report.converged and not static.turns.jumped(state, trial):
                state, done = trial, 1.0 if reached == factor else done + step
                step *= 2.0
                continue
            static.restore(state, 0.0, before=True, scale=known + done * (factor - known))
            step *= 0.5
            if step < SMALLEST:
                last = known + done * (factor - known)
                raise SolveError(
                    f"No equilibrium was found beyond the load factor {last:.6g}, on the way to {factor:.6g}: the "
                    "load may have an extreme there. What to try: a smaller band; model.path follows equilibria "
                    "through limit points"
                )
        return state
