"""Loads that see motion: wrenches that depend on position, orientation and twist of the places that they act on.

A law gives the wrench at a place in the place's axes, its derivatives by increments of the pose (at constant twist) and
by the twist, and the power that it dissipates outside of the model; what else it does is work from outside. Laws are
compiled, one ``if`` each in :func:`answer`, or Python functions. Places are rigidly connected with nodes, so everything
stays within the diagonal blocks of these.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.nodes.attached_poses import attached_pose, link_map
from viscorod.mechanics.nodes.drag import drag
from viscorod.mechanics.rotations.vectors import Quaternion, Vector, quaternion, rotated, vector
from viscorod.typing import Floats, Integers

PYTHON, DRAG = 0.0, 1.0
"""Laws, by the first number of their row; a Python function has its number and its address after it."""
LAWS = {"drag": DRAG}
"""Compiled laws by their word in the model."""
ROW = 9
"""In the row of a law: which, and what it takes."""
ANSWERED = 79
"""Exchanged with a Python function: its number, position, rotation matrix, twist, whether derivatives are wanted; it
leaves wrench, two matrices and power."""


class MotionLoads(NamedTuple):
    """Places ``(m, ...)`` of all loads that see motion.

    Attributes:
        nodes: that they are connected with; arms, turns: poses in the nodes' axes ``(m, 3)`` [m], ``(m, 4)``.
        maps: body increments and twists at the places from those of the nodes ``(m, 6, 6)``.
        laws: rows of numbers ``(m, ROW)``.
    """

    nodes: Integers
    arms: Floats
    turns: Floats
    maps: Floats
    laws: Floats

    @classmethod
    def of(cls, nodes: Integers, arms: Floats, turns: Floats, laws: Floats) -> MotionLoads:
        """Collect places and laws."""
        maps = np.zeros((len(nodes), 6, 6))
        for k in range(len(nodes)):
            link_map(arms[k], turns[k], maps[k])
        return cls(nodes, arms, turns, maps, laws)

    @classmethod
    def none(cls) -> MotionLoads:
        """Return no places."""
        return cls.of(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, ROW)))


class MotionWork(NamedTuple):
    """Scratch: twist and wrench ``(6,)``, derivatives and their product with a map ``(6, 6)``, numbers of Python."""

    twist: Floats
    wrench: Floats
    stiffness: Floats
    damping: Floats
    product: Floats
    numbers: Floats

    @classmethod
    def new(cls) -> MotionWork:
        """Allocate."""
        first, second, third = np.zeros((3, 6, 6))
        return cls(np.zeros(6), np.zeros(6), first, second, third, np.zeros(ANSWERED))


class MotionTangent(NamedTuple):
    """Where derivatives go; no blocks: they are not wanted.

    Attributes:
        rate_map: d(twist)/d(increment) of the nodes ``(n, 6, 6)``, or no rows: twists do not change.
        blocks: of the matrix ``(b, 6, 6)`` (see ``geometric_element.assemble``); rate_blocks: by twists alone, or none.
        diagonal: blocks of the nodes ``(n,)``.
    """

    rate_map: Floats
    blocks: Floats
    rate_blocks: Floats
    diagonal: Integers

    @classmethod
    def none(cls) -> MotionTangent:
        """Return that none is wanted."""
        nothing = np.zeros((0, 6, 6))
        return cls(nothing, nothing, nothing, np.zeros(0, dtype=np.int64))


@part
def ask_python(law: Floats, k: int, r: Vector, q: Quaternion, tangent: bool, work: MotionWork) -> float:
    """Let a Python function answer; derivatives cost it many calls, and are asked for if they are wanted."""
    numbers, twist = work.numbers, work.twist
    numbers[0] = law[k, 1]
    for a in range(3):
        numbers[1 + a] = r[a]
        for b in range(3):
            unit = (1.0 if b == 0 else 0.0), (1.0 if b == 1 else 0.0), (1.0 if b == 2 else 0.0)
            numbers[4 + 3 * a + b] = rotated(q, unit)[a]
    for a in range(6):
        numbers[13 + a] = twist[a]
    numbers[19] = 1.0 if tangent else 0.0
    call(int(law[k, 2]), numbers.ctypes, numbers.shape[0])
    for a in range(6):
        work.wrench[a] = numbers[a]
        for b in range(6):
            work.stiffness[a, b] = numbers[6 + 6 * a + b]
            work.damping[a, b] = numbers[42 + 6 * a + b]
    power: float = numbers[ANSWERED - 1]
    return power


@part
def answer(law: Floats, k: int, r: Vector, q: Quaternion, tangent: bool, work: MotionWork) -> float:
    """Write the wrench of row ``k`` and its derivatives, at the twist in ``work``; return the dissipated power.

    Args:
        r, q: pose of the place; tangent: whether derivatives are wanted.
    """
    for a in range(6):
        for b in range(6):
            work.stiffness[a, b] = work.damping[a, b] = 0.0
    if law[k, 0] == DRAG:
        return drag(law, k, q, work.twist, work.wrench, work.stiffness, work.damping)
    return ask_python(law, k, r, q, tangent, work)


@part
def to_node(X: Floats, k: int, factor: float, matrix: Floats, product: Floats) -> None:
    """Replace the 6x6 ``matrix`` at place ``k`` by ``factor X^T matrix X``, that at the node."""
    for i in range(6):
        for j in range(6):
            product[i, j] = 0.0
            for a in range(6):
                product[i, j] += factor * matrix[i, a] * X[k, a, j]
    for i in range(6):
        for j in range(6):
            matrix[i, j] = 0.0
            for a in range(6):
                matrix[i, j] += X[k, a, i] * product[a, j]


@kernel
def add_motion_loads(
    loads: MotionLoads,
    factors: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    external: Floats,
    tangent: MotionTangent,
    work: MotionWork,
) -> float:
    """Add the loads to ``external (n, 6)``, take their derivative off the matrix; return the dissipated power [W].

    Args:
        loads: places and laws; factors: of the places, lengths that they stand for included ``(m,)``.
        r, q: poses of all nodes; twist: of all nodes, body axes ``(n, 6)``.
        tangent: where derivatives go; work: scratch.
    """
    nodes, arms, turns, maps, laws = loads
    rate_map, blocks, rate_blocks, diagonal = tangent
    power = 0.0
    for k in range(nodes.shape[0]):
        factor, node = factors[k], nodes[k]
        if factor == 0.0:
            continue
        for a in range(6):
            work.twist[a] = 0.0
            for b in range(6):
                work.twist[a] += maps[k, a, b] * twist[node, b]
        place, turn = attached_pose(
            vector(arms, k, 0), quaternion(turns, k), vector(r, node, 0), quaternion(q, node)
        )
        power += factor * answer(laws, k, place, turn, blocks.shape[0] > 0, work)
        for a in range(6):
            for b in range(6):
                external[node, a] += factor * maps[k, b, a] * work.wrench[b]
        if blocks.shape[0] == 0:
            continue
        to_node(maps, k, factor, work.stiffness, work.product)
        to_node(maps, k, factor, work.damping, work.product)
        slot = diagonal[node]
        for j in range(6):
            for i in range(6):
                change = work.stiffness[i, j]
                if rate_map.shape[0] > 0:
                    for a in range(6):
                        change += work.damping[i, a] * rate_map[node, a, j]
                blocks[slot, j, i] -= change
                if rate_blocks.shape[0] > 0:
                    rate_blocks[slot, j, i] -= work.damping[i, j]
    return power
