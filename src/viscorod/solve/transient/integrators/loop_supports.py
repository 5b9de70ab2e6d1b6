"""Supports in the compiled loop of steps: motions that it knows, and velocities of nodes that are held in part."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.nodes.motion_courses import write_motion
from viscorod.solve.transient.integrators.kernel_results import NOTHING, REAL
from viscorod.solve.transient.integrators.loop_data import KINETIC, StepLoop

__all__ = ["furthest", "move", "project"]

_do, _measure, _with = returning(NOTHING), returning(REAL), returning(NOTHING, whole=False)


@exact_part
def move(run: StepLoop, t: float, before: bool, i: int) -> None:
    """Put the supports at stage ``i`` where they are at ``t`` [s]; ``before``: the limits from the left."""
    courses, motion, supports = run.loads.motions, run.model.task.motion, run.model.task.body.supports
    target, rate = motion.target[i], motion.rate[i]
    write_motion(courses, t, before, target, rate)
    where = (supports.axes, supports.r0, supports.q0)
    into = (motion.r[i], motion.q[i], motion.twist[i], motion.twist_rate[i])
    _do(run.calls.prescribe, (*where, target, rate, courses.acceleration, *into))


@exact_part
def furthest(run: StepLoop, t: float, end: float) -> float:
    """Return how far motions that are tables go from what the stages of a step from ``t`` to ``end`` [s] show."""
    distance: float = _measure(run.calls.furthest, (run.loads.tables, t, end))
    return distance


@exact_part
def project(run: StepLoop) -> None:
    """Give nodes that supports hold in part velocities that these allow, at the end of a step."""
    if run.calls.turn_alone != 0:
        _with(run.calls.turn_alone, (run,))
    task, now, held = run.model.task, run.state.now, run.model.held
    last = task.motion.target.shape[0] - 1
    given = (task.body.supports, held.rows, task.motion.target[last], task.motion.rate[last], held.turning)
    _do(run.calls.project_twists, (*given, now.r, now.q, run.model.reading.directions, now.twist))
    run.clock[KINETIC] = _measure(run.calls.kinetic, (task.body.mass, now.twist))
