"""Couplings of nodes beside elements, for the stages of a collocation step: joints, springs and held strains.

Multipliers are unknowns of every stage, like the coordinates of the nodes, and positions are what is held: gaps are
closed at every stage (and, by the midpoint rule, at the end of the step). Springs are carried along the iteration like
section forces, so that a frozen Jacobian serves stiff ones too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.elements.held_strains import HeldStrains, strain_gaps
from viscorod.mechanics.joints.joint_forces import (
    JointLaws,
    Joints,
    JointStates,
    SpringOperators,
    gradient_of,
)
from viscorod.mechanics.joints.settled_multipliers import Settling
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.constraints.constraints import Constraints
    from viscorod.solve.problem.problem import Problem

GAP = 1e-10
"""Gap of a joint over the length (or in rad), or held strain, that a step may leave."""


POINT = 1e-6
"""Part of the model's length as whose radius of gyration that of a point mass counts."""


class ConstraintArrays(NamedTuple):
    """Joints and held strains, and their state at the stages (first index of some arrays).

    Attributes:
        joints, held: what they are; laws: Python functions that give forces; operators: frozen, of springs.
        states: of all coordinates at the stages.
        scale: of multipliers ``(places,)``; unit: of the gaps ``(places,)``.
        target_rate: of held coordinates ``(s, c)``; end_target: at the end of the step, if that is not a stage.
        worst: the largest gap of all stages in its unit ``(1,)``, or nothing if there are no constraints.
        settling: of the multipliers of a step.
    """

    joints: Joints
    held: HeldStrains
    laws: JointLaws
    operators: SpringOperators
    states: JointStates
    scale: Floats
    unit: Floats
    target_rate: Floats
    end_target: Floats
    worst: Floats
    settling: Settling

    @classmethod
    def of(cls, constraints: Constraints, stages: int) -> ConstraintArrays:
        """Allocate; what ``constraints`` keeps (near, operators, scale) is shared with it."""
        c = constraints.joints.count
        return cls(
            constraints.arrays,
            constraints.held,
            constraints.functions,
            constraints.operators,
            JointStates.of(stages, constraints.near, len(constraints.gap)),
            constraints.scale,
            constraints.unit,
            target_rate=np.zeros((stages, c)),
            end_target=np.zeros(c),
            worst=np.zeros(1),
            settling=Settling.of(_inverse(constraints.problem), c),
        )

    @classmethod
    def none(cls) -> ConstraintArrays:
        """Return those of a model without constraints."""
        none, table = np.zeros(0), np.zeros((0, 0))
        states = JointStates.of(0, none, 0)
        return cls(
            Joints.none(),
            HeldStrains.none(),
            JointLaws(0, none),
            SpringOperators.of(0),
            states,
            none,
            none,
            target_rate=table,
            end_target=none,
            worst=none,
            settling=Settling.of(np.zeros((0, 6)), 0),
        )


def _inverse(problem: Problem) -> Floats:
    """Return the inverse of masses and moments of inertia of the nodes ``(n, 6)``, 0 where they are supported."""
    diagonal = np.einsum("nii->ni", problem.mass).copy()
    # what has no inertia of its own turns as lightly as what is far smaller than the model
    least = POINT**2 * diagonal[:, :3].max(axis=1, keepdims=True) * problem.length**2
    diagonal[:, 3:] = np.maximum(diagonal[:, 3:], least)
    inverse = 1.0 / np.maximum(diagonal, np.finfo(float).tiny)
    inverse[problem.supports.nodes] = 0.0
    return np.asarray(inverse)


@part
def add_gaps(gap: Floats, scale: Floats, factor: float, n: int, residual: Floats) -> None:
    """Write scaled gaps ``(s, places)`` into the rows of the residual ``(s, N, 6)`` behind those of ``n`` nodes."""
    for i in range(residual.shape[0]):
        for p in range(scale.shape[0]):
            residual[i, n + p // 6, p % 6] = factor * scale[p] * gap[i, p]


@part
def largest_gap(gap: Floats, unit: Floats) -> float:
    """Return the largest gap of all stages in its unit."""
    largest = 0.0
    for i in range(gap.shape[0]):
        for p in range(unit.shape[0]):
            largest = max(largest, abs(gap[i, p]) / unit[p])
    return largest


@part
def move_multipliers(change: Floats, scale: Floats, n: int, multiplier: Floats) -> None:
    """Change multipliers ``(s, places)`` by the rows of an increment ``(s, N, 6)`` behind those of ``n`` nodes."""
    for i in range(multiplier.shape[0]):
        for p in range(scale.shape[0]):
            multiplier[i, p] += scale[p] * change[i, n + p // 6, p % 6]


@part
def end_gaps(links: ConstraintArrays, r: Floats, q: Floats, strain: Floats) -> None:
    """Write the gaps ``(1, places)`` at the end of a step: poses ``(1, n, ...)``, strains ``(1, e, points, 6)``."""
    joints, place, states = links.joints, links.joints.place, links.states
    for c in range(place.shape[0]):
        if place[c] >= 0:
            value = gradient_of(c, joints, r[0], q[0], states.near[c], states.gradient)
            states.gap[0, place[c]] = value - links.end_target[c]
    strain_gaps(links.held, strain, states.gap)


@part
def add_motors(links: ConstraintArrays, power: Floats) -> None:
    """Add the power of motors to that of loads and supports ``(s,)`` [W]."""
    place, force, target_rate = links.joints.place, links.states.force, links.target_rate
    for i in range(power.shape[0]):
        for c in range(place.shape[0]):
            if place[c] >= 0:
                power[i] -= force[i, c] * target_rate[i, c]
