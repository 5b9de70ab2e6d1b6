"""What loads and prescribed motions do within a step, between the instants at which a method looks.

A table of many rows is not integrated row by row. Over a step it is replaced by the polynomial with the same moments,
of as many terms as the method has stages: impulse and delay are exact whatever the content. What the polynomial leaves
out is a force that is held against the tolerance like the estimated error of the step, and so are the parts of Python
functions that lie between the stages: steps follow the content as far as it moves something.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.nodes.table_motions import furthest_motion
from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.time_table import TimeTable
from viscorod.solve.problem.motion_courses import hermite_terms, samples_of, table_motions
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

SAMPLES = 2**15
"""Samples of a Python function over a run; up to half as many are added where it changes most."""

_GAUSS, _WEIGHTS = legendre.leggauss(4)
"""Within a piece of a table, a cubic: products with polynomials of degree 4, and with itself, are exact."""


class StepContent:
    """The content of one step after the other.

    Args:
        problem: whose loads and motions are looked at.
        nodes: of the method, the last 1 if there are several, as parts of a step.
        duration: of the run [s], over which functions are sampled; inf: they are not.

    Attributes:
        courses: of loads given as records, by their number: factors at the stages of the step ``(s,)``.
        rest: of loads by number: what the stages do not show, root mean square of a record, largest of a function.
        gap: distance of prescribed motions from what the stages show of them: over the length, or in rad.
        tables: motions that compiled code knows, if there are any; alone: there is nothing else to look at.
        asks: loads or motions are functions of the user's.
    """

    def __init__(self, problem: Problem, nodes: Floats, duration: float) -> None:
        self.length = problem.length
        self._nodes = nodes
        self._at_stages = legendre.legvander(2.0 * nodes - 1.0, len(nodes) - 1)
        self._records, self._ends = problem.records, problem.record_ends
        through = 2.0 * np.concatenate([[0.0], nodes]) - 1.0
        self._through = np.linalg.inv(legendre.legvander(through, len(nodes)))
        self._hermite = hermite_terms(np.concatenate([[0.0], nodes]))
        factors: dict[int, Callable[[float, bool], float]] = {}
        for loads in (problem.nodal_loads, problem.motion_loads, problem.station_loads):
            factors |= {load.load: load.factor for load in loads}
        self._functions = {}
        for number, function in problem.functions.items():
            factor = factors.get(number, function.value)
            course = getattr(getattr(factor, "__self__", None), "course", function.value)  # names the load
            self._functions[number] = course, *_scan(function, duration, factor)
        self._motions = [
            (motion, component < 3, *_course(motion, duration))
            for _, component, motion in problem.supports.motions
            if isinstance(motion, TimeTable | FunctionOfTime) and type(motion) is not TimeTable
        ]
        self.tables = table_motions(problem.supports, problem.length, nodes)
        self.alone = not (self._records or self._functions or self._motions)
        self.asks = bool(self._functions) or any(isinstance(f, FunctionOfTime) for f, *_ in self._motions)
        self._furthest = KnownTypes(furthest_motion)
        self.courses: dict[int, Floats] = {}
        self.rest: dict[int, float] = {}
        self.gap = 0.0

    @classmethod
    def of(cls, problem: Problem, nodes: Floats, duration: float) -> StepContent | None:
        """Return what looks into the steps, None if there is nothing to look for."""
        motions = (motion for _, _, motion in problem.supports.motions)
        seen = any(isinstance(motion, TimeTable | FunctionOfTime) for motion in motions)
        return cls(problem, nodes, duration) if problem.records or problem.functions or seen else None

    def look(self, start: float, end: float) -> None:
        """Look into the step from ``start`` to ``end`` [s]."""
        self.rest = {}
        for number, record in self._records.items():
            if start >= self._ends[number]:
                self.courses[number] = np.zeros(len(self._nodes))
                continue
            terms, left = _projection(record, start, end, len(self._nodes))
            self.courses[number] = self._at_stages @ terms
            if left > 0.0:
                self.rest[number] = left
        h = end - start
        instants = start + h * np.concatenate([[0.0], self._nodes])
        for number, (value, times, values) in self._functions.items():
            among = slice(*np.searchsorted(times, [start, end], side="right"))
            if among.start < among.stop:
                shown = self._through @ _values(value, instants)
                left = _furthest(shown, (times[among] - start) / h, values[among])
                if left > 0.0:
                    self.rest[number] = left
        self.gap = 0.0 if self.tables is None else self._furthest.call(self.tables, start, end)
        for motion, shift, times, values in self._motions:
            among = slice(*np.searchsorted(times, [start, end], side="right"))
            if among.start < among.stop:
                data = np.concatenate([_values(motion.value, instants), h * _values(motion.rate, instants)])
                left = _furthest(self._hermite @ data, (times[among] - start) / h, values[among])
                self.gap = max(self.gap, left / self.length if shift else left)


def _values(function: Callable[[float, bool], float], instants: Floats) -> Floats:
    """Return the values at the instants of a step, at its end the limit from the left."""
    last = len(instants) - 1
    return np.array([function(float(t), k == last) for k, t in enumerate(instants)])


def _furthest(polynomial: Floats, places: Floats, values: Floats) -> float:
    """Return the largest distance of values at ``places`` (0 to 1) from a polynomial, by Legendre's coefficients."""
    return float(np.abs(legendre.legval(2.0 * places - 1.0, polynomial) - values).max())


