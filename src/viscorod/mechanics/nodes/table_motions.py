"""Prescribed motions that are tables: how far they go from what the stages of a step show of them.

Stages of a collocation method see values and rates at their instants. The polynomial through these is what the step
knows of a motion; rows of a table that lie between may be elsewhere.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.mechanics.nodes.load_courses import TABLE, course_at, interval_of
from viscorod.mechanics.nodes.motion_courses import rates_at
from viscorod.typing import Floats, Integers

__all__ = ["TableMotions", "furthest_motion"]


class TableMotions(NamedTuple):
    """Tables that are prescribed, and what is known of a step.

    Attributes:
        begins: where the numbers of each table begin ``(k,)`` among ``numbers``, see ``load_courses``.
        first: where its samples begin ``(k + 1,)`` among ``times`` [s] and ``values`` [m or rad], ascending.
        units: what distances are measured in: the length of the model [m], or 1 rad ``(k,)``.
        instants: of start and stages as parts of a step ``(i,)``.
        hermite: coefficients of Legendre's polynomials from values and slopes there ``(2 i, 2 i)``.
        data, terms: scratch ``(2 i,)``.
    """

    begins: Integers
    numbers: Floats
    first: Integers
    times: Floats
    values: Floats
    units: Floats
    instants: Floats
    hermite: Floats
    data: Floats
    terms: Floats

    @classmethod
    def none(cls) -> TableMotions:
        """Return no tables."""
        nothing, numbers = np.zeros(0, dtype=np.int64), np.zeros(0)
        first, table = np.zeros(1, dtype=np.int64), np.zeros((0, 0))
        return cls(nothing, numbers, first, numbers, numbers, numbers, numbers, table, numbers, numbers)


@exact_part
def find_terms(given: TableMotions, k: int, start: float, h: float) -> None:
    """Write the coefficients of the polynomial that a step of ``h`` [s] from ``start`` has of table ``k``."""
    instants, data, terms, first = given.instants, given.data, given.terms, given.begins[k]
    count = instants.shape[0]
    for i in range(count):
        t, before = start + h * instants[i], i == count - 1
        rate, _ = rates_at(TABLE, given.numbers, first, t, before)
        data[i], data[count + i] = course_at(TABLE, given.numbers, first, t, before), h * rate
    for a in range(terms.shape[0]):
        terms[a] = 0.0
        for b in range(data.shape[0]):
            terms[a] += given.hermite[a, b] * data[b]


@exact_part
def legendre_at(terms: Floats, x: float) -> float:
    """Return a sum of Legendre's polynomials of degrees 0, 1, ... at ``x``, by their recurrence."""
    before, now, total = 0.0, 1.0, 0.0
    for degree in range(terms.shape[0]):
        total += terms[degree] * now
        before, now = now, ((2.0 * degree + 1.0) * x * now - degree * before) / (degree + 1.0)
    return total


@loop
def furthest_motion(given: TableMotions, start: float, end: float) -> float:
    """Return the largest distance of rows, and of middles between, from what a step from ``start`` to ``end`` shows."""
    h, largest = end - start, 0.0
    for k in range(given.begins.shape[0]):
        first = given.first[k]
        samples = given.first[k + 1] - first
        begin = first + interval_of(given.times, first, samples, start, False) + 1
        until = first + interval_of(given.times, first, samples, end, False) + 1
        if begin < until:
            find_terms(given, k, start, h)
        for m in range(begin, until):
            x = 2.0 * ((given.times[m] - start) / h) - 1.0
            largest = max(largest, abs(legendre_at(given.terms, x) - given.values[m]) / given.units[k])
    return largest
