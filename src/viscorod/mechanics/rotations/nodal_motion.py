"""Motion of nodes within a step, in coordinates of the pose at its start.

A node's pose is ``H = H0 exp(X)`` with ``X = (a, theta)`` in the body frame of the start; its twist follows from the
rate of ``X`` by the right tangent of the exponential (see ``exponential_map``). Nodes that are ``split`` use
``r = r0 + R0 a`` and ``R = R0 exp(theta)`` instead, in which held displacements are linear.
"""

from __future__ import annotations

from typing import TypeAlias

from viscorod.mechanics.compilation.compiled import kernel, lane_kernel, part
from viscorod.mechanics.rotations.exponential_map import (
    body_twist,
    coordinate_rate,
    exponential,
    logarithm,
    pose_after,
    screw_logarithm,
    screw_translation,
)
from viscorod.mechanics.rotations.vectors import (
    Quaternion,
    Vector,
    conjugate,
    difference,
    entries,
    plus,
    product,
    put_entries,
    put_quaternion,
    put_stage,
    quaternion,
    quaternion_of,
    rotated,
    rotated_back,
    scaled,
    stage_vector,
    vector,
)
from viscorod.typing import Floats

Pair: TypeAlias = tuple[Vector, Vector]
"""Coordinates ``(a, theta)``, their rates, or a twist ``(v, w)``."""


@part
def moved(X: Pair, rate: Pair, split: bool) -> tuple[Vector, Quaternion, Pair]:
    """Return translation, rotation and body twist of coordinates that change at ``rate`` [1/s]."""
    x = exponential(X[1])
    v, w = body_twist(X[0], X[1], rate[0], rate[1])
    if split:
        return X[0], x, (rotated_back(x, rate[0]), w)
    return screw_translation(X[0], X[1]), x, (v, w)


@part
def rates_of(X: Pair, twist: Pair, split: bool) -> Pair:
    """Return the rates of the coordinates of a node that moves with the body twist."""
    rate = coordinate_rate(X[0], X[1], twist[0], twist[1])
    if split:
        return rotated(exponential(X[1]), twist[0]), rate[1]
    return rate


@part
def coordinates_of(r0: Vector, q0: Quaternion, r: Vector, q: Quaternion, split: bool) -> Pair:
    """Return the coordinates of the pose ``(r, q)`` relative to ``(r0, q0)``, less than half a turn away."""
    theta = logarithm(product(conjugate(q0), q))
    u = rotated_back(q0, difference(r, r0))
    if split:
        return u, theta
    return screw_logarithm(u, theta), theta


@lane_kernel
def pair(values: Floats) -> Pair:
    """Return six numbers as two vectors."""
    return entries(values, 0), entries(values, 3)


@lane_kernel
def stage_pair(stages: Floats, i: int, k: int) -> Pair:
    """Return row ``k`` of state ``i`` as two vectors."""
    return stage_vector(stages, i, k, 0), stage_vector(stages, i, k, 3)


@lane_kernel
def put_pair(values: Floats, a: Pair) -> None:
    """Write two vectors as six numbers."""
    put_entries(values, 0, a[0])
    put_entries(values, 3, a[1])


@kernel
def place(
    r0: Floats, q0: Floats, X: Floats, rate: Floats, split: bool, r: Floats, q: Floats, twist: Floats
) -> None:
    """Write pose and body twist of one node from its coordinates ``X (6,)`` and their ``rate (6,)`` [1/s].

    Args:
        r0, q0: pose at the start of the step; r, q, twist: outputs (3,), (4,), (6,).
        split: whether displacement and rotation are separate coordinates.
    """
    u, x, body = moved(pair(X), pair(rate), split)
    position, turn = pose_after(entries(r0, 0), quaternion_of(q0), u, x)
    put_entries(r, 0, position)
    put_quaternion(q, turn)
    put_pair(twist, body)


