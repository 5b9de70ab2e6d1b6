"""What the linearisation of a step is made of beside elements, loads and supports, in compiled code."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.rotations.vectors import (
    difference,
    put_stage,
    rotated_back,
    stage_quaternion,
    stage_vector,
    vector,
)
from viscorod.typing import Floats, Integers

__all__ = ["begin_stages", "fall", "mean_jacobian"]


@kernel
def begin_stages(
    mass: Floats,
    twist: Floats,
    diagonal: Integers,
    K: Floats,
    C: Floats,
    masses: Floats,
) -> None:
    """Begin the Jacobians of all stages: zero, and in ``C`` the derivatives of ``L1(x) M x`` by twists.

    Args:
        mass: of the nodes ``(n, 6, 6)``; twist: at the stages ``(s, n, 6)``.
        diagonal: their blocks in ``K, C (s, b, 6, 6)``, whose entries ``[b, j, i]`` are in row i and column j.
        masses: output, the inertia at every stage ``(s, n, 6, 6)``.
    """
    for s in range(K.shape[0]):
        for b in range(K.shape[1]):
            for j in range(6):
                for i in range(6):
                    K[s, b, j, i] = C[s, b, j, i] = 0.0
        for n in range(mass.shape[0]):
            b = diagonal[n]
            for j in range(6):
                for i in range(6):
                    masses[s, n, i, j] = mass[n, i, j]
            # -ad(x)^T M, row by row
            for i in range(3):
                k, m = (i + 1) % 3, (i + 2) % 3
                v1, v2, w1, w2 = twist[s, n, k], twist[s, n, m], twist[s, n, 3 + k], twist[s, n, 3 + m]
                for j in range(6):
                    C[s, b, j, i] += w1 * mass[n, m, j] - w2 * mass[n, k, j]
                    C[s, b, j, 3 + i] += v1 * mass[n, m, j] - v2 * mass[n, k, j]
                    C[s, b, j, 3 + i] += w1 * mass[n, 3 + m, j] - w2 * mass[n, 3 + k, j]
            # at constant momentum (p, h): -[[0, p~], [p~, h~]]
            for i in range(3):
                k, m = (i + 1) % 3, (i + 2) % 3
                p = h = 0.0
                for j in range(6):
                    p += mass[n, i, j] * twist[s, n, j]
                    h += mass[n, 3 + i, j] * twist[s, n, j]
                C[s, b, 3 + m, k] += p
                C[s, b, 3 + k, m] -= p
                C[s, b, m, 3 + k] += p
                C[s, b, k, 3 + m] -= p
                C[s, b, 3 + m, 3 + k] += h
                C[s, b, 3 + k, 3 + m] -= h


@kernel
def fall(q: Floats, acceleration: Floats, gravity: Floats, out: Floats) -> None:
    """Write the accelerations of the nodes ``(s, n, 6)`` against ``gravity (s, 3)``, that of the whole model."""
    for s in range(q.shape[0]):
        pull = vector(gravity, s, 0)
        still = pull[0] == 0.0 and pull[1] == 0.0 and pull[2] == 0.0
        for n in range(q.shape[1]):
            linear = stage_vector(acceleration, s, n, 0)
            if not still:
                linear = difference(linear, rotated_back(stage_quaternion(q, s, n), pull))
            put_stage(out, s, n, 0, linear)
            put_stage(out, s, n, 3, stage_vector(acceleration, s, n, 3))


@kernel
def mean_jacobian(
    K: Floats,
    C: Floats,
    masses: Floats,
    twist: Floats,
    columns: Integers,
    diagonal: Integers,
    turn: Floats,
    mean_K: Floats,
    mean_C: Floats,
    mean_mass: Floats,
) -> None:
    """Write the means over the stages, as a step has them: twists follow increments that turn with the nodes.

    With ``ad`` of the mean twist it is ``K + C ad`` and ``C + M ad``.

    Args:
        K, C: Jacobians of the stages ``(s, b, 6, 6)``; masses, twist: of the nodes ``(s, n, ...)``.
        columns: of the blocks; diagonal: blocks of the nodes; turn: scratch ``(n, 6, 6)``.
        mean_K, mean_C, mean_mass: outputs.
    """
    stages, nodes = twist.shape[0], twist.shape[1]
    part_of = 1.0 / stages
    for n in range(nodes):
        for i in range(6):
            for j in range(6):
                total = 0.0
                for s in range(stages):
                    total += masses[s, n, i, j]
                mean_mass[n, i, j] = total * part_of
                turn[n, i, j] = 0.0
        for i in range(3):
            k, m = (i + 1) % 3, (i + 2) % 3
            v = w = 0.0
            for s in range(stages):
                v += twist[s, n, i]
                w += twist[s, n, 3 + i]
            v, w = v * part_of, w * part_of
            turn[n, k, m] = turn[n, 3 + k, 3 + m] = -w
            turn[n, m, k] = turn[n, 3 + m, 3 + k] = w
            turn[n, k, 3 + m], turn[n, m, 3 + k] = -v, v
    for b in range(K.shape[1]):
        for j in range(6):
            for i in range(6):
                one = two = 0.0
                for s in range(stages):
                    one += K[s, b, j, i]
                    two += C[s, b, j, i]
                mean_K[b, j, i], mean_C[b, j, i] = one * part_of, two * part_of
        n = columns[b]
        if n >= nodes:
            continue
        for j in range(6):
            for k in range(3 if j < 3 else 6):
                by = turn[n, k, j]
                for i in range(6):
                    mean_K[b, j, i] += by * mean_C[b, k, i]
    for n in range(nodes):
        b = diagonal[n]
        for j in range(6):
            for k in range(3 if j < 3 else 6):
                by = turn[n, k, j]
                for i in range(6):
                    mean_C[b, j, i] += mean_mass[n, i, k] * by
