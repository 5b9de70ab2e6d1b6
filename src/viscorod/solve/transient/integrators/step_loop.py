"""Many steps of Radau IIA in one compiled call: attempts, step control, energy account, records.

The large kernels (the step, factorisations) are called through their addresses, so that the loop is compiled once and
quickly; Python is called for what only it can do, new Jacobians and loads that change. Every number is that of steps
taken one by one (see ``collocation``, ``radau``, ``transient_solver``), bit for bit.
"""

from __future__ import annotations

import math
from typing import Any

from numba import types

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import exact_part, loop, loop_part
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.transient.amplitude import (
    LENGTH,
    USUAL,
    extend,
    grows,
    tolerance_after,
    tolerance_now,
    usual_at,
)
from viscorod.solve.transient.integrators.iteration_verdict import CONVERGED
from viscorod.solve.transient.integrators.loop_data import (
    ALLOWED,
    ASK,
    BROKEN,
    DURATION,
    ELASTIC,
    EVALUATED,
    EXPONENT,
    FACTOR,
    FACTOR_STEP,
    FACTORISED,
    FARTHEST,
    FIRST,
    FOLLOWS,
    FRESH,
    FULL,
    HAVE,
    ITERATED,
    KINETIC,
    LARGEST,
    LAST_STEP,
    LEAST,
    LONGER,
    LOSS,
    MARKS,
    MOST,
    NEWTON,
    NEXT,
    OUTPUT,
    POWER,
    RAISED,
    RATE,
    REACHED,
    REJECTED,
    ROWS,
    SAFETY,
    SETTLED,
    SMALLEST,
    STALE,
    STEPS,
    STRAIN,
    TOLERANCE,
    TURN,
    WORK,
    Addresses,
    Batch,
    LoopModel,
    LoopState,
    LoopSystems,
    T,
)
from viscorod.solve.transient.integrators.predictor import LastStep
from viscorod.solve.transient.integrators.record_kernels import (
    Between,
    ResultFields,
    StageFields,
)
from viscorod.solve.transient.integrators.stage_data import (
    IterationLimits,
)
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.solve.transient.step_choice import ACCEPTED, CORNER, accept_step, end_of_step
from viscorod.typing import Floats, Integers

__all__ = ["take_steps"]

TURN_OF_RECORD = 0.25
"""Rotation [rad] from record to record, if that takes more states than one above the stages."""

_tuple: Any = types.Tuple
NOTHING, NUMBER, TURNED = types.none, types.int64, _tuple((types.float64, types.int64))
ATTEMPTED = _tuple((types.int64,) * 2 + (types.float64,) * 2 + (types.int64, types.float64, types.int64))
ENDED, EXTENT = _tuple((types.float64,) * 5), _tuple((types.float64,) * 2)
"""What the kernels return."""

_do, _factorise, _turn = returning(NOTHING), returning(NUMBER), returning(TURNED)
_attempt, _end, _extent = returning(ATTEMPTED), returning(ENDED), returning(EXTENT)


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
def factorise(model: LoopModel, method: Tableau, systems: LoopSystems, calls: Addresses, h: float) -> bool:
    """Factorise the systems for a step of ``h`` [s]; return whether all went well."""
    K, C, mass, _, directions, _ = model.parts.matrices
    factors, supports, pattern = model.parts.factors, model.body.supports, model.body.pattern
    real, pairs, scales = factors.real, factors.pairs, factors.scales
    slots, kept, targets = systems.slots, systems.kept, systems.targets
    matrices = (K, C, mass)
    with_real = (supports, directions, pattern, scales, factors.real_rows, systems.real)
    _do(calls.combine_real, (*matrices, method.real / h, *with_real))
    for m in range(method.pairs.shape[0]):
        with_pair = (supports, directions, pattern, scales, factors.pair_rows[m], systems.pairs[m])
        _do(calls.combine_pair, (*matrices, method.pairs[m] / h, *with_pair))
    given = (real.values, real.fronts, real.integers, real.groups, real.rest)
    if _factorise(calls.reduce_real, (systems.real, slots, kept, targets, *given)) != 0:
        return False
    for m in range(method.pairs.shape[0]):
        one = (pairs.values[m], pairs.fronts[m], pairs.integers[m], pairs.groups, pairs.rest[m])
        if _factorise(calls.reduce_pair, (systems.pairs[m], slots, kept, targets, *one)) != 0:
            return False
    return True


