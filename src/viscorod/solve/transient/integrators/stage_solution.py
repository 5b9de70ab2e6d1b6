"""What an iteration of a collocation step ends with: conditions of supports, the solution, and the stages moved by it.

Kernels that only some models need, or that others call as well, are called through their addresses (see
``step_task``).
"""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import far, sharing
from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.linearised import add_frozen_forces, carry_stress
from viscorod.mechanics.nodes.support_rows import impose
from viscorod.mechanics.rotations.nodal_motion import move_stages
from viscorod.solve.linear.substitution import substitute
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.stage_kernels import (
    add,
    clear,
    clear_held,
    differentiate,
    held_power,
    to_changes,
    to_modes,
)
from viscorod.solve.transient.integrators.step_branches import move_branches
from viscorod.solve.transient.integrators.step_ends import hold_ends
from viscorod.solve.transient.integrators.step_error import project_free
from viscorod.solve.transient.integrators.step_links import freeze_links, move_links
from viscorod.solve.transient.integrators.step_task import H, StepTask
from viscorod.typing import Floats

__all__ = ["freeze", "move", "release_held", "solve_real", "solve_stages", "support"]

_impose, _substitute = far(impose, NOTHING), far(substitute, NOTHING)
_hold_ends, _move_branches = sharing(hold_ends, NOTHING), sharing(move_branches, NOTHING)
_freeze_links, _move_links = sharing(freeze_links, NOTHING), sharing(move_links, NOTHING)


@lane_kernel
def support(step: StepTask, final: bool) -> None:
    """Put the conditions of supports into their rows of the residuals; keep reactions."""
    body, stages, directions = step.body, step.stages, step.work.directions
    target, r, q, residual, reaction = (
        step.motion.target,
        stages.r,
        stages.q,
        stages.residual,
        stages.reaction,
    )
    if final:
        held_power(body.supports.nodes, body.complete, residual, stages.twist, stages.held_power)
    if final or body.partly:
        for i in range(r.shape[0]):
            held = (target[i], r[i], q[i], residual[i], reaction[i], directions)
            _impose(step.calls.impose, (body.supports, *held))


@lane_kernel
def freeze(step: StepTask) -> None:
    """Add what section forces and springs differ from their iterates by, through the frozen operators.

    It is projected as the Jacobian is: what stiff sections add here dwarfs all other forces.
    """
    body, points, matrices, calls = step.body, step.points, step.matrices, step.calls
    internal, forces = step.stages.internal, (points.section_force, points.stress)
    clear(internal)
    add_frozen_forces(whole_of(body.elements), matrices.operators.strain, *forces, internal)
    if calls.freeze_links != 0:
        _freeze_links(calls.freeze_links, (step,))
    if body.partly:
        for i in range(internal.shape[0]):
            project_free(whole_of(body.supports), matrices.directions.Z, step.work.vector, internal[i])
    add(internal, step.stages.residual)


@lane_kernel
def release_held(step: StepTask) -> None:
    """Clear the residual of nodes whose poses are prescribed; hold others at the end of the step."""
    clear_held(step.body.held, step.stages.residual)
    if step.calls.hold_ends != 0:
        _hold_ends(step.calls.hold_ends, (step,))


@lane_kernel
def solve_real(step: StepTask, right: Floats) -> None:
    """Solve with the real factors in place."""
    f = step.factors.real
    given = (f.values, f.fronts, f.vector, f.integers, f.rows, f.groups, f.members, f.rest)
    _substitute(step.calls.substitute, (*given, right))


@lane_kernel
def solve_stages(step: StepTask) -> tuple[float, int]:
    """Solve for the changes of all stages, which take the place of the residual; return the largest and its unknown."""
    body, method, factors, work = step.body, step.method, step.factors, step.work
    residual, real, pairs, f = step.stages.residual, work.real, work.pairs, step.factors.pairs
    to_modes(residual, method.to_modes, factors.real_rows, factors.pair_rows, real, pairs)
    solve_real(step, real)
    for m in range(pairs.shape[0]):
        given = (f.values[m], f.fronts[m], f.vector, f.integers[m], f.rows, f.groups, f.members, f.rest[m])
        _substitute(step.calls.substitute_pair, (*given, pairs[m]))
    return to_changes(real, pairs, method.to_stages, factors.scales, body.held, body.length, residual)


@lane_kernel
def move(step: StepTask) -> None:
    """Move the nodes by the changes, and carry stresses, springs and multipliers along."""
    body, points, operators, calls = step.body, step.points, step.matrices.operators, step.calls
    elements, change, rates = whole_of(body.elements), step.stages.residual, step.work.rates
    move_stages(step.stages.X, change, body.split, body.held)
    differentiate(step.method.derivative, step.numbers[H], change, rates)
    forces = (points.section_force, points.stress)
    carry_stress(elements, operators.force, operators.viscous, change, rates, *forces)
    if calls.move_branches != 0:
        _move_branches(calls.move_branches, (step,))
    if calls.move_links != 0:
        _move_links(calls.move_links, (step,))
