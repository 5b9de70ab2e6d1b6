"""Newton's method on the balance at one instant, from Python: arrays that are kept, and what compiled code leaves."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.mechanics.compilation.by_address import address_of
from viscorod.mechanics.compilation.callback import Callback
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.gauss_batch import PointFields
from viscorod.mechanics.elements.geometric_element import Assembled, assemble
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.transient.integrators import momentum_balance
from viscorod.solve.transient.integrators.kernel_results import NOTHING, NUMBER
from viscorod.solve.transient.integrators.momentum_balance import (
    ASSEMBLED,
    BalanceBody,
    Instant,
    Iterate,
    Places,
    Solver,
    solve_balance,
)
from viscorod.typing import Floats

__all__ = ["BalanceIteration"]


class BalanceIteration:
    """Solves the balance at one instant after the other.

    Args:
        system, supports: the model; maps: of increments to twists ``(n, 6, 6)``, written.

    Attributes:
        residual: before the last change ``(N, 6)``, of the balance as it is solved.
    """

    def __init__(self, system: GeometricSystem, supports: SupportState, maps: Floats) -> None:
        problem, matrix = system.problem, system.matrix
        self.system, self.supports = system, supports
        n, rows = problem.size, problem.pattern.size
        held = supports.set.nodes[supports.complete]
        self._body = BalanceBody(
            system.batches,
            problem.mass,
            held,
            supports.nodes,
            problem.pattern,
            matrix.scales,
            matrix.scaled,
            problem.length,
        )
        self._maps, self._right = maps, np.zeros(6 * rows)
        self.residual: Floats = np.zeros((rows, 6))
        self._moved = self._right.reshape(-1, 6)[:n]
        self._still = np.zeros((len(held), 3)), np.zeros((len(held), 4)), np.zeros((len(held), 6))
        self._numbers = np.zeros(momentum_balance.NUMBERS, dtype=np.int64)
        self._sizes = np.zeros(2)
        self._rest = Callback(self._do_rest)
        self._message = np.zeros(1)
        self._assembly = KnownTypes(assemble)
        self._kernel = KnownTypes(solve_balance)
        self._given: tuple[Any, ...] = ()
        self._known: tuple[KnownTypes, int, int] | None = None
        self._at: tuple[State, LoadState]

    def begin(
        self,
        old: State,
        new: State,
        increment: Floats,
        relation: tuple[float, Floats, Floats],
        loads: LoadState,
    ) -> None:
        """Set up the balance that ``increment``, which is predicted, leads to from the state ``old``.

        Args:
            new: state that is written; relation: slope, constant and history of
                :class:`~viscorod.solve.transient.integrators.generalized_alpha.Relation`; loads: that act there.
        """
        system, supports, matrix = self.system, self.supports, self.system.matrix
        self._at = new, loads
        elements, points = system.lend(loads)
        system.hold_stress(new)
        slope, constant, history = relation
        moving = supports.moving and len(supports.complete) > 0
        motion = supports.complete_motion()[:3] if moving else self._still
        at = Instant(
            old.r,
            old.q,
            slope,
            constant,
            history,
            moving,
            *motion,
            loads.nodes,
            loads.dead,
            loads.following,
            loads.gravity,
            loads.levers,
            supports.target,
        )
        now = Iterate(
            new.r,
            new.q,
            new.twist,
            increment,
            self._maps,
            system.internal,
            system.external,
            matrix.blocks,
            self.residual,
            self._right,
            self._moved,
            supports.reaction,
            supports.directions,
        )
        solver = matrix.solver
        places = Solver(*solver.places, solver.factors, solver.plan.banded)
        calls = Places(*self._addresses(elements, points, now), self._message)
        self._numbers[:], self._sizes[momentum_balance.LAST] = 0, np.inf
        self._given = (self._body, elements, points, at, now, places, calls, self._numbers, self._sizes)

    def run(self, tolerance: float, limit: int) -> tuple[int, float]:
        """Iterate to the end; return the verdict (of ``iteration_verdict``) and the size of the last change.

        Args:
            tolerance: of the last change (displacement over length, rotation [rad]); limit: allowed iterations.

        Raises:
            SingularMatrixError: the matrix is singular.
        """
        numbers, sizes = self._numbers, self._sizes
        sizes[momentum_balance.TOLERANCE], numbers[momentum_balance.LIMIT] = tolerance, limit
        while True:
            verdict = self._kernel.call(*self._given)
            if verdict == momentum_balance.RAISED:
                self._rest.check()
            if verdict != momentum_balance.ASK:
                return verdict, float(sizes[momentum_balance.LAST])
            self._solve()
            numbers[momentum_balance.FACTORISED] = 1

    @property
    def count(self) -> int:
        """Iterations since :meth:`begin`."""
        return int(self._numbers[momentum_balance.COUNT])

    def _solve(self) -> None:
        """Factorise and solve, where compiled code does not."""
        matrix, known = self.system.matrix, self._given[5]
        solver = matrix.solver
        solver.factorise(matrix.blocks)
        np.negative(self.residual.ravel(), out=self._right)
        matrix.solve(self._right)
        if solver.factors is not known.factors:
            given = list(self._given)
            given[5] = Solver(*solver.places, solver.factors, solver.plan.banded)
            self._given = tuple(given)

    def _addresses(self, elements: Elements, points: PointFields, now: Iterate) -> tuple[int, int, int]:
        """Return the addresses of the assembly, of the factorisation, and of what is Python's."""
        rest = self._rest.address if self.system.has_more else 0
        if PURE_PYTHON:
            return 0, 0, rest
        system, matrix = self.system, self.system.matrix
        reduction = matrix.solver.reduction
        if self._known is None or self._known[0] is not reduction:
            group = system.groups[0]
            out = Assembled(now.internal, now.blocks, now.blocks[:0])
            where = now.r, now.q, now.twist
            factors = matrix.solver.factors
            given = factors.values, factors.fronts, factors.integers, factors.groups, factors.rest
            self._known = (
                reduction,
                address_of(
                    self._assembly,
                    NOTHING,
                    lambda: (elements, group, points, *where, True, now.maps, True, out),
                ),
                address_of(reduction, NUMBER, lambda: (now.blocks, *matrix.solver.places, *given)),
            )
        return self._known[1], self._known[2], rest

    def _do_rest(self, message: Floats) -> None:
        """Add what the elements are not, or change the multipliers."""
        system, (new, loads) = self.system, self._at
        if message[0] == ASSEMBLED:
            system.add_rest(new, loads, self._maps)
            self.residual[:] = system.residual()
        elif system.problem.multipliers:
            new.multiplier += system.multiplier_change(self._right.reshape(-1, 6))
            system.hold_stress(new)
