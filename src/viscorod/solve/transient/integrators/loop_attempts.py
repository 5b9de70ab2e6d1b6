"""One step in the compiled loop: factors, attempt, tolerated error, and the step as it is taken."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import exact_part, loop_part
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
from viscorod.solve.transient.integrators.kernel_results import (
    ATTEMPTED,
    ENDED,
    EXTENT,
    NOTHING,
    NUMBER,
    TURNED,
)
from viscorod.solve.transient.integrators.loop_data import (
    ALLOWED,
    ASK,
    ELASTIC,
    EVALUATED,
    EXPONENT,
    FACTOR,
    FACTOR_STEP,
    FACTORISED,
    FARTHEST,
    FOLLOWS,
    FRESH,
    FULL,
    HAVE,
    KINETIC,
    LAST_STEP,
    LOSS,
    LOST,
    NEWTON,
    POWER,
    RAISED,
    RATE,
    REACHED,
    SAFETY,
    STRAIN,
    TOLERANCE,
    TURN,
    WORK,
    Addresses,
    LoopModel,
    LoopState,
    LoopSystems,
    T,
)
from viscorod.solve.transient.integrators.predictor import LastStep
from viscorod.solve.transient.integrators.stage_data import IterationLimits
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers

__all__ = ["accept", "attempt", "copy", "follow"]

_do, _factorise, _turn = returning(NOTHING), returning(NUMBER), returning(TURNED)
_attempt, _end, _extent = returning(ATTEMPTED), returning(ENDED), returning(EXTENT)


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
    half: bool,
) -> tuple[int, int, float, int]:
    """Try a step to ``end`` [s]; ``half`` of one that is tried again, which counts for nothing.

    Returns:
        what it came to: :data:`REACHED`, :data:`FULL` if it is to be tried again with another Jacobian, or why the loop
        ends; iterations; error over the tolerated one, and the unknown where it is largest.
    """
    t, stages = clock[T], model.parts.stages
    h, s, counted = end - t, stages.X.shape[0], 0 if half else 1
    if numbers[HAVE] == 0:
        calls.message[0], calls.message[3] = t, 1.0 if half else 0.0
        call(calls.renew, calls.message.ctypes, 4)
        if calls.message[0] != t:
            return RAISED, 0, 0.0, 0
        numbers[HAVE] = numbers[FRESH] = 1
        clock[FACTOR_STEP], numbers[LOST] = 0.0, 0
    other = abs(h - clock[FACTOR_STEP]) > 1e-9 * h
    if other or numbers[LOST] != 0:
        numbers[LOST] = 0
        if other:
            clock[FACTOR_STEP] = h
        if not factorise(model, method, systems, calls, clock[FACTOR_STEP]):
            clock[FACTOR_STEP] = 0.0
            return ASK, 0, 0.0, 0
        if other:
            numbers[FACTORISED] += counted
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
        numbers[EVALUATED] += counted * count * s
        clock[RATE], numbers[HAVE] = 1.0, 0
        return FULL, count, 0.0, 0
    numbers[EVALUATED] += counted * (count + 1) * s
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
