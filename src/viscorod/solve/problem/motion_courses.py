"""The prescribed motions of a problem for compiled code, where they are functions of time that it knows."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.nodes.load_courses import TABLE
from viscorod.mechanics.nodes.motion_courses import MotionCourses
from viscorod.solve.problem.load_courses import known_course
from viscorod.solve.problem.problem import SupportSet

__all__ = ["course_motions"]


def course_motions(supports: SupportSet) -> MotionCourses | None:
    """Return the motions of supports; None if some are other functions of time.

    So are tables: what they do within steps is looked at, which the loop does not.
    """
    where: list[tuple[int, int]] = []
    formulas: list[int] = []
    begins: list[int] = []
    numbers: list[float] = []
    for support, component, motion in supports.motions:
        known = known_course(motion)
        if known is None or known[0] == TABLE:
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
        np.zeros((len(supports.nodes), 6)),
    )
