"""The linear systems of a collocation step, one real, the others complex, factorised once for many iterations."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.plan import Plan
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.linear.stacked_solvers import StackedSolvers
from viscorod.solve.transient.integrators import jacobian
from viscorod.solve.transient.integrators.stage_dashpots import StageDashpots
from viscorod.solve.transient.integrators.stage_data import Discretisation, Matrices, StageFactors
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats


class StageSystems:
    """Matrices ``mu^2 M + mu C + K`` with the eigenvalues ``mu`` of a method, and their factors.

    Args:
        body: the model; scales: of its unknowns ``(6 N,)``; tableau: the method; plan: of factorisations,
            without the nodes that are held.
        dashpots: Maxwell branches, whose stiffness depends on ``mu``; None if there are none.

    Attributes:
        factors: for compiled code; the same object as long as the plan is.
    """

    unsaved = frozenset({"_eigenvalues", "_pair_blocks", "_real_blocks", "_wanted"})

    def __init__(
        self,
        body: Discretisation,
        scales: Floats,
        tableau: Tableau,
        plan: Plan,
        dashpots: StageDashpots | None,
    ) -> None:
        self.body, self.tableau, self.dashpots = body, tableau, dashpots
        self._eigenvalues: list[complex] = tableau.pairs.tolist()
        blocks, pairs = len(body.pattern.rows), len(tableau.pairs)
        self.real, self.pairs = DirectSolver(plan), StackedSolvers(plan, pairs)
        self._real_blocks = np.zeros((blocks, 6, 6))
        self._pair_blocks = np.zeros((pairs, blocks, 6, 6), dtype=complex)
        self._wanted: tuple[Matrices, float] | None = None
        self.combination, self.pair_combination = KnownTypes(jacobian.combine), KnownTypes(jacobian.combine)
        self.factors = StageFactors(
            self.real.factors,
            self.pairs.factors,
            np.ones_like(scales),
            np.ones((pairs, len(scales))),
            scales,
        )

    @property
    def blocks(self) -> tuple[Floats, Floats]:
        """Blocks of the real and of the complex matrices, which factorisations overwrite."""
        return self._real_blocks, self._pair_blocks

    def want(self, matrices: Matrices, h: float) -> None:
        """Factorise for the step ``h`` [s] as soon as the factors are needed, unless others are before."""
        self._wanted = matrices, h

    def provide(self) -> None:
        """Factorise what is wanted."""
        if self._wanted is not None:
            self.factorise(*self._wanted)

    def factorise(self, matrices: Matrices, h: float) -> bool:
        """Factorise for the step ``h`` [s]; False if a matrix is singular."""
        self._wanted = None
        real, pairs, rows, pair_rows, _ = self.factors
        self._combine(self.combination, matrices, self.tableau.real / h, rows, self._real_blocks)
        for m, pair in enumerate(self._eigenvalues):
            self._combine(self.pair_combination, matrices, pair / h, pair_rows[m], self._pair_blocks[m])
        try:
            self.real.factorise(self._real_blocks)
            self.pairs.factorise(self._pair_blocks)
        except SingularMatrixError:
            return False
        if real is not self.real.factors or pairs is not self.pairs.factors:
            self.factors = self.factors._replace(real=self.real.factors, pairs=self.pairs.factors)
        return True

    def solve_real(self, right: Floats) -> Floats:
        """Return the solution with the real matrix for ``right (N, 6)``; held nodes do not move."""
        self.provide()
        x = np.ascontiguousarray(right * self.factors.real_rows.reshape(right.shape))
        x[list(self.real.plan.without)] = 0.0
        self.real.solve(x)
        return np.asarray(x * self.factors.scales.reshape(right.shape))

    def check(self) -> None:
        """Raise what went wrong in solutions within compiled code."""
        if not self.real.plan.banded or not self.pairs.plan.banded:
            self.real.check()
            self.pairs.check()

    def _combine(
        self, combine: KnownTypes, matrices: Matrices, mu: complex, rows: Floats, blocks: Floats
    ) -> None:
        body = self.body
        combine.call(
            matrices.K if self.dashpots is None else self.dashpots.add_stiffness(matrices, mu),
            matrices.C,
            matrices.mass,
            mu,
            body.supports,
            matrices.directions,
            body.pattern,
            self.factors.scales,
            rows,
            blocks,
        )
