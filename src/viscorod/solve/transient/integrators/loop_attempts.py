"""One step in the compiled loop: factors, attempt, tolerated error, and the step as it is taken."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.elements.gauss_batch import group_of, points_of
from viscorod.mechanics.nodes.load_courses import sum_loads
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.solve.transient.amplitude import (
    LENGTH,
    USUAL,
    extend,
    grows,
    tolerance_after,
    tolerance_now,
    usual_at,
)
from viscorod.solve.transient.integrators import loop_branches, loop_supports
from viscorod.solve.transient.integrators.iteration_verdict import CONVERGED
from viscorod.solve.transient.integrators.kernel_results import (
    ATTEMPTED,
    ENDED,
    EXTENT,
    NOTHING,
    NUMBER,
    REAL,
    TURNED,
)
from viscorod.solve.transient.integrators.loop_data import (
    AGAIN,
    AGED,
    ALLOWED,
    ASK,
    ELASTIC,
    EVALUATED,
    EXPONENT,
    EXTRA_ROWS,
    FACTOR,
    FACTOR_STEP,
    FACTORISED,
    FAILED,
    FARTHEST,
    FOLLOWS,
    FRESH,
    GAP,
    GOES_ON,
    HAVE,
    KINETIC,
    LAST_STEP,
    LOSS,
    LOST,
    MARKS,
    NEWTON,
    OF_MIDDLE,
    OF_START,
    OLD,
    OUTSIDE,
    POWER,
    RAISED,
    RATE,
    RENEWED,
    SAFETY,
    SECOND_HALF,
    STALE,
    START,
    STRAIN,
    TAKEN,
    TOLERANCE,
    TRIAL_ROWS,
    TRIED,
    TURN,
    WHOLE,
    WORK,
    StepLoop,
    T,
)
from viscorod.solve.transient.integrators.predictor import LastStep
from viscorod.solve.transient.integrators.record_kernels import Between
from viscorod.solve.transient.integrators.step_task import ITERATIONS, H
from viscorod.solve.transient.integrators.step_task import RATE as TRUSTED
from viscorod.solve.transient.integrators.step_task import TOLERANCE as TOLERATED
from viscorod.solve.transient.step_choice import CORNER
from viscorod.typing import Floats, Integers

__all__ = ["attempt", "copy", "follow", "row_of_trial", "take_end"]

_do, _place = returning(NOTHING), returning(NOTHING, whole=False)
_factorise, _turn = returning(NUMBER), returning(TURNED)
_attempt, _end, _extent = returning(ATTEMPTED, whole=False), returning(ENDED), returning(EXTENT)
_measure = returning(REAL)


@exact_part
def combine(run: StepLoop, h: float) -> None:
    """Put the systems for a step of ``h`` [s] together."""
    task, systems, calls = run.model.task, run.systems, run.calls
    body, method, factors, frozen = task.body, task.method, task.factors, task.matrices
    matrices = (frozen.K, frozen.C, frozen.mass)
    where = (body.supports, frozen.directions, body.pattern, factors.scales)
    _do(calls.combine_real, (*matrices, method.real / h, *where, factors.real_rows, systems.real))
    for m in range(method.pairs.shape[0]):
        with_pair = (*where, factors.pair_rows[m], systems.pairs[m])
        _do(calls.combine_pair, (*matrices, method.pairs[m] / h, *with_pair))


@exact_part
def factorise(run: StepLoop, h: float) -> bool:
    """Factorise the systems for a step of ``h`` [s]; return whether all went well."""
    task, systems, calls = run.model.task, run.systems, run.calls
    method, real, pairs = task.method, task.factors.real, task.factors.pairs
    if calls.stiffen_real != 0:
        loop_branches.combine(run, h)
    else:
        combine(run, h)
    places = (systems.slots, systems.kept, systems.targets)
    given = (real.values, real.fronts, real.integers, real.groups, real.rest)
    if _factorise(calls.reduce_real, (systems.real, *places, *given)) != 0:
        return False
    for m in range(method.pairs.shape[0]):
        one = (pairs.values[m], pairs.fronts[m], pairs.integers[m], pairs.groups, pairs.rest[m])
        if _factorise(calls.reduce_pair, (systems.pairs[m], *places, *one)) != 0:
            return False
    return True


@exact_part
def extent_of(run: StepLoop) -> tuple[float, float]:
    """Return how far the last stage is from where the motion began, and how fast it is."""
    stages, begun = run.model.task.stages, run.state.follows
    last = stages.X.shape[0] - 1
    where = (stages.r[last], stages.q[last], stages.twist[last])
    found: tuple[float, float] = _extent(run.calls.extent, (begun.r, begun.q, *where, begun.numbers[LENGTH]))
    return found


@exact_part
def tolerance_of(run: StepLoop, end: float) -> float:
    """Return what the step to ``end`` [s] may err by."""
    limits, numbers = run.limits, run.state.follows.numbers
    if limits[FOLLOWS] == 0.0:
        return float(limits[TOLERANCE])
    if usual_at(numbers, end):
        return float(limits[SAFETY] * USUAL)
    moved, speed = extent_of(run)
    return float(limits[SAFETY] * tolerance_after(numbers, end, moved, speed))


@exact_part
def follow(run: StepLoop, t: float) -> None:
    """Let the tolerances follow the motion to the time ``t`` [s]."""
    limits, numbers = run.limits, run.state.follows.numbers
    if limits[FOLLOWS] == 0.0:
        return
    moved, speed = 0.0, 0.0
    if grows(numbers):
        moved, speed = extent_of(run)
    extend(numbers, t, moved, speed)
    change = limits[FACTOR] * tolerance_now(numbers) ** limits[EXPONENT]
    limits[NEWTON] = max(change, limits[FOLLOWS])


@exact_part
def renew(run: StepLoop) -> None:
    """Linearise about the middle of a step that is predicted, as ``stage_model.StageModel.renew_jacobian`` does.

    It is the start where the numbers say so.
    """
    task, now, calls, known = run.model.task, run.state.now, run.calls, run.renewal
    stages, at_middle = task.stages, run.numbers[FRESH] == OF_MIDDLE
    r, q, twist = now.r, now.q, now.twist
    if at_middle:
        _place(calls.place, (task,))
        middle = (stages.X.shape[0] - 1) // 2
        r, q, twist = stages.r[middle], stages.q[middle], stages.twist[middle]
    body, loads, matrices, out = task.body, run.loads.start, task.matrices, known.out
    mass, diagonal = body.mass, body.pattern.diagonal
    _do(calls.adjoint, (twist, known.ad))
    clear_blocks(out.blocks)
    clear_blocks(out.rate_blocks)
    clear(out.force)
    clear(known.external)
    for g in range(known.groups.shape[0]):
        group, points = group_of(known.groups, g), points_of(known.groups, g, known.fields)
        if not at_middle:
            points = points_of(known.groups, g, known.at_start)
        _do(calls.assemble, (known.elements, group, points, r, q, twist, True, known.ad, True, out))
        _do(calls.collect, (known.elements, group, points, matrices.operators))
    sum_loads(run.loads.courses, run.clock[T], False, 0, loads)
    if loads.acting[0] != 0.0:
        acting = (loads.dead[0], loads.following[0], loads.gravity[0], loads.levers[0], mass)
        _do(calls.add_loads, (body.loaded, q, *acting, True, known.external, out.blocks, diagonal))
    if calls.add_moving != 0:
        into = MotionTangent(known.ad, out.blocks, out.rate_blocks, diagonal)
        moving = (task.loads.motion, loads.moving[0], r, q, twist, known.external)
        _measure(calls.add_moving, (*moving, into, task.loads.motion_work))
    copy_blocks(mass, matrices.mass)
    inertia = (mass, twist, known.ad, out.blocks, out.rate_blocks, diagonal, matrices.adjoint)
    _do(calls.add_inertia, (*inertia, known.square))
    held = (body.supports, known.target, run.state.kept.reaction, r, q, body.pattern)
    projected = (out.blocks, out.rate_blocks, matrices.mass, matrices.directions, known.square[0])
    _do(calls.project, (*held, *projected))


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
        if not factorise(run, clock[FACTOR_STEP]):
            clock[FACTOR_STEP] = 0.0
            return ASK
        if other and whole:
            numbers[FACTORISED] += 1
    return GOES_ON


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


@exact_part
def attempt(run: StepLoop, end: float) -> tuple[int, int, float, int]:
    """Try a step to ``end`` [s]; halves of one that is tried again count for nothing.

    Returns:
        :data:`GOES_ON` if it is good, :data:`AGAIN` if it is to be tried again with another Jacobian, :data:`FAILED` if
        that was a new one, or why the loop ends; iterations; error over the tolerated one, and the unknown where it is
        largest.
    """
    clock, numbers, limits, task = run.clock, run.numbers, run.limits, run.model.task
    h, stages, calls = end - clock[T], task.stages, run.calls
    predict(run, h)
    why = provide(run, end)
    if why != GOES_ON:
        return why, 0, 0.0, 0
    if calls.begin_branches != 0:
        loop_branches.begin(run, h)
    given = task.numbers
    given[H], given[TOLERATED] = h, limits[NEWTON]
    given[TRUSTED], given[ITERATIONS] = clock[RATE], limits[ALLOWED]
    code, count, _, rate, _, error, unknown = _attempt(calls.step, (task,))
    good, s, counted = code == CONVERGED, stages.X.shape[0], 1 if numbers[TAKEN] == WHOLE else 0
    numbers[EVALUATED] += counted * (count + 1 if good else count) * s
    if not good:
        clock[RATE] = 1.0
        if numbers[FRESH] == OF_START:
            return FAILED, count, 0.0, 0
        numbers[HAVE] = 0
        return AGAIN, count, 0.0, 0
    clock[RATE], numbers[FRESH] = rate, OLD
    clock[TURN], node = _turn(calls.turn, (stages.X[s - 1],))
    if calls.furthest != 0 and clock[GAP] > error:
        error, unknown = clock[GAP], 0
    if calls.unseen != 0 and counted != 0:
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


@exact_part
def clear(rows: Floats) -> None:
    """Set rows to zero."""
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            rows[k, i] = 0.0


@exact_part
def clear_blocks(blocks: Floats) -> None:
    """Set blocks to zero."""
    for s in range(blocks.shape[0]):
        for i in range(blocks.shape[1]):
            for j in range(blocks.shape[2]):
                blocks[s, i, j] = 0.0


@exact_part
def copy_blocks(a: Floats, b: Floats) -> None:
    """Copy blocks."""
    for s in range(a.shape[0]):
        for i in range(a.shape[1]):
            for j in range(a.shape[2]):
                b[s, i, j] = a[s, i, j]


@exact_part
def copy(a: Floats, b: Floats) -> None:
    """Copy rows."""
    for k in range(a.shape[0]):
        for i in range(a.shape[1]):
            b[k, i] = a[k, i]


@exact_part
def take_end(run: StepLoop, t: float) -> None:
    """Take the attempted step to ``t`` [s]."""
    task, clock, numbers, state = run.model.task, run.clock, run.numbers, run.state
    now, old, end, stages, account = state.now, state.last, state.end, task.stages, task.account
    h, last = t - clock[T], stages.X.shape[0] - 1
    copy(now.r, old.r)
    copy(now.q, old.q)
    copy(now.twist, old.twist)
    for field in range(3):
        copy(state.points[1, field], state.points[0, field])
    copy(state.reactions[1], state.reactions[0])
    given = (h, task.method, stages, account, task.motion.target, run.model.reading, state.kept, end)
    clock[KINETIC], clock[STRAIN], clock[WORK], clock[LOSS], clock[OUTSIDE] = _end(run.calls.end, given)
    clock[ELASTIC] = account.elastic[last]
    copy(end.r, now.r)
    copy(end.q, now.q)
    copy(end.twist, now.twist)
    for field in range(3):
        copy(end.points[field], state.points[1, field])
    copy(end.reactions[last], state.reactions[1])
    if run.calls.keep_branches != 0:
        loop_branches.keep(run)
    if run.calls.project_twists != 0:
        loop_supports.project(run)
    clock[LAST_STEP], clock[T] = h, t
    if clock[RATE] > run.limits[STALE]:
        numbers[HAVE] = 0
