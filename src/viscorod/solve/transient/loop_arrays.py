"""The arrays of the compiled loop of steps, made once for a motion."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.branch_memory import BranchMemory, BranchRows
from viscorod.mechanics.nodes.carried_motion import Carrier
from viscorod.mechanics.nodes.load_courses import LoadCourses, LoadSums
from viscorod.mechanics.nodes.motion_courses import MotionCourses
from viscorod.mechanics.nodes.table_motions import TableMotions
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.transient import amplitude
from viscorod.solve.transient.integrators import loop_data
from viscorod.solve.transient.integrators.branch_systems import Stiffened
from viscorod.solve.transient.integrators.lent_steps import Lent
from viscorod.solve.transient.integrators.link_memory import LinkMemory
from viscorod.solve.transient.integrators.radau import LEAST_CHANGE, Radau
from viscorod.solve.transient.integrators.record_kernels import Between, StepEnd
from viscorod.solve.transient.integrators.step_task import StepTask
from viscorod.solve.transient.loop_addresses import NOWHERE
from viscorod.solve.transient.loop_link_arrays import link_arrays
from viscorod.solve.transient.motion_scale import PartOfMotion, Tolerance
from viscorod.solve.transient.step_control import ErrorControl
from viscorod.typing import Floats

__all__ = ["MOST_CORNERS", "MOST_STEPS", "loop_arrays"]

MOST_STEPS = 128
"""Steps at once: an interrupt waits for them."""
MOST_CORNERS = 63
"""Corners of loads that are known beforehand, beside the next one."""
MOST_ROWS, LEAST_ROWS = 256, 32
"""States at once."""
MOST_BYTES = 2**24
"""What strains of Maxwell branches in so many states may take, beyond the least number of these."""
LEAST_STEP = 1e-6
"""Shortest step over the duration: one by one, steps are watched more closely."""
LARGEST_STRAIN = 100.0
"""Shear or stretch beyond which a run is stopped: nothing that means anything comes after it."""


_NO_BRANCHES = loop_data.LoopBranches(
    BranchMemory.none(), Stiffened.of(0, 0, float), Stiffened.of(0, 0, complex)
)


_NO_ROWS, _NO_MOTION = np.zeros((0, 6)), np.zeros((0, 0))
_NO_SUPPORTS = loop_data.HeldInPart(
    np.zeros(0, dtype=np.int64),
    _NO_ROWS,
    np.zeros((0, 3, 3)),
    *(_NO_MOTION, _NO_MOTION, _NO_ROWS, _NO_ROWS, _NO_ROWS),
    np.zeros((3, 0, 6)),
    *(_NO_MOTION, _NO_MOTION, _NO_ROWS, _NO_ROWS),
)


def loop_arrays(
    integrator: Radau,
    control: ErrorControl,
    duration: float,
    output_interval: float | None,
    courses: LoadCourses | None,
    motions: MotionCourses | None,
) -> loop_data.StepLoop:
    """Make all that a loop works on, but the addresses of the kernels; arguments as of ``ManySteps``.

    ``courses`` and ``motions`` are those of loads and supports that the loop knows, None if Python evaluates them.
    """
    lent, body = integrator.lent, integrator.body
    fields, reaction = integrator.recorder.present
    state = _state(integrator, lent, fields.shape[1], len(reaction))
    branches = _branches(integrator)
    clock = np.zeros(loop_data.CLOCK)
    inside = len(integrator.tableau.exact_inside)
    batch = _batch(len(body.mass), fields.shape[1], len(reaction), len(branches.memory.loss), inside)
    links = link_arrays(integrator, lent, len(batch.states.r))
    return loop_data.StepLoop(
        model=loop_data.LoopModel(
            lent.task,
            lent.reading,
            integrator.predictor.gap,
            branches,
            _held_in_part(integrator),
        ),
        systems=loop_data.LoopSystems(*integrator.systems.blocks, *integrator.systems.real.places),
        state=state,
        calls=NOWHERE,
        clock=clock,
        numbers=np.zeros(loop_data.NUMBERS, dtype=np.int64),
        limits=_limits(integrator, duration, output_interval),
        control=control.numbers,
        trials=np.zeros(loop_data.TRIALS),
        batch=batch,
        backup=_backup(state, branches.memory, lent.task.bundle, links.memory, clock),
        renewal=_renewal(integrator, lent),
        message=np.zeros(4),
        loads=_loads(integrator, courses, motions),
        ahead=np.full(MOST_CORNERS + 1, np.inf),
        links=links,
    )


def _state(integrator: Radau, lent: Lent, points: int, supports: int) -> loop_data.LoopState:
    stages = integrator.stages
    n, s = len(integrator.body.mass), len(integrator.tableau.nodes)
    return loop_data.LoopState(
        lent.task.bundle.start,
        MovingPoses(np.empty((n, 3)), np.empty((n, 4)), np.empty((n, 6)), lent.start_rate),
        lent.kept,
        integrator.predictor.stresses.reshape(s + 1, -1),
        stages.stress.reshape(s, -1),
        StepEnd.of(stages, lent.reading),
        np.empty((2, 3, points, 6)),
        np.empty((2, supports, 6)),
        np.empty((s, s + 1)),
        _followed(integrator.tolerance, n),
        np.empty_like(integrator.predictor.X),
        np.empty_like(integrator.predictor.stresses.reshape(s + 1, -1)),
    )


def _branches(integrator: Radau) -> loop_data.LoopBranches:
    dashpots = integrator.dashpots
    if dashpots is None:
        return _NO_BRANCHES
    return loop_data.LoopBranches(dashpots.own, dashpots.real, dashpots.pair)


def _held_in_part(integrator: Radau) -> loop_data.HeldInPart:
    supports = integrator.supports
    if not len(supports.partial):
        return _NO_SUPPORTS
    rows = np.ascontiguousarray(supports.partial, dtype=np.int64)
    p, (turning, twist_rate) = len(rows), np.zeros((2, len(rows), 6))
    return loop_data.HeldInPart(
        rows,
        turning,
        supports.set.axes[rows],
        supports.r0[rows],
        supports.q0[rows],
        supports.set.fixed[rows],
        np.zeros_like(supports.target),
        np.zeros_like(supports.target),
        np.zeros((3, p, 6)),
        np.empty((p, 3)),
        np.empty((p, 4)),
        twist_rate,
        np.empty((1, 6)),
    )


def _batch(nodes: int, points: int, supports: int, branches: int, inside: int) -> loop_data.Batch:
    fit = MOST_BYTES // max(48 * points * branches, 1)
    rows = min(max(fit, LEAST_ROWS), MOST_ROWS)
    states = rows + inside + loop_data.EXTRA_ROWS
    return loop_data.Batch(
        np.zeros(MOST_STEPS),
        np.zeros(MOST_STEPS),
        np.zeros((3, MOST_STEPS), dtype=np.int64),
        np.zeros((MOST_STEPS + 1, 5)),
        np.zeros((MOST_STEPS + 1, branches)),
        np.zeros(rows),
        np.full(rows + 1, 0.5),
        np.zeros(rows, dtype=np.int64),
        Between.of(states, nodes, points, supports),
        BranchRows.of(states, points, branches),
        np.zeros(loop_data.MARKS, dtype=np.int64),
        np.zeros((loop_data.MOST_TRIALS, 4)),
    )


def _limits(integrator: Radau, duration: float, output_interval: float | None) -> Floats:
    limits = np.zeros(loop_data.LIMITS)
    follows = type(integrator.tolerance) is PartOfMotion
    limits[loop_data.FOLLOWS : loop_data.HALF] = (
        LEAST_CHANGE if follows else 0.0,
        integrator.step_factor,
        integrator.newton_factor,
        integrator.newton_power,
        integrator.stale,
        integrator.aged,
        integrator.iterations,
        integrator.largest_turn,
        float(integrator.estimate_order + 1),
        0.0 if output_interval is None else output_interval,
        duration,
        LEAST_STEP * duration,
        len(integrator.tableau.nodes) + 1,
        LARGEST_STRAIN,
    )
    return limits


def _backup(
    state: loop_data.LoopState, branches: BranchMemory, task: StepTask, memory: LinkMemory, clock: Floats
) -> loop_data.Backup:
    """Return what steps go on from, as rows of numbers."""
    now, last, kept, end, links = state.now, state.last, state.kept, state.end, task.links
    K, C, mass, adjoint, directions, operators = task.matrices
    springs = links.operators.gradients, links.operators.A, links.operators.P
    arrays = (
        *(clock, now.r, now.q, now.twist, last.r, last.q, last.twist, state.points, state.reactions),
        *(*kept, *end, state.follows.numbers, branches.dashpot, branches.strain),
        *(K, C, mass, adjoint, *directions, *operators),
        *(*memory, links.states.near, links.scale, *springs),
    )
    live = tuple(array.reshape(-1) for array in arrays)
    size = sum(map(len, live))
    return loop_data.Backup(live, np.zeros(size), np.zeros(size))


def _renewal(integrator: Radau, lent: Lent) -> loop_data.Renewal:
    """Return what Jacobians are renewed with."""
    system = integrator.system
    matrices, work = lent.task.bundle.matrices, lent.task.bundle.work
    if not isinstance(system, GeometricSystem):
        raise TypeError(f"the compiled loop knows no tangent of a {type(system).__name__}")
    stress = integrator.stages.stress
    elements, groups, fields, out = system.lend_tangent(
        stress[(len(stress) - 1) // 2], matrices.K, matrices.C
    )
    at_start = fields._replace(stress=lent.kept.stress)
    return loop_data.Renewal(
        elements, groups, fields, at_start, out, lent.ad, work.change, work.square, integrator.supports.target
    )


def _loads(
    integrator: Radau, courses: LoadCourses | None, motions: MotionCourses | None
) -> loop_data.LoopLoads:
    """Return the loads, which the loop writes to where steps read them."""
    given, at, offset = integrator.task.loads, len(integrator.body.mass), integrator.actions.loads.offset
    places, content = len(given.motion.nodes), integrator.actions.content
    tables = None if content is None or motions is None else content.tables
    known = LoadCourses.none() if courses is None else courses
    count = len(known.formulas)
    unknown = np.full((len(given.acting), count), np.nan)
    sums = given.acting, given.dead, given.following, given.gravity, given.levers, given.motion_factors
    moved = MotionCourses.none() if motions is None else motions
    seen = TableMotions.none() if tables is None else tables
    start = LoadSums.of(1, count, at, places=places, offset=offset)
    return loop_data.LoopLoads(known, moved, seen, LoadSums(unknown, *sums), start)


def _followed(tolerance: Tolerance, nodes: int) -> loop_data.Follows:
    """Return what a tolerance follows, if it follows anything."""
    numbers, carrier = np.zeros(amplitude.COUNT), None
    if isinstance(tolerance, PartOfMotion):
        numbers, carrier = tolerance.numbers, tolerance.carrier
    poses, carried = ((np.zeros((nodes, 3)), np.zeros((nodes, 4))) for _ in range(2))
    return loop_data.Follows(numbers, *poses, carrier or Carrier.none(), *carried, np.zeros((nodes, 6)))
