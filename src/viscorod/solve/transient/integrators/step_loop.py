"""Many steps of Radau IIA in one compiled call: attempts, step control, energy account, records, and halves of steps.

The large kernels (the step, factorisations) are called through their addresses, so that the loop is compiled once and
quickly; Python is called for what only it can do, new Jacobians and loads that change. Every number is that of steps
taken one by one (see ``collocation``, ``radau``, ``transient_solver``), bit for bit.
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import loop
from viscorod.solve.transient import trial_choice
from viscorod.solve.transient.integrators.loop_attempts import accept, attempt, follow
from viscorod.solve.transient.integrators.loop_data import (
    ASK,
    BETTER_END,
    BETTER_MIDDLE,
    BROKEN,
    ELASTIC,
    END,
    FIRST,
    FIRST_HALF,
    FRESH,
    FULL,
    HALF,
    HAVE,
    ITERATED,
    KINETIC,
    LARGEST,
    LONGER,
    LOSS,
    MOST,
    MOST_TRIALS,
    NEWTON,
    RAISED,
    RATE,
    REACHED,
    REJECTED,
    ROWS,
    SECOND_HALF,
    SMALLEST,
    STALE,
    START,
    STEPS,
    STRAIN,
    TRIED,
    TRYING,
    WHOLE,
    WORK,
    Addresses,
    Backup,
    Batch,
    LoopModel,
    LoopState,
    LoopSystems,
    T,
)
from viscorod.solve.transient.integrators.loop_records import keep, record, room_for
from viscorod.solve.transient.integrators.loop_trials import (
    come_back,
    is_tried,
    leave,
    next_trial,
    row_of_trial,
)
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.solve.transient.step_choice import ACCEPTED, CORNER, accept_step, end_of_step
from viscorod.typing import Floats, Integers

__all__ = ["take_steps"]


@loop
def take_steps(
    model: LoopModel,
    method: Tableau,
    systems: LoopSystems,
    state: LoopState,
    calls: Addresses,
    clock: Floats,
    numbers: Integers,
    limits: Floats,
    control: Floats,
    trials: Floats,
    batch: Batch,
    backup: Backup,
) -> int:
    """Take steps up to the corner that ``control`` has, or until something is Python's; return why it ends.

    Some are tried again in halves, from where they began, and then the motion goes on from where it was.

    Args:
        model, method, systems, state, calls: what steps are made of.
        clock, numbers, limits: see above; control: those of ``step_choice``; trials: steps that are tried again.
        batch: outputs; backup: of what steps go on from.
    """
    most, rows, accounts = numbers[MOST], batch.instants.shape[0], batch.accounts
    taken, whole_end, whole = WHOLE, 0.0, 0.0
    tolerance = limits[NEWTON]  # of Newton's method after the step that is tried again
    while True:
        t, steps = clock[T], numbers[STEPS]
        number = trials[FIRST] + steps
        if taken == WHOLE:
            if not t < control[CORNER]:
                return REACHED
            end = end_of_step(control, t)
            if steps == most or numbers[ROWS] + room_for(limits, t, end) > rows:
                return FULL
            if end - t < limits[SMALLEST]:
                return ASK
            if numbers[TRYING] == 0 and is_tried(trials, number, end - t):
                if numbers[TRIED] == MOST_TRIALS:
                    return FULL
                numbers[TRYING] = 1
                keep(state, clock, batch.states, row_of_trial(numbers, batch.states) + START)
                leave(backup, backup.before, clock, numbers)
        else:
            end = whole_end if taken == SECOND_HALF else whole_end - 0.5 * whole
        h, half = end - t, taken != WHOLE
        if calls.prepare != 0:
            calls.message[0], calls.message[1] = t, end
            calls.message[2] = 1.0 if end == control[CORNER] else 0.0
            call(calls.prepare, calls.message.ctypes, 4)
        came, count, error, unknown = RAISED, 0, 0.0, 0
        if calls.prepare == 0 or calls.message[0] == t:
            came, count, error, unknown = attempt(
                model, method, systems, state, calls, clock, numbers, limits, end, half
            )
        if half and came != REACHED:
            if came == FULL:
                continue
            batch.trials[numbers[TRIED], 3] = 0.0
            taken, limits[NEWTON] = WHOLE, tolerance
            come_back(backup, backup.after, clock, numbers)
            numbers[TRYING], numbers[TRIED] = 0, numbers[TRIED] + 1
            if came == RAISED:
                return RAISED
            continue
        if not half:
            numbers[ITERATED] += count
            batch.notes[0, steps] += count
            if came == FULL:
                continue
            if came != REACHED:
                return came
            count = batch.notes[0, steps]
            batch.notes[0, steps] = 0
            if not accept_step(control, True, error, count, h):
                numbers[REJECTED] += 1
                continue
        accept(model, method, state, calls, clock, h)
        clock[T] = end
        if not half:
            follow(model, state, calls, limits, end)
        numbers[FRESH] = 0
        if clock[RATE] > limits[STALE]:
            numbers[HAVE] = 0
        if not half:
            batch.ends[steps], batch.lengths[steps] = end, h
            batch.notes[0, steps], batch.notes[1, steps] = count, int(control[ACCEPTED])
            batch.notes[2, steps] = unknown
            if not clock[STRAIN] < limits[LARGEST]:
                return BROKEN
            accounts[steps + 1, 0], accounts[steps + 1, 1] = clock[KINETIC], clock[ELASTIC]
            accounts[steps + 1, 2] = accounts[steps, 2] + clock[LOSS]
            accounts[steps + 1, 3] = accounts[steps, 3] + clock[WORK]
            record(model, method, state, calls, clock, numbers, limits, t, batch)
            numbers[STEPS] = steps + 1
            next_trial(trials, number)
            if numbers[TRYING] == 0:
                continue
        # a step that is tried again, or one of its halves: keep where it ends, and go on
        row = row_of_trial(numbers, batch.states)
        if taken == WHOLE:
            keep(state, clock, batch.states, row + END)
            trial = batch.trials[numbers[TRIED]]
            trial[0], trial[1], trial[2], trial[3] = steps, end, h, 1.0
            whole_end, whole, tolerance, taken = end, h, limits[NEWTON], FIRST_HALF
            leave(backup, backup.after, clock, numbers)
            come_back(backup, backup.before, clock, numbers)
            limits[NEWTON] = limits[HALF]
        elif taken == FIRST_HALF:
            keep(state, clock, batch.states, row + BETTER_MIDDLE)
            taken = SECOND_HALF
        else:
            keep(state, clock, batch.states, row + BETTER_END)
            longer = trial_choice.LONGER * whole
            if not trials[LONGER] < math.inf or longer > trials[LONGER]:
                trials[LONGER] = longer
            taken, limits[NEWTON] = WHOLE, tolerance
            come_back(backup, backup.after, clock, numbers)
            numbers[TRYING], numbers[TRIED] = 0, numbers[TRIED] + 1
