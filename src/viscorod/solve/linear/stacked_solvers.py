"""Direct solution with several complex matrices of one pattern, whose factors compiled code takes as one stack."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.factors import Factors
from viscorod.solve.linear.plan import Plan
from viscorod.typing import Floats


class StackedSolvers:
    """One :class:`DirectSolver` per matrix; all follow the same plan, also where that turns out to be unfit for one.

    Args:
        plan: how; count: of matrices, none too.

    Attributes:
        factors: for :func:`~viscorod.solve.linear.substitution.solve_each`. Arrays that differ from matrix to matrix
            have these first; they stay the same while the plan does: look here again after a factorisation.
    """

    factors: Factors

    def __init__(self, plan: Plan, count: int) -> None:
        self._count = count
        self._take(plan)

    def _take(self, plan: Plan) -> None:
        self.plan = plan
        self._solvers = [DirectSolver(plan, complex) for _ in range(self._count)]
        one, count = Factors.of(plan, complex, 0), self._count
        self.factors = one._replace(
            values=np.repeat(one.values[None], count, axis=0),
            fronts=np.repeat(one.fronts[None], count, axis=0),
            integers=np.repeat(one.integers[None], count, axis=0),
            rest=np.repeat(one.rest[None], count, axis=0),
        )
        values, fronts, _, integers, *_, rest = self.factors
        for m, solver in enumerate(self._solvers):
            rest[m] = solver.factors.rest
            solver.factors = one._replace(
                values=values[m], fronts=fronts[m], integers=integers[m], rest=rest[m]
            )

    @property
    def reduction(self) -> KnownTypes:
        """The kernel that factorises one of them."""
        return self._solvers[0].reduction

    def factorise(self, blocks: Floats) -> None:
        """Factorise all matrices, with values ``blocks (p, b, 6, 6)``; raises as :meth:`DirectSolver.factorise`."""
        for solver, values in zip(self._solvers, blocks, strict=True):
            solver.factorise(values)
        for solver in self._solvers:
            if solver.plan is not self.plan:
                self._take(self.plan.plain)
                self.factorise(blocks)
                return

    def check(self) -> None:
        """Raise what went wrong in solutions within compiled code."""
        for solver in self._solvers:
            solver.check()
