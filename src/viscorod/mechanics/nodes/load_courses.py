"""Loads of nodes whose factors are known functions of time, summed at one instant in compiled code.

The formulas are those of ``model.actions.time_function`` and ``time_table``, and the sums those of
``solve.problem.external_loads``, in the same order: every number is the same, bit for bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.typing import Floats, Integers

__all__ = ["CONSTANT", "RAMP", "SINE", "SMOOTH_RAMP", "SPIN_UP", "TABLE", "UNTIL"]
__all__ += ["LoadCourses", "LoadSums", "Rows", "sum_loads"]

CONSTANT, UNTIL, RAMP, SMOOTH_RAMP, SINE, SPIN_UP, TABLE = range(7)
"""Functions of time, with their numbers: level; time and level; start, end and level (twice); offset, amplitude,
angular frequency and phase; speed and duration; number of rows, their times, their values, and the coefficients of the
cubics between them."""

_TWO_PI, _SQUARE = 2.0 * math.pi, 4.0 * math.pi**2


class Rows(NamedTuple):
    """Values ``(k, ...)`` at nodes ``(k,)``; those of a load ``i`` begin at ``first[i]``, to where the next begin."""

    first: Integers
    nodes: Integers
    values: Floats


class LoadCourses(NamedTuple):
    """Loads of nodes.

    Attributes:
        formulas: of each load ``(k,)``; begins: where its numbers begin among ``numbers``; until: time from which on it
            is zero [s], inf for none ``(k,)``.
        dead, following, levers: wrenches ``(rows, 6)`` and levers ``(rows, 3, 3)``, as in ``add_nodal_loads``.
        gravity: ``(k, 3)``.
        moving: of loads that see motion, which come last: numbers of their places, and lengths that these stand for.
    """

    formulas: Integers
    begins: Integers
    numbers: Floats
    until: Floats
    dead: Rows
    following: Rows
    levers: Rows
    gravity: Floats
    moving: Rows

    @classmethod
    def none(cls) -> LoadCourses:
        """Return no loads."""
        nothing, single = np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64)
        wrenches, levers = Rows(single, nothing, np.zeros((0, 6))), Rows(single, nothing, np.zeros((0, 3, 3)))
        loads = wrenches, wrenches, levers, np.zeros((0, 3)), Rows(single, nothing, np.zeros(0))
        return cls(nothing, nothing, np.zeros(0), np.zeros(0), *loads)


class LoadSums(NamedTuple):
    """All loads at some instants (first index), as in ``add_nodal_loads``, and whether there are any.

    ``factors`` are those of the single loads, not a number where nothing has been summed yet; ``moving`` are those
    of the places of loads that see motion, lengths included.
    """

    factors: Floats
    acting: Floats
    dead: Floats
    following: Floats
    gravity: Floats
    levers: Floats
    moving: Floats

    @classmethod
    def of(cls, instants: int, loads: int, nodes: int, *, places: int = 0, offset: bool) -> LoadSums:
        """Allocate; ``places``: of loads that see motion; ``offset``: any dead force acts at an arm."""
        return cls(
            np.full((instants, loads), np.nan),
            np.zeros(instants),
            np.zeros((instants, nodes, 6)),
            np.zeros((instants, nodes, 6)),
            np.zeros((instants, 3)),
            np.zeros((instants, nodes if offset else 0, 3, 3)),
            np.zeros((instants, places)),
        )


@exact_part
def interval_of(numbers: Floats, first: int, rows: int, t: float, before: bool) -> int:
    """Return the number of the rows of a table that are over at ``t``, less one; ``before``: just before that."""
    low, high = 0, rows
    while low < high:
        middle = (low + high) // 2
        row = numbers[first + middle]
        if row < t or (not before and row == t):
            low = middle + 1
        else:
            high = middle
    return low - 1


@exact_part
def table_at(numbers: Floats, first: int, t: float, before: bool) -> float:
    """Return the value of a table."""
    rows = int(numbers[first])
    times = first + 1
    values, coefficients = times + rows, times + 2 * rows
    interval = interval_of(numbers, times, rows, t, before)
    if interval < 0:
        return float(numbers[values])
    if interval >= rows - 1:
        return float(numbers[values + rows - 1])
    c, x = coefficients + 4 * interval, t - numbers[times + interval]
    return float(numbers[c] + x * (numbers[c + 1] + x * (numbers[c + 2] + x * numbers[c + 3])))


@exact_part
def course_at(formula: int, numbers: Floats, first: int, t: float, before: bool) -> float:
    """Return the value of a function of time at ``t`` [s]; ``before``: the limit from the left."""
    if formula == TABLE:
        return table_at(numbers, first, t, before)
    a, b = numbers[first], numbers[first + 1]
    if formula == CONSTANT:
        return float(a)
    if formula == UNTIL:
        return float(b if t < a or (before and t == a) else 0.0)
    if formula == SINE:
        return float(a + b * math.sin(numbers[first + 2] * t + numbers[first + 3]))
    if formula == SPIN_UP:
        x = t / b
        if x <= 0.0:
            return 0.0
        if x >= 1.0:
            return float(a * (t - b / 2.0))
        return float(a * b * (x * x / 2.0 + (math.cos(_TWO_PI * x) - 1.0) / _SQUARE))
    part, level = min(max((t - a) / (b - a), 0.0), 1.0), numbers[first + 2]
    if formula == RAMP:
        return float(level * part)
    return float(level * (part - math.sin(_TWO_PI * part) / _TWO_PI))


@exact_part
def find_factors(given: LoadCourses, t: float, before: bool, factors: Floats) -> bool:
    """Write the factors of all loads ``(k,)`` at ``t`` [s]; return whether any has changed."""
    changed = False
    for k in range(factors.shape[0]):
        over = given.until[k]
        factor = 0.0
        if t < over or (before and t == over):
            factor = course_at(given.formulas[k], given.numbers, given.begins[k], t, before)
        if factor != factors[k]:
            factors[k], changed = factor, True
    return changed


@exact_part
def add_rows(factor: float, k: int, rows: Rows, sums: Floats) -> bool:
    """Add the wrenches of a load; return whether it has any."""
    first, nodes, values = rows.first, rows.nodes, rows.values
    for row in range(first[k], first[k + 1]):
        for a in range(6):
            sums[nodes[row], a] += factor * values[row, a]
    return bool(first[k] < first[k + 1])


@exact_part
def add_levers(factor: float, k: int, rows: Rows, sums: Floats) -> bool:
    """Add the levers of a load; return whether it has any."""
    first, nodes, values = rows.first, rows.nodes, rows.values
    for row in range(first[k], first[k + 1]):
        for a in range(3):
            for b in range(3):
                sums[nodes[row], a, b] += factor * values[row, a, b]
    return bool(first[k] < first[k + 1])


@exact_part
def write_places(factor: float, k: int, rows: Rows, places: Floats) -> None:
    """Write the factors of the places of a load that sees motion."""
    first, numbers, lengths = rows.first, rows.nodes, rows.values
    for row in range(first[k], first[k + 1]):
        places[numbers[row]] = factor * lengths[row]


@exact_part
def clear_sums(dead: Floats, following: Floats, gravity: Floats, levers: Floats) -> None:
    """Set the sums of one instant to zero."""
    for k in range(dead.shape[0]):
        for a in range(6):
            dead[k, a] = following[k, a] = 0.0
    for k in range(levers.shape[0]):
        for a in range(3):
            for b in range(3):
                levers[k, a, b] = 0.0
    for a in range(3):
        gravity[a] = 0.0


@exact_part
def sum_loads(given: LoadCourses, t: float, before: bool, i: int, sums: LoadSums) -> None:
    """Sum all loads at ``t`` [s] into those of the instant ``i``, unless all factors are what they were.

    Args:
        before: limits from the left are meant.
    """
    factors = sums.factors[i]
    if not find_factors(given, t, before, factors):
        return
    dead, following, gravity, levers = sums.dead[i], sums.following[i], sums.gravity[i], sums.levers[i]
    clear_sums(dead, following, gravity, levers)
    any_load = False
    for k in range(factors.shape[0]):
        factor = factors[k]
        write_places(factor, k, given.moving, sums.moving[i])
        if factor == 0.0:
            continue
        # all of them: what comes after an "or" that is true is not computed
        pulled, pushed = (
            add_rows(factor, k, given.dead, dead),
            add_rows(factor, k, given.following, following),
        )
        turned = add_levers(factor, k, given.levers, levers)
        any_load = any_load or pulled or pushed or turned
        for a in range(3):
            gravity[a] += factor * given.gravity[k, a]
    heavy = gravity[0] != 0.0 or gravity[1] != 0.0 or gravity[2] != 0.0
    sums.acting[i] = 1.0 if any_load or heavy else 0.0
