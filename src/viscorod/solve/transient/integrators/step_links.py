"""Joints, springs and held strains in a collocation step, in kernels that only models with any of these compile."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.held_strains import give_stress, keep_stress, strain_gaps
from viscorod.mechanics.joints.joint_forces import (
    add_frozen_springs,
    carry_springs,
    hold_coordinates,
)
from viscorod.mechanics.joints.settled_multipliers import settle_multipliers
from viscorod.solve.transient.integrators.constraint_arrays import (
    add_gaps,
    add_motors,
    end_gaps,
    largest_gap,
    move_multipliers,
)
from viscorod.solve.transient.integrators.midpoint_end import strains_at_end
from viscorod.solve.transient.integrators.step_task import FINAL, StepTask

__all__ = ["account_links", "freeze_links", "give_links", "hold_links", "move_links"]


@kernel
def give_links(step: StepTask) -> None:
    """Give the multipliers of held strains to the stresses."""
    links = step.links
    give_stress(whole_of(links.held), links.states.multiplier, step.points.stress)


@kernel
def hold_links(step: StepTask) -> None:
    """Add the forces of joints and springs, and put what is to be held into its rows of the residuals."""
    links, stages, points, ends = step.links, step.stages, step.points, step.ends
    held, states = whole_of(links.held), whole_of(links.states)
    between = ends.r.shape[0] > 0
    if between and step.strains.start.shape[0] > 0:
        strains_at_end(step.strains.start, points.strain, ends.strain)
    keep_stress(held, points.stress, points.section_force)
    strain_gaps(held, points.strain, states.gap)
    where = (stages.r, stages.q, stages.twist, stages.internal)
    hold_coordinates(whole_of(links.joints), whole_of(links.laws), states, step.numbers[FINAL] != 0.0, *where)
    if between:
        end_gaps(whole_of(links), ends.r, ends.q, ends.strain)
    links.worst[0] = largest_gap(states.gap, links.unit)
    # by the midpoint rule half of what is defect at the end is defect in the middle
    factor = 0.5 if between else 1.0
    add_gaps(states.gap, links.scale, factor, step.body.mass.shape[0], stages.residual)


@kernel
def freeze_links(step: StepTask) -> None:
    """Add what the forces of springs differ from their iterates by to the internal forces."""
    links = step.links
    add_frozen_springs(
        whole_of(links.joints), whole_of(links.operators), whole_of(links.states), step.stages.internal
    )


@kernel
def move_links(step: StepTask) -> None:
    """Carry multipliers and springs along with the changes of the stages."""
    links, change = step.links, step.stages.residual
    move_multipliers(change, links.scale, step.body.mass.shape[0], links.states.multiplier)
    carried = (whole_of(links.joints), whole_of(links.operators))
    carry_springs(*carried, change, step.work.rates, whole_of(links.states))


@kernel
def account_links(step: StepTask) -> None:
    """Settle multipliers, and add the powers of motors and dampers and the energies of springs."""
    states, powers, elastic = step.links.states, step.account.powers, step.account.elastic
    about = (whole_of(step.links.joints), whole_of(states), whole_of(step.links.settling), step.body.length)
    settle_multipliers(*about, step.stages.r, step.stages.q, step.stages.residual)
    energy, power = states.energy, states.power
    add_motors(whole_of(step.links), powers[0])
    for i in range(elastic.shape[0]):
        elastic[i] += energy[i]
        powers[1, i] += power[i]
