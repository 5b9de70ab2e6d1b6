"""Paths of equilibria by pseudo-arc-length continuation: through limit points, past bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.statics.newton import (
    Convergence,
    NewtonReport,
    Outcome,
    SingularMatrixError,
    interruption,
    worst_node,
)
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import negative_eigenvalues
from viscorod.typing import Floats

SMALLEST = 1e-6
"""Smallest distance between points, as a part of the largest."""
SHARPEST_TURN = 0.9
"""Cosine of the largest angle between a step and the path at its end: beyond it the step may have left the path."""
LARGEST_GAP = 2.0
"""Largest distance between two points over the difference of their distances from a third one before them."""
HALVINGS = 24
"""Halvings of a step that contains a limit point or a bifurcation."""
SECANTS = 30
LINEAR = 1e-3
"""Change of the load factor, as a part of its unit, by which the imbalance is differenced."""


class Direction(NamedTuple):
    """A direction of the path: increments of the nodes ``(n, 6)`` and of the load factor."""

    increment: Floats
    factor: float


class PathPoint(NamedTuple):
    """An equilibrium on the path.

    Attributes:
        state, factor: where it is; forward: unit direction in which the path goes on.
        unstable: number of negative eigenvalues of the tangent stiffness, -1 if not counted; iterations: of Newton's
            method to get there.
        change: all of the increments since the point before it.
    """

    state: State
    factor: float
    forward: Direction
    unstable: int
    iterations: int
    change: Direction


Ending = Callable[[PathPoint], float]
"""Zero where a path is to end; it ends where the sign changes."""


@dataclass
class Path:
    """Course of a path.

    Attributes:
        outcome: COMPLETED, POINTS (as many as allowed), or why it could not be followed further.
        count: points so far; limit_points, bifurcations: the numbers of those that are one.
        iterations: of Newton's method, those of rejected steps among them; rejected: steps that were taken anew.
        report: of the last iteration that failed; reason: why an INTERRUPTED path stopped.
    """

    outcome: Outcome = Outcome.COMPLETED
    count: int = 0
    limit_points: list[int] = field(default_factory=list)
    bifurcations: list[int] = field(default_factory=list)
    iterations: int = 0
    rejected: int = 0
    report: NewtonReport | None = None
    reason: str = ""


class PathFollower:
    """Follows the equilibria of a model from the unloaded one on, while loads grow or shrink.

    A point at the distance s from the last one, whose unit direction is t, fulfils the balance and t . (u, factor) = s.
    The bordered system is solved with two right sides and the factors of the tangent stiffness alone (Riks; Crisfield).
    Distances are the root of the mean square over the nodes of displacements (over the length of the model) and
    rotations (rad), with that of the load factor over its unit as one more component.

    Args:
        static: solver of the model; unit: of the load factor; t, before: time of the loads, see ``StaticSolver``.
    """

    def __init__(
        self, static: StaticSolver, unit: float = 1.0, t: float = 0.0, *, before: bool = True
    ) -> None:
        self.static, self.system, self.supports = static, static.system, static.supports
        self.unit, self.t, self.before = unit, t, before
        problem = self.system.problem
        length = problem.length
        scale = np.array([length, length, length, 1.0, 1.0, 1.0])
        self._weights = np.broadcast_to(1.0 / (scale**2 * problem.size), (problem.size, 6))
        self.path = Path()

    def follow(
        self,
        state: State,
        *,
        first: float = 0.0,
        load_factor: float | None = None,
        endings: Sequence[Ending] = (),
        largest: float = 0.1,
        points: int = 200,
        limit_point: int | None = None,
        on_point: Callable[[PathPoint], None],
    ) -> Path:
        """Follow the path from an equilibrium, by default the one without loads.

        Args:
            state: start, the equilibrium at the load factor ``first``.
            load_factor: the path begins towards it, and ends where it is reached.
            endings: other places to end.
            largest: distance of two points at most; points: number of points at most.
            limit_point: number of the one at which to end, 1 for the first.
            on_point: called after every point, with the system in that state.
        """
        path = self.path = Path()
        try:
            self._follow(state, first, load_factor, endings, largest, points, limit_point, on_point)
        except KeyboardInterrupt as asked:
            path.outcome, path.reason = Outcome.INTERRUPTED, interruption(asked)
        return path

    def _follow(
        self,
        state: State,
        first: float,
        load_factor: float | None,
        endings: Sequence[Ending],
        largest: float,
        points: int,
        limit_point: int | None,
        on_point: Callable[[PathPoint], None],
    ) -> None:
        path = self.path
        if load_factor is not None:
            endings = [*endings, lambda point: point.factor - load_factor]
        begin = -1.0 if load_factor is not None and load_factor < first else 1.0
        start = self._point(state, first, Direction(np.zeros_like(state.twist), begin), 0)
        if start is None:
            path.outcome = Outcome.SINGULAR
            return
        at = self._counted(start)
        self._record(at, on_point)
        step = 0.25 * largest
        while path.count < points:
            reached = self.step(at, step)
            if reached is None:
                path.rejected += 1
                step *= 0.45  # not one half, or the end might stay where the matrix is singular
                if step < SMALLEST * largest:
                    path.outcome = path.report.outcome if path.report is not None else Outcome.SINGULAR
                    return
                continue
            reached = self._counted(reached)
            ended = self._ended(at, reached, step, endings, load_factor)
            passed = self._passed(at, ended or reached, step)
            if passed is None:
                path.rejected += 1
                step *= 0.45
                if step < SMALLEST * largest:
                    path.outcome = Outcome.DIVERGED
                    return
                continue
            for special, kind in passed:
                kind.append(path.count)
                self._record(special, on_point)
                if limit_point is not None and len(path.limit_points) >= limit_point:
                    return
            at = ended or reached
            self._record(at, on_point)
            if ended:
                return
            step = min(
                step * (1.5 if reached.iterations <= 5 else 0.7 if reached.iterations > 8 else 1.0), largest
            )
        path.outcome = Outcome.POINTS

    def step(self, at: PathPoint, distance: float) -> PathPoint | None:
        """Return the equilibrium at a ``distance`` from a point, or None if none is found near the path there."""
        static, system, problem = self.static, self.system, self.system.problem
        trial, factor = at.state.copy(), at.factor
        convergence = Convergence(problem.length, static.tolerance, static.iterations)
        static.restore(trial, self.t, before=self.before, scale=factor)
        total = np.zeros_like(at.forward.increment)
        count = 0
        try:
            plain, per_factor = self._solve(trial, factor)
            while True:
                static.check_interrupt()
                missing = distance - self._inner(at.forward, Direction(total, factor - at.factor))
                along = self._inner(at.forward, Direction(plain[: problem.size], 0.0))
                rate = self._inner(at.forward, Direction(per_factor[: problem.size], 1.0))
                change = (missing - along) / rate
                increment = plain + change * per_factor
                count += 1
                verdict, size = convergence.judge(increment[: problem.size], count)
                if verdict is Outcome.NOT_FINITE or not np.isfinite(change):
                    return self._failed(Outcome.SINGULAR, count, size)
                retract(trial.r, trial.q, increment, trial.r, trial.q)
                system.carry_stress(increment)
                trial.multiplier += system.multiplier_change(increment)
                total += increment[: problem.size]
                factor += change
                if verdict is Outcome.CONVERGED and abs(change) <= 1e-7 * max(self.unit, abs(factor)):
                    break
                if verdict not in (None, Outcome.CONVERGED) or count >= static.iterations:
                    return self._failed(verdict or Outcome.SLOW, count, size)
                plain, per_factor = self._solve(trial, factor)
        except SingularMatrixError:
            return self._failed(Outcome.SINGULAR, count, np.inf)
        self.path.iterations += count
        gone = Direction(total, factor - at.factor)
        found = self._point(trial, factor, gone, count)
        if found is None:
            return self._failed(Outcome.SINGULAR, 0, np.inf)
        turn = self._inner(found.forward, gone) / np.sqrt(self._inner(gone, gone))
        return found if turn > SHARPEST_TURN else self._failed(Outcome.DIVERGED, 0, np.inf)

    def _point(self, state: State, factor: float, gone: Direction, iterations: int) -> PathPoint | None:
        """Complete a point, to which the path came by ``gone``; None if the tangent stiffness is singular there."""
        self.static.restore(state, self.t, before=self.before, scale=factor)
        try:
            _, per_factor = self._solve(state, factor)
        except SingularMatrixError:
            return None
        forward = Direction(per_factor[: self.system.problem.size], 1.0)
        size = np.sqrt(self._inner(forward, forward))
        if not np.isfinite(size):
            return None
        size = np.copysign(size, self._inner(forward, gone))
        return PathPoint(state, factor, Direction(forward.increment / size, 1.0 / size), -1, iterations, gone)

    def _counted(self, point: PathPoint) -> PathPoint:
        """Count the negative eigenvalues at a point."""
        if point.unstable >= 0:
            return point
        tangent = self.static.tangent(point.state, self.t, before=self.before, scale=point.factor)
        return point._replace(unstable=negative_eigenvalues(tangent))

    def _ended(
        self,
        at: PathPoint,
        reached: PathPoint,
        step: float,
        endings: Sequence[Ending],
        load_factor: float | None,
    ) -> PathPoint | None:
        """Return where the path ends between two points, or None."""
        ends = []
        for ending in endings:
            if ending(at) * ending(reached) < 0.0 or (ending(reached) == 0.0 and ending(at) != 0.0):
                ends.append(self._zero(at, reached, step, ending))
        if not ends:
            return None
        end = min(ends, key=lambda point: self._inner(at.forward, point.change))
        if load_factor is not None and abs(end.factor - load_factor) < 1e-6 * self.unit:
            exact = end.state.copy()
            if self.static.newton(exact, self.t, before=self.before, scale=load_factor).converged:
                end = self._point(exact, load_factor, end.change, end.iterations) or end
        return self._counted(end)

    def _zero(self, at: PathPoint, reached: PathPoint, step: float, ending: Ending) -> PathPoint:
        """Find where ``ending`` vanishes within a step, by the rule of false position (Illinois)."""
        low, high = 0.0, step
        f_low, f_high = ending(at), ending(reached)
        scale, found = max(abs(f_low), abs(f_high)), reached
        for _ in range(SECANTS):
            if f_high == f_low or abs(f_high) <= 1e-12 * scale:
                break
            middle = (low * f_high - high * f_low) / (f_high - f_low)
            point = self.step(at, middle)
            if point is None:
                break
            found, value = point, ending(point)
            if abs(value) <= 1e-12 * scale:
                break
            if value * f_high < 0.0:
                low, f_low = high, f_high
            else:
                f_low *= 0.5
            high, f_high = middle, value
        return found

    def _passed(
        self, at: PathPoint, reached: PathPoint, step: float
    ) -> list[tuple[PathPoint, list[int]]] | None:
        """Find limit points and bifurcations between two points, in their order; None if no path joins the points."""
        path = self.path
        found: list[tuple[PathPoint, list[int]]] = []
        more = reached.unstable - at.unstable
        turned = at.forward.factor * reached.forward.factor < 0.0
        if turned:
            limit = self._change(
                at, reached, step, lambda point: point.forward.factor * at.forward.factor > 0.0
            )
            if limit is None:
                return None
            found.append((self._counted(limit), path.limit_points))
        if abs(more) > int(turned):  # at a limit point one eigenvalue changes its sign, no bifurcation
            crossed = self._change(
                at, reached, step, lambda point: self._counted(point).unstable == at.unstable
            )
            if crossed is not None and found and abs(crossed.factor - found[0][0].factor) < 1e-6 * self.unit:
                crossed = self._change(
                    at, reached, step, lambda point: self._counted(point).unstable != reached.unstable
                )
            if crossed is None:
                return None
            found.append((self._counted(crossed), path.bifurcations))
        return sorted(found, key=lambda pair: self._inner(at.forward, pair[0].change))

    def _change(
        self, at: PathPoint, reached: PathPoint, step: float, before: Callable[[PathPoint], bool]
    ) -> PathPoint | None:
        """Halve a step to find where ``before`` ceases to hold; the last point where it does, None if that is a gap.

        Points on the two sides come as near to each other as their distances from ``at``, unless the step led to
        another path.
        """
        low, high, last, after = 0.0, step, at, reached
        none = Direction(np.zeros_like(at.forward.increment), 0.0)
        first, end, known = (
            none,
            reached.change,
            step,
        )  # changes of the last two points, and how far the latter is
        for halving in range(HALVINGS):
            middle = 0.5 * (low + high)
            point = self.step(at, middle)
            if point is None:  # the matrix is singular there, or there is no path
                high = middle
            elif before(point):
                low, last, first = middle, point, point.change
            else:
                high, known, after, end = middle, middle, point, point.change
            gap = Direction(end.increment - first.increment, end.factor - first.factor)
            if np.sqrt(self._inner(gap, gap)) > LARGEST_GAP * (known - low):
                return None
            if halving >= 10 and known - low > 0.01 * step:
                return None
            if max(abs(last.forward.factor), abs(after.forward.factor)) * (high - low) < 1e-9 * self.unit:
                break
        return last if last is not at else after

    def _record(self, point: PathPoint, on_point: Callable[[PathPoint], None]) -> None:
        self.static.restore(point.state, self.t, before=self.before, scale=point.factor)
        self.path.count += 1
        on_point(point)

    def _failed(self, outcome: Outcome, count: int, size: float) -> PathPoint | None:
        """Note why a step failed; returns None."""
        problem = self.system.problem
        self.path.iterations += count
        residual = self.system.residual()
        imbalance, node = worst_node(self.supports.unbalanced(residual)[: problem.size], problem.length)
        self.path.report = NewtonReport(outcome, count, size, imbalance, node)
        return None

    def _inner(self, a: Direction, b: Direction) -> float:
        # next to singular matrices this overflows; who asks looks whether it is finite
        with np.errstate(over="ignore", invalid="ignore"):
            shape = float(np.sum(self._weights * a.increment * b.increment))
        return shape + a.factor * b.factor / self.unit**2

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

    def _solve(self, state: State, factor: float) -> tuple[Floats, Floats]:
        """Return the increments that close the imbalance, and those per load factor.

        Raises:
            SingularMatrixError: the tangent stiffness is singular.
        """
        change = LINEAR * self.unit
        varied = self._assemble(state, factor + change, tangent=False)
        residual = self._assemble(state, factor, tangent=True)
        matrix = self.system.matrix
        matrix.factorise()
        return matrix.solve(-residual), matrix.solve((residual - varied) / change)
