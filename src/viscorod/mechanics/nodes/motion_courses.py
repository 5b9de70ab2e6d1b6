"""Prescribed motions of supports that are known functions of time, at one instant in compiled code.

Values are those of ``load_courses``; the formulas of their rates and accelerations are those of
``model.actions.time_function`` and ``time_table``: every number is the same, bit for bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.nodes.load_courses import (
    RAMP,
    SINE,
    SMOOTH_RAMP,
    SPIN_UP,
    TABLE,
    course_at,
    interval_of,
)
from viscorod.typing import Floats, Integers

__all__ = ["MotionCourses", "rates_at", "write_motion"]

_TWO_PI = 2.0 * math.pi


class MotionCourses(NamedTuple):
    """Prescribed motions.

    Attributes:
        supports, components: of each motion ``(k,)``; formulas: of its function of time, whose numbers begin at
            ``begins`` among ``numbers``, see ``load_courses``.
        acceleration: scratch, of all supports ``(m, 6)``.
    """

    supports: Integers
    components: Integers
    formulas: Integers
    begins: Integers
    numbers: Floats
    acceleration: Floats

    @classmethod
    def none(cls) -> MotionCourses:
        """Return no motions."""
        nothing = np.zeros(0, dtype=np.int64)
        return cls(nothing, nothing, nothing, nothing, np.zeros(0), np.zeros((0, 6)))


@exact_part
def table_rates(numbers: Floats, first: int, t: float, before: bool) -> tuple[float, float]:
    """Return the first and second derivative of a table, without the spikes of jumps and corners."""
    rows, times = int(numbers[first]), first + 1
    interval = interval_of(numbers, times, rows, t, before)
    if interval < 0 or interval >= rows - 1:
        return 0.0, 0.0
    c, x = times + 2 * rows + 4 * interval, t - numbers[times + interval]
    c1, c2, c3 = numbers[c + 1], numbers[c + 2], numbers[c + 3]
    return c1 + x * (2.0 * c2 + x * 3.0 * c3), 2.0 * c2 + x * 6.0 * c3


@exact_part
def rates_at(formula: int, numbers: Floats, first: int, t: float, before: bool) -> tuple[float, float]:
    """Return the first and second derivative of a function of time at ``t`` [s]; ``before``: limits from the left."""
    if formula == TABLE:
        return table_rates(numbers, first, t, before)
    a, b = numbers[first], numbers[first + 1]
    if formula == SINE:
        omega, phase = numbers[first + 2], numbers[first + 3]
        return b * omega * math.cos(omega * t + phase), -b * omega**2 * math.sin(omega * t + phase)
    if formula == SPIN_UP:
        x = min(max(t / b, 0.0), 1.0)
        speed = a * (x - math.sin(_TWO_PI * x) / _TWO_PI)
        return speed, a / b * (1.0 - math.cos(_TWO_PI * x))
    if formula == RAMP:
        inside = (a < t <= b) if before else (a <= t < b)
        return numbers[first + 2] / (b - a) if inside else 0.0, 0.0
    if formula == SMOOTH_RAMP:
        x, level = min(max((t - a) / (b - a), 0.0), 1.0), numbers[first + 2]
        bend = _TWO_PI * level / (b - a) ** 2 * math.sin(_TWO_PI * x)
        return level / (b - a) * (1.0 - math.cos(_TWO_PI * x)), bend
    return 0.0, 0.0


@exact_part
def write_motion(given: MotionCourses, t: float, before: bool, target: Floats, rate: Floats) -> None:
    """Write the prescribed values of supports and their rates ``(m, 6)``, and accelerations, at ``t`` [s]."""
    for k in range(given.formulas.shape[0]):
        s, a, formula, first = given.supports[k], given.components[k], given.formulas[k], given.begins[k]
        target[s, a] = course_at(formula, given.numbers, first, t, before)
        rate[s, a], given.acceleration[s, a] = rates_at(formula, given.numbers, first, t, before)
