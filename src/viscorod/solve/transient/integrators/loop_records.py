"""What the compiled loop records of its steps."""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.transient.integrators import loop_branches
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.loop_data import (
    DURATION,
    EXTRA_ROWS,
    LEAST,
    LOSS,
    MARKS,
    MIDDLE,
    OUTPUT,
    ROWS,
    STEPS,
    TRYING,
    TURN,
    StepLoop,
    T,
)
from viscorod.solve.transient.integrators.loop_prediction import row_of_trial
from viscorod.solve.transient.integrators.loop_trials import keep
from viscorod.solve.transient.integrators.record_kernels import Between, ResultFields, StageFields
from viscorod.typing import Floats

__all__ = ["record", "record_due", "room_for"]

TURN_OF_RECORD = 0.25
"""Rotation [rad] from record to record, if that takes more states than one above the stages."""

_do, _with = returning(NOTHING), returning(NOTHING, whole=False)


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


@exact_part
def record(run: StepLoop, t: float) -> None:
    """Record what is due of the step that began at ``t`` [s] and has been accepted."""
    clock, instants = run.clock, run.batch.instants[run.numbers[ROWS] :]
    record_due(run, t, instants_of(run.limits, t, clock[T], clock[TURN], instants))


@exact_part
def record_due(run: StepLoop, t: float, count: int) -> None:
    """Record the step that began at ``t`` [s] at its next ``count`` instants, which are known."""
    clock, numbers, batch, found = run.clock, run.numbers, run.batch, run.batch.states
    end, row, rows, marks = clock[T], numbers[ROWS], found.r.shape[0], batch.marks
    places, of_step, within = batch.places, batch.of_step, 0
    for k in range(count):
        place = (batch.instants[row + k] - t) / (end - t)
        places[row + k] = place
        of_step[row + k] = numbers[STEPS]
        if place <= 1.0 - 1e-9:
            within += 1
    if numbers[TRYING] != 0:  # the middle, where ``places`` end with one half
        middle = row_of_trial(numbers, found) + MIDDLE
        read(run, end - t, places.shape[0] - 1, 1, middle)
        if run.calls.close_within != 0:
            _with(run.calls.close_within, (run, places.shape[0] - 1, 1, middle))
    if within > 0:
        read(run, end - t, row, within, row)
        if run.calls.read_within != 0:
            loop_branches.within(run, row, within)
        if run.calls.close_within != 0:
            _with(run.calls.close_within, (run, row, within, row))
    if count > within:
        at = row + count - 1
        keep_record(run, at)
        places[at] = 1.0
    numbers[ROWS] = row + count
    for m in range(MARKS):
        if marks[m] == numbers[STEPS] + 1:
            keep_record(run, rows - EXTRA_ROWS + m)


@exact_part
def keep_record(run: StepLoop, at: int) -> None:
    """Keep the present state in the row ``at``, with its branches."""
    keep(run, at)
    if run.calls.read_branches != 0:
        loop_branches.read(run, at)
    if run.calls.read_links != 0:
        _with(run.calls.read_links, (run, at))


@exact_part
def read(run: StepLoop, h: float, first: int, size: int, to: int) -> None:
    """Read states within the step of ``h`` [s], at ``size`` places from the ``first`` on, into rows from ``to`` on."""
    task, state, found = run.model.task, run.state, run.batch.states
    stages = task.stages
    now, reading = state.now, run.model.reading
    begin = ResultFields(state.points[0], state.reactions[0])
    at_stages = StageFields(
        stages.twist,
        stages.strain,
        stages.strain_rate,
        stages.stress,
        state.end.reactions,
        task.account.powers,
    )
    reached = MovingPoses(now.r, now.q, now.twist, state.end.rate)
    step = (h, task.method, state.last, reached, begin, at_stages, run.clock[LOSS], reading)
    into = Between(to, found.r, found.q, found.twist, found.fields, found.energies)
    many = run.calls.go_through != 0
    corrected, places = many or run.calls.correct_within != 0, run.batch.places[first : first + size]
    for k in range(2 if corrected else 1):
        if k == 1 and many:
            spare = run.batch.instants.shape[0]
            inside = Between(spare, found.r, found.q, found.twist, found.fields, found.energies)
            _do(run.calls.between, (task.method.nodes[: stages.X.shape[0] - 1], *step, True, False, inside))
            through, states = (stages.r, stages.q, stages.twist), (found.r, found.q, found.twist)
            _do(run.calls.go_through, (places, task.method, through, to, spare, states))
        if k == 1 and run.calls.correct_within != 0:
            _with(run.calls.correct_within, (run, first, size, to))
        kind = (k == 0, k == 1 or not corrected)
        _do(run.calls.between, (places, *step, *kind, into))
