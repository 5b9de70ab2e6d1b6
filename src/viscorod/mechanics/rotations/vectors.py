"""Vectors and quaternions as tuples of numbers: formulas in them stay in registers and vectorise over lanes."""

from __future__ import annotations

import math
from typing import TypeAlias

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.typing import Floats

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, Vector]
"""Scalar and vector part; also any four coordinates that pair with them, such as forces."""


@lane_kernel
def dot(a: Vector, b: Vector) -> float:
    """Return ``a . b``."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@lane_kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Return ``a x b``."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lane_kernel
def unit(i: int) -> Vector:
    """Return the unit vector along axis ``i``."""
    return 1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0


@lane_kernel
def scaled(s: float, a: Vector) -> Vector:
    """Return ``s a``."""
    return s * a[0], s * a[1], s * a[2]


@lane_kernel
def plus(a: Vector, s: float, b: Vector) -> Vector:
    """Return ``a + s b``."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@lane_kernel
def difference(a: Vector, b: Vector) -> Vector:
    """Return ``a - b``."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@lane_kernel
def plus4(a: Quaternion, s: float, b: Quaternion) -> Quaternion:
    """Return ``a + s b``."""
    return a[0] + s * b[0], plus(a[1], s, b[1])


@lane_kernel
def scaled4(s: float, a: Quaternion) -> Quaternion:
    """Return ``s a``."""
    return s * a[0], scaled(s, a[1])


@lane_kernel
def conjugate(q: Quaternion) -> Quaternion:
    """Return the inverse of the unit quaternion ``q``."""
    return q[0], scaled(-1.0, q[1])


@lane_kernel
def normalised(q: Quaternion) -> Quaternion:
    """Return ``q/|q|``."""
    s = 1.0 / math.sqrt(q[0] * q[0] + dot(q[1], q[1]))
    return s * q[0], scaled(s, q[1])


@lane_kernel
def same_hemisphere(before: Quaternion, q: Quaternion) -> Quaternion:
    """Return ``q`` or ``-q``, the one on the side of ``before``."""
    if before[0] * q[0] + dot(before[1], q[1]) < 0.0:
        return -q[0], scaled(-1.0, q[1])
    return q


@lane_kernel
def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the quaternion product ``p q``."""
    p0, a = p
    q0, b = q
    return p0 * q0 - dot(a, b), plus(plus(cross(a, b), p0, b), q0, a)


@lane_kernel
def rotated(q: Quaternion, a: Vector) -> Vector:
    """Return ``R(q) a`` for a unit quaternion ``q``."""
    t = scaled(2.0, cross(q[1], a))
    return plus(plus(a, q[0], t), 1.0, cross(q[1], t))


@lane_kernel
def rotated_back(q: Quaternion, a: Vector) -> Vector:
    """Return ``R(q)^T a`` for a unit quaternion ``q``."""
    return rotated(conjugate(q), a)


@lane_kernel
def entries(values: Floats, at: int) -> Vector:
    """Return three numbers, from number ``at`` on."""
    return values[at], values[at + 1], values[at + 2]


@lane_kernel
def put_entries(values: Floats, at: int, a: Vector) -> None:
    """Write ``a``, from number ``at`` on."""
    values[at], values[at + 1], values[at + 2] = a


@lane_kernel
def quaternion_of(values: Floats) -> Quaternion:
    """Return four numbers as a quaternion."""
    return values[0], entries(values, 1)


@lane_kernel
def put_quaternion(values: Floats, a: Quaternion) -> None:
    """Write ``a`` as four numbers."""
    values[0] = a[0]
    put_entries(values, 1, a[1])


@lane_kernel
def vector(rows: Floats, k: int, at: int) -> Vector:
    """Return three numbers of row ``k``, from column ``at`` on."""
    return rows[k, at], rows[k, at + 1], rows[k, at + 2]


@lane_kernel
def quaternion(rows: Floats, k: int) -> Quaternion:
    """Return the quaternion in row ``k``."""
    return rows[k, 0], vector(rows, k, 1)


@lane_kernel
def put(rows: Floats, k: int, at: int, a: Vector) -> None:
    """Write ``a`` to row ``k``, from column ``at`` on."""
    rows[k, at], rows[k, at + 1], rows[k, at + 2] = a


@lane_kernel
def put4(rows: Floats, k: int, a: Quaternion) -> None:
    """Write ``a`` to row ``k``."""
    rows[k, 0] = a[0]
    put(rows, k, 1, a[1])


@lane_kernel
def stage_vector(stages: Floats, i: int, k: int, at: int) -> Vector:
    """Return three numbers of row ``k`` of state ``i``, from column ``at`` on."""
    return stages[i, k, at], stages[i, k, at + 1], stages[i, k, at + 2]


@lane_kernel
def stage_quaternion(stages: Floats, i: int, k: int) -> Quaternion:
    """Return the quaternion in row ``k`` of state ``i``."""
    return stages[i, k, 0], stage_vector(stages, i, k, 1)


@lane_kernel
def put_stage(stages: Floats, i: int, k: int, at: int, a: Vector) -> None:
    """Write ``a`` to row ``k`` of state ``i``, from column ``at`` on."""
    stages[i, k, at], stages[i, k, at + 1], stages[i, k, at + 2] = a


@lane_kernel
def load(records: Floats, k: int, at: int, lane: int) -> Vector:
    """Return the vector of one lane in three rows of record ``k``, from row ``at`` on.

    Records are never sliced in a hot loop: each slice would count a reference, which costs as much as the formula.
    """
    return records[k, at, lane], records[k, at + 1, lane], records[k, at + 2, lane]


@lane_kernel
def store(records: Floats, k: int, at: int, lane: int, a: Vector) -> None:
    """Write ``a`` to the rows that :func:`load` reads."""
    records[k, at, lane] = a[0]
    records[k, at + 1, lane] = a[1]
    records[k, at + 2, lane] = a[2]


@lane_kernel
def load4(records: Floats, k: int, at: int, lane: int) -> Quaternion:
    """Return the quaternion of one lane in four rows of record ``k``."""
    return records[k, at, lane], load(records, k, at + 1, lane)


@lane_kernel
def store4(records: Floats, k: int, at: int, lane: int, a: Quaternion) -> None:
    """Write ``a`` to the rows that :func:`load4` reads."""
    records[k, at, lane] = a[0]
    store(records, k, at + 1, lane, a[1])
