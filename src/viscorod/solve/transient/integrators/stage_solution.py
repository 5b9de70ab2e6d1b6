"""What an iteration of a collocation step ends with: conditions of supports, the solution, and the stages moved by it.

Parts that a model may lack are None, see ``collocation_step``.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.linearised import add_frozen_forces, carry_stress
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays, carry_branches
from viscorod.mechanics.joints.joint_forces import add_frozen_springs, carry_springs
from viscorod.mechanics.rotations.nodal_motion import move_stages
from viscorod.solve.linear.substitution import solve, solve_each
from viscorod.solve.transient.integrators.constraint_arrays import (
    ConstraintArrays,
    add_gaps,
    move_multipliers,
)
from viscorod.solve.transient.integrators.midpoint_end import hold_ends
from viscorod.solve.transient.integrators.stage_data import Ends, StepTask
from viscorod.solve.transient.integrators.stage_kernels import (
    add,
    clear,
    clear_held,
    differentiate,
    held_power,
    impose,
    to_changes,
    to_modes,
)
from viscorod.solve.transient.integrators.step_error import project_free

__all__ = ["freeze", "move", "release_held", "solve_stages", "support"]


@lane_kernel
def support(step: StepTask, ends: Ends | None, links: ConstraintArrays | None, final: bool) -> None:
    """Put the conditions of supports and links into their rows of the residuals; keep reactions."""
    body, stages = step.body, step.stages
    if links is not None:
        # by the midpoint rule half of what is defect at the end is defect in the middle
        factor = 1.0 if ends is None else 0.5
        add_gaps(links.states.gap, links.scale, factor, body.mass.shape[0], stages.residual)
    if final:
        held_power(body.supports.nodes, body.complete, stages.residual, stages.twist, stages.held_power)
    if final or body.partly:
        supports, directions = whole_of(body.supports), whole_of(step.work.directions)
        poses = (step.motion.target, stages.r, stages.q)
        impose(supports, *poses, stages.residual, stages.reaction, directions)


@lane_kernel
def freeze(step: StepTask, links: ConstraintArrays | None) -> None:
    """Add what section forces and springs differ from their iterates by, through the frozen operators.

    It is projected as the Jacobian is: what stiff sections add here dwarfs all other forces.
    """
    body, points, matrices = step.body, step.points, step.matrices
    internal, forces = step.stages.internal, (points.section_force, points.stress)
    clear(internal)
    add_frozen_forces(whole_of(body.elements), matrices.operators.strain, *forces, internal)
    if links is not None:
        operators, states = whole_of(links.operators), whole_of(links.states)
        add_frozen_springs(whole_of(links.joints), operators, states, internal)
    if body.partly:
        for i in range(internal.shape[0]):
            project_free(whole_of(body.supports), matrices.directions.Z, step.work.vector, internal[i])
    add(internal, step.stages.residual)


@lane_kernel
def release_held(step: StepTask, ends: Ends | None) -> None:
    """Clear the residual of nodes whose poses are prescribed; hold others at the end of the step."""
    body, work, residual = step.body, step.work, step.stages.residual
    clear_held(body.held, residual)
    if ends is not None:
        scratch = (work.vector, work.reaction, whole_of(work.directions))
        hold_ends(whole_of(body.supports), step.motion.target, whole_of(ends), *scratch, residual)


@lane_kernel
def solve_stages(step: StepTask) -> tuple[float, int]:
    """Solve for the changes of all stages, which take the place of the residual; return the largest and its unknown."""
    body, method, factors, work = step.body, step.method, step.factors, step.work
    residual, real, pairs = step.stages.residual, work.real, work.pairs
    to_modes(residual, method.to_modes, factors.real_rows, factors.pair_rows, real, pairs)
    solve(whole_of(factors.real), real)
    solve_each(whole_of(factors.pairs), pairs)
    return to_changes(real, pairs, method.to_stages, factors.scales, body.held, body.length, residual)


@lane_kernel
def move(step: StepTask, links: ConstraintArrays | None, branches: MaxwellArrays | None) -> None:
    """Move the nodes by the changes, and carry stresses, springs and multipliers along."""
    body, points, operators = step.body, step.points, step.matrices.operators
    elements, change, rates = whole_of(body.elements), step.stages.residual, step.work.rates
    move_stages(step.stages.X, change, body.split, body.held)
    differentiate(step.method.derivative, step.h, change, rates)
    forces = (points.section_force, points.stress)
    carry_stress(elements, operators.force, operators.viscous, change, rates, *forces)
    if branches is not None:
        carry_branches(elements, whole_of(branches), operators.strain, change, points.stress)
    if links is not None:
        move_multipliers(change, links.scale, body.mass.shape[0], links.states.multiplier)
        carried = (whole_of(links.joints), whole_of(links.operators))
        carry_springs(*carried, change, rates, whole_of(links.states))
