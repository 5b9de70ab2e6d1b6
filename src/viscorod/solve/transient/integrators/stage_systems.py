"""The two linear systems of a collocation step, real and complex, that are factorised once for many iterations."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.transient.integrators import jacobian
from viscorod.solve.transient.integrators.stage_dashpots import StageDashpots
from viscorod.solve.transient.integrators.stage_data import Discretisation, Matrices, StageFactors
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats


class StageSystems:
    """Matrices ``mu^2 M + mu C + K`` with the eigenvalues ``mu`` of a method, and their factors.

    Args:
        body: the model; scales: of its unknowns ``(6 N,)``; tableau: the method; plan: of factorisations.
        dashpots: Maxwell branches, whose stiffness depends on ``mu``; None if there are none.

    Attributes:
        factors: for compiled code, others after every factorisation.
    """

    def __init__(
        self,
        body: Discretisation,
        scales: Floats,
        tableau: Tableau,
        plan: Plan,
        dashpots: StageDashpots | None,
    ) -> None:
        self.body, self.tableau, self.dashpots = body, tableau, dashpots
        self._several = len(tableau.nodes) > 1
        # without a complex system its solver is the smallest possible
        pair = plan if self._several else Plan.of(Pattern.of(1, ()))
        self.real, self.pair = DirectSolver(plan), DirectSolver(pair, complex)
        self._real_blocks = np.zeros((len(body.pattern.rows), 6, 6))
        self._pair_blocks = np.zeros((len(pair.pattern.rows), 6, 6), dtype=complex)
        self._real_of, self._pair_of = KnownTypes(jacobian.combine), KnownTypes(jacobian.combine)
        self.factors = StageFactors(
            self.real.factors, self.pair.factors, np.ones_like(scales), np.ones_like(scales), scales
        )

    def factorise(self, matrices: Matrices, h: float) -> bool:
        """Factorise for the step ``h`` [s]; False if a matrix is singular."""
        try:
            self._combine(
                self._real_of, matrices, self.tableau.real / h, self.factors.real_rows, self._real_blocks
            )
            self.real.factorise(self._real_blocks)
            if self._several:
                self._combine(
                    self._pair_of,
                    matrices,
                    self.tableau.pair / h,
                    self.factors.complex_rows,
                    self._pair_blocks,
                )
                self.pair.factorise(self._pair_blocks)
        except SingularMatrixError:
            return False
        self.factors = self.factors._replace(real=self.real.factors, complex=self.pair.factors)
        return True

    def solve_real(self, right: Floats) -> Floats:
        """Return the solution with the real matrix for ``right (N, 6)``."""
        x = np.ascontiguousarray(right * self.factors.real_rows.reshape(right.shape))
        self.real.solve(x)
        return np.asarray(x * self.factors.scales.reshape(right.shape))

    def check(self) -> None:
        """Raise what went wrong in solutions within compiled code."""
        self.real.check()
        self.pair.check()

    def _combine(
        self, combine: KnownTypes, matrices: Matrices, mu: complex, rows: Floats, blocks: Floats
    ) -> None:
        body, pattern = self.body, self.body.pattern
        combine(
            matrices.K if self.dashpots is None else self.dashpots.add_stiffness(matrices, mu),
            matrices.C,
            matrices.mass,
            mu,
            body.supports,
            matrices.directions,
            pattern,
            self.factors.scales,
            rows,
            blocks,
        )
