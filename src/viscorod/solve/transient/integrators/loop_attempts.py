"""Attempts of steps in the compiled loop: loads, Jacobian and factors, iteration, and what the step errs by."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.nodes.load_courses import sum_loads
from viscorod.solve.transient.integrators import loop_branches, loop_supports
from viscorod.solve.transient.integrators.iteration_verdict import CONVERGED
from viscorod.solve.transient.integrators.kernel_results import ATTEMPTED, NOTHING, TURNED
from viscorod.solve.transient.integrators.loop_data import (
    AGAIN,
    AGED,
    ALLOWED,
    ASK,
    EVALUATED,
    FACTOR_STEP,
    FACTORISED,
    FAILED,
    FARTHEST,
    FRESH,
    GAP,
    GOES_ON,
    HAVE,
    LAST_STEP,
    LENT,
    LOST,
    NEWTON,
    OF_MIDDLE,
    OF_START,
    OLD,
    POWER,
    RAISED,
    RATE,
    RENEWED,
    TAKEN,
    TURN,
    WHOLE,
    StepLoop,
    T,
)
from viscorod.solve.transient.integrators.loop_jacobian import renew
from viscorod.solve.transient.integrators.loop_prediction import predict
from viscorod.solve.transient.integrators.loop_systems import factorise
from viscorod.solve.transient.integrators.loop_tolerance import tolerance_of
from viscorod.solve.transient.integrators.step_task import ITERATIONS, H
from viscorod.solve.transient.integrators.step_task import RATE as TRUSTED
from viscorod.solve.transient.integrators.step_task import TOLERANCE as TOLERATED
from viscorod.solve.transient.step_choice import CORNER

__all__ = ["attempt", "iterate", "prepare"]

_attempt, _turn = returning(ATTEMPTED, whole=False), returning(TURNED)
_with = returning(NOTHING, whole=False)


@exact_part
def give_loads(run: StepLoop, t: float, end: float) -> None:
    """Find loads and motions at the stages of a step from ``t`` to ``end`` [s], at a corner limits from the left."""
    nodes, loads, corner = run.model.task.method.nodes, run.loads, run.control[CORNER]
    last = nodes.shape[0] - 1
    for i in range(last + 1):
        at, before = t + nodes[i] * (end - t), False
        if i == last:
            at, before = end, end == corner
        sum_loads(loads.courses, at, before, i, loads.stages)
        if run.calls.prescribe != 0:
            loop_supports.move(run, at, before, i)
        if run.calls.drive_links != 0:
            _with(run.calls.drive_links, (run, at, before, i))
    if run.calls.furthest != 0:
        run.clock[GAP] = loop_supports.furthest(run, t, end)


@exact_part
def provide(run: StepLoop, end: float) -> int:
    """Provide loads, Jacobian and factors of a step to ``end`` [s]; return why the loop ends, or :data:`GOES_ON`."""
    clock, numbers, calls = run.clock, run.numbers, run.calls
    t, message, whole = clock[T], run.message, numbers[TAKEN] == WHOLE
    if calls.prepare != 0:
        message[0], message[1] = t, end
        message[2] = 1.0 if end == run.control[CORNER] else 0.0
        call(calls.prepare, message.ctypes, 4)
        if message[0] != t:
            return RAISED
    else:
        give_loads(run, t, end)
    h = end - t
    other = abs(h - clock[FACTOR_STEP]) > 1e-9 * h
    if other and clock[RATE] > run.limits[AGED]:
        numbers[HAVE] = 0
    if numbers[HAVE] == 0:
        run.model.task.numbers[H] = h
        again = numbers[FRESH] != OLD
        numbers[FRESH] = OF_START if again or not clock[LAST_STEP] > 0.0 else OF_MIDDLE
        if calls.renew == 0:
            renew(run)
            numbers[RENEWED] += 1 if whole else 0
        else:
            message[0], message[1], message[3] = t, end, 0.0 if whole else 1.0
            message[2] = 1.0 if numbers[FRESH] == OF_START else 0.0
            call(calls.renew, message.ctypes, 4)
            if message[0] != t:
                return RAISED
        numbers[HAVE] = 1
        clock[FACTOR_STEP], numbers[LOST], other = 0.0, 0, True
    if other or numbers[LOST] != 0:
        numbers[LOST] = 0
        if other:
            clock[FACTOR_STEP] = h
        if numbers[LENT] == 0 and not factorise(run, clock[FACTOR_STEP]):
            clock[FACTOR_STEP] = 0.0
            return ASK
        if other and whole:
            numbers[FACTORISED] += 1
    return GOES_ON


@exact_part
def prepare(run: StepLoop, end: float) -> int:
    """Predict the stages of a step to ``end`` [s], and provide what they are iterated with, as :func:`provide`."""
    h, calls = end - run.clock[T], run.calls
    predict(run, h)
    why = provide(run, end)
    if why != GOES_ON:
        return why
    if calls.begin_branches != 0:
        loop_branches.begin(run, h)
    if calls.predict_links != 0:
        _with(calls.predict_links, (run, h))
    return GOES_ON


@exact_part
def iterate(run: StepLoop, h: float) -> tuple[int, int, float, int]:
    """Iterate the stages of a step of ``h`` [s], which is prepared; return as :func:`attempt`, the error in itself."""
    clock, numbers, limits, task = run.clock, run.numbers, run.limits, run.model.task
    given = task.numbers
    given[H], given[TOLERATED] = h, limits[NEWTON]
    given[TRUSTED], given[ITERATIONS] = clock[RATE], limits[ALLOWED]
    code, count, _, rate, _, error, unknown = _attempt(run.calls.step, (task,))
    good, s, counted = code == CONVERGED, task.stages.X.shape[0], 1 if numbers[TAKEN] == WHOLE else 0
    numbers[EVALUATED] += counted * (count + 1 if good else count) * s
    if good:
        clock[RATE], numbers[FRESH] = rate, OLD
        return GOES_ON, count, error, unknown
    clock[RATE] = 1.0
    if numbers[FRESH] == OF_START:
        return FAILED, count, 0.0, 0
    numbers[HAVE] = 0
    return AGAIN, count, 0.0, 0


@exact_part
def attempt(run: StepLoop, end: float) -> tuple[int, int, float, int]:
    """Try a step to ``end`` [s]; halves of one that is tried again count for nothing.

    Returns:
        :data:`GOES_ON` if it is good, :data:`AGAIN` if it is to be tried again with another Jacobian, :data:`FAILED` if
        that was a new one, or why the loop ends; iterations; error over the tolerated one, and the unknown where it is
        largest.
    """
    clock, numbers, limits, calls = run.clock, run.numbers, run.limits, run.calls
    why = prepare(run, end)
    if why != GOES_ON:
        return why, 0, 0.0, 0
    why, count, error, unknown = iterate(run, end - clock[T])
    if why != GOES_ON:
        return why, count, 0.0, 0
    X = run.model.task.stages.X
    clock[TURN], node = _turn(calls.turn, (X[X.shape[0] - 1],))
    if calls.furthest != 0 and clock[GAP] > error:
        error, unknown = clock[GAP], 0
    if calls.unseen != 0 and numbers[TAKEN] == WHOLE:
        message = run.message
        message[0] = clock[T]
        call(calls.unseen, message.ctypes, 4)
        if message[0] != clock[T]:
            return RAISED, count, 0.0, 0
        if message[1] > error:
            error, unknown = message[1], int(message[2])
    error /= tolerance_of(run, end)
    too_far = (clock[TURN] / limits[FARTHEST]) ** limits[POWER]
    if too_far > error:
        error, unknown = too_far, 6 * node + 3
    return GOES_ON, count, error, unknown
