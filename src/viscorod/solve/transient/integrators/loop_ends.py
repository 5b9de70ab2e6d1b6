"""The end of a step in the compiled loop, where the next one begins."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.solve.transient.integrators import loop_branches, loop_supports
from viscorod.solve.transient.integrators.copied_rows import copy
from viscorod.solve.transient.integrators.kernel_results import ENDED, NOTHING
from viscorod.solve.transient.integrators.loop_data import (
    ELASTIC,
    HAVE,
    KINETIC,
    LAST_STEP,
    LOSS,
    OUTSIDE,
    RATE,
    STALE,
    STRAIN,
    WORK,
    StepLoop,
    T,
)

__all__ = ["take_end"]

_end, _with = returning(ENDED), returning(NOTHING, whole=False)


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
    if run.calls.keep_links != 0:
        _with(run.calls.keep_links, (run,))
    clock[LAST_STEP], clock[T] = h, t
    if clock[RATE] > run.limits[STALE]:
        numbers[HAVE] = 0
