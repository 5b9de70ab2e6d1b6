"""Critical loads: where along its equilibria a structure loses stiffness, and how it gives way there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from viscorod.solve.formulations.system import State
from viscorod.solve.statics.linear_buckling import critical_factors
from viscorod.solve.statics.path_follower import Path, PathFollower
from viscorod.solve.statics.special_points import PathPoint
from viscorod.solve.statics.tangent import softest
from viscorod.typing import Floats

__all__ = ["BEYOND", "CriticalPoint", "CriticalSearch"]

BEYOND = 2.0
"""Multiple of the largest linear critical factor up to which the equilibria are followed."""
POINTS = 1000
"""Points of a path at most."""


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
        reached: load factor to which the equilibria were followed.
    """

    def __init__(self, path: PathFollower, state: State, about: float) -> None:
        self._path, self._state, self._about = path, state, about
        self.reached = about

    def linear(self, count: int) -> tuple[Floats, Floats]:
        """Return the critical factors ``(k,)`` of the linear problem, and body increments ``(6 n, k)``."""
        self._path.prepare(self._state, self._about)
        return critical_factors(self._path, self._state, self._about, count)

    def exact(
        self, count: int, expected: Floats, told: Callable[[float, float], None] | None = None
    ) -> tuple[list[CriticalPoint], Path]:
        """Follow the equilibria to ``count`` vanishing stiffnesses.

        Args:
            count: of them.
            expected: linear critical factors; the path is given up at a multiple of the largest, without any at that
                of the loads themselves.
            told: is told the load factor of every point, and the step to it.

        Returns:
            The points in the order of the path; and the path, whose outcome is COMPLETED or POINTS where fewer were
            found.
        """
        points: list[PathPoint] = []
        last = float(expected[-1]) if len(expected) else self._about + 1.0

        def keep(point: PathPoint) -> None:
            self.reached = float(point.factor)
            if told is not None:
                before = points[-1].factor if points else self._about
                told(float(point.factor), float(abs(point.factor - before)))
            points.append(point)

        course = self._path.follow(
            self._state.copy(),
            first=self._about,
            load_factor=self._about + BEYOND * (last - self._about),
            critical=count,
            points=POINTS,
            on_point=keep,
        )
        found = [
            self._point(points[number], number, course)
            for number in sorted({*course.limit_points, *course.bifurcations})
        ]
        return found, course

    def _point(self, point: PathPoint, number: int, course: Path) -> CriticalPoint:
        limit = number in course.limit_points
        branches = dict(zip(course.bifurcations, course.multiplicity, strict=True)).get(number, 0)
        path = self._path
        tangent = path.static.tangent(point.state, path.t, before=path.before, scale=point.factor)
        return CriticalPoint(point.factor, point.state, softest(tangent, branches + int(limit)), limit)