@loop_part
def extent_of(model: LoopModel, state: LoopState, calls: Addresses) -> tuple[float, float]:
    """Return how far the last stage is from where the motion began, and how fast it is."""
    stages, begun = model.parts.stages, state.follows
    last = stages.X.shape[0] - 1
    where = (stages.r[last], stages.q[last], stages.twist[last])
    found: tuple[float, float] = _extent(calls.extent, (begun.r, begun.q, *where, begun.numbers[LENGTH]))
    return found


@loop_part
def tolerance_of(model: LoopModel, state: LoopState, calls: Addresses, limits: Floats, end: float) -> float:
    """Return what the step to ``end`` [s] may err by."""
    if limits[FOLLOWS] == 0.0:
        return float(limits[TOLERANCE])
    numbers = state.follows.numbers
    if usual_at(numbers, end):
        return float(limits[SAFETY] * USUAL)
    moved, speed = extent_of(model, state, calls)
    return float(limits[SAFETY] * tolerance_after(numbers, end, moved, speed))


@loop_part
def follow(model: LoopModel, state: LoopState, calls: Addresses, limits: Floats, t: float) -> None:
    """Let the tolerances follow the motion to the time ``t`` [s]."""
    if limits[FOLLOWS] == 0.0:
        return
    numbers, moved, speed = state.follows.numbers, 0.0, 0.0
    if grows(numbers):
        moved, speed = extent_of(model, state, calls)
    extend(numbers, t, moved, speed)
    change = limits[FACTOR] * tolerance_now(numbers) ** limits[EXPONENT]
    limits[NEWTON] = max(change, limits[FOLLOWS])


@loop_part
def attempt(
    model: LoopModel,
    method: Tableau,
    systems: LoopSystems,
    state: LoopState,
    calls: Addresses,
    clock: Floats,
    numbers: Integers,
    limits: Floats,
    end: float,
) -> tuple[int, int, float, int]:
    """Try a step to ``end`` [s].

    Returns:
        what it came to: :data:`REACHED`, :data:`FULL` if it is to be tried again with another Jacobian, or why the loop
        ends; iterations; error over the tolerated one, and the unknown where it is largest.
    """
    t, stages = clock[T], model.parts.stages
    h, s = end - t, stages.X.shape[0]
    if numbers[HAVE] == 0:
        calls.message[0] = t
        call(calls.renew, calls.message.ctypes, 4)
        if calls.message[0] != t:
            return RAISED, 0, 0.0, 0
        numbers[HAVE] = numbers[FRESH] = 1
        clock[FACTOR_STEP] = 0.0
    if abs(h - clock[FACTOR_STEP]) > 1e-9 * h:
        if not factorise(model, method, systems, calls, h):
            clock[FACTOR_STEP] = 0.0
            return ASK, 0, 0.0, 0
        clock[FACTOR_STEP] = h
        numbers[FACTORISED] += 1
    now, old = state.now, state.last
    last = LastStep(clock[LAST_STEP], old.r, old.q, old.twist, state.kept.X, state.stress)
    where = (now.r, now.q, model.body.split, model.body.held)
    _do(
        calls.predict,
        (method, model.gap, last, h, *where, state.weights, stages.X, state.stages_stress),
    )
    allowed = IterationLimits(limits[NEWTON], int(limits[ALLOWED]), clock[RATE])
    given = (model.body, method, now, h, model.motion, model.loads, model.parts, allowed)
    code, count, _, rate, _, error, unknown = _attempt(calls.step, (*given, None, None, None, None))
    if code != CONVERGED:
        if numbers[FRESH] != 0:
            return ASK, 0, 0.0, 0
        numbers[EVALUATED] += count * s
        clock[RATE], numbers[HAVE] = 1.0, 0
        return FULL, count, 0.0, 0
    numbers[EVALUATED] += (count + 1) * s
    clock[RATE] = rate
    clock[TURN], node = _turn(calls.turn, (stages.X[s - 1],))
    error /= tolerance_of(model, state, calls, limits, end)
    too_far = (clock[TURN] / limits[FARTHEST]) ** limits[POWER]
    if too_far > error:
        error, unknown = too_far, 6 * node + 3
    return REACHED, count, error, unknown


