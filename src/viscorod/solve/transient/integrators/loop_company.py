"""One step of one of several models that take the same steps side by side, in one compiled call; see ``company``.

It is the step of the compiled loop, with what its prediction lacks known beforehand, to an end and with records that
are known, too, and whatever its error.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.mechanics.compilation.references import refer, row_of
from viscorod.solve.transient.integrators.loop_attempts import iterate, prepare
from viscorod.solve.transient.integrators.loop_data import (
    ASK,
    BROKEN,
    FACTOR_STEP,
    FAILED,
    GOES_ON,
    ITERATED,
    LENT,
    STEPS,
    StepLoop,
    T,
)
from viscorod.solve.transient.integrators.loop_ends import take_end
from viscorod.solve.transient.integrators.loop_records import record_due
from viscorod.solve.transient.integrators.step_loop import account
from viscorod.typing import Floats

__all__ = ["Guided", "take_guided"]


class Guided(NamedTuple):
    """What a step is told beforehand, and tells.

    Attributes:
        predicted: coordinates, stresses, multipliers and forces of springs at the stages, a row of numbers each.
        lack: what their predictions are to lack; lacked: what they did, both in one row.
    """

    predicted: tuple[Floats, ...]
    lack: Floats
    lacked: Floats

    @classmethod
    def of(cls, predicted: tuple[Floats, ...]) -> Guided:
        """Allocate for some rows."""
        lack, lacked = np.zeros((2, sum(map(len, predicted))))
        return cls(predicted, lack, lacked)


@loop
def take_guided(given: StepLoop, by: Guided, end: float, records: int) -> int:
    """Take a step to ``end`` [s] and record its next ``records`` instants; return why not, or GOES_ON."""
    run, guided = refer(given), refer(by)
    clock, numbers = run.clock, run.numbers
    t, h = clock[T], end - clock[T]
    while True:
        if numbers[LENT] != 0:
            clock[FACTOR_STEP] = h
        why = prepare(run, end)
        if why != GOES_ON:
            return why
        correct(guided)
        why, count, _, unknown = iterate(run, h)
        numbers[ITERATED] += count
        if why == GOES_ON:
            break
        if why == FAILED or numbers[LENT] != 0:
            return ASK
    learn(guided)
    take_end(run, end)
    if not account(run, end, h, count, unknown):
        return BROKEN
    record_due(run, t, records)
    numbers[STEPS] += 1
    return GOES_ON


@exact_part
def correct(guided: Guided) -> None:
    """Correct what is predicted by what it is to lack, and keep it."""
    lack, lacked = guided.lack, guided.lacked
    at = k = 0
    while at < lack.shape[0]:
        row = row_of(guided.predicted, k)
        for i in range(row.shape[0]):
            lacked[at + i] = row[i]
            row[i] += lack[at + i]
        at, k = at + row.shape[0], k + 1


@exact_part
def learn(guided: Guided) -> None:
    """Find what the prediction lacked."""
    lacked = guided.lacked
    at = k = 0
    while at < lacked.shape[0]:
        row = row_of(guided.predicted, k)
        for i in range(row.shape[0]):
            lacked[at + i] = row[i] - lacked[at + i]
        at, k = at + row.shape[0], k + 1
