"""The loads of a problem for compiled code, where they are functions of time that it knows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from viscorod.mechanics.nodes import load_courses as courses
from viscorod.mechanics.nodes.load_courses import LoadCourses, Rows
from viscorod.model.actions.load_base import AnyLoad
from viscorod.model.actions.load_effects import TimeFactor
from viscorod.model.actions.time_function import Constant, Ramp, Sine, SmoothRamp, SpinUp, TimeFunction, Until
from viscorod.model.actions.time_table import TimeTable
from viscorod.solve.problem.external_loads import ExternalLoads, LoadRows
from viscorod.solve.problem.problem import Problem

__all__ = ["course_loads", "known_course"]

_FORMULAS: dict[type, tuple[int, Callable[[Any], Sequence[float]]]] = {
    Constant: (courses.CONSTANT, lambda given: (given.level,)),
    Until: (courses.UNTIL, lambda given: (given.time, given.level)),
    Ramp: (courses.RAMP, lambda given: (given.start, given.end, given.level)),
    SmoothRamp: (courses.SMOOTH_RAMP, lambda given: (given.start, given.end, given.level)),
    Sine: (
        courses.SINE,
        lambda given: (given.offset, given.amplitude, 2.0 * math.pi * given.frequency, given.phase),
    ),
    SpinUp: (courses.SPIN_UP, lambda given: (given.speed, given.duration)),
    TimeTable: (courses.TABLE, lambda given: given.numbers),
}
"""Of each kind of function its formula, and what gives its numbers."""


def known_course(function: TimeFunction) -> tuple[int, Sequence[float]] | None:
    """Return formula and numbers of a function of time; None if it is another one."""
    known = _FORMULAS.get(type(function))
    return None if known is None else (known[0], known[1](function))


def course_loads(loads: ExternalLoads) -> LoadCourses | None:
    """Return the loads of a problem; None if some act between nodes, or are other functions of time."""
    problem = loads.problem
    if problem.station_loads:
        return None
    formulas: list[int] = []
    begins: list[int] = []
    until: list[float] = []
    numbers: list[float] = []
    factors = [load.factor for load in problem.nodal_loads] + [load.factor for load in problem.motion_loads]
    for factor in factors:
        found = _course(factor)
        if found is None:
            return None
        formula, given, over = found
        formulas.append(formula)
        begins.append(len(numbers))
        until.append(over)
        numbers += [*given, 0.0]  # one more, which the shortest formula is asked for and does not use
    dead, following, levers = zip(*loads.rows, strict=True) if loads.rows else ((), (), ())
    no_rows = (None,) * len(problem.motion_loads)
    gravity = [load.gravity for load in problem.nodal_loads] + [np.zeros(3) for _ in no_rows]
    return LoadCourses(
        np.array(formulas, dtype=np.int64),
        np.array(begins, dtype=np.int64),
        np.array(numbers),
        np.array(until),
        _gathered((*dead, *no_rows), (6,)),
        _gathered((*following, *no_rows), (6,)),
        _gathered((*levers, *no_rows), (3, 3)),
        np.array(gravity).reshape(-1, 3),
        _places(problem),
    )


def _places(problem: Problem) -> Rows:
    """Return the places of the loads that see motion, one load after the other behind those that do not."""
    counts = [0] * len(problem.nodal_loads) + [len(load.lengths) for load in problem.motion_loads]
    lengths = np.concatenate([np.zeros(0), *(load.lengths for load in problem.motion_loads)])
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return Rows(first, np.arange(len(lengths), dtype=np.int64), lengths)


def _course(factor: TimeFactor) -> tuple[int, Sequence[float], float] | None:
    """Return formula and numbers of a factor, and when it is over [s]; None if it is another function."""
    load = getattr(factor, "__self__", None)
    if not isinstance(load, AnyLoad) or getattr(factor, "__func__", None) is not AnyLoad.factor:
        return None
    over = math.inf if load.until is None else load.until
    if type(load).course is not AnyLoad.course:
        return None
    if load.time is None:
        return courses.CONSTANT, (1.0,), over
    known = known_course(load.time)
    return None if known is None else (*known, over)


def _gathered(rows: Iterable[LoadRows | None], shape: tuple[int, ...]) -> Rows:
    """Put the rows of all loads one after the other; None is a load that has none."""
    first, nodes, values = [0], [], []
    for one in rows:
        if one is not None:
            nodes.append(one.nodes)
            values.append(one.values)
        first.append(first[-1] + (0 if one is None else len(one.nodes)))
    where = np.concatenate(nodes) if nodes else np.zeros(0, dtype=np.int64)
    return Rows(np.array(first), where, np.concatenate(values) if values else np.zeros((0, *shape)))
