"""From the user's joints and springs to coordinates between nodes (see ``mechanics.joints.joint_coordinates``)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.joints import joint_coordinates as kinds
from viscorod.mechanics.joints.joint_forces import Joints, measure
from viscorod.mechanics.rotations.quaternion import from_matrices, matrices
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.connections.joint_base import ResolvedJoint
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import AnyPlace
from viscorod.model.connections.spring import ResolvedSpring
from viscorod.model.connections.spring_laws import Law
from viscorod.solve.linear.pattern import Pattern
from viscorod.typing import Floats, Integers

GROUND = -1


class Coordinate(NamedTuple):
    """One coordinate of a joint or spring.

    Attributes:
        joint: number of the joint; word: motion word; kind, geometry: see ``mechanics.joints.joint_coordinates``.
        held: a multiplier holds it; motion: that it follows then, None for the reference value.
        stiffness, damping, rest: of a spring.
    """

    joint: int
    word: str
    kind: int
    geometry: Floats
    held: bool
    motion: TimeFunction | None = None
    stiffness: Law = 0.0
    damping: Law = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class JointSet:
    """All joints and springs of a problem.

    Attributes:
        names: of the joints and springs.
        joint: which of them every coordinate belongs to ``(c,)``; words: the coordinates' motion words.
        arrays: for kernels.
        blocks: number of block rows of multipliers; row: block row of the multipliers of every joint, -1 for none.
        unit: unit of the gap of every coordinate ``(c,)``: a length for displacements, 1 for rotations.
        motions: coordinates that follow functions of time.
        laws: Python functions, or None for the numbers in ``arrays``, of every law (force and damping force).
    """

    names: tuple[str, ...]
    joint: Integers
    words: tuple[str, ...]
    arrays: Joints
    blocks: int
    row: Integers
    unit: Floats
    motions: tuple[tuple[int, TimeFunction], ...]
    laws: tuple[tuple[Law, Law, float], ...] = field(default=())

    @property
    def count(self) -> int:
        """Number of coordinates."""
        return len(self.words)

    @property
    def has_spring(self) -> np.ndarray:
        """Mask of the coordinates with springs, numbers or functions ``(c,)``; dampers do not hold anything."""
        found: np.ndarray = self.arrays.stiffness != 0.0
        for c in np.flatnonzero(self.arrays.law >= 0):
            stiffness = self.laws[self.arrays.law[c]][0]
            found[c] = callable(stiffness) or stiffness != 0.0
        return found

    def measure(
        self, r: Floats, q: Floats, twist: Floats, near: Floats | None = None
    ) -> tuple[Floats, Floats, Floats]:
        """Return values and rates ``(c,)`` and gradients ``(c, 12)`` of all coordinates; see ``joints.measure``."""
        value, rate, gradients = np.zeros(self.count), np.zeros(self.count), np.zeros((self.count, 12))
        known = np.zeros(self.count) if near is None else near
        measure(self.arrays, r, q, twist, known, value, rate, gradients)
        return value, rate, gradients

    def label(self, coordinate: int) -> str:
        """Name a coordinate for messages: "hinge, ux"."""
        return f"{self.names[self.joint[coordinate]]}, {self.words[coordinate]}"

    def cliques(self, nodes: int) -> list[Integers]:
        """Return the block rows that couple through joints; multipliers come after the ``nodes``."""
        groups: dict[int, list[list[int]]] = {}
        for joint in range(len(self.names)):
            mine = np.flatnonzero(self.joint == joint)
            if len(mine) == 0:
                continue
            members = [int(n) for n in self.arrays.nodes[mine[0]] if n != GROUND]
            if self.row[joint] >= 0:
                members.append(nodes + int(self.row[joint]))
            groups.setdefault(len(members), []).append(members)
        return [np.array(group, dtype=np.int64) for group in groups.values()]

    def placed(self, pattern: Pattern, nodes: int) -> JointSet:
        """Return these joints with the numbers of their blocks in a pattern."""
        a = self.arrays
        slots, up, down = (np.full(array.shape, -1, dtype=np.int64) for array in (a.slots, a.up, a.down))
        for c in range(self.count):
            ends = [(side, int(n)) for side, n in enumerate(a.nodes[c]) if n != GROUND]
            row = nodes + a.place[c] // 6
            for i, n in ends:
                for k, o in ends:
                    slots[c, i, k] = pattern.slot(n, o)
                if a.place[c] >= 0:
                    up[c, i], down[c, i] = pattern.slot(n, row), pattern.slot(row, n)
        return replace(self, arrays=a._replace(slots=slots, up=up, down=down))


def joint_set(
    joints: Sequence[ResolvedJoint],
    springs: Sequence[ResolvedSpring],
    node_of: Callable[[AnyPlace], int],
    positions: Floats,
    quaternions: Floats,
    length: float,
) -> JointSet:
    """Write joints and springs as coordinates.

    Args:
        joints, springs: from the model; node_of: the node of a place.
        positions, quaternions: reference poses of the nodes; length: size of the model [m].
    """
    ends: list[tuple[int, int]] = []
    found: list[Coordinate] = []
    parts: list[ResolvedJoint | ResolvedSpring] = [*joints, *springs]
    for number, part in enumerate(parts):
        # motions are those of the part's a relative to its b, so b carries the axes
        carrier = GROUND if part.b is None else node_of(part.b)
        moved = node_of(part.a)
        ends.append((carrier, moved))
        geometry = _JointEnd.of(carrier, _reference_point(part), moved, part.at_a, positions, quaternions)
        if isinstance(part, ResolvedJoint):
            found += _of_joint(number, part, geometry)
        else:
            found += _of_spring(number, part, geometry)
    count = len(found)
    place, row = np.full(count, -1, dtype=np.int64), np.full(len(ends), -1, dtype=np.int64)
    taken = [0] * len(ends)
    blocks = 0
    for c, coordinate in enumerate(found):
        if not coordinate.held:
            continue
        if row[coordinate.joint] < 0:
            row[coordinate.joint] = blocks
            blocks += 1
        place[c] = 6 * row[coordinate.joint] + taken[coordinate.joint]
        taken[coordinate.joint] += 1
    law = np.full(count, -1, dtype=np.int64)
    laws: list[tuple[Law, Law, float]] = []
    numbers = np.zeros((3, count))
    for c, coordinate in enumerate(found):
        if callable(coordinate.stiffness) or callable(coordinate.damping):
            law[c] = len(laws)
            laws.append((coordinate.stiffness, coordinate.damping, coordinate.rest))
        else:
            numbers[:, c] = coordinate.stiffness, coordinate.damping, coordinate.rest
    none = np.full((count, 2), -1, dtype=np.int64)
    arrays = Joints(
        nodes=np.array([ends[c.joint] for c in found], dtype=np.int64).reshape(-1, 2),
        kind=np.array([c.kind for c in found], dtype=np.int64),
        geometry=np.array([c.geometry for c in found]).reshape(-1, kinds.GEOMETRY),
        place=place,
        stiffness=numbers[0].copy(),
        damping=numbers[1].copy(),
        rest=numbers[2].copy(),
        law=law,
        slots=np.full((count, 2, 2), -1, dtype=np.int64),
        up=none,
        down=none.copy(),
    )
    lengths = np.isin(arrays.kind, (kinds.TRANSLATION, kinds.DISTANCE))
    return JointSet(
        names=tuple(part.label for part in parts),
        joint=np.array([c.joint for c in found], dtype=np.int64),
        words=tuple(c.word for c in found),
        arrays=arrays,
        blocks=blocks,
        row=row,
        unit=np.where(lengths, length, 1.0),
        motions=tuple((c, x.motion) for c, x in enumerate(found) if x.motion is not None),
        laws=tuple(laws),
    )


def _reference_point(part: ResolvedJoint | ResolvedSpring) -> Floats:
    """Return the point of b that free displacements of a are measured from: they are 0 in the reference shape."""
    if part.kind == "line":
        return part.at_b
    held = part.held if isinstance(part, ResolvedJoint) else ()
    along = part.frame.T @ (part.at_a - part.at_b)
    free = np.array([0.0 if word in held else 1.0 for word in MOTIONS[:3]])
    return np.asarray(part.at_b + part.frame @ (free * along))


@dataclass(frozen=True)
class _JointEnd:
    """Points and axes of a joint in the axes of its two nodes."""

    rho: tuple[Floats, Floats]
    turn: tuple[Floats, Floats]

    @classmethod
    def of(
        cls, a: int, at_a: Floats, b: int, at_b: Floats, positions: Floats, quaternions: Floats
    ) -> _JointEnd:
        turns, points = [], []
        for node, at in ((a, at_a), (b, at_b)):
            R = np.eye(3) if node == GROUND else matrices(quaternions[node][None])[0]
            origin = np.zeros(3) if node == GROUND else positions[node]
            turns.append(R.T)
            points.append(R.T @ (at - origin))
        return cls((points[0], points[1]), (turns[0], turns[1]))

    def row(self, *pairs: tuple[Floats, Floats], axes: Floats | None = None, component: int = 0) -> Floats:
        """Return the geometry of a coordinate: pairs of global axes (fixed in a, fixed in b), joint axes."""
        out = np.zeros(kinds.GEOMETRY)
        out[kinds.AT_RHO_A : kinds.AT_RHO_A + 3], out[kinds.AT_RHO_B : kinds.AT_RHO_B + 3] = self.rho
        for (u, v), at in zip(pairs, (kinds.AT_U1, kinds.AT_U2), strict=False):
            out[at : at + 3], out[at + 3 : at + 6] = self.turn[0] @ u, self.turn[1] @ v
        if axes is not None:
            both = from_matrices(np.array([turn @ axes for turn in self.turn]))
            out[kinds.AT_Q_A : kinds.AT_Q_A + 4], out[kinds.AT_Q_B : kinds.AT_Q_B + 4] = both
        out[kinds.AT_COMPONENT] = component
        return out


def _of_joint(number: int, joint: ResolvedJoint, ends: _JointEnd) -> list[Coordinate]:
    frame = joint.frame

    def coordinate(word: str, kind: int, geometry: Floats) -> Coordinate:
        motion = joint.motion.get(word)
        return Coordinate(
            number,
            word,
            kind,
            geometry,
            word in joint.held or motion is not None,
            motion,
            joint.stiffness.get(word, 0.0),
            joint.damping.get(word, 0.0),
            joint.rest.get(word, 0.0),
        )

    found = [
        coordinate(word, kinds.TRANSLATION, ends.row((frame[:, i], frame[:, i])))
        for i, word in enumerate(MOTIONS[:3])
    ]
    free = [i for i, word in enumerate(MOTIONS[3:]) if word in joint.free]
    acting = {*joint.stiffness, *joint.damping, *joint.motion}
    for word, kind, geometry in _rotations(free, frame, ends):
        if len(free) < 3 or word in acting:  # rotation vectors do not count turns: only on request
            found.append(coordinate(word, kind, geometry))
    return found


def _rotations(free: list[int], frame: Floats, ends: _JointEnd) -> list[tuple[str, int, Floats]]:
    """Return the coordinates of the rotations of a joint, of which ``free`` are free, by word."""
    words = MOTIONS[3:]
    if len(free) == 3:
        return [(words[i], kinds.ROTATION, ends.row(axes=frame, component=i)) for i in range(3)]
    if not free:
        # each product of two axes is changed by a rotation about the third
        pairs = (((i + 1) % 3, (i + 2) % 3, i) for i in range(3))
        return [
            (words[about], kinds.ALIGNMENT, ends.row((frame[:, i], frame[:, j]))) for i, j, about in pairs
        ]
    if len(free) == 1:
        k = free[0]
        i, j = (k + 1) % 3, (k + 2) % 3
        x, y, z = frame[:, i], frame[:, j], frame[:, k]
        return [
            (words[j], kinds.ALIGNMENT, ends.row((x, z))),
            (words[i], kinds.ALIGNMENT, ends.row((y, z))),
            (words[k], kinds.ANGLE, ends.row((y, x), (x, x))),
        ]
    # two: the later axis is carried by a (the model's b), the earlier one by b, and both stay perpendicular
    second, first = free
    third = 3 - first - second
    f, s = frame[:, first], frame[:, second]
    t = np.cross(f, s)
    return [
        (words[third], kinds.ALIGNMENT, ends.row((f, s))),
        (words[first], kinds.ANGLE, ends.row((t, s), (s, s))),
        (words[second], kinds.ANGLE, ends.row((f, t), (f, f))),
    ]


def _of_spring(number: int, spring: ResolvedSpring, ends: _JointEnd) -> list[Coordinate]:
    words = [word for word in MOTIONS if word in {*spring.stiffness, *spring.damping}]

    def coordinate(word: str, kind: int, geometry: Floats, rest: float) -> Coordinate:
        law, loss = spring.stiffness.get(word, 0.0), spring.damping.get(word, 0.0)
        return Coordinate(number, word, kind, geometry, False, None, law, loss, rest)

    if spring.kind == "line":
        return [coordinate(words[0], kinds.DISTANCE, ends.row(), spring.length)]
    found = []
    for word in words:
        i = MOTIONS.index(word)
        axis = spring.frame[:, i % 3]
        kind, row = (
            (kinds.TRANSLATION, ends.row((axis, axis)))
            if i < 3
            else (kinds.ROTATION, ends.row(axes=spring.frame, component=i - 3))
        )
        found.append(coordinate(word, kind, row, spring.rest.get(word, 0.0)))
    return found
