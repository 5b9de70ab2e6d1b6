"""Steps of pseudo-arc-length continuation."""

from __future__ import annotations

from functools import partial

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.statics.newton import (
    ROUGH,
    Convergence,
    NewtonReport,
    Outcome,
    SingularMatrixError,
    worst_node,
)
from viscorod.solve.statics.parting import parted_by_rounding
from viscorod.solve.statics.softness import softness
from viscorod.solve.statics.special_points import Direction, PathPoint
from viscorod.solve.statics.stability import stability_of
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

SHARPEST_TURN = 0.9
"""Cosine of the largest angle between a step and the path at its end: beyond it the step may have left the path."""
LINEAR = 1e-3
"""Change of the load factor, as a part of its unit, by which the imbalance is differenced."""


class ArcLength:
    """Steps of a given length along the equilibria of a model, with the load factor as one more unknown.

    A point at the distance s from the last one, whose unit direction is t, fulfils the balance and t . (u, factor) = s.
    The bordered system is solved with two right sides and the factors of the tangent stiffness alone (Riks; Crisfield).
    Distances are the root of the mean square over the nodes of displacements (over the length of the model) and
    rotations (rad), with that of the load factor over its unit as one more component.

    Args:
        static: solver of the model; t, before: time of the loads, see ``StaticSolver``.

    Attributes:
        unit: of the load factor; weights: of the components of increments ``(n, 6)`` in the square of a distance.
        iterations: of Newton's method, those of rejected steps among them; report: of the last iteration that failed.
    """

    def __init__(self, static: StaticSolver, t: float = 0.0, *, before: bool = True) -> None:
        self.static, self.system, self.supports = static, static.system, static.supports
        self.unit, self.t, self.before = 1.0, t, before
        problem = self.system.problem
        length = problem.length
        scale = np.array([length, length, length, 1.0, 1.0, 1.0])
        self.weights = np.broadcast_to(1.0 / (scale**2 * problem.size), (problem.size, 6))
        self.iterations = 0
        self.report: NewtonReport | None = None

    def distance(self, at: PathPoint, change: Direction) -> float:
        """Return how far along the direction of a point a change goes."""
        return self._inner(at.forward, change)

    def astray(self, at: PathPoint, change: Direction) -> float:
        """Return the part of a change that leads across the direction of a point."""
        size = self.size(change)
        along = self.distance(at, change) / size if size > 0.0 else 1.0
        return float(np.sqrt(max(1.0 - along**2, 0.0)))

    def size(self, change: Direction) -> float:
        """Return the size of a change."""
        return float(np.sqrt(self._inner(change, change)))

    def step(self, at: PathPoint, distance: float, begin: Direction | None = None) -> PathPoint | None:
        """Return the equilibrium at a ``distance`` from a point, or None if none is found near the path there.

        The first guess is ``begin`` away from the point.
        """
        static, system, problem = self.static, self.system, self.system.problem
        trial, factor = at.state.copy(), at.factor
        convergence = Convergence(problem.length, static.tolerance, static.iterations)
        static.restore(trial, self.t, before=self.before, scale=factor)
        total = np.zeros_like(at.forward.increment)
        count = 0
        if begin is not None:
            retract(trial.r, trial.q, begin.increment, trial.r, trial.q)
            total += begin.increment
            factor += begin.factor
            static.restore(trial, self.t, before=self.before, scale=factor)
        try:
            plain, per_factor = self.solve(trial, factor)
            while True:
                static.check_interrupt()
                missing = distance - self._inner(at.forward, Direction(total, factor - at.factor))
                along = self._inner(at.forward, Direction(plain[: problem.size], 0.0))
                rate = self._inner(at.forward, Direction(per_factor[: problem.size], 1.0))
                change = (missing - along) / rate
                increment = plain + change * per_factor
                count += 1
                verdict, size = convergence.judge(
                    increment[: problem.size], count, partial(static.is_round_off, trial, self._residual)
                )
                if verdict is Outcome.NOT_FINITE or not np.isfinite(change):
                    return self._failed(Outcome.SINGULAR, count, size)
                if verdict is Outcome.CONVERGED and size > ROUGH:
                    break
                retract(trial.r, trial.q, increment, trial.r, trial.q)
                system.carry_stress(increment)
                trial.multiplier += system.multiplier_change(increment)
                total += increment[: problem.size]
                factor += change
                if verdict is Outcome.CONVERGED and abs(change) <= 1e-7 * max(self.unit, abs(factor)):
                    break
                if verdict not in (None, Outcome.CONVERGED) or count >= static.iterations:
                    return self._failed(verdict or Outcome.SLOW, count, size)
                plain, per_factor = self.solve(trial, factor)
        except SingularMatrixError:
            return self._failed(Outcome.SINGULAR, count, np.inf)
        self.iterations += count
        gone = Direction(total, factor - at.factor)
        found = self.complete(trial, factor, gone, count)
        if found is None:
            return self._failed(Outcome.SINGULAR, 0, np.inf)
        crushed = static.crushed()
        if crushed is not None:
            return self._failed(Outcome.INSIDE_OUT, 0, np.inf, crushed)
        if static.turns.jumped(at.state, found.state):
            return self._failed(Outcome.WRAPPED, 0, np.inf, static.turns.worst(found.state))
        turn = self._inner(found.forward, gone) / self.size(gone)
        return found if turn > SHARPEST_TURN else self._failed(Outcome.DIVERGED, 0, np.inf)

    def complete(self, state: State, factor: float, gone: Direction, iterations: int) -> PathPoint | None:
        """Complete a point, to which the path came by ``gone``; None if the tangent stiffness is singular there."""
        self.static.restore(state, self.t, before=self.before, scale=factor)
        try:
            _, per_factor = self.solve(state, factor)
        except SingularMatrixError:
            return None
        forward = Direction(per_factor[: self.system.problem.size], 1.0)
        size = np.sqrt(self._inner(forward, forward))
        if not np.isfinite(size):
            return None
        size = np.copysign(size, self._inner(forward, gone))
        return PathPoint(
            state, factor, Direction(forward.increment / size, 1.0 / size), None, iterations, gone
        )

    def judged(self, point: PathPoint) -> PathPoint:
        """Return a point with its stability."""
        if point.stability is not None:
            return point
        found = stability_of(self.static, point.state, self.t, before=self.before, scale=point.factor)
        return point._replace(stability=found)

    def softened(self, point: PathPoint) -> PathPoint:
        """Return a point with its softness, where the tangent stiffness tells stability."""
        point = self.judged(point)
        assert point.stability is not None
        if point.softness is not None or point.stability.by_motion:
            return point
        return point._replace(softness=softness(self, point.state, point.factor, point.forward.factor))

    def rounded(self, first: PathPoint, last: PathPoint) -> bool:
        """Return whether no more than rounding parts two points beside a bifurcation."""
        return not self._by_motion(first, last) and parted_by_rounding(self, first, last)

    def imbalance(self, point: PathPoint) -> Floats:
        """Return the forces and moments ``(n, 6)`` that are left at the nodes of a point, body components."""
        self.static.restore(point.state, self.t, before=self.before, scale=point.factor)
        return self._assemble(point.state, point.factor, tangent=False)[: self.system.problem.size]

    def _by_motion(self, *points: PathPoint) -> bool:
        """Return whether it is small motions that tell the stability of a point."""
        found = [self.judged(point).stability for point in points]
        return any(one is not None and one.by_motion for one in found)

    def _failed(self, outcome: Outcome, count: int, size: float, at: int | None = None) -> PathPoint | None:
        """Note why a step failed, and at which node; returns None."""
        problem = self.system.problem
        self.iterations += count
        residual = self.system.residual()
        imbalance, node = worst_node(self.supports.unbalanced(residual)[: problem.size], problem.length)
        self.report = NewtonReport(outcome, count, size, imbalance, node if at is None else at)
        return None

    def _inner(self, a: Direction, b: Direction) -> float:
        return self.shape(a.increment, b.increment) + a.factor * b.factor / self.unit**2

    def shape(self, a: Floats, b: Floats | None = None) -> float:
        """Return the product of two increments, or of one with itself."""
        # next to singular matrices this overflows; who asks looks whether it is finite
        with np.errstate(over="ignore", invalid="ignore"):
            return float(np.sum(self.weights * a * (a if b is None else b)))

    def _assemble(self, state: State, factor: float, *, tangent: bool) -> Floats:
        """Assemble at a load factor; return the imbalance, with the rows of supports."""
        system, supports = self.system, self.supports
        supports.update(self.t, self.before, factor)
        system.constraints.update(self.t, self.before, factor)
        loads = self.static.loads.at(self.t, self.before, factor)
        system.assemble(state, loads, None, tangent=tangent, moving=False)
        residual = system.residual()
        supports.impose(state, residual, system.matrix, tangent=tangent)
        return residual

    def solve(self, state: State, factor: float) -> tuple[Floats, Floats]:
        """Return the increments that close the imbalance, and those per load factor.

        Raises:
            SingularMatrixError: the tangent stiffness is singular.
        """
        change = LINEAR * self.unit
        varied = self._assemble(state, factor + change, tangent=False)
        self._residual = self._assemble(state, factor, tangent=False)
        per_factor = (self._residual - varied) / change
        residual = self._assemble(state, factor, tangent=True)
        matrix = self.system.matrix
        matrix.factorise()
        return matrix.solve(-residual), matrix.solve(self.supports.weights * per_factor)