def _projection(record: TimeTable, start: float, end: float, terms: int) -> tuple[Floats, float]:
    """Return the Legendre coefficients of a record over a step, and the root mean square of what they leave out."""
    knots = record.knots
    among = slice(*np.searchsorted(knots, [start, end], side="right"))
    edges = np.concatenate([[start], knots[among], [end]])
    middles, halves = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    times = middles[:, None] + halves[:, None] * _GAUSS
    values, weights = record.at(times), halves[:, None] * _WEIGHTS / (end - start)
    basis = legendre.legvander((2.0 * times - start - end) / (end - start), terms - 1)
    found = (2.0 * np.arange(terms) + 1.0) * np.einsum("kg,kg,kgi->i", weights, values, basis)
    if among.start >= among.stop and record.straight:
        return found, 0.0
    return found, float(np.sqrt(np.sum(weights * (values - basis @ found) ** 2)))


def _scan(
    function: FunctionOfTime, duration: float, used: Callable[[float, bool], float]
) -> tuple[Floats, Floats]:
    """Return times and values of a function over a run: evenly, and more where it changes much.

    Where it has no value, what is ``used`` of it says so by an error, or does not need it.
    """
    if not np.isfinite(duration):
        return np.zeros(0), np.zeros(0)

    def sample(t: float) -> float:
        try:
            return float(function.value_function(t))
        except Exception:  # the user's; what is used of it tells
            return math.nan

    times = np.linspace(0.0, duration, SAMPLES + 1)
    values = np.array([sample(t) for t in times.tolist()])
    change = np.abs(np.diff(values))
    steep = np.flatnonzero(change > 0.01 * max(np.ptp(values), np.finfo(float).tiny))
    steep = steep[np.argsort(change[steep])[::-1]][: SAMPLES // 14]
    more = (times[steep, None] + np.diff(times)[steep, None] * np.arange(1, 8) / 8.0).ravel()
    times = np.concatenate([times, more])
    values = np.concatenate([values, [sample(t) for t in more.tolist()]])
    missing = np.flatnonzero(~np.isfinite(values))
    for k in missing[np.argsort(times[missing])].tolist():
        values[k] = used(float(times[k]), False)  # refuses the value, with the time
    order = np.argsort(times)
    return times[order], values[order]


def _course(motion: TimeTable | FunctionOfTime, duration: float) -> tuple[Floats, Floats]:
    """Return times and values of a prescribed motion: those of a table, or samples of a function."""
    if isinstance(motion, FunctionOfTime):
        return _scan(motion, duration, motion.value)
    return samples_of(motion)
