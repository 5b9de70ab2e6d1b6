"""Steps of the compiled loop that are tried again: which, where their states are kept, and how the motion goes on."""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.compilation.references import row_of
from viscorod.solve.transient.integrators.copied_rows import copy
from viscorod.solve.transient.integrators.loop_attempts import attempt
from viscorod.solve.transient.integrators.loop_data import (
    AGAIN,
    BETTER_END,
    BETTER_MIDDLE,
    ELASTIC,
    END,
    FIRST_HALF,
    FRESH,
    GOES_ON,
    HAD,
    HALF,
    HAVE,
    KINETIC,
    LONGER,
    LOST,
    NEWTON,
    NEXT,
    RAISED,
    SECOND_HALF,
    SETTLED,
    START,
    STEPS,
    TAKEN,
    TRIED,
    TRYING,
    WAS,
    WAS_FRESH,
    WHOLE,
    Backup,
    StepLoop,
)
from viscorod.solve.transient.integrators.loop_ends import take_end
from viscorod.solve.transient.integrators.loop_prediction import row_of_trial
from viscorod.solve.transient.trial_choice import FARTHEST, PART
from viscorod.solve.transient.trial_choice import LONGER as BY
from viscorod.typing import Floats

__all__ = ["begin_halves", "begin_trial", "is_tried", "keep", "next_trial", "take_half"]


@exact_part
def save(backup: Backup, kept: Floats) -> None:
    """Keep what steps go on from."""
    at = k = 0
    while at < kept.shape[0]:
        row = row_of(backup.live, k)
        for i in range(row.shape[0]):
            kept[at + i] = row[i]
        at, k = at + row.shape[0], k + 1


@exact_part
def put_back(backup: Backup, kept: Floats) -> None:
    """Undo what happened since :func:`save`."""
    at = k = 0
    while at < kept.shape[0]:
        row = row_of(backup.live, k)
        for i in range(row.shape[0]):
            row[i] = kept[at + i]
        at, k = at + row.shape[0], k + 1


@exact_part
def leave(run: StepLoop, kept: Floats) -> None:
    """Keep what steps go on from, with what is known of the Jacobian."""
    clock, numbers = run.clock, run.numbers
    clock[HAD], clock[WAS_FRESH] = numbers[HAVE], numbers[FRESH]
    save(run.backup, kept)


@exact_part
def come_back(run: StepLoop, kept: Floats) -> None:
    """Undo what happened since :func:`leave`; factors are lost."""
    clock, numbers = run.clock, run.numbers
    put_back(run.backup, kept)
    numbers[HAVE], numbers[FRESH], numbers[LOST] = int(clock[HAD]), int(clock[WAS_FRESH]), 1


@exact_part
def is_tried(trials: Floats, number: float, h: float) -> bool:
    """Return whether a step of ``h`` [s] is one to be tried again: see ``halved_steps.HalvedSteps.tries``."""
    return bool(number == trials[NEXT] or (number > trials[SETTLED] and h > trials[LONGER]))


@exact_part
def next_trial(trials: Floats, number: float) -> None:
    """Set the number of the next step that is tried again, after one."""
    if number == trials[NEXT]:
        trials[NEXT] += min(2.0 * number + 1.0, max(float(FARTHEST), number // PART))


@exact_part
def keep(run: StepLoop, at: int) -> None:
    """Keep the present state in the row ``at``."""
    state, clock, found = run.state, run.clock, run.batch.states
    now, fields, energies = state.now, found.fields, found.energies
    copy(now.r, found.r[at])
    copy(now.q, found.q[at])
    copy(now.twist, found.twist[at])
    for field in range(3):
        copy(state.points[1, field], fields.points[field, at])
    copy(state.reactions[1], fields.reactions[at])
    energies[0, at], energies[4, at] = clock[KINETIC], clock[ELASTIC]
    multiplier = run.links.memory.multiplier
    for p in range(multiplier.shape[0]):
        run.links.rows.multiplier[at, p] = multiplier[p]


@exact_part
def begin_trial(run: StepLoop) -> None:
    """Keep the state before a step that will be tried again."""
    run.numbers[TRYING] = 1
    keep(run, row_of_trial(run.numbers, run.batch.states) + START)
    leave(run, run.backup.before)


@exact_part
def keep_whole(run: StepLoop) -> None:
    """Keep the stages of a step that has been taken: its halves are predicted by them."""
    state = run.state
    copy(state.stress, state.whole_stress)
    for i in range(state.whole_coordinates.shape[0]):
        copy(state.kept.X[i], state.whole_coordinates[i])
    copy(run.links.memory.multipliers, run.links.whole.multipliers)
    copy(run.links.memory.forces, run.links.whole.forces)


@exact_part
def begin_halves(run: StepLoop, end: float, h: float) -> None:
    """Keep where a step of ``h`` [s] came to at ``end`` [s], and go back to its start."""
    numbers, limits, batch = run.numbers, run.limits, run.batch
    keep(run, row_of_trial(numbers, batch.states) + END)
    keep_whole(run)
    trial = batch.trials[numbers[TRIED]]
    trial[0], trial[1], trial[2], trial[3] = numbers[STEPS] - 1, end, h, 1.0
    leave(run, run.backup.after)
    come_back(run, run.backup.before)
    numbers[TAKEN], limits[WAS], limits[NEWTON] = FIRST_HALF, limits[NEWTON], limits[HALF]


@exact_part
def end_trial(run: StepLoop) -> None:
    """Go on from the end of the step that has been tried again."""
    numbers = run.numbers
    numbers[TAKEN], run.limits[NEWTON] = WHOLE, run.limits[WAS]
    come_back(run, run.backup.after)
    numbers[TRYING], numbers[TRIED] = 0, numbers[TRIED] + 1


@exact_part
def take_half(run: StepLoop) -> int:
    """Take a half of the step that is tried again; return why the loop ends, or :data:`GOES_ON`."""
    numbers, trials = run.numbers, run.trials
    trial, second = run.batch.trials[numbers[TRIED]], numbers[TAKEN] == SECOND_HALF
    whole_end, whole = trial[1], trial[2]
    end = whole_end if second else whole_end - 0.5 * whole
    came, _, _, _ = attempt(run, end)
    if came == AGAIN:
        return GOES_ON
    if came != GOES_ON:
        trial[3] = 0.0
        end_trial(run)
        return RAISED if came == RAISED else GOES_ON
    take_end(run, end)
    row = row_of_trial(numbers, run.batch.states)
    if not second:
        keep(run, row + BETTER_MIDDLE)
        numbers[TAKEN] = SECOND_HALF
        return GOES_ON
    keep(run, row + BETTER_END)
    longer = BY * whole
    if not trials[LONGER] < math.inf or longer > trials[LONGER]:
        trials[LONGER] = longer
    end_trial(run)
    return GOES_ON
