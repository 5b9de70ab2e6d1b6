"""Critical loads: where along its equilibria a structure loses stiffness, and how it gives way there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.statics.linear_buckling import critical_factors
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.path_follower import Path, PathFollower
from viscorod.solve.statics.special_points import PathPoint
from viscorod.solve.statics.tangent import softest
from viscorod.typing import Floats

__all__ = ["BEYOND", "CriticalPoint", "CriticalSearch"]

BEYOND = 2.0
"""Multiple of the largest linear critical factor up to which equilibria are followed, before it is computed anew."""
LEGS = 6
"""How often the linear problem is solved, about the state reached, for how far to go."""
FOLLOWED = (Outcome.COMPLETED, Outcome.POINTS)
POINTS = 1000
"""Points of a path at most."""
GIVEN_WAY = 0.2
"""Slope of the load over displacements, as a part of the first one, below which a model that stiffens again has given
way without losing its stiffness: it buckles as what is not quite straight does (Koiter)."""
STIFFER = 1.2
"""Times by which the slope grows again after that."""


@dataclass(frozen=True)
class CriticalPoint:
    """A state at which stiffness vanishes.

    Attributes:
        factor: of the loads; state: the equilibrium there, or next to it.
        increments: body increments of the nodes ``(6 n, k)`` in the ``k`` directions without stiffness.
        limit: whether the load has an extreme there; otherwise other equilibria branch off.
    """

    factor: float
    state: State
    increments: Floats
    limit: bool


class CriticalSearch:
    """Looks for critical loads from an equilibrium on.

    Args:
        path: follows the equilibria; its solver has the stage of the loads that grow.
        state: the equilibrium at the load factor ``about``.

    Attributes:
        about: see above.
        reached: load factor to which the equilibria were followed.
        by_motion: whether loads without a potential made the stiffness unsymmetric on the way.
        flutter: load factors at which growing oscillations begin or end there.
        rounded: load factor before the first critical point near which the model gives way but keeps its stiffness,
            as it does where an imperfection rounds a bifurcation off; None if it does not.
    """

    def __init__(self, path: PathFollower, state: State, about: float) -> None:
        self._path, self._state, self.about = path, state, about
        self.reached, self._end = about, state
        self.by_motion, self.flutter = False, list[float]()
        self.rounded: float | None = None
        self._slopes, self._passed_one = list[tuple[float, float]](), False

    def linear(self, count: int) -> tuple[Floats, Floats]:
        """Return the critical factors ``(k,)`` of the linear problem, and body increments ``(6 n, k)``."""
        self._path.prepare(self._state, self.about)
        return critical_factors(self._path, self._state, self.about, count)

    def exact(
        self, count: int, expected: Floats, told: Callable[[float, float], None] | None = None
    ) -> tuple[list[CriticalPoint], Path]:
        """Follow the equilibria to ``count`` vanishing stiffnesses.

        Args:
            count: of them.
            expected: linear critical factors, which tell how far to go: to a multiple of the largest, without any to
                that of the loads themselves. There they are computed anew, as long as there are some and the loads
                have a potential: else oscillations come first.
            told: is told the load factor of every point, and the step to it.

        Returns:
            The points in the order of the path; and the path, whose outcome is COMPLETED or POINTS where fewer were
            found.
        """
        points: list[CriticalPoint] = []
        wanted = count
        state, first = self._state.copy(), self.about
        course: Path | None = None
        for _ in range(LEGS):
            last = float(expected[-1]) if len(expected) else first + 1.0
            leg, passed = self._leg(state, first, first + BEYOND * (last - first), wanted, told)
            points += passed
            if course is not None and leg.outcome not in (*FOLLOWED, Outcome.INTERRUPTED):
                break  # as far as the first linear problem says, all is known
            course = leg
            wanted = count - sum(point.increments.shape[1] for point in points)
            if course.outcome is not Outcome.COMPLETED or wanted <= 0 or self.by_motion:
                break
            state, first = self._end, self.reached
            try:
                expected, _ = critical_factors(self._path, state, first, wanted)
            except SingularMatrixError:
                break
            if not len(expected):
                break
        assert course is not None
        return points, course

    def _leg(
        self, state: State, first: float, end: float, count: int, told: Callable[[float, float], None] | None
    ) -> tuple[Path, list[CriticalPoint]]:
        """Follow the equilibria from one to a load factor, or to ``count`` vanishing stiffnesses before."""
        points: list[PathPoint] = []

        def keep(point: PathPoint) -> None:
            self.reached, self._end = float(point.factor), point.state
            self.by_motion |= point.stability is not None and point.stability.by_motion
            if told is not None:
                before = points[-1].factor if points else first
                told(float(point.factor), float(abs(point.factor - before)))
            points.append(point)

        course = self._path.follow(
            state.copy(), first=first, load_factor=end, critical=count, points=POINTS, on_point=keep
        )
        self.flutter += [float(points[number].factor) for number in course.flutter]
        numbers = sorted({*course.limit_points, *course.bifurcations})
        if not self._passed_one:
            before = points[: numbers[0]] if numbers else points
            self._slopes += [(point.factor, self._path.slope(point.forward)) for point in before]
            self.rounded = _given_way(self._slopes)
            self._passed_one = bool(numbers)
        return course, [self._point(points[number], number, course) for number in numbers]

    def _point(self, point: PathPoint, number: int, course: Path) -> CriticalPoint:
        limit = number in course.limit_points
        branches = dict(zip(course.bifurcations, course.multiplicity, strict=True)).get(number, 0)
        path = self._path
        tangent = path.static.tangent(point.state, path.t, before=path.before, scale=point.factor)
        return CriticalPoint(point.factor, point.state, softest(tangent, branches + int(limit)), limit)


def _given_way(course: list[tuple[float, float]]) -> float | None:
    """Return the load factor of the first marked minimum of the slope of a course of load factors and slopes."""
    moved = [point for point in course if np.isfinite(point[1])]
    least = first = abs(moved[0][1]) if moved else 0.0
    found = None
    for factor, slope in moved:
        if slope < least:
            least, found = slope, factor
        elif least < GIVEN_WAY * first and slope > STIFFER * least:
            return found
    return None
