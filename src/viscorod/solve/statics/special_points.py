"""Points of paths, and the special ones among them: limit points, bifurcations, and where flutter begins or ends."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.statics.softness import Softness
from viscorod.solve.statics.stability import Stability
from viscorod.typing import Floats

__all__ = ["Direction", "PathPoint", "SpecialPoint", "special_points"]

NARROW = 1e-7
"""Part of a step within which a special point is located."""
FINE = 1e-9
"""Change of the load factor, in its unit, within which it is."""
LOCATED = 0.01
"""Part of a step within which it must be, where no point is found next to it: the matrix is singular there."""
ASTRAY = 0.1
"""Part of the way between two points next to it that may lead across the path: otherwise they are on two paths."""
SAME = 1e-5
"""Part of a step within which two special points are one: round-off parts eigenvalues that vanish together."""
PIECE = 0.05
"""Part of a step in which two special points are not sought between ends that look alike."""
NUDGES = (0.5, 0.37, 0.63, 0.2, 0.8, 0.1, 0.9, 0.03, 0.97)
"""Where a part of a step is divided; the next one where no point of the path is found at the last."""
EXACT = 1e-7
"""Distance below which points are not told apart by where they are."""
MEETING = 0.1 * float(np.cbrt(np.finfo(float).eps))
"""Distance between points next to it, beside a bifurcation that round-off parts: there the deflection a that nothing
resists but its cube makes up for an imbalance of the order of eps, so two paths nearer than this are one. Arches are
parted by 1.4e-7; 2e-6 is what a force of 1e-3 N across a buckling strip of steel does, which is to be followed."""
LARGEST_GAP = 2.0
"""Largest distance between two points over the difference of their distances from a third one before them."""


class Direction(NamedTuple):
    """A direction of a path: increments of the nodes ``(n, 6)`` and of the load factor."""

    increment: Floats
    factor: float


class PathPoint(NamedTuple):
    """An equilibrium on the path.

    Attributes:
        state, factor: where it is; forward: unit direction in which the path goes on.
        stability: see there; None if not known yet.
        iterations: of Newton's method to get there.
        change: all of the increments since the point before it.
        softness: the smallest stiffnesses; None if they are not known.
    """

    state: State
    factor: float
    forward: Direction
    stability: Stability | None
    iterations: int
    change: Direction
    softness: Softness | None = None


class SpecialPoint(NamedTuple):
    """A special point of a path.

    Attributes:
        point: an equilibrium next to it.
        limit: whether loads turn from growing to shrinking or back.
        branches: number of eigenvalues of the stiffness that vanish there, beside that of a limit point.
        flutter: whether growing oscillations begin or end.
    """

    point: PathPoint
    limit: bool
    branches: int
    flutter: bool


class Follower(Protocol):
    """What is needed of a path to look for its special points."""

    unit: float

    def step(self, at: PathPoint, distance: float) -> PathPoint | None:
        """Return the point at a distance from another one."""

    def judged(self, point: PathPoint) -> PathPoint:
        """Return a point with its stability."""

    def softened(self, point: PathPoint) -> PathPoint:
        """Return a point with its softness, where that can be told."""

    def size(self, change: Direction) -> float:
        """Return the size of a change."""

    def astray(self, at: PathPoint, change: Direction) -> float:
        """Return the part of a change that leads across the direction of a point."""

    def rounded(self, first: PathPoint, last: PathPoint) -> bool:
        """Return whether no more than rounding parts two points beside a bifurcation."""


class _Kind(NamedTuple):
    """What differs on the two sides of a special point."""

    growing: bool
    divergent: int
    oscillating: int


def special_points(
    path: Follower, at: PathPoint, reached: PathPoint, step: float
) -> list[SpecialPoint] | None:
    """Return all special points between two points of a path, in their order; None if no path joins these.

    A step is halved wherever its two ends differ, so several special points within one are told apart, and where they
    are alike but a stiffness may have vanished twice. Points on the
    two sides come as near to each other as their distances from ``at``, unless the step led to another path.
    """
    none = Direction(np.zeros_like(at.forward.increment), 0.0)
    found: list[_Located] = []
    by_motion = any(_stability(path, point).by_motion for point in (at, reached))
    pending = [((0.0, at._replace(change=none)), (step, reached))]
    while pending:
        (low, first), (high, last) = pending.pop()
        before, after = _kind(path, first), _kind(path, last)
        if before == after:
            if high - low > PIECE * step:
                first, last = path.softened(first), path.softened(last)
                middle = _between(path, at, low, high) if _hides(first, last, high - low) else None
                if middle is not None:
                    pending.append((middle, (high, last)))
                    pending.append(((low, first), middle))
            continue
        gap = Direction(
            last.change.increment - first.change.increment, last.change.factor - first.change.factor
        )
        close = high - low < LOCATED * step
        apart = path.size(gap) > LARGEST_GAP * (high - low) + EXACT
        if apart and not (close and path.rounded(first, last)):
            return None
        steepest = max(abs(first.forward.factor), abs(last.forward.factor))
        near = high - low < NARROW * step or high - low < (1.0 if by_motion else 0.01) * EXACT
        near = near or apart or steepest * (high - low) < FINE * path.unit
        middle = None if near else _between(path, at, low, high)
        if middle is not None:
            pending.append((middle, (high, last)))
            pending.append(((low, first), middle))
        elif close and (apart or _meet(path, at, first, last, gap) or path.rounded(first, last)):
            place = path.judged(last if low == 0.0 else first)
            if found and low - found[-1].until < max(SAME * step, EXACT):
                found[-1] = found[-1]._replace(after=after, until=high)
            else:
                found.append(_Located(place, before, after, high))
        else:
            return None
    events = [one.special() for one in found]
    return [event for event in events if event.limit or event.branches or event.flutter]


class _Located(NamedTuple):
    """Where and how the kind of points changes, and up to which distance."""

    point: PathPoint
    before: _Kind
    after: _Kind
    until: float

    def special(self) -> SpecialPoint:
        """Return what this makes of the point; at a limit point one eigenvalue changes its sign, no bifurcation."""
        limit = self.before.growing != self.after.growing
        branches = max(abs(self.after.divergent - self.before.divergent) - int(limit), 0)
        return SpecialPoint(self.point, limit, branches, self.after.oscillating != self.before.oscillating)


def _meet(path: Follower, at: PathPoint, first: PathPoint, last: PathPoint, gap: Direction) -> bool:
    """Return whether two points are near to each other, or as much along the path, as those of one path.

    A path that turns sharply between ``at`` and the two, as at a limit point, leads from one to the other by their own
    directions; where two paths are nearest to each other what parts them is across both.
    """
    near = path.size(gap) < MEETING or path.astray(at, gap) < ASTRAY
    return near or max(path.astray(first, gap), path.astray(last, gap)) < ASTRAY


def _between(path: Follower, at: PathPoint, low: float, high: float) -> tuple[float, PathPoint] | None:
    """Return a point between two distances, about halfway if there is one; None if none is found."""
    for part in NUDGES:
        distance = low + part * (high - low)
        point = path.step(at, distance)
        if point is not None:
            return distance, path.judged(point)
    return None


def _hides(first: PathPoint, last: PathPoint, distance: float) -> bool:
    """Return whether a stiffness may have vanished twice between two points that are alike."""
    if first.softness is None or last.softness is None:
        return False
    return first.softness.may_vanish_before(last.softness, distance)


def _kind(path: Follower, point: PathPoint) -> _Kind:
    stability = _stability(path, point)
    return _Kind(point.forward.factor > 0.0, stability.divergent, stability.oscillating)


def _stability(path: Follower, point: PathPoint) -> Stability:
    stability = path.judged(point).stability
    assert stability is not None
    return stability