@part
def place_stages(
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    X: Floats,
    D: Floats,
    h: float,
    split: Floats,
    held: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    acceleration: Floats,
) -> None:
    """Write poses, body twists and their rates of all nodes at all stages, from the coordinates there.

    Args:
        r0, q0, twist0: poses and twists at the start of the step.
        X: coordinates ``(s, n, 6)``; D: derivatives from stage values ``(s, s)``; h: step [s].
        split, held: per node, coordinates are separate / pose and twist are known (left alone).
        r, q, twist, acceleration: outputs ``(s, n, ...)``; the acceleration is that of the body twist.
    """
    stages = X.shape[0]
    for k in range(X.shape[1]):
        if held[k] != 0.0:
            continue
        position, turn = vector(r0, k, 0), quaternion(q0, k)
        for i in range(stages):
            da, dtheta = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for j in range(stages):
                a, theta = stage_pair(X, j, k)
                da, dtheta = plus(da, D[i, j] / h, a), plus(dtheta, D[i, j] / h, theta)
            u, x, (v, w) = moved(stage_pair(X, i, k), (da, dtheta), split[k] != 0.0)
            put_stage(twist, i, k, 0, v)
            put_stage(twist, i, k, 3, w)
            here, turned = pose_after(position, turn, u, x)
            put_stage(r, i, k, 0, here)
            q[i, k, 0] = turned[0]
            put_stage(q, i, k, 1, turned[1])
        for i in range(stages):
            dv, dw = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for j in range(stages):
                v, w = stage_pair(twist, j, k)
                dv = plus(dv, D[i, j] / h, difference(v, vector(twist0, k, 0)))
                dw = plus(dw, D[i, j] / h, difference(w, vector(twist0, k, 3)))
            put_stage(acceleration, i, k, 0, dv)
            put_stage(acceleration, i, k, 3, dw)


@part
def coordinate_rates(X: Floats, twist: Floats, split: bool, out: Floats) -> None:
    """Write the rates of the coordinates ``X (6,)`` of a node that moves with the body ``twist (6,)``."""
    put_pair(out, rates_of(pair(X), pair(twist), split))


@part
def move_stages(X: Floats, change: Floats, split: Floats, held: Floats) -> None:
    """Change the coordinates ``X (s, n, 6)`` so that poses move by body increments ``change``, to first order."""
    for k in range(X.shape[1]):
        if held[k] != 0.0:
            continue
        for i in range(X.shape[0]):
            a, theta = stage_pair(X, i, k)
            da, dtheta = rates_of((a, theta), stage_pair(change, i, k), split[k] != 0.0)
            put_stage(X, i, k, 0, plus(a, 1.0, da))
            put_stage(X, i, k, 3, plus(theta, 1.0, dtheta))


@kernel
def coordinates(r0: Floats, q0: Floats, r: Floats, q: Floats, split: bool, X: Floats) -> None:
    """Write the coordinates ``X (6,)`` of the pose ``(r, q)`` relative to ``(r0, q0)``, less than half a turn away."""
    put_pair(X, coordinates_of(entries(r0, 0), quaternion_of(q0), entries(r, 0), quaternion_of(q), split))


@kernel
def pose_differences(r0: Floats, q0: Floats, r: Floats, q: Floats, out: Floats) -> None:
    """Write displacements and rotations in body axes ``(n, 6)`` that lead from poses ``(r0, q0)`` to ``(r, q)``."""
    for k in range(out.shape[0]):
        coordinates(r0[k], q0[k], r[k], q[k], True, out[k])


@part
def extrapolate(
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    X: Floats,
    weights: Floats,
    r1: Floats,
    q1: Floats,
    split: Floats,
    held: Floats,
    out: Floats,
) -> None:
    """Continue the motion of a step as coordinates from another start.

    Args:
        r0, q0, twist0: poses and twists at the start of the old step; X: its stage coordinates ``(stages, n, 6)``.
        weights: ``(new stages, stages + 1)``, of the old stages at the new ones, and of ``twist0`` [s].
        r1, q1: poses at the start of the new step.
        split, held: per node, coordinates are separate / pose is prescribed (left zero).
        out: ``(new stages, n, 6)``.
    """
    last = X.shape[0]
    for k in range(r0.shape[0]):
        apart, v, w = split[k] != 0.0, vector(twist0, k, 0), vector(twist0, k, 3)
        for i in range(out.shape[0]):
            a, theta = scaled(weights[i, last], v), scaled(weights[i, last], w)
            for j in range(last):
                one, other = stage_pair(X, j, k)
                a, theta = plus(a, weights[i, j], one), plus(theta, weights[i, j], other)
            if held[k] != 0.0:
                a = theta = (0.0, 0.0, 0.0)
            else:
                u = a if apart else screw_translation(a, theta)
                r, q = pose_after(vector(r0, k, 0), quaternion(q0, k), u, exponential(theta))
                a, theta = coordinates_of(vector(r1, k, 0), quaternion(q1, k), r, q, apart)
            put_stage(out, i, k, 0, a)
            put_stage(out, i, k, 3, theta)