@exact_part
def copy(a: Floats, b: Floats) -> None:
    """Copy rows."""
    for k in range(a.shape[0]):
        for i in range(a.shape[1]):
            b[k, i] = a[k, i]


@loop_part
def accept(
    model: LoopModel, method: Tableau, state: LoopState, calls: Addresses, clock: Floats, h: float
) -> None:
    """Take the attempted step of ``h`` [s]."""
    parts, now, old, end = model.parts, state.now, state.last, state.end
    copy(now.r, old.r)
    copy(now.q, old.q)
    copy(now.twist, old.twist)
    for field in range(3):
        copy(state.points[1, field], state.points[0, field])
    copy(state.reactions[1], state.reactions[0])
    stages, account = parts.stages, parts.account
    given = (h, method, stages, account, model.motion.target, model.reading, state.kept, end)
    clock[KINETIC], clock[STRAIN], clock[WORK], clock[LOSS], _ = _end(calls.end, given)
    last = stages.X.shape[0] - 1
    clock[ELASTIC] = account.elastic[last]
    copy(end.r, now.r)
    copy(end.q, now.q)
    copy(end.twist, now.twist)
    for field in range(3):
        copy(end.points[field], state.points[1, field])
    copy(end.reactions[last], state.reactions[1])
    clock[LAST_STEP] = h


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
    if within > 0:
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
        into = Between(row, found.r, found.q, found.twist, fields, found.energies)
        places = batch.places[row : row + within]
        step = (h, method, state.last, reached, begin, of_stages, clock[LOSS], model.reading)
        _do(calls.between, (places, *step, True, True, into))
    if count > within:
        at = row + count - 1
        keep(state, clock, found, at)
        batch.places[at] = 1.0
    numbers[ROWS] = row + count
    for m in range(MARKS):
        if batch.marks[m] == numbers[STEPS] + 1:
            keep(state, clock, found, found.r.shape[0] - MARKS + m)


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
) -> int:
    """Take steps up to the corner that ``control`` has, or until something is Python's; return why it ends.

    Args:
        model, method, systems, state, calls: what steps are made of.
        clock, numbers, limits: see above; control: those of ``step_choice``; trials: steps that are tried again.
        batch: outputs.
    """
    most, rows, accounts = numbers[MOST], batch.instants.shape[0], batch.accounts
    while True:
        t = clock[T]
        if not t < control[CORNER]:
            return REACHED
        steps = numbers[STEPS]
        end = end_of_step(control, t)
        h = end - t
        if steps == most or numbers[ROWS] + room_for(limits, t, end) > rows:
            return FULL
        number = trials[FIRST] + steps
        tried = number == trials[NEXT] or (number > trials[SETTLED] and h > trials[LONGER])
        if tried or h < limits[SMALLEST]:
            return ASK
        if calls.prepare != 0:
            calls.message[0], calls.message[1] = t, end
            calls.message[2] = 1.0 if end == control[CORNER] else 0.0
            call(calls.prepare, calls.message.ctypes, 4)
            if calls.message[0] != t:
                return RAISED
        came, count, error, unknown = attempt(
            model, method, systems, state, calls, clock, numbers, limits, end
        )
        if came == FULL:
            numbers[ITERATED] += count
            batch.notes[0, steps] += count
            continue
        if came != REACHED:
            return came
        numbers[ITERATED] += count
        count += batch.notes[0, steps]
        batch.notes[0, steps] = 0
        if not accept_step(control, True, error, count, h):
            numbers[REJECTED] += 1
            continue
        accept(model, method, state, calls, clock, h)
        clock[T] = end
        follow(model, state, calls, limits, end)
        numbers[FRESH] = 0
        if clock[RATE] > limits[STALE]:
            numbers[HAVE] = 0
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
