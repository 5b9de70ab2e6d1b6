"""Steps of the compiled loop that are tried again: which, where their states are kept, and how the motion goes on."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import exact_part, loop_part
from viscorod.solve.transient import trial_choice
from viscorod.solve.transient.integrators.loop_data import (
    EXTRA_ROWS,
    FRESH,
    HAD,
    HAVE,
    LONGER,
    LOST,
    MARKS,
    NEXT,
    SETTLED,
    TRIAL_ROWS,
    TRIED,
    WAS_FRESH,
    Backup,
)
from viscorod.solve.transient.integrators.record_kernels import Between
from viscorod.typing import Floats, Integers

__all__ = ["come_back", "is_tried", "leave", "next_trial", "row_of_trial"]


@exact_part
def save(live: tuple[Floats, ...], kept: Floats) -> None:
    """Keep what steps go on from."""
    at = 0
    for k in range(len(live)):
        row = live[k]
        for i in range(row.shape[0]):
            kept[at + i] = row[i]
        at += row.shape[0]


@exact_part
def put_back(kept: Floats, live: tuple[Floats, ...]) -> None:
    """Undo what happened since :func:`save`."""
    at = 0
    for k in range(len(live)):
        row = live[k]
        for i in range(row.shape[0]):
            row[i] = kept[at + i]
        at += row.shape[0]


@loop_part
def leave(backup: Backup, kept: Floats, clock: Floats, numbers: Integers) -> None:
    """Keep what steps go on from, with what is known of the Jacobian."""
    clock[HAD], clock[WAS_FRESH] = numbers[HAVE], numbers[FRESH]
    save(backup.live, kept)


@loop_part
def come_back(backup: Backup, kept: Floats, clock: Floats, numbers: Integers) -> None:
    """Undo what happened since :func:`leave`; factors are lost."""
    put_back(kept, backup.live)
    numbers[HAVE], numbers[FRESH], numbers[LOST] = int(clock[HAD]), int(clock[WAS_FRESH]), 1


@exact_part
def is_tried(trials: Floats, number: float, h: float) -> bool:
    """Return whether a step of ``h`` [s] is one to be tried again: see ``halved_steps.HalvedSteps.tries``."""
    return bool(number == trials[NEXT] or (number > trials[SETTLED] and h > trials[LONGER]))


@exact_part
def next_trial(trials: Floats, number: float) -> None:
    """Set the number of the next step that is tried again, after one."""
    if number == trials[NEXT]:
        trials[NEXT] += min(
            2.0 * number + 1.0, max(float(trial_choice.FARTHEST), number // trial_choice.PART)
        )


@loop_part
def row_of_trial(numbers: Integers, found: Between) -> int:
    """Return the first row of the step that is tried again."""
    return int(found.r.shape[0] - EXTRA_ROWS + MARKS + TRIAL_ROWS * numbers[TRIED])
