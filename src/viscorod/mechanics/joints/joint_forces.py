"""Forces of joints: coordinates that are held by multipliers, and springs and dampers on those that are free.

A held coordinate has a multiplier ``lambda``, a separate unknown: ``lambda gradient`` is added to the internal forces
of its nodes, and ``value - target`` is the residual of its row. A free coordinate with a spring and a damper has the
force ``k (value - rest) + c rate`` instead, or the force that Python functions return (see ``callback``).
Multipliers and rows are measured in a ``scale`` that makes them comparable with the stiffness of the nodes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.joints.joint_coordinates import GEOMETRY, coordinate, place_of
from viscorod.typing import Floats, Integers


class Joints(NamedTuple):
    """Coordinates of all joints.

    Attributes:
        nodes: a and b of every coordinate ``(c, 2)``, -1 for the ground.
        kind, geometry: see ``joint_coordinates`` ``(c,)``, ``(c, GEOMETRY)``.
        place: number of the multiplier of held coordinates ``(c,)``, -1 of free ones.
        stiffness, damping, rest: of springs and dampers ``(c,)``.
        law: number of the Python function that gives a force instead ``(c,)``, -1 for none.
        slots: blocks between the nodes ``(c, 2, 2)``; [i, k] couples node i with increments of node k, -1 at
            the ground.
        up, down: blocks (node, multiplier) and (multiplier, node) ``(c, 2)``, -1 where there is none.
    """

    nodes: Integers
    kind: Integers
    geometry: Floats
    place: Integers
    stiffness: Floats
    damping: Floats
    rest: Floats
    law: Integers
    slots: Integers
    up: Integers
    down: Integers

    @classmethod
    def none(cls) -> Joints:
        """Return an empty set of coordinates."""
        pairs = np.zeros((0, 2), dtype=np.int64)
        whole, real = np.zeros(0, dtype=np.int64), np.zeros(0)
        square = np.zeros((0, 2, 2), dtype=np.int64)
        return cls(
            pairs, whole, np.zeros((0, GEOMETRY)), whole, real, real, real, whole, square, pairs, pairs
        )


class JointLaws(NamedTuple):
    """Python functions that give forces: the address of their callback, and what it reads and writes (see ``obey``)."""

    address: int
    buffer: Floats


class JointStates(NamedTuple):
    """All coordinates in some states (first index), the last of which is kept.

    Attributes:
        near: values ``(c,)`` that angles are to be near; target: of held coordinates ``(s, c)``.
        multiplier: ``(s, places)``; carried: forces of springs along an iteration ``(s, c)``.
        value: output ``(c,)``, of the last state; rate, force: outputs ``(s, c)``.
        energy, power: outputs ``(s,)``, stored [J] and dissipated [W]; gap: ``(s, places)``, of held coordinates.
        gradient: scratch ``(12,)``.
    """

    near: Floats
    target: Floats
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
    def of(cls, states: int, near: Floats, places: int) -> JointStates:
        """Allocate for a number of states, and of places of multipliers; ``near`` is kept."""
        c = len(near)
        return cls(
            near=near,
            target=np.zeros((states, c)),
            multiplier=np.zeros((states, places)),
            carried=np.zeros((states, c)),
            value=np.zeros(c),
            rate=np.zeros((states, c)),
            force=np.zeros((states, c)),
            energy=np.zeros(states),
            power=np.zeros(states),
            gap=np.zeros((states, places)),
            gradient=np.zeros(12),
        )


class SpringOperators(NamedTuple):
    """Frozen operators of all coordinates ``(c, 12)``: gradients, and the force's change per increment and rate.

    ``scratch (2, 12)`` and ``turning (12, 12)`` are for making them.
    """

    gradients: Floats
    A: Floats
    P: Floats
    scratch: Floats
    turning: Floats

    @classmethod
    def of(cls, count: int) -> SpringOperators:
        """Allocate for a number of coordinates."""
        gradients, A, P = np.zeros((3, count, 12))
        return cls(gradients, A, P, np.zeros((2, 12)), np.zeros((12, 12)))


@part
def gradient_of(c: int, joints: Joints, r: Floats, q: Floats, near: float, gradient: Floats) -> float:
    """Return the value of coordinate ``c`` at poses ``r (n, 3), q (n, 4)``; write its gradient ``(12,)``."""
    ra, qa = place_of(r, q, joints.nodes[c, 0])
    rb, qb = place_of(r, q, joints.nodes[c, 1])
    return coordinate(c, joints.kind, joints.geometry, ra, qa, rb, qb, near, gradient)


@part
def along(c: int, nodes: Integers, gradient: Floats, x: Floats) -> float:
    """Return the product of a gradient ``(12,)`` with twists or increments ``x (n, 6)`` of the nodes."""
    total = 0.0
    for side in range(2):
        n = nodes[c, side]
        if n >= 0:
            for i in range(6):
                total += gradient[6 * side + i] * x[n, i]
    return total


@part
def scatter_force(c: int, nodes: Integers, gradient: Floats, force: float, out: Floats) -> None:
    """Add ``force gradient`` to the forces ``out (n, 6)`` of the nodes."""
    for side in range(2):
        n = nodes[c, side]
        if n >= 0:
            for i in range(6):
                out[n, i] += force * gradient[6 * side + i]


@kernel
def measure(
    joints: Joints,
    r: Floats,
    q: Floats,
    twist: Floats,
    near: Floats,
    value: Floats,
    rate: Floats,
    gradients: Floats,
) -> None:
    """Write values and rates ``(c,)`` and gradients ``(c, 12)`` of all coordinates in one state.

    Args:
        r, q, twist: of all nodes; near: values ``(c,)`` that angles are to be near.
    """
    for c in range(joints.kind.shape[0]):
        value[c] = gradient_of(c, joints, r, q, near[c], gradients[c])
        rate[c] = along(c, joints.nodes, gradients[c], twist)


@kernel
def joint_forces(
    joints: Joints,
    laws: JointLaws,
    states: JointStates,
    r: Floats,
    q: Floats,
    twist: Floats,
    internal: Floats,
) -> None:
    """Call :func:`hold_coordinates` from Python, with the present forces of springs."""
    hold_coordinates(joints, laws, states, True, r, q, twist, internal)


@part
def hold_coordinates(
    joints: Joints,
    laws: JointLaws,
    states: JointStates,
    final: bool,
    r: Floats,
    q: Floats,
    twist: Floats,
    internal: Floats,
) -> None:
    """Add the forces of all coordinates to the internal forces of some states, and write the gaps of held ones.

    Args:
        final: use the present forces of springs instead of the carried ones.
        r, q, twist: ``(s, n, ...)``; internal: ``(s, n, 6)``, added to.
    """
    nodes, kind, _, place, stiffness, damping, rest, law = joints[:8]
    address, buffer = laws
    near, target, multiplier, carried, value, rate, force, energy, power, gap, gradient = states
    for i in range(internal.shape[0]):
        energy[i] = power[i] = 0.0
        for c in range(kind.shape[0]):
            at = gradient_of(c, joints, r[i], q[i], near[c], gradient)
            value[c] = at
            rate[i, c] = along(c, nodes, gradient, twist[i])
            if place[c] >= 0:
                force[i, c] = multiplier[i, place[c]]
                gap[i, place[c]] = at - target[i, c]
                acting = force[i, c]
            else:
                if law[c] < 0:
                    stretch = at - rest[c]
                    force[i, c] = stiffness[c] * stretch + damping[c] * rate[i, c]
                    energy[i] += 0.5 * stiffness[c] * stretch * stretch
                    power[i] += damping[c] * rate[i, c] * rate[i, c]
                else:
                    obey(address, buffer, law[c], at, rate[i, c])
                    force[i, c] = buffer[0]
                    power[i] += buffer[1]
                acting = force[i, c] if final else carried[i, c]
            if acting != 0.0:
                scatter_force(c, nodes, gradient, acting, internal[i])


@part
def add_frozen_springs(
    joints: Joints, operators: SpringOperators, states: JointStates, internal: Floats
) -> None:
    """Add the difference of the springs' forces from the carried ones, along the frozen gradients."""
    nodes, place, force, carried = joints.nodes, joints.place, states.force, states.carried
    for i in range(internal.shape[0]):
        for c in range(place.shape[0]):
            if place[c] < 0 and force[i, c] != carried[i, c]:
                excess = force[i, c] - carried[i, c]
                scatter_force(c, nodes, operators.gradients[c], excess, internal[i])


@part
def carry_springs(
    joints: Joints, operators: SpringOperators, change: Floats, rate: Floats, states: JointStates
) -> None:
    """Update the forces of springs by increments ``change (s, n, 6)`` and their rates, with frozen operators."""
    nodes, place = joints.nodes, joints.place
    for i in range(change.shape[0]):
        for c in range(place.shape[0]):
            if place[c] < 0:
                moved = along(c, nodes, operators.A[c], change[i]) + along(c, nodes, operators.P[c], rate[i])
                states.carried[i, c] = states.force[i, c] + moved


@part
def obey(address: int, buffer: Floats, law: int, value: float, rate: float) -> None:
    """Evaluate the Python functions of a coordinate.

    Args:
        address: of the callback; law: number of the functions; value, rate: of the coordinate.
        buffer: ``(3,)``, receives force and dissipated power [W].
    """
    buffer[0], buffer[1], buffer[2] = law, value, rate
    call(address, buffer.ctypes, buffer.shape[0])
