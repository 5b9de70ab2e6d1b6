"""How the tolerances of the compiled loop follow the motion."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.solve.transient.amplitude import (
    LENGTH,
    USUAL,
    extend,
    grows,
    tolerance_after,
    tolerance_now,
    usual_at,
)
from viscorod.solve.transient.integrators.kernel_results import EXTENT, NOTHING
from viscorod.solve.transient.integrators.loop_data import (
    EXPONENT,
    FACTOR,
    FOLLOWS,
    NEWTON,
    SAFETY,
    TOLERANCE,
    StepLoop,
)
from viscorod.typing import Floats

__all__ = ["follow", "tolerance_of"]

_extent, _carry = returning(EXTENT), returning(NOTHING)


@exact_part
def extent_of(run: StepLoop, r: Floats, q: Floats, twist: Floats) -> tuple[float, float]:
    """Return how far a state is from where the motion began, or was carried since, and how fast it is beside that."""
    begun = run.state.follows
    length = begun.numbers[LENGTH]
    if run.calls.carry == 0:
        still: tuple[float, float] = _extent(run.calls.extent, (begun.r, begun.q, r, q, twist, length))
        return still
    to = (begun.carried_r, begun.carried_q, begun.relative_twist)
    _carry(run.calls.carry, (begun.carrier, begun.r, begun.q, r, q, twist, *to))
    found: tuple[float, float] = _extent(run.calls.extent, (to[0], to[1], r, q, to[2], length))
    return found


@exact_part
def tolerance_of(run: StepLoop, end: float) -> float:
    """Return what the step to ``end`` [s] may err by."""
    limits, numbers = run.limits, run.state.follows.numbers
    if limits[FOLLOWS] == 0.0:
        return float(limits[TOLERANCE])
    if usual_at(numbers, end):
        return float(limits[SAFETY] * USUAL)
    stages = run.model.task.stages
    last = stages.X.shape[0] - 1
    moved, speed = extent_of(run, stages.r[last], stages.q[last], stages.twist[last])
    return float(limits[SAFETY] * tolerance_after(numbers, end, moved, speed))


@exact_part
def follow(run: StepLoop, t: float) -> None:
    """Let the tolerances follow the motion to the time ``t`` [s]."""
    limits, numbers = run.limits, run.state.follows.numbers
    if limits[FOLLOWS] == 0.0:
        return
    moved, speed, now = 0.0, 0.0, run.state.now
    if grows(numbers):
        moved, speed = extent_of(run, now.r, now.q, now.twist)
    extend(numbers, t, moved, speed)
    change = limits[FACTOR] * tolerance_now(numbers) ** limits[EXPONENT]
    limits[NEWTON] = max(change, limits[FOLLOWS])
