"""Linear systems of all stages of a step with their exact Jacobians, and the transposed ones.

GMRES (Saad and Schultz 1986), preconditioned with the matrices ``(mu/h)^2 M + (mu/h) C + K`` of a method's eigenvalues,
which are the whole system where the Jacobians of all stages are one and rotations within the step are small.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import solve_triangular

from viscorod.errors import SolveError
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.nodes.support_rows import Directions
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.problem.problem import Problem
from viscorod.solve.sensitivity.stage_terms import mean_jacobian
from viscorod.solve.sensitivity.transposed_solution import (
    Preconditioner,
    StageSystem,
    Workspace,
    solve_transposed,
)
from viscorod.solve.transient.integrators import jacobian
from viscorod.solve.transient.integrators.stage_data import Discretisation
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

__all__ = ["StageSolver"]

LEFT = 1e-15
"""Of the right side, after preconditioning, where the iteration ends: at 1e-13 of one velocity 1e-4 were left."""
ENOUGH = 1e-9
"""The same, where it goes no further: less is wrong."""
ITERATIONS = 60


class StageSolver:
    """Solves the systems of one step after the other.

    Args:
        problem: the model; tableau: the method; body: the model for kernels; scales: of its unknowns ``(6 N,)``.

    Attributes:
        iterations: so far; work: scratch of compiled code.
    """

    def __init__(self, problem: Problem, tableau: Tableau, body: Discretisation, scales: Floats) -> None:
        self.problem, self.tableau, self.body = problem, tableau, body
        self._scales = scales
        plan, pattern = problem.plan, problem.pattern
        self._mus: list[complex] = [tableau.real, *map(complex, tableau.pairs)]
        self._solvers = [DirectSolver(plan), *(DirectSolver(plan, complex) for _ in tableau.pairs)]
        self._combine = [KnownTypes(jacobian.combine) for _ in self._mus]
        self._rows = [np.ones_like(scales) for _ in self._mus]
        self._blocks = [
            np.zeros((len(pattern.rows), 6, 6), dtype=complex if k else float) for k in range(len(self._mus))
        ]
        self._mean, blocks, n = KnownTypes(mean_jacobian), len(pattern.rows), problem.size
        self._means = [np.zeros((count, 6, 6)) for count in (blocks, blocks, n, n)]
        self._units = np.where(np.arange(6) < 3, 1.0 / problem.length, 1.0)
        self.iterations = 0
        self._transposed = KnownTypes(solve_transposed)
        stages, n = len(tableau.nodes), problem.size
        self.work = Workspace.of((stages, pattern.size, 6), n, ITERATIONS)

    def factorise(
        self,
        K: Floats,
        C: Floats,
        mass: Floats,
        twist: Floats,
        directions: Directions,
        h: float,
        stiffen: Callable[[Floats, complex], Floats] | None = None,
    ) -> None:
        """Factorise for a step of ``h`` [s] with the Jacobians of its stages ``(s, b, 6, 6)``, rows projected.

        Args:
            K, C: derivatives of the balances by poses at constant twists, and by twists; mass: ``(s, n, 6, 6)``.
            twist: of the nodes ``(s, n, 6)``, with which increments turn; directions: of the supports.
            stiffen: adds to the blocks of K what Maxwell branches do at ``s = mu/h``.

        Raises:
            SolveError: a matrix is singular.
        """
        pattern = self.problem.pattern
        mean_K, mean_C, mean_mass, turn = self._means
        fields = pattern.columns, pattern.diagonal, turn, mean_K, mean_C, mean_mass
        self._mean.call(K, C, mass, twist, *fields)
        for k, solver in enumerate(self._solvers):
            mu = self._mus[k] / h if k else float(np.real(self._mus[0])) / h
            self._combine[k].call(
                mean_K if stiffen is None else stiffen(mean_K, mu),
                mean_C,
                mean_mass,
                mu,
                self.body.supports,
                directions,
                pattern,
                self._scales,
                self._rows[k],
                self._blocks[k],
            )
            try:
                solver.factorise(self._blocks[k])
            except SingularMatrixError:
                raise SolveError("the linearisation of a step is singular: it has no derivatives") from None

    def solve(self, apply: Callable[[Floats], Floats], right: Floats) -> Floats:
        """Return the solution ``(s, N, 6)`` of ``apply(p) = right``."""
        units, start = self._units, self._precondition(right)
        found = self._iterate(lambda z: units * self._precondition(apply(z / units)), units * start)
        return np.asarray(found / units)

    def solve_transposed(self, apply: Callable[[Floats], Floats], right: Floats) -> Floats:
        """Return the solution ``(s, N, 6)`` of ``apply(y) = right``, where ``apply`` is the transposed system."""
        units, back = self._units, self._precondition_transposed
        found = self._iterate(lambda z: units * back(apply(z / units)), units * back(right))
        return np.asarray(found / units)

    @property
    def compiled(self) -> bool:
        """Whether :meth:`solve_compiled` knows the method."""
        return len(self._mus) == 2

    def solve_compiled(self, system: StageSystem, right: Floats) -> Floats:
        """Return the solution of the transposed ``system`` as :meth:`solve_transposed` does, in one call.

        Raises:
            SolveError: the iteration did not end.
        """
        factors = [solver.transposed_factors for solver in self._solvers]
        by = Preconditioner(
            self.tableau.to_stages,
            self.tableau.to_modes,
            self._scales,
            self._units,
            self._rows[0],
            self._rows[1],
            factors[0],
            factors[1],
        )
        found = np.empty_like(right)
        count = self._transposed.call(system, by, self.work, right, LEFT, ENOUGH, found)
        for solver in self._solvers:
            solver.check()
        if count < 0:
            raise _unsolved()
        self.iterations += count
        return found

    def solve_real(self, right: Floats) -> Floats:
        """Return the solution with the real matrix for ``right (N, 6)``, as steps have it."""
        x = right.ravel() * self._rows[0]
        self._solvers[0].solve(x)
        return np.asarray((x * self._scales).reshape(right.shape))

    def solve_real_transposed(self, weights: Floats) -> Floats:
        """Return the transpose of :meth:`solve_real` times ``weights (N, 6)``."""
        x = weights.ravel() * self._scales
        self._solvers[0].solve(x, transposed=True)
        return np.asarray((x * self._rows[0]).reshape(weights.shape))

    def _iterate(self, apply: Callable[[Floats], Floats], right: Floats) -> Floats:
        """Return the solution of a system near to the identity, by GMRES."""
        size = float(np.linalg.norm(right))
        if size == 0.0:
            return right
        flat, basis = right.ravel(), np.empty((ITERATIONS + 1, right.size))
        basis[0] = flat / size
        rows, goal = np.zeros((ITERATIONS + 1, ITERATIONS)), np.zeros(ITERATIONS + 1)
        turns: list[tuple[float, float]] = []
        goal[0], k = size, 0
        while abs(goal[k]) > LEFT * size:
            if k == ITERATIONS:
                if abs(goal[k]) > ENOUGH * size:
                    raise _unsolved()
                break
            new = apply(basis[k].reshape(right.shape)).ravel()
            for _ in range(2):  # what one projection leaves, the second removes
                along = basis[: k + 1] @ new
                new = new - along @ basis[: k + 1]
                rows[: k + 1, k] += along
            norm = float(np.linalg.norm(new))
            column = rows[:, k]
            for j, (c, s) in enumerate(turns):
                column[j], column[j + 1] = (
                    c * column[j] + s * column[j + 1],
                    c * column[j + 1] - s * column[j],
                )
            length = math.hypot(column[k], norm)
            turns.append((column[k] / length, norm / length))
            column[k], column[k + 1] = length, 0.0
            c, s = turns[-1]
            goal[k], goal[k + 1] = c * goal[k], -s * goal[k]
            k += 1
            self.iterations += 1
            if norm <= 1e-15 * length:
                break
            basis[k] = new / norm
        best = solve_triangular(rows[:k, :k], goal[:k])
        return np.asarray((best @ basis[:k]).reshape(right.shape))

    def _precondition(self, residual: Floats) -> Floats:
        """Return the changes ``(s, N, 6)`` that take away a residual of the mean Jacobian."""
        modes = self.tableau.to_modes @ residual.reshape(len(residual), -1)
        for k, solver in enumerate(self._solvers):
            if k == 0:
                modes[0] *= self._rows[0]
                solver.solve(modes[0])
            else:
                x = self._rows[k] * (modes[2 * k - 1] + 1j * modes[2 * k])
                solver.solve(x)
                modes[2 * k - 1], modes[2 * k] = x.real, x.imag
        return np.asarray(((self.tableau.to_stages @ modes) * self._scales).reshape(residual.shape))

    def _precondition_transposed(self, weights: Floats) -> Floats:
        """Return the transpose of :meth:`_precondition` times ``weights (s, N, 6)``."""
        modes = self.tableau.to_stages.T @ (weights.reshape(len(weights), -1) * self._scales)
        for k, solver in enumerate(self._solvers):
            if k == 0:
                solver.solve(modes[0], transposed=True)
                modes[0] *= self._rows[0]
            else:
                x = modes[2 * k - 1] - 1j * modes[2 * k]
                solver.solve(x, transposed=True)
                x *= self._rows[k]
                modes[2 * k - 1], modes[2 * k] = x.real, -x.imag
        return np.asarray((self.tableau.to_modes.T @ modes).reshape(weights.shape))


def _unsolved() -> SolveError:
    return SolveError("the linearisation of a step was not solved: its derivatives are unknown")
