"""What the compiled loop records of its steps."""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part, loop_part
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.loop_attempts import copy
from viscorod.solve.transient.integrators.loop_data import (
    DURATION,
    ELASTIC,
    EXTRA_ROWS,
    KINETIC,
    LEAST,
    LOSS,
    MARKS,
    MIDDLE,
    OUTPUT,
    ROWS,
    STEPS,
    TRYING,
    TURN,
    Addresses,
    Batch,
    LoopModel,
    LoopState,
    T,
)
from viscorod.solve.transient.integrators.loop_trials import row_of_trial
from viscorod.solve.transient.integrators.record_kernels import Between, ResultFields, StageFields
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers

__all__ = ["keep", "record", "room_for"]

TURN_OF_RECORD = 0.25
"""Rotation [rad] from record to record, if that takes more states than one above the stages."""

_do = returning(NOTHING)


@exact_part
def instants_of(limits: Floats, t: float, end: float, turn: float, instants: Floats) -> int:
    """Write the instants [s] in the step from ``t`` to ``end`` at which states are recorded; return their number."""
    interval = limits[OUTPUT]
    if interval == 0.0:
        least = int(limits[LEAST])
        count = min(max(least, math.ceil(turn / TURN_OF_RECORD)), 4 * least)
        for k in range(1, count):
            instants[k - 1] = t + k / count * (end - t)
        instants[count - 1] = end
        return count
    first = math.floor(t / interval * (1.0 + 1e-12) + 1e-9) + 1
    last = math.floor(end / interval * (1.0 + 1e-12) + 1e-9)
    count = 0
    for k in range(first, last + 1):
        instants[count] = k * interval
        count += 1
    final = end == limits[DURATION]
    if final and (count == 0 or instants[count - 1] < end * (1.0 - 1e-9)):
        instants[count] = end
        count += 1
    return count


@exact_part
def room_for(limits: Floats, t: float, end: float) -> int:
    """Return the most records that a step may have."""
    if limits[OUTPUT] == 0.0:
        return 4 * int(limits[LEAST])
    return int((end - t) / limits[OUTPUT]) + 3


@loop_part
def keep(state: LoopState, clock: Floats, found: Between, at: int) -> None:
    """Keep the present state in the row ``at``."""
    now, fields = state.now, found.fields
    copy(now.r, found.r[at])
    copy(now.q, found.q[at])
    copy(now.twist, found.twist[at])
    for field in range(3):
        copy(state.points[1, field], fields.points[field, at])
    copy(state.reactions[1], fields.reactions[at])
    found.energies[0, at], found.energies[3, at] = clock[KINETIC], clock[ELASTIC]


@loop_part
def record(
    model: LoopModel,
    method: Tableau,
    state: LoopState,
    calls: Addresses,
    clock: Floats,
    numbers: Integers,
    limits: Floats,
    t: float,
    batch: Batch,
) -> None:
    """Record what is due of the step that began at ``t`` [s] and has been accepted."""
    end, row, found = clock[T], numbers[ROWS], batch.states
    h = end - t
    count = instants_of(limits, t, end, clock[TURN], batch.instants[row:])
    within = 0
    for k in range(count):
        place = (batch.instants[row + k] - t) / h
        batch.places[row + k] = place
        batch.of_step[row + k] = numbers[STEPS]
        if place <= 1.0 - 1e-9:
            within += 1
    stages, now, fields = model.parts.stages, state.now, found.fields
    begin = ResultFields(state.points[0], state.reactions[0])
    of_stages = StageFields(
        stages.twist,
        stages.strain,
        stages.strain_rate,
        stages.stress,
        state.end.reactions,
        model.parts.account.powers,
    )
    reached = MovingPoses(now.r, now.q, now.twist, state.end.rate)
    step = (h, method, state.last, reached, begin, of_stages, clock[LOSS], model.reading)
    for records in range(2):
        to, first, size = row, row, within
        if records == 0:  # the middle of a step that is tried again
            to, first, size = (
                row_of_trial(numbers, found) + MIDDLE,
                batch.places.shape[0] - 1,
                numbers[TRYING],
            )
        if size > 0:
            into = Between(to, found.r, found.q, found.twist, fields, found.energies)
            _do(calls.between, (batch.places[first : first + size], *step, True, True, into))
    if count > within:
        at = row + count - 1
        keep(state, clock, found, at)
        batch.places[at] = 1.0
    numbers[ROWS] = row + count
    for m in range(MARKS):
        if batch.marks[m] == numbers[STEPS] + 1:
            keep(state, clock, found, found.r.shape[0] - EXTRA_ROWS + m)
