"""Paths of equilibria: through limit points, past bifurcations or onto the branches that leave there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.statics.arc_length import ArcLength
from viscorod.solve.statics.newton import NewtonReport, Outcome, SingularMatrixError, interruption
from viscorod.solve.statics.special_points import Direction, PathPoint, SpecialPoint, special_points
from viscorod.solve.statics.tangent import softest

SMALLEST = 1e-6
"""Smallest distance between points, as a part of the largest."""
MOVED = 1.0
"""Displacement of the reference shape, in its length, whose load is the unit of the load factor at most."""
STILL = 1e-12
"""Displacement under the unit of the load factor that is round-off."""
FINE = 1e-3
"""Part of the largest distance below which steps are not taken anew because the path bends."""
BENT, FLAT = 0.35, 0.1
"""Change of the slope of loads over displacements in a step, as a part of the largest slope: beyond the first the step
is taken anew, below the second the next one may be longer."""
SECANTS = 30
PARTING = 10
"""Points of a path after which it comes near another one anew."""

Ending = Callable[[PathPoint], float]
"""Zero where a path is to end; it ends where the sign changes."""


def _to(factor: float) -> Ending:
    """Return how far a point is from a load factor."""
    return lambda point: point.factor - factor


@dataclass
class Path:
    """Course of a path.

    Attributes:
        outcome: COMPLETED, POINTS (as many as allowed), or why it could not be followed further.
        count: points so far; limit_points, bifurcations, flutter: the numbers of those that are one.
        multiplicity: of each bifurcation, how many branches of its own direction start there.
        parting: load factors at which the path turns off beside another one that it does not meet.
        iterations: of Newton's method, those of rejected steps among them; rejected: steps that were taken anew.
        report: of the last iteration that failed; reason: why an INTERRUPTED path stopped.
    """

    outcome: Outcome = Outcome.COMPLETED
    count: int = 0
    limit_points: list[int] = field(default_factory=list)
    bifurcations: list[int] = field(default_factory=list)
    multiplicity: list[int] = field(default_factory=list)
    flutter: list[int] = field(default_factory=list)
    parting: list[float] = field(default_factory=list)
    iterations: int = 0
    rejected: int = 0
    report: NewtonReport | None = None
    reason: str = ""

    @property
    def vanished(self) -> int:
        """Number of stiffnesses that have vanished on the way, at limit points and bifurcations."""
        return len(self.limit_points) + sum(self.multiplicity)


class _Ends(NamedTuple):
    """Where a path ends, and what is looked for on the way; see :meth:`PathFollower.follow`."""

    load_factor: float | None
    endings: Sequence[Ending]
    wanted: Sequence[float]
    points: int
    limit_point: int | None
    branch: int | None
    critical: int | None


class _Leg(NamedTuple):
    """A step along a path.

    Attributes:
        last: the point that it leads to; ended: the path ends there; events: special points on the way.
        lengthened: the next step over this one.
    """

    last: PathPoint
    ended: bool
    events: Sequence[SpecialPoint]
    lengthened: float


_Passed = tuple[PathPoint, SpecialPoint | None]
"""A point, and what is special about it; None of a wanted load factor."""


class PathFollower(ArcLength):
    """Follows the equilibria of a model from the unloaded one on, while loads grow or shrink.

    The unit of the load factor follows from the wanted one and from the response of the reference shape: a path does
    not depend on the size of the reference loads.

    Args:
        static: solver of the model; t, before: time of the loads, see ``StaticSolver``.
    """

    path: Path

    def follow(
        self,
        state: State,
        *,
        first: float = 0.0,
        load_factor: float | None = None,
        endings: Sequence[Ending] = (),
        wanted: Sequence[float] = (),
        largest: float | None = None,
        points: int = 200,
        limit_point: int | None = None,
        branch: int | None = None,
        critical: int | None = None,
        on_point: Callable[[PathPoint], None],
    ) -> Path:
        """Follow the path from an equilibrium, by default the one without loads.

        Args:
            state: start, the equilibrium at the load factor ``first``.
            load_factor: the path begins towards it, and ends where it is reached.
            endings: other places to end.
            wanted: load factors at which there is to be a point, each time the path passes one.
            largest: distance of two points at most; None: 0.1, or more for large prescribed motions.
            points: number of points at most.
            limit_point: number of the one at which to end, 1 for the first.
            branch: number of the bifurcation at which to go over to the other branch, negative for its other side.
            critical: number of stiffnesses that have vanished, at limit points and bifurcations, at which to end.
            on_point: called after every point, with the system in that state.
        """
        path, self._parted = Path(), 0
        self.path = path
        self.iterations, self.report = 0, None
        try:
            self.prepare(state, first, load_factor, largest)
            ends = _Ends(load_factor, endings, wanted, points, limit_point, branch, critical)
            self._follow(state, first, ends, on_point)
        except KeyboardInterrupt as asked:
            path.outcome, path.reason = Outcome.INTERRUPTED, interruption(asked)
        path.iterations, path.report = self.iterations, self.report
        return path

    def prepare(
        self, state: State, first: float, load_factor: float | None = None, largest: float | None = None
    ) -> None:
        """Choose the unit of the load factor and the largest distance of a path; see :meth:`follow`."""
        supports, constraints = self.supports, self.system.constraints
        supports.update(self.t, self.before)
        constraints.update(self.t, self.before)
        motion = max(
            supports.largest_turn,
            constraints.largest_turn,
            float(np.abs(supports.target[:, :3]).max(initial=0.0)) / self.system.problem.length,
        )
        self.largest = max(0.1, 0.01 * motion * abs(load_factor or 1.0)) if largest is None else largest
        self._steepest = 0.0
        self.largest_change = self.static.largest_step(self.t, before=self.before)
        units = [abs(load_factor)] if load_factor else []
        self.unit = 1e-3 / max(motion, 1.0)
        try:
            self.static.restore(state, self.t, before=self.before, scale=first)
            _, per_factor = self.solve(state, first)
        except SingularMatrixError:
            per_factor = np.zeros((1, 6))
        moved = np.sqrt(self.shape(per_factor[: self.system.problem.size]))
        if np.isfinite(moved) and moved > 0.0:
            units.append(MOVED / moved)
        self.unit = min(units, default=1.0)

    def _follow(self, state: State, first: float, ends: _Ends, on_point: Callable[[PathPoint], None]) -> None:
        path, largest, load_factor = self.path, self.largest, ends.load_factor
        if load_factor is not None:
            ends = ends._replace(endings=[*ends.endings, _to(load_factor)])
        begin = -1.0 if load_factor is not None and load_factor < first else 1.0
        start = self.complete(state, first, Direction(np.zeros_like(state.twist), begin), 0)
        if start is None:
            path.outcome = Outcome.SINGULAR
            return
        at = self.softened(start)
        self._record(at, on_point)
        step = 0.25 * largest
        while path.count < ends.points:
            step = min(step, self.largest_change * abs(1.0 / (at.forward.factor or 1e-300)))
            leg = self._leg(at, step, ends)
            if isinstance(leg, Outcome):
                path.rejected += 1
                step *= 0.45  # not one half, or the end might stay where the matrix is singular
                if step < SMALLEST * largest:
                    path.outcome = leg
                    return
                continue
            ended, branch = self._pass(self._passed(at, leg, step, ends), ends, on_point)
            if ended:
                return
            at = leg.last if branch is None else branch
            self._record(at, on_point)
            if branch is not None:
                ends, step = ends._replace(branch=None), 0.25 * largest
                continue
            if leg.ended:
                return
            at = self._measured(at, abs(load_factor or np.inf))
            step = min(step * leg.lengthened, largest)
        path.outcome = Outcome.POINTS

    def _leg(self, at: PathPoint, step: float, ends: _Ends) -> _Leg | Outcome:
        """Take a step from a point; return why it is to be a shorter one if it fails, or bends too much."""
        reached = self.step(at, step)
        if reached is None:
            return self.report.outcome if self.report is not None else Outcome.SINGULAR
        bent = self._bent(at, reached)
        if bent > BENT and step > FINE * self.largest:
            return Outcome.DIVERGED
        reached = self.judged(reached)
        end = self._ended(at, reached, step, ends.endings, ends.load_factor)
        last = self.softened(end or reached)
        events = special_points(self, at, last, self.distance(at, last.change))
        if events is None:
            self._part(at.factor)
            return Outcome.DIVERGED
        easy, hard = reached.iterations <= 5 and bent < FLAT, reached.iterations > 8 or bent > 2.0 * FLAT
        return _Leg(last, end is not None, events, 1.5 if easy else 0.7 if hard else 1.0)

    def _passed(self, at: PathPoint, leg: _Leg, step: float, ends: _Ends) -> list[_Passed]:
        """Return the special and the wanted points of a step, in their order on the path."""
        special: list[_Passed] = [(event.point, event) for event in leg.events]
        wanted: list[_Passed] = [(point, None) for point in self._wanted(at, leg.last, step, ends.wanted)]
        return sorted([*special, *wanted], key=lambda one: self.distance(at, one[0].change))

    def _pass(
        self, passed: Sequence[_Passed], ends: _Ends, on_point: Callable[[PathPoint], None]
    ) -> tuple[bool, PathPoint | None]:
        """Record points that are passed; return whether the path ends at one, and where it goes over to a branch."""
        path = self.path
        for point, event in passed:
            if event is not None:
                self._note(event)
            self._record(point, on_point)
            if ends.limit_point is not None and len(path.limit_points) >= ends.limit_point:
                return True, None
            if ends.critical is not None and path.vanished >= ends.critical:
                return True, None
            leaves = ends.branch is not None and event is not None and event.branches > 0
            if leaves and len(path.bifurcations) >= abs(ends.branch or 0):
                branch = self._switch(point, float(np.sign(ends.branch or 0)))
                if branch is None:
                    path.outcome = Outcome.NO_BRANCH
                return branch is None, branch
        return False, None

    def _part(self, factor: float) -> None:
        """Note that a step led to another path, which is near this one until steps are long again."""
        path = self.path
        if path.parting and path.count <= self._parted + PARTING:
            path.parting.pop()
        path.parting.append(factor)
        self._parted = path.count

    def _bent(self, at: PathPoint, reached: PathPoint) -> float:
        """Return the change of the slope of loads over displacements, as a part of the largest slope so far."""
        first, last = (self.slope(point.forward) for point in (at, reached))
        self._steepest = max(self._steepest, abs(first))
        return (
            abs(last - first) / self._steepest if np.isfinite(last + first) and self._steepest > 0.0 else 0.0
        )

    def slope(self, forward: Direction) -> float:
        """Return the change of the load factor per distance moved in a direction of a path; infinite if none."""
        moved = np.sqrt(self.shape(forward.increment))
        return float(forward.factor / moved) if moved > 1e-12 * abs(forward.factor) / self.unit else np.inf

    def _measured(self, at: PathPoint, most: float) -> PathPoint:
        """Return a point with its direction in a new unit of the load factor, if the structure has become stiffer."""
        moved = np.sqrt(self.shape(at.forward.increment)) / max(abs(at.forward.factor), 1e-300)
        if moved * self.unit < STILL:
            return at
        unit = min(MOVED / moved, most)
        if not self.unit < unit < np.inf or not np.isfinite(moved):
            return at
        self.unit = unit
        size = self.size(at.forward)
        return at._replace(forward=Direction(at.forward.increment / size, at.forward.factor / size))

    def _note(self, event: SpecialPoint) -> None:
        """Add the number of the next point to the lists of what it is."""
        path = self.path
        if event.limit:
            path.limit_points.append(path.count)
        if event.branches:
            path.bifurcations.append(path.count)
            path.multiplicity.append(event.branches)
        if event.flutter:
            path.flutter.append(path.count)

    def _switch(self, point: PathPoint, side: float) -> PathPoint | None:
        """Return a point on the branch that crosses the path at a bifurcation, in the direction without stiffness."""
        tangent = self.static.tangent(point.state, self.t, before=self.before, scale=point.factor)
        increment = side * softest(tangent)[:, 0].reshape(-1, 6)
        forward = Direction(increment / np.sqrt(self.shape(increment)), 0.0)
        leaving = point._replace(forward=forward)
        distance = 0.25 * self.largest
        for _ in range(8):
            found = self.step(leaving, distance, begin=Direction(distance * forward.increment, 0.0))
            if found is not None:
                return self.judged(found)
            distance *= 0.5
        return None

    def _wanted(
        self, at: PathPoint, reached: PathPoint, step: float, wanted: Sequence[float]
    ) -> list[PathPoint]:
        """Return points with wanted load factors between two points."""
        found = []
        for factor in wanted:
            if (at.factor - factor) * (reached.factor - factor) < 0.0:
                found.append(self._exactly(self._zero(at, reached, step, _to(factor)), factor))
        return found

    def _exactly(self, point: PathPoint, factor: float) -> PathPoint:
        """Return a point at exactly a load factor near its own, if it can be found."""
        if abs(point.factor - factor) < 1e-6 * max(self.unit, abs(factor)):
            exact = point.state.copy()
            if self.static.newton(exact, self.t, before=self.before, scale=factor).converged:
                point = self.complete(exact, factor, point.change, point.iterations) or point
        return self.judged(point)

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
        end = min(ends, key=lambda point: self.distance(at, point.change))
        return self.judged(end) if load_factor is None else self._exactly(end, load_factor)

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

    def _record(self, point: PathPoint, on_point: Callable[[PathPoint], None]) -> None:
        self.static.restore(point.state, self.t, before=self.before, scale=point.factor)
        self.path.count += 1
        on_point(point)
