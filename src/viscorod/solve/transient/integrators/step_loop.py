"""Many steps of Radau IIA in one compiled call: attempts, step control, energy account, records, and halves of steps.

The large kernels (the step, factorisations) are called through their addresses, and what the loop works on is handed
from part to part by reference, so that it is compiled once and quickly. Loads are summed here if they are functions of
time that are known (see ``load_courses``); Python is called for others, for motions of supports, and for Jacobians of
some models. Every number is that of steps taken one by one (see ``collocation``, ``radau``, ``transient_solver``), bit
for bit.
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.mechanics.compilation.references import refer
from viscorod.solve.transient.integrators import loop_branches
from viscorod.solve.transient.integrators.loop_attempts import attempt
from viscorod.solve.transient.integrators.loop_data import (
    AGAIN,
    ASK,
    BROKEN,
    ELASTIC,
    FAILED,
    FIRST,
    FULL,
    GOES_ON,
    ITERATED,
    KINETIC,
    LARGEST,
    LOSS,
    MOST,
    MOST_TRIALS,
    OUTSIDE,
    PASSED,
    REACHED,
    REJECTED,
    ROWS,
    SMALLEST,
    STEPS,
    STRAIN,
    TAKEN,
    TRIED,
    TRYING,
    WHOLE,
    WORK,
    StepLoop,
    T,
)
from viscorod.solve.transient.integrators.loop_ends import take_end
from viscorod.solve.transient.integrators.loop_records import record, room_for
from viscorod.solve.transient.integrators.loop_tolerance import follow
from viscorod.solve.transient.integrators.loop_trials import (
    begin_halves,
    begin_trial,
    is_tried,
    next_trial,
    take_half,
)
from viscorod.solve.transient.step_choice import ACCEPTED, CORNER, accept_step, end_of_step

__all__ = ["take_steps"]


@loop
def take_steps(given: StepLoop) -> int:
    """Take steps up to the last corner that is known, or until something is Python's; return why it ends.

    Some are tried again in halves, from where they began, and then the motion goes on from where it was.
    """
    run = refer(given)
    while True:
        why = take_whole(run) if run.numbers[TAKEN] == WHOLE else take_half(run)
        if why != GOES_ON:
            return why


@exact_part
def take_whole(run: StepLoop) -> int:
    """Try a step of the motion, and take it if its error is tolerated; return why the loop ends, or GOES_ON."""
    t, numbers, notes = run.clock[T], run.numbers, run.batch.notes
    if not t < run.control[CORNER] and not pass_corner(run):
        return REACHED
    end = end_of_step(run.control, t)
    why = begin(run, t, end)
    if why != GOES_ON:
        return why
    steps, h = numbers[STEPS], end - t
    came, count, error, unknown = attempt(run, end)
    numbers[ITERATED] += count
    notes[0, steps] += count
    if came == AGAIN:
        return GOES_ON
    if came == FAILED:
        notes[0, steps] = 0
        accept_step(run.control, False, 0.0, count, h)
        numbers[REJECTED] += 1
        return GOES_ON
    if came != GOES_ON:
        return came
    count = notes[0, steps]
    notes[0, steps] = 0
    if not accept_step(run.control, True, error, count, h):
        numbers[REJECTED] += 1
        return GOES_ON
    take_end(run, end)
    follow(run, end)
    if not account(run, end, h, count, unknown):
        return BROKEN
    record(run, t)
    numbers[STEPS] = steps + 1
    next_trial(run.trials, run.trials[FIRST] + steps)
    if numbers[TRYING] != 0:
        begin_halves(run, end, h)
    return GOES_ON


@exact_part
def pass_corner(run: StepLoop) -> bool:
    """Go on beyond a corner, if there is nothing to be done there; return whether there is not."""
    corner = run.ahead[run.numbers[PASSED]]
    if not corner < math.inf:
        return False
    run.control[CORNER] = corner
    run.numbers[PASSED] += 1
    return True


@exact_part
def begin(run: StepLoop, t: float, end: float) -> int:
    """Look whether a step from ``t`` to ``end`` [s] can be tried, and whether it will be again, in halves."""
    numbers, trials = run.numbers, run.trials
    if (
        numbers[STEPS] == numbers[MOST]
        or numbers[ROWS] + room_for(run.limits, t, end) > run.batch.instants.shape[0]
    ):
        return FULL
    if end - t < run.limits[SMALLEST]:
        return ASK
    if numbers[TRYING] == 0 and is_tried(trials, trials[FIRST] + numbers[STEPS], end - t):
        if numbers[TRIED] == MOST_TRIALS:
            return FULL
        begin_trial(run)
    return GOES_ON


@exact_part
def account(run: StepLoop, end: float, h: float, count: int, unknown: int) -> bool:
    """Take note of a step of ``h`` [s] to ``end`` [s] and its energies; return whether strains are within bounds."""
    clock, batch, steps = run.clock, run.batch, run.numbers[STEPS]
    notes, accounts, ends, lengths = batch.notes, batch.accounts, batch.ends, batch.lengths
    ends[steps], lengths[steps] = end, h
    notes[0, steps], notes[1, steps] = count, int(run.control[ACCEPTED])
    notes[2, steps] = unknown
    if not clock[STRAIN] < run.limits[LARGEST]:
        return False
    accounts[steps + 1, 0], accounts[steps + 1, 1] = clock[KINETIC], clock[ELASTIC]
    accounts[steps + 1, 2] = accounts[steps, 2] + clock[LOSS]
    accounts[steps + 1, 3] = accounts[steps, 3] + clock[WORK]
    accounts[steps + 1, 4] = accounts[steps, 4] + clock[OUTSIDE]
    loop_branches.add_losses(run)
    return True
