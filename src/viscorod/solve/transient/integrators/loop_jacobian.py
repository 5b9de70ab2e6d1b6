"""The Jacobian of a step in the compiled loop."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.mechanics.elements.gauss_batch import group_of, points_of
from viscorod.mechanics.nodes.load_courses import sum_loads
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.solve.transient.integrators.copied_rows import clear, clear_blocks, copy_blocks
from viscorod.solve.transient.integrators.kernel_results import NOTHING, REAL
from viscorod.solve.transient.integrators.loop_data import FRESH, OF_MIDDLE, StepLoop, T

__all__ = ["renew"]

_do, _with, _measure = returning(NOTHING), returning(NOTHING, whole=False), returning(REAL)


@exact_part
def renew(run: StepLoop) -> None:
    """Linearise about the middle of a step that is predicted, as ``stage_model.StageModel.renew_jacobian`` does.

    It is the start where the numbers say so.
    """
    task, now, calls, known = run.model.task, run.state.now, run.calls, run.renewal
    stages, at_middle = task.stages, run.numbers[FRESH] == OF_MIDDLE
    r, q, twist = now.r, now.q, now.twist
    if at_middle:
        _with(calls.place, (task,))
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
    if calls.linearise_links != 0:
        _with(calls.linearise_links, (run, at_middle))
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
    if calls.prescribe_start != 0:
        _with(calls.prescribe_start, (run,))
    held = (body.supports, known.target, run.state.kept.reaction, r, q, body.pattern)
    projected = (out.blocks, out.rate_blocks, matrices.mass, matrices.directions, known.square[0])
    _do(calls.project, (*held, *projected))
