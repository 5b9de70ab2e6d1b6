"""What the compiled loop predicts of a step before it is tried."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.solve.transient.integrators.copied_rows import copy
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.loop_data import (
    EXTRA_ROWS,
    LAST_STEP,
    MARKS,
    SECOND_HALF,
    START,
    TAKEN,
    TRIAL_ROWS,
    TRIED,
    WHOLE,
    StepLoop,
)
from viscorod.solve.transient.integrators.predictor import LastStep
from viscorod.solve.transient.integrators.record_kernels import Between
from viscorod.typing import Integers

__all__ = ["predict", "row_of_trial"]

_do = returning(NOTHING)


@exact_part
def row_of_trial(numbers: Integers, found: Between) -> int:
    """Return the first row of the step that is tried again."""
    return int(found.r.shape[0] - EXTRA_ROWS + MARKS + TRIAL_ROWS * numbers[TRIED])


@exact_part
def predict(run: StepLoop, h: float) -> None:
    """Predict the stages of a step of ``h`` [s], those of halves by the whole; see ``predictor.Predictor``."""
    task, state, numbers, found = run.model.task, run.state, run.numbers, run.batch.states
    now, old, body = state.now, state.last, task.body
    onto = (h, now.r, now.q, body.split, body.held, state.weights, task.stages.X, state.stages_stress)
    if numbers[TAKEN] != WHOLE:
        place = 0.5 if numbers[TAKEN] == SECOND_HALF else 0.0
        start, length = row_of_trial(numbers, found) + START, run.batch.trials[numbers[TRIED], 2]
        begun = (found.r[start], found.q[start], found.twist[start])
        whole = LastStep(length, place, *begun, state.whole_coordinates, state.whole_stress)
        _do(run.calls.predict, (task.method, run.model.gap, whole, *onto))
    elif run.clock[LAST_STEP] > 0.0:
        last = LastStep(run.clock[LAST_STEP], 1.0, old.r, old.q, old.twist, state.kept.X, state.stress)
        _do(run.calls.predict, (task.method, run.model.gap, last, *onto))
    else:
        predict_first(run, h)


@exact_part
def predict_first(run: StepLoop, h: float) -> None:
    """Predict the stages of a step that none precedes: twists and stresses stay."""
    task, state = run.model.task, run.state
    now, stages, kept, body = state.now, task.stages, state.kept, task.body
    for i in range(stages.X.shape[0]):
        for e in range(kept.stress.shape[0]):
            copy(kept.stress[e], stages.stress[i, e])
        ahead = task.method.nodes[i] * h
        for k in range(now.twist.shape[0]):
            for a in range(6):
                stages.X[i, k, a] = 0.0 if body.held[k] != 0.0 else ahead * now.twist[k, a]
