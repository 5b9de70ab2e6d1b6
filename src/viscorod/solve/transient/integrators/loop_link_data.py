"""Joints, springs and held strains in the compiled loop of steps: what it works on, and what records have of them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from viscorod.mechanics.joints.joint_forces import JointLaws, JointStates
from viscorod.mechanics.nodes.motion_courses import MotionCourses
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.transient.integrators.link_memory import LinkMemory
from viscorod.typing import Floats, Integers

__all__ = ["LinkRows", "LoopLinks"]


class LinkRows(NamedTuple):
    """Joints in the states of the records: values, rates and forces that they exert, and what they are closed to.

    ``value``, ``rate``, ``force``, ``target``, ``target_rate`` and ``near`` are ``(rows, c)``, ``multiplier`` is
    ``(rows, places)``.
    """

    value: Floats
    rate: Floats
    force: Floats
    target: Floats
    target_rate: Floats
    near: Floats
    multiplier: Floats

    @classmethod
    def of(cls, rows: int, coordinates: int, places: int) -> LinkRows:
        """Allocate."""
        value, rate, force, target, target_rate, near = np.zeros((6, rows, coordinates))
        return cls(value, rate, force, target, target_rate, near, np.zeros((rows, places)))


class LoopLinks(NamedTuple):
    """Joints, springs and held strains.

    Attributes:
        memory: from step to step; whole: the same of a step that is tried again in halves.
        motors: what drives coordinates, as motions of one support with so many components.
        laws: there are none; alone, force: of one state, for Jacobians, the latter ``(1, n, 6)``.
        start: the present state as one of one state; stiffness, damping: of springs ``(c,)``.
        idle: multipliers without a condition, block and place in it ``(k, 2)``; unit: of displacements [m], and its
            square.
        closing: what records are closed with, a shared bundle; strains: whether strains are held; rows: of records.
    """

    memory: LinkMemory
    whole: LinkMemory
    motors: MotionCourses
    laws: JointLaws
    alone: JointStates
    force: Floats
    start: MovingPoses
    stiffness: Floats
    damping: Floats
    idle: Integers
    unit: Floats
    closing: Any
    strains: int
    rows: LinkRows
