"""Joints, springs and held strains in the compiled loop of steps: kernels that only models with any of these compile.

They take a reference to all that the loop works on. Sums are those of ``stage_constraints`` and ``constraints``, in the
same order.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.mechanics.compilation.references import refer
from viscorod.mechanics.joints.joint_tangent import JointSlopes
from viscorod.mechanics.nodes.motion_courses import write_motion
from viscorod.solve.transient.integrators.closed_states import Closed, Wanted
from viscorod.solve.transient.integrators.copied_rows import clear
from viscorod.solve.transient.integrators.kernel_results import NOTHING, REAL
from viscorod.solve.transient.integrators.loop_data import (
    LAST_STEP,
    SECOND_HALF,
    TAKEN,
    TRIED,
    WHOLE,
    StepLoop,
    T,
)
from viscorod.solve.transient.integrators.step_task import H
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

__all__ = ["drive", "keep", "linearise", "predict", "read", "within"]

_do, _close = returning(NOTHING), returning(REAL, whole=False)


@loop
def drive(given: StepLoop, t: float, before: bool, i: int) -> None:
    """Put the motors at stage ``i`` where they are to be at ``t`` [s]; ``before``: the limits from the left."""
    run = refer(given)
    links = run.model.task.links
    states, place = links.states, links.joints.place
    write_motion(run.links.motors, t, before, states.target[i : i + 1], links.target_rate[i : i + 1])
    for c in range(place.shape[0]):
        if place[c] >= 0:
            states.near[c] = states.target[i, c]


@exact_part
def stiffest(run: StepLoop, K: Floats, inertia: float) -> float:
    """Return the largest diagonal entry of all nodes with so much of their inertia, or of springs, or 1."""
    mass, diagonal, unit = run.model.task.body.mass, run.model.task.body.pattern.diagonal, run.links.unit
    largest = 0.0
    for k in range(mass.shape[0]):
        for a in range(6):
            found = abs(K[diagonal[k], a, a]) + inertia * mass[k, a, a]
            if a < 3:
                found *= unit[1]
            if not found <= largest:
                largest = found
    if largest != 0.0:
        return largest
    stiffness = run.links.stiffness
    for c in range(stiffness.shape[0]):
        largest = max(largest, abs(stiffness[c]))
    return largest if largest != 0.0 else 1.0


@loop
def linearise(given: StepLoop, at_middle: bool) -> None:
    """Add the constraints to the Jacobian, whose elements are assembled, as ``StageConstraints.linearise`` does."""
    run = refer(given)
    task, mine, known, calls = run.model.task, run.links, run.renewal, run.calls
    links, stages, alone, out = task.links, task.stages, run.links.alone, known.out
    pace = task.method.real / task.numbers[H]
    stiff = stiffest(run, out.blocks, pace * pace)
    if calls.joint_forces != 0:
        for p in range(alone.multiplier.shape[1]):
            alone.multiplier[0, p] = mine.memory.multiplier[p]
        clear(mine.force[0])
        r, q, twist = mine.start.r, mine.start.q, mine.start.twist
        if at_middle:
            i = (stages.X.shape[0] - 1) // 2
            r, q, twist = stages.r[i : i + 1], stages.q[i : i + 1], stages.twist[i : i + 1]
        _do(calls.joint_forces, (links.joints, mine.laws, alone, r, q, twist, mine.force))
        slopes = JointSlopes(links.states.near, alone.force[0], mine.stiffness, mine.damping)
        where = (links.joints, r[0], q[0], twist[0], slopes, known.ad)
        into = (links.scale, out.blocks, out.rate_blocks, links.operators)
        _do(calls.joint_tangent, (*where, stiff, mine.unit[0], *into))
    if calls.hold_strains != 0:
        held = (links.held, task.body.elements.order, stiff, mine.unit[0], task.matrices.operators.strain)
        _do(calls.hold_strains, (*held, links.scale, out.blocks))
    for k in range(mine.idle.shape[0]):
        a = mine.idle[k, 1]
        out.blocks[mine.idle[k, 0], a, a] = 1.0


@exact_part
def through(method: Tableau, place: float, known: Floats, out: Floats) -> None:
    """Write the values ``(m,)`` at a place of polynomials through ``known``, see ``link_memory.through_stages``."""
    values, s = method.values, method.nodes.shape[0]
    for m in range(out.shape[0]):
        out[m] = 0.0
    for j in range(s):
        power, weight = place, 0.0
        for k in range(s):
            weight += values[j, k] * power
            power *= place
        for m in range(out.shape[0]):
            out[m] += weight * (known[j + 1, m] - known[0, m])
    for m in range(out.shape[0]):
        out[m] = known[0, m] + out[m]


@loop
def predict(given: StepLoop, h: float) -> None:
    """Predict multipliers and spring forces of a step of ``h`` [s], those of halves by the whole."""
    run = refer(given)
    task, numbers, memory = run.model.task, run.numbers, run.links.memory
    states, nodes, last, place = task.links.states, task.method.nodes, run.clock[LAST_STEP], 1.0
    multipliers, forces = memory.multipliers, memory.forces
    if numbers[TAKEN] != WHOLE:
        last = run.batch.trials[numbers[TRIED], 2]
        place = 0.5 if numbers[TAKEN] == SECOND_HALF else 0.0
        multipliers, forces = run.links.whole.multipliers, run.links.whole.forces
    for i in range(nodes.shape[0]):
        if last > 0.0:
            at = place + nodes[i] * (h / last)
            through(task.method, at, multipliers, states.multiplier[i])
            through(task.method, at, forces, states.carried[i])
        else:
            for p in range(memory.multiplier.shape[0]):
                states.multiplier[i, p] = memory.multiplier[p]
            for c in range(memory.force.shape[0]):
                states.carried[i, c] = memory.force[c]


@loop
def keep(given: StepLoop) -> None:
    """Take the end of a step, as ``StageConstraints.end_step`` does."""
    run = refer(given)
    links, memory = run.model.task.links, run.links.memory
    states, place = links.states, links.joints.place
    last = states.multiplier.shape[0] - 1
    for p in range(memory.multiplier.shape[0]):
        memory.multipliers[0, p] = memory.multiplier[p]
        for i in range(last + 1):
            memory.multipliers[i + 1, p] = states.multiplier[i, p]
        memory.multiplier[p] = states.multiplier[last, p]
        memory.drift[0] = max(memory.drift[0], abs(states.gap[last, p]) / links.unit[p])
    for c in range(place.shape[0]):
        memory.forces[0, c] = memory.force[c]
        for i in range(last + 1):
            memory.forces[i + 1, c] = states.force[i, c]
        memory.value[c], memory.rate[c], memory.force[c] = (
            states.value[c],
            states.rate[last, c],
            states.force[last, c],
        )
        if place[c] < 0:
            states.near[c] = states.value[c]


@exact_part
def want(run: StepLoop, t: float, before: bool, at: int) -> None:
    """Write where the joints are to be at ``t`` [s] into the row ``at``."""
    links, rows = run.model.task.links, run.links.rows
    states, place = links.states, links.joints.place
    for c in range(place.shape[0]):
        rows.target[at, c], rows.target_rate[at, c] = states.target[0, c], links.target_rate[0, c]
    write_motion(run.links.motors, t, before, rows.target[at : at + 1], rows.target_rate[at : at + 1])
    for c in range(place.shape[0]):
        rows.near[at, c] = rows.target[at, c] if place[c] >= 0 else states.near[c]


@exact_part
def close(run: StepLoop, first: int, count: int, poses: bool) -> None:
    """Close the states in some rows; ``poses``: they are open, too."""
    mine, found = run.links, run.batch.states
    rows, memory, place = mine.rows, mine.memory, 0 if poses else 1
    wanted = Wanted(rows.target, rows.target_rate, rows.near)
    states = Closed(found.r, found.q, found.twist, rows.value, rows.rate)
    left = _close(run.calls.close, (mine.closing, wanted, states, first, count, poses, mine.strains != 0))
    memory.drift[place] = max(memory.drift[place], left)


@loop
def within(given: StepLoop, first: int, size: int, to: int) -> None:
    """Close states within the last step, at ``size`` places from the ``first`` on, in rows from ``to`` on."""
    run = refer(given)
    clock, rows, memory = run.clock, run.links.rows, run.links.memory
    for k in range(size):
        place, at = run.batch.places[first + k], to + k
        want(run, clock[T] - (1.0 - place) * clock[LAST_STEP], False, at)
        through(run.model.task.method, place, memory.forces, rows.force[at])
        for c in range(memory.force.shape[0]):
            rows.force[at, c] = -rows.force[at, c]
        for p in range(memory.multiplier.shape[0]):
            rows.multiplier[at, p] = memory.multiplier[p]
    close(run, to, size, True)


@loop
def read(given: StepLoop, at: int) -> None:
    """Write the joints at the end of the last step into the row ``at``, whose velocities are those that are allowed."""
    run = refer(given)
    rows, memory = run.links.rows, run.links.memory
    want(run, run.clock[T], True, at)
    close(run, at, 1, False)
    for c in range(memory.value.shape[0]):
        rows.value[at, c], rows.force[at, c] = memory.value[c], -memory.force[c]
