"""Maxwell branches in a collocation step, in kernels that only models with branches compile."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.maxwell_branches import (
    add_branch_error,
    add_branch_forces,
    branch_energies,
    carry_branches,
    lacking_work,
    stretch_springs,
)
from viscorod.solve.transient.integrators.stage_kernels import clear
from viscorod.solve.transient.integrators.step_error import project_free
from viscorod.solve.transient.integrators.step_task import H, StepTask

__all__ = ["account_branches", "add_branches", "branch_defect", "end_branches", "move_branches"]


@kernel
def add_branches(step: StepTask) -> None:
    """Add the forces of the branches to the section forces."""
    elements, points = whole_of(step.body.elements), step.points
    add_branch_forces(elements, whole_of(step.branches), points.strain, points.section_force)


@kernel
def branch_defect(step: StepTask) -> None:
    """Write what the work of the branches lacks between the ends of a step of the midpoint rule."""
    elements, branches, points, ends = whole_of(step.body.elements), step.branches, step.points, step.ends
    relaxing = whole_of(branches)
    stretch_springs(elements, relaxing, points.strain)
    lacking_work(
        elements,
        relaxing,
        points.strain_rate,
        ends.start_strain,
        ends.strain,
        step.numbers[H],
        ends.defect,
    )


@kernel
def move_branches(step: StepTask) -> None:
    """Carry the stresses of the branches along with the changes of the stages."""
    elements, operator = whole_of(step.body.elements), step.matrices.operators.strain
    carry_branches(elements, whole_of(step.branches), operator, step.stages.residual, step.points.stress)


@kernel
def end_branches(step: StepTask) -> None:
    """Write the strains of the springs at all stages, and what the branches add to the equation of the error."""
    elements, relaxing, stages = whole_of(step.body.elements), whole_of(step.branches), step.stages
    strain, internal, h = stages.strain, stages.internal, step.numbers[H]
    stretch_springs(elements, relaxing, strain)
    if internal.shape[0] == 1:
        return
    method, matrices, supports = step.method, step.matrices, whole_of(step.body.supports)
    operator, weights, mu = matrices.operators.strain, method.error, method.real / h
    clear(internal)
    add_branch_error(elements, relaxing, strain, operator, weights, mu, h, internal[0])
    project_free(supports, matrices.directions.Z, step.work.change, internal[0])


@kernel
def account_branches(step: StepTask) -> None:
    """Add the energies and powers of the branches."""
    account = step.account
    branch_energies(whole_of(step.body.elements), whole_of(step.branches), account.elastic, account.powers[1])
