"""States within a step of many stages: poses and twists that go through these as well."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.vectors import (
    conjugate,
    difference,
    normalised,
    plus,
    product,
    put_stage,
    stage_quaternion,
    stage_vector,
)
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

__all__ = ["go_through_stages"]


@part
def weight_of(values: Floats, stage: int, place: float) -> float:
    """Return the value at a ``place`` of what is one at one stage, and zero at the others and at the start."""
    power, total = place, 0.0
    for p in range(values.shape[1]):
        total += values[stage, p] * power
        power *= place
    return total


@kernel
def go_through_stages(
    parts: Floats,
    method: Tableau,
    stages: tuple[Floats, Floats, Floats],
    row: int,
    at_stages: int,
    states: tuple[Floats, Floats, Floats],
) -> None:
    """Correct poses and twists within a step so that they go through its stages, but for the last one, its end.

    Args:
        parts: places in the step ``(k,)``, 0 to 1.
        stages: positions, rotations and twists at the stages ``(s, n, ...)``.
        row, at_stages: where the states at these places begin in ``states (rows, n, ...)``, and those at the stages
            but the last one, which were interpolated in the same way.
        states: positions, rotations and twists; those at the places are overwritten.
    """
    r, q, twist = states
    r_stages, q_stages, twist_stages = stages
    inner = method.nodes.shape[0] - 1
    for m in range(parts.shape[0]):
        i = row + m
        for k in range(r.shape[1]):
            moved, turned = stage_vector(r, i, k, 0), (0.0, 0.0, 0.0)
            velocity, spin = stage_vector(twist, i, k, 0), stage_vector(twist, i, k, 3)
            for j in range(inner):
                weight, other = weight_of(method.values, j, parts[m]), at_stages + j
                moved = plus(
                    moved, weight, difference(stage_vector(r_stages, j, k, 0), stage_vector(r, other, k, 0))
                )
                velocity = plus(
                    velocity,
                    weight,
                    difference(stage_vector(twist_stages, j, k, 0), stage_vector(twist, other, k, 0)),
                )
                spin = plus(
                    spin,
                    weight,
                    difference(stage_vector(twist_stages, j, k, 3), stage_vector(twist, other, k, 3)),
                )
                # half of a small rotation vector
                w, v = product(conjugate(stage_quaternion(q, other, k)), stage_quaternion(q_stages, j, k))
                turned = plus(turned, weight / w, v)
            put_stage(r, i, k, 0, moved)
            put_stage(twist, i, k, 0, velocity)
            put_stage(twist, i, k, 3, spin)
            here = product(stage_quaternion(q, i, k), normalised((1.0, turned)))
            q[i, k, 0] = here[0]
            put_stage(q, i, k, 1, here[1])
