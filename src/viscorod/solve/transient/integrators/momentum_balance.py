"""Newton's method on the momenta at one instant of a step, in one compiled call.

An increment of the poses is sought with which the momentum rate and all forces balance. Twists are linear in the
increment and momentum rates in the spatial momenta (see ``generalized_alpha``), so an iteration places the nodes, lets
the elements respond, loads, adds the momentum rate, puts the supports in, solves, and moves. The assembly and the
factorisation are called through their addresses, so that they are compiled once; joints, held strains and loads that
see motion are Python's, which is called back for them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from viscorod.mechanics.compilation.by_address import far
from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import exact_part, kernel, lane_kernel
from viscorod.mechanics.elements.gauss_batch import PointFields, group_of, points_of
from viscorod.mechanics.elements.geometric_element import Assembled, assemble, update_stress
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.nodes.applied_loads import add_nodal_loads
from viscorod.mechanics.nodes.inertia import add_momentum_rate
from viscorod.mechanics.nodes.support_rows import Directions, SupportedNodes, impose, impose_tangent
from viscorod.mechanics.rotations.rotation import add_mapped, increment_size, inverse_motion_tangent, retract
from viscorod.solve.linear.factors import Factors, reduce
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.substitution import solve
from viscorod.solve.transient.integrators.iteration_verdict import (
    CONVERGED,
    DIVERGED,
    GOING,
    NOT_FINITE,
    SLOW,
)
from viscorod.solve.transient.integrators.kernel_results import NOTHING, NUMBER
from viscorod.typing import Floats, Integers

__all__ = ["solve_balance"]

ASK, RAISED = 5, 6
"""Verdicts beside those of ``iteration_verdict``: Python is to factorise the matrix and to solve; it raised."""

COUNT, GROWN, FACTORISED, LIMIT, NUMBERS = range(5)
"""Places among the numbers: iterations, changes in a row that were larger than the last one, whether Python solved,
allowed iterations."""

LAST, TOLERANCE = range(2)
"""Places among the sizes: the last change, and what the last one may be, displacement over length or rotation [rad]."""

ASSEMBLED, SOLVED = 0.0, 1.0
"""What Python is called back after."""

_assemble: Any = far(assemble, NOTHING)
_reduce: Any = far(reduce, NUMBER)


class BalanceBody(NamedTuple):
    """What does not change in a run.

    Attributes:
        groups: of elements, as :attr:`~viscorod.solve.formulations.geometric_system.GeometricSystem.batches`.
        mass: ``(n, 6, 6)``; held: nodes whose poses are prescribed ``(h,)``; supports, pattern: of the matrix.
        scales: of its unknowns ``(6 N,)``; scaled: any is not one; length: of the model [m].
    """

    groups: Integers
    mass: Floats
    held: Integers
    supports: SupportedNodes
    pattern: Pattern
    scales: Floats
    scaled: bool
    length: float


class Instant(NamedTuple):
    """What the balance at one instant is made of.

    Attributes:
        r, q: poses at the start of the step; slope, constant, history: see ``generalized_alpha.Relation``.
        moving: any support moves; held_r, held_q, held_twist: motions of nodes whose poses are prescribed ``(h, ...)``.
        loaded, dead, following, gravity, levers: loads of nodes, as in ``add_nodal_loads``.
        target: of the supports ``(m, 6)``.
    """

    r: Floats
    q: Floats
    slope: float
    constant: Floats
    history: Floats
    moving: bool
    held_r: Floats
    held_q: Floats
    held_twist: Floats
    loaded: Integers
    dead: Floats
    following: Floats
    gravity: Floats
    levers: Floats
    target: Floats


class Iterate(NamedTuple):
    """Where the iteration is: poses, twists and increment ``(n, ...)``, and what follows from them.

    Attributes:
        maps: derivatives of the twists by body increments ``(n, 6, 6)``; internal, external: forces ``(n, 6)``.
        blocks: of the matrix; residual: ``(N, 6)``; right: the change ``(6 N,)``; moved: that of nodes ``(n, 6)``.
        reaction, directions: of the supports.
    """

    r: Floats
    q: Floats
    twist: Floats
    increment: Floats
    maps: Floats
    internal: Floats
    external: Floats
    blocks: Floats
    residual: Floats
    right: Floats
    moved: Floats
    reaction: Floats
    directions: Directions


class Solver(NamedTuple):
    """Places of the blocks in what is factorised, its factors, and whether they are those of a band."""

    slots: Integers
    kept: Integers
    targets: Integers
    factors: Factors
    banded: bool


class Places(NamedTuple):
    """Addresses of kernels and of Python, 0 where it is not needed, and what it is told ``(1,)``."""

    assemble: int
    reduce: int
    rest: int
    message: Floats


@exact_part
def twists(slope: float, increment: Floats, constant: Floats, twist: Floats) -> None:
    """Write the twists that belong to an increment."""
    for k in range(increment.shape[0]):
        for a in range(6):
            twist[k, a] = increment[k, a] * slope + constant[k, a]


@lane_kernel
def place(body: BalanceBody, at: Instant, now: Iterate) -> None:
    """Put all nodes where the increment and the supports say; write the maps of increments to twists."""
    held, maps = body.held, now.maps
    retract(at.r, at.q, now.increment, now.r, now.q)
    twists(at.slope, now.increment, at.constant, now.twist)
    inverse_motion_tangent(now.increment, at.slope, maps)
    for m in range(held.shape[0]):
        k = held[m]
        for a in range(6):
            now.twist[k, a] = at.held_twist[m, a]
            for b in range(6):
                maps[k, a, b] = 0.0
        if at.moving:
            for a in range(3):
                now.r[k, a] = at.held_r[m, a]
            for a in range(4):
                now.q[k, a] = at.held_q[m, a]


@lane_kernel
def add_elements(
    body: BalanceBody, elements: Elements, points: PointFields, now: Iterate, calls: Places
) -> None:
    """Assemble the elements of all groups with their tangent."""
    internal, external, blocks, groups = now.internal, now.external, now.blocks, body.groups
    for k in range(internal.shape[0]):
        for a in range(6):
            internal[k, a] = external[k, a] = 0.0
    for s in range(blocks.shape[0]):
        for j in range(6):
            for i in range(6):
                blocks[s, j, i] = 0.0
    out = Assembled(internal, blocks, blocks[:0])
    for g in range(groups.shape[0]):
        group, fields = group_of(groups, g), points_of(groups, g, points)
        where = (now.r, now.q, now.twist)
        _assemble(calls.assemble, (elements, group, fields, *where, True, now.maps, True, out))


@lane_kernel
def balance(body: BalanceBody, at: Instant, now: Iterate, calls: Places) -> bool:
    """Add loads, whatever Python adds, and the momentum rate; put the supports in; return whether Python did well."""
    residual, external, internal = now.residual, now.external, now.internal
    n, diagonal = internal.shape[0], body.pattern.diagonal
    if calls.rest != 0:
        calls.message[0] = ASSEMBLED
        call(calls.rest, calls.message.ctypes, 1)
        if calls.message[0] != ASSEMBLED:
            return False
    else:
        loads = (at.dead, at.following, at.gravity, at.levers)
        add_nodal_loads(at.loaded, now.q, *loads, body.mass, True, external, now.blocks, diagonal)
    for k in range(n):
        for a in range(6):
            residual[k, a] = internal[k, a] - external[k, a]
    with_rates = (at.slope, at.history, now.maps, True, residual, now.blocks, diagonal)
    add_momentum_rate(body.mass, now.r, now.q, now.twist, *with_rates)
    impose(body.supports, at.target, now.r, now.q, residual, now.reaction, now.directions)
    pattern = body.pattern
    rows = (pattern.starts, pattern.across, pattern.diagonal)
    impose_tangent(body.supports, now.directions, now.reaction, residual, now.blocks, *rows)
    return True


@lane_kernel
def scale(body: BalanceBody, blocks: Floats) -> None:
    """Measure displacements in the unit of the matrix."""
    rows, columns, scales = body.pattern.rows, body.pattern.columns, body.scales
    for s in range(blocks.shape[0]):
        for j in range(6):
            for i in range(6):
                blocks[s, j, i] *= scales[6 * rows[s] + i] * scales[6 * columns[s] + j]


@lane_kernel
def solve_for_change(body: BalanceBody, now: Iterate, solver: Solver) -> None:
    """Solve for the change of the poses."""
    right, residual, scales = now.right, now.residual, body.scales
    for k in range(residual.shape[0]):
        for a in range(6):
            right[6 * k + a] = -residual[k, a]
    if body.scaled:
        for i in range(right.shape[0]):
            right[i] *= scales[i]
    solve(solver.factors, right)
    if body.scaled:
        for i in range(right.shape[0]):
            right[i] *= scales[i]


@lane_kernel
def move(
    body: BalanceBody, elements: Elements, points: PointFields, at: Instant, now: Iterate, calls: Places
) -> bool:
    """Change the increment and carry the stresses along; return whether Python did well with the multipliers."""
    add_mapped(now.maps, now.moved, 1.0 / at.slope, now.increment)
    for g in range(body.groups.shape[0]):
        group, fields = group_of(body.groups, g), points_of(body.groups, g, points)
        update_stress(elements, group, fields, now.moved, points.stress)
    if calls.rest != 0:
        calls.message[0] = SOLVED
        call(calls.rest, calls.message.ctypes, 1)
        return bool(calls.message[0] == SOLVED)
    return True


@exact_part
def judge_change(size: float, numbers: Integers, sizes: Floats) -> int:
    """Return the verdict on a change of the poses: see ``statics.newton.Convergence``."""
    numbers[COUNT] += 1
    last = sizes[LAST]
    sizes[LAST] = size
    if not math.isfinite(size):
        return NOT_FINITE
    if size <= sizes[TOLERANCE]:
        return CONVERGED
    if size > 1e4:
        return DIVERGED
    numbers[GROWN] = numbers[GROWN] + 1 if size > last else 0
    if numbers[GROWN] >= 6:
        return DIVERGED
    return SLOW if numbers[COUNT] >= numbers[LIMIT] else GOING


@kernel
def solve_balance(
    body: BalanceBody,
    elements: Elements,
    points: PointFields,
    at: Instant,
    now: Iterate,
    solver: Solver,
    calls: Places,
    numbers: Integers,
    sizes: Floats,
) -> int:
    """Iterate until the poses change no more; return the verdict.

    Args:
        body, elements, points, at: what is to balance; now: the predicted increment, and where it leads.
        solver, calls: how; numbers, sizes: see above.
    """
    factors = solver.factors
    given = (factors.values, factors.fronts, factors.integers, factors.groups, factors.rest)
    while True:
        if numbers[FACTORISED] == 0:
            place(body, at, now)
            add_elements(body, elements, points, now, calls)
            if not balance(body, at, now, calls):
                return RAISED
            if body.scaled:
                scale(body, now.blocks)
            if not solver.banded:
                return ASK
            if _reduce(calls.reduce, (now.blocks, solver.slots, solver.kept, solver.targets, *given)) != 0:
                return ASK
            solve_for_change(body, now, solver)
        numbers[FACTORISED] = 0
        if not move(body, elements, points, at, now, calls):
            return RAISED
        verdict = judge_change(increment_size(now.moved, body.length), numbers, sizes)
        if verdict != GOING:
            return verdict
