"""Moving supports that hold nodes in part, in the compiled loop: kernels that only models with such supports compile.

They take a reference to all that the loop works on. Poses within steps are corrected as ``SupportState.correct`` does.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.mechanics.compilation.references import refer
from viscorod.mechanics.nodes.motion_courses import write_motion
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.loop_data import LAST_STEP, StepLoop, T
from viscorod.typing import Floats

__all__ = ["correct_within", "prescribe_start", "turn_alone"]

_do = returning(NOTHING)


@exact_part
def turn(run: StepLoop, target: Floats, rate: Floats) -> None:
    """Write how the held rotations alone turn the nodes, of prescribed values of all supports and their rates."""
    held = run.model.held
    for i in range(held.rows.shape[0]):
        s = held.rows[i]
        for a in range(6):
            held.given[0, i, a] = held.fixed[i, a] * target[s, a]
            held.given[1, i, a] = held.fixed[i, a] * rate[s, a]
    given = (held.given[0], held.given[1], held.given[2])
    where = (held.axes, held.r0, held.q0)
    _do(run.calls.prescribe, (*where, *given, held.r, held.q, held.turning, held.twist_rate))


@loop
def prescribe_start(given: StepLoop) -> None:
    """Write the prescribed values at the start of a step, about which it is linearised."""
    run = refer(given)
    write_motion(run.loads.motions, run.clock[T], False, run.renewal.target, run.model.held.rate)


@loop
def turn_alone(given: StepLoop) -> None:
    """Write how the held rotations alone turn the nodes at the end of a step."""
    run = refer(given)
    motion = run.model.task.motion
    last = motion.target.shape[0] - 1
    turn(run, motion.target[last], motion.rate[last])


@loop
def correct_within(given: StepLoop, first: int, size: int, to: int) -> None:
    """Correct states within the last step, at ``size`` places from the ``first`` on, in rows from ``to`` on."""
    run = refer(given)
    held, clock, found = run.model.held, run.clock, run.batch.states
    supports, directions = run.model.task.body.supports, run.model.reading.directions
    for k in range(size):
        at, t = to + k, clock[T] - (1.0 - run.batch.places[first + k]) * clock[LAST_STEP]
        write_motion(run.loads.motions, t, False, held.target, held.rate)
        r, q = found.r[at], found.q[at]
        _do(run.calls.correct, (supports, held.rows, held.target, r, q, directions, held.change))
        turn(run, held.target, held.rate)
        turned = (held.target, held.rate, held.turning)
        _do(run.calls.project_twists, (supports, held.rows, *turned, r, q, directions, found.twist[at]))
