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
from viscorod.solve.transient.integrators.kernel_results import EXTENT
from viscorod.solve.transient.integrators.loop_data import (
    EXPONENT,
    FACTOR,
    FOLLOWS,
    NEWTON,
    SAFETY,
    TOLERANCE,
    StepLoop,
)

__all__ = ["follow", "tolerance_of"]

_extent = returning(EXTENT)


@exact_part
def extent_of(run: StepLoop) -> tuple[float, float]:
    """Return how far the last stage is from where the motion began, and how fast it is."""
    stages, begun = run.model.task.stages, run.state.follows
    last = stages.X.shape[0] - 1
    where = (stages.r[last], stages.q[last], stages.twist[last])
    found: tuple[float, float] = _extent(run.calls.extent, (begun.r, begun.q, *where, begun.numbers[LENGTH]))
    return found


@exact_part
def tolerance_of(run: StepLoop, end: float) -> float:
    """Return what the step to ``end`` [s] may err by."""
    limits, numbers = run.limits, run.state.follows.numbers
    if limits[FOLLOWS] == 0.0:
        return float(limits[TOLERANCE])
    if usual_at(numbers, end):
        return float(limits[SAFETY] * USUAL)
    moved, speed = extent_of(run)
    return float(limits[SAFETY] * tolerance_after(numbers, end, moved, speed))


@exact_part
def follow(run: StepLoop, t: float) -> None:
    """Let the tolerances follow the motion to the time ``t`` [s]."""
    limits, numbers = run.limits, run.state.follows.numbers
    if limits[FOLLOWS] == 0.0:
        return
    moved, speed = 0.0, 0.0
    if grows(numbers):
        moved, speed = extent_of(run)
    extend(numbers, t, moved, speed)
    change = limits[FACTOR] * tolerance_now(numbers) ** limits[EXPONENT]
    limits[NEWTON] = max(change, limits[FOLLOWS])
