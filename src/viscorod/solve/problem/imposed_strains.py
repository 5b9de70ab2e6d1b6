"""Rest strains of a problem at its Gauss points: what is constant, and what changes with time."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.basis import lobatto
from viscorod.model.actions.rest_strain import RestStrain, instant
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["Imposed", "ImposedStrains"]


class Imposed(NamedTuple):
    """How much of the rest strains acts: a ``part`` of those at the time ``t`` [s], from the left if ``before``."""

    part: float = 1.0
    t: float = 0.0
    before: bool = False


class _Placed(NamedTuple):
    """A rest strain at the Gauss points of its rod: elements, points, arc lengths [m], and its values at t = 0."""

    strain: RestStrain
    element: Integers
    point: Integers
    s: Floats
    values: Floats


class ImposedStrains:
    """The sum of all rest strains, in arrays ``(e, points, 6)``.

    Attributes:
        constant: those that do not change with time; changes: whether there are others.
    """

    def __init__(self, problem: Problem) -> None:
        self._shape = (sum(len(e.nodes) for e in problem.sets), max(e.order for e in problem.sets), 6)
        placed = [_place(problem, rod, strain) for rod, strain in problem.rest_strains]
        self._driven = [one for one in placed if one.strain.changes]
        self.changes = bool(self._driven)
        self.constant = self._sum(
            (one, one.strain.factor(0.0) * one.values) for one in placed if not one.strain.changes
        )
        self._known: tuple[float, bool, Floats] | None = None

    def driven(self, t: float, before: bool = False) -> Floats:
        """Return what changes with time, at the time ``t`` [s] (from the left if ``before``)."""
        if self._known is None or self._known[:2] != (t, before):
            found = self._sum((one, one.strain.factor(t, before) * _at(one, t)) for one in self._driven)
            self._known = t, before, found
        return self._known[2]

    def rate(self, t: float, before: bool = False) -> Floats:
        """Return its rate [1/s]; that of Python functions by a difference to one side."""
        step = -instant(t) if before else instant(t)

        def rate_of(one: _Placed) -> Floats:
            if one.strain.sees_time:
                return (_at(one, t + step) - _at(one, t)) / step
            return one.strain.factor_rate(t, before) * one.values

        return self._sum((one, rate_of(one)) for one in self._driven)

    def whole(self, given: Imposed) -> Floats:
        """Return a part of all at a time."""
        return given.part * (self.constant + self.driven(given.t, given.before))

    def _sum(self, parts: Iterable[tuple[_Placed, Floats]]) -> Floats:
        total: Floats = np.zeros(self._shape)
        for one, values in parts:
            total[one.element, one.point] += values
        return total


def _at(one: _Placed, t: float) -> Floats:
    """Return the strains of the points of one ``(m, 6)`` with the factor 1."""
    if not one.strain.sees_time:
        return one.values
    return np.array([one.strain.at(s, t) for s in one.s.tolist()])


def _place(problem: Problem, rod: int, strain: RestStrain) -> _Placed:
    """Find the Gauss points of a rod."""
    element, point, s = [], [], []
    first = 0
    for e in problem.sets:
        inside = 1.0 + e.shapes @ lobatto(e.order)[0]
        mine = np.flatnonzero(e.rod == rod)
        element.append(np.repeat(first + mine, e.order))
        point.append(np.tile(np.arange(e.order), len(mine)))
        s.append((e.start[mine, None] + e.half_lengths[mine, None] * inside).ravel())
        first += len(e.nodes)
    places = np.concatenate(s)
    values = np.array([strain.at(at) for at in places.tolist()])
    return _Placed(strain, np.concatenate(element), np.concatenate(point), places, values)
