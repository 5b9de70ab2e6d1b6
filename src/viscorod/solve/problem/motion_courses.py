"""The prescribed motions of a problem for compiled code, where they are functions of time that it knows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.polynomial import legendre

from viscorod.mechanics.nodes.motion_courses import MotionCourses
from viscorod.mechanics.nodes.table_motions import TableMotions
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_table import TimeTable
from viscorod.solve.problem.joint_set import JointSet
from viscorod.solve.problem.load_courses import known_course
from viscorod.solve.problem.problem import SupportSet
from viscorod.typing import Floats

__all__ = ["course_motions", "course_motors", "hermite_terms", "samples_of", "table_motions"]


def course_motions(supports: SupportSet) -> MotionCourses | None:
    """Return the motions of supports; None if some are other functions of time."""
    return _courses(supports.motions, (len(supports.nodes), 6))


def course_motors(joints: JointSet) -> MotionCourses | None:
    """Return what drives coordinates of joints, as components of one support; None as of :func:`course_motions`."""
    return _courses([(0, number, motion) for number, motion in joints.motions], (1, joints.count))


def _courses(
    motions: Iterable[tuple[int, int, TimeFunction]], shape: tuple[int, int]
) -> MotionCourses | None:
    where: list[tuple[int, int]] = []
    formulas: list[int] = []
    begins: list[int] = []
    numbers: list[float] = []
    for support, component, motion in motions:
        known = known_course(motion)
        if known is None:
            return None
        formula, given = known
        where.append((support, component))
        formulas.append(formula)
        begins.append(len(numbers))
        numbers += [*given, 0.0]  # one more, which the shortest formula is asked for and does not use
    at = np.array(where, dtype=np.int64).reshape(-1, 2)
    return MotionCourses(
        np.ascontiguousarray(at[:, 0]),
        np.ascontiguousarray(at[:, 1]),
        np.array(formulas, dtype=np.int64),
        np.array(begins, dtype=np.int64),
        np.array(numbers),
        np.zeros(shape),
    )


def hermite_terms(instants: Floats) -> Floats:
    """Return what makes Legendre coefficients ``(2 i, 2 i)`` of values and slopes at ``instants (i,)`` of a step."""
    through = 2.0 * instants - 1.0
    basis = np.eye(2 * len(through))
    slopes = 2.0 * legendre.legval(through, legendre.legder(basis)).T
    values = legendre.legval(through, basis).T
    return np.ascontiguousarray(np.linalg.inv(np.concatenate([values, slopes])))


def samples_of(table: TimeTable) -> tuple[Floats, Floats]:
    """Return times and values of a table, at its rows and in the middle between."""
    times = np.sort(np.concatenate([table.knots, 0.5 * (table.knots[1:] + table.knots[:-1])]))
    return times, table.at(times)


def table_motions(supports: SupportSet, length: float, nodes: Floats) -> TableMotions | None:
    """Return the motions that are tables as compiled code knows them, None if there are none.

    Args:
        supports: of a problem of this ``length`` [m]; nodes: of the method, as parts of a step.
    """
    tables = [(motion, component) for _, component, motion in supports.motions if type(motion) is TimeTable]
    if not tables:
        return None
    numbers = [motion.numbers for motion, _ in tables]
    samples = [samples_of(motion) for motion, _ in tables]
    instants = np.concatenate([[0.0], nodes])
    return TableMotions(
        np.cumsum([0, *map(len, numbers[:-1])], dtype=np.int64),
        np.concatenate(numbers),
        np.cumsum([0, *(len(times) for times, _ in samples)], dtype=np.int64),
        np.concatenate([times for times, _ in samples]),
        np.concatenate([values for _, values in samples]),
        np.array([length if component < 3 else 1.0 for _, component in tables]),
        instants,
        hermite_terms(instants),
        *np.zeros((2, 2 * len(instants))),
    )
