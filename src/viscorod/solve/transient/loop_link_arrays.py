"""Joints, springs and held strains for the compiled loop of steps: which it serves, and in what arrays."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.mechanics.compilation.shared import Shared
from viscorod.mechanics.joints.joint_forces import JointLaws, JointStates
from viscorod.mechanics.nodes.motion_courses import MotionCourses
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.linear.matrix import unit_of
from viscorod.solve.problem.motion_courses import course_motors
from viscorod.solve.transient.integrators.closed_states import Closing, Solver
from viscorod.solve.transient.integrators.lent_steps import Lent
from viscorod.solve.transient.integrators.link_memory import LinkMemory
from viscorod.solve.transient.integrators.loop_link_data import LinkRows, LoopLinks
from viscorod.solve.transient.integrators.radau import Radau

__all__ = ["link_arrays", "serves_links"]


_NOTHING, _BLOCK = np.zeros(0), np.zeros((0, 0, 6))
_NONE = LoopLinks(
    LinkMemory.of(0, 0, 0),
    LinkMemory.of(0, 0, 0),
    MotionCourses.none(),
    JointLaws(0, _NOTHING),
    JointStates.of(0, _NOTHING, 0),
    _BLOCK,
    MovingPoses(_BLOCK, _BLOCK, _BLOCK, _BLOCK),
    _NOTHING,
    _NOTHING,
    np.zeros((0, 2), dtype=np.int64),
    _NOTHING,
    None,
    0,
    LinkRows.of(0, 0, 0),
)
"""Of a model that has none of these, but for what nothing is closed with, whose types are those of other arrays."""

_closing: list[Shared[Closing]] = []
"""What nothing is closed with, once it is known."""


def serves_links(constraints: Constraints) -> bool:
    """Return whether the loop knows all that joints and springs do.

    Functions of the user's are Python's, and so are motors of rotation vectors, whose axes are turned between steps.
    """
    joints = constraints.joints
    if joints.laws or constraints.drives_rotations or not bool(np.all(constraints.stage[1] == 1.0)):
        return False
    return course_motors(joints) is not None


def link_arrays(integrator: Radau, lent: Lent, rows: int) -> LoopLinks:
    """Make what the loop has of joints, springs and held strains, with ``rows`` for records."""
    links, constraints = integrator.stage_constraints, integrator.system.constraints
    if links is None:
        return _NONE._replace(closing=_nothing(integrator, lent))
    bundle, problem = lent.task.bundle, integrator.system.problem
    now, given = bundle.start, bundle.links
    c, places, stages = len(given.states.near), len(given.scale), len(integrator.tableau.nodes)
    unit, motors = unit_of(problem.length), course_motors(constraints.joints)
    at, diagonal = constraints.idle, problem.pattern.diagonal
    return LoopLinks(
        links.memory,
        LinkMemory.of(stages, places, c),
        MotionCourses.none() if motors is None else motors,
        JointLaws(0, constraints.functions.buffer),
        JointStates.of(1, given.states.near, places),
        np.zeros((1, *now.twist.shape)),
        MovingPoses(now.r[None], now.q[None], now.twist[None], now.twist[None]),
        *constraints.slopes,
        np.stack([diagonal[problem.size + at // 6], at % 6], axis=1),
        np.array([unit, unit**2]),
        links.closed_states.share(integrator.systems),
        int(constraints.measures_strains),
        LinkRows.of(rows, c, places),
    )


def _nothing(integrator: Radau, lent: Lent) -> Shared[Closing]:
    """Return what nothing is closed with, of the same types in all models."""
    if not _closing:
        _closing.append(Shared(_emptied(_closing_of(integrator, lent))))
    return _closing[0]


def _emptied(value: Any) -> Any:
    """Return a bundle of the same types whose arrays have no entries."""
    if isinstance(value, tuple):
        items = map(_emptied, value)
        return type(value)._make(items) if hasattr(value, "_make") else tuple(items)
    return np.zeros((0,) * value.ndim, value.dtype) if isinstance(value, np.ndarray) else value


def _closing_of(integrator: Radau, lent: Lent) -> Closing:
    task, factors = lent.task.bundle, integrator.systems.factors
    links, none = task.links, np.zeros(0, dtype=np.int64)
    solver = Solver(factors.real, factors.real_rows, factors.scales, none, 0, 0, 0)
    strained = task.body.elements, task.points, task.work.element, task.stages.internal
    scratch = links.scale, factors.scales, task.start.twist, links.operators.gradients
    length = integrator.system.problem.length
    return Closing(links.joints, links.held, links.unit, links.scale, *strained, length, *scratch, solver)
