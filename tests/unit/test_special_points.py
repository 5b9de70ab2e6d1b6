"""Special points of paths against a pitchfork with a known imperfection: ``a^3 + (s - 1) a = e`` at the distance s.

Its primary path ``a = e / (s - 1)`` leaves the bifurcation at s = 1 on one side by about ``cbrt(e)`` (Koiter; see
Thompson and Hunt, A General Theory of Elastic Stability, 1973): of round-off e it is one path, of a real e it is two.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from viscorod.solve.statics.special_points import Direction, PathPoint, special_points
from viscorod.solve.statics.stability import Stability

BIFURCATION = 1.0
ROUNDED = 1e-11
"""Imperfection up to which it is that of rounding, as where sections are stiff."""


class Pitchfork:
    """A follower of the path whose deflection is that of the nearest root, which fails where nothing resists."""

    unit = 1.0

    def __init__(self, imperfection, blind):
        self.imperfection, self.blind = imperfection, blind

    def step(self, at, distance):
        stiffness = BIFURCATION - distance
        if abs(stiffness) < self.blind:
            return None
        roots = np.roots([1.0, 0.0, stiffness, -self.imperfection])
        real = roots.real[abs(roots.imag) < 1e-6 * abs(roots).max()]
        a = float(real[np.argmin(abs(real))])
        change = np.array([[distance, a, 0.0, 0.0, 0.0, 0.0]])
        unstable = int(stiffness + 3.0 * a**2 < 0.0)
        along = Direction(np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]), 1.0)
        state: Any = SimpleNamespace()
        stability = Stability(unstable, unstable, by_motion=False)
        return PathPoint(state, distance, along, stability, 3, Direction(change, 0.0))

    def judged(self, point):
        return point

    softened = judged

    def size(self, change):
        return float(np.linalg.norm(change.increment))

    def astray(self, at, change):
        return abs(change.increment[0, 1]) / self.size(change)

    def rounded(self, first, last):
        return abs(self.imperfection) < ROUNDED


@pytest.mark.parametrize("imperfection", [3e-14, -3e-14, 8e-12, -8e-12])
def test_paths_that_round_off_parts_are_one(imperfection):
    """Two ends mostly across the path, between which nothing is found, are one bifurcation: 4e-7 to 4e-4 apart."""
    path = Pitchfork(imperfection=imperfection, blind=2e-7)
    first, last = path.step(None, 0.98), path.step(None, 1.01)
    (event,) = special_points(path, first, last, 1.01)
    assert event.branches == 1
    assert not event.limit
    assert event.point.change.increment[0, 0] == pytest.approx(BIFURCATION, abs=1e-3)


def test_paths_that_an_imperfection_parts_are_two():
    """An imperfection of 1e-9 parts the paths by 1e-3: no path joins the ends of the step."""
    path = Pitchfork(imperfection=1e-9, blind=2e-7)
    first, last = path.step(None, 0.98), path.step(None, 1.01)
    assert special_points(path, first, last, 1.01) is None
