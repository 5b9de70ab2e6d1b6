"""Couplings of nodes beside elements, for the stages of a collocation step: joints, springs and held strains.

Multipliers are unknowns of every stage, like the coordinates of the nodes, and positions are what is held: gaps are
closed at every stage (and, by the midpoint rule, at the end of the step). Springs are carried along the iteration like
section forces, so that a frozen Jacobian serves stiff ones too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.elements.held_strains import strain_gaps
from viscorod.mechanics.joints.joint_forces import gradient_of
from viscorod.solve.constraints.constraints import Constraints
from viscorod.typing import Floats, Integers

GAP = 1e-10
"""Gap of a joint over the length (or in rad), or held strain, that a step may leave."""


class ConstraintArrays(NamedTuple):
    """Joints and held strains, and their state at the stages (first index of some arrays).

    Attributes:
        nodes to law: as in ``mechanics.joints.joint_forces.Joints``; element to weight: as in
            ``mechanics.elements.held_strains``.
        address, buffer: of Python functions; near: values that angles are to be near ``(c,)``.
        gradients, A, P: frozen operators of the coordinates ``(c, 12)``; scale: of multipliers ``(places,)``.
        unit: of the gaps ``(places,)``.
        target, target_rate: of held coordinates ``(s, c)``; end_target: at the end of the step, if that is not a stage.
        multiplier: ``(s, places)``; carried: forces of springs along the iteration ``(s, c)``.
        value: of the last stage ``(c,)``; rate, force: ``(s, c)``; energy, power: ``(s,)``; gap: ``(s, places)``.
        gradient: scratch ``(12,)``.
    """

    nodes: Integers
    kind: Integers
    geometry: Floats
    place: Integers
    stiffness: Floats
    damping: Floats
    rest: Floats
    law: Integers
    element: Integers
    point: Integers
    component: Integers
    held_place: Integers
    weight: Floats
    address: int
    buffer: Floats
    near: Floats
    gradients: Floats
    A: Floats
    P: Floats
    scale: Floats
    unit: Floats
    target: Floats
    target_rate: Floats
    end_target: Floats
    multiplier: Floats
    carried: Floats
    value: Floats
    rate: Floats
    force: Floats
    energy: Floats
    power: Floats
    gap: Floats
    gradient: Floats

    @classmethod
    def of(cls, constraints: Constraints, stages: int) -> ConstraintArrays:
        """Allocate; what ``constraints`` keeps (near, operators, scale) is shared with it."""
        joints, held = constraints.arrays, constraints.held
        c, places = constraints.joints.count, len(constraints.gap)
        return cls(
            *joints[:8],
            held.element,
            held.point,
            held.component,
            held.place,
            held.weight,
            constraints.laws.callback.address,
            constraints.buffer,
            constraints.near,
            constraints.gradients,
            constraints.A,
            constraints.P,
            constraints.scale,
            constraints.unit,
            target=np.zeros((stages, c)),
            target_rate=np.zeros((stages, c)),
            end_target=np.zeros(c),
            multiplier=np.zeros((stages, places)),
            carried=np.zeros((stages, c)),
            value=np.zeros(c),
            rate=np.zeros((stages, c)),
            force=np.zeros((stages, c)),
            energy=np.zeros(stages),
            power=np.zeros(stages),
            gap=np.zeros((stages, places)),
            gradient=np.zeros(12),
        )


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
def end_gaps(
    nodes: Integers,
    kind: Integers,
    geometry: Floats,
    place: Integers,
    element: Integers,
    point: Integers,
    component: Integers,
    held_place: Integers,
    near: Floats,
    target: Floats,
    r: Floats,
    q: Floats,
    strain: Floats,
    gradient: Floats,
    gap: Floats,
) -> None:
    """Write the gaps ``(1, places)`` at the end of a step: poses ``(1, n, ...)``, strains ``(1, e, points, 6)``."""
    for c in range(kind.shape[0]):
        if place[c] >= 0:
            gap[0, place[c]] = (
                gradient_of(c, nodes, kind, geometry, r[0], q[0], near[c], gradient) - target[c]
            )
    strain_gaps(element, point, component, held_place, strain, gap)


@part
def add_motors(place: Integers, force: Floats, target_rate: Floats, power: Floats) -> None:
    """Add the power of motors to that of loads and supports ``(s,)`` [W]."""
    for i in range(power.shape[0]):
        for c in range(place.shape[0]):
            if place[c] >= 0:
                power[i] -= force[i, c] * target_rate[i, c]
