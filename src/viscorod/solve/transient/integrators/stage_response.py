"""What an iteration of a collocation step begins with: nodes are placed, the material and the joints respond.

Parts that a model may lack are None, see ``collocation_step``.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.held_strains import give_stress, keep_stress, strain_gaps
from viscorod.mechanics.elements.internal_force import GaussStates, conserve_energy, internal_forces
from viscorod.mechanics.elements.intrinsic_element import StrainMotion, stage_forces
from viscorod.mechanics.elements.maxwell_branches import (
    MaxwellArrays,
    add_branch_forces,
    lacking_work,
    stretch_springs,
)
from viscorod.mechanics.elements.rest_strains import deduct_rest, shift
from viscorod.mechanics.elements.section_laws import add_lacking_work
from viscorod.mechanics.joints.joint_forces import hold_coordinates
from viscorod.mechanics.nodes.inertia import balance
from viscorod.mechanics.nodes.support_rows import lacking_motion
from viscorod.mechanics.rotations.nodal_motion import place_stages
from viscorod.solve.transient.integrators.constraint_arrays import (
    GAP,
    ConstraintArrays,
    end_gaps,
    largest_gap,
)
from viscorod.solve.transient.integrators.midpoint_end import place_end, strains_at_end
from viscorod.solve.transient.integrators.stage_data import Ends, IterationLimits, StepTask
from viscorod.solve.transient.integrators.stage_kernels import evaluate_loads, place_held_nodes

__all__ = ["gaps_are_open", "hold", "load", "place", "respond"]


@lane_kernel
def place(step: StepTask, ends: Ends | None) -> None:
    """Put all nodes where their coordinates and the supports say, at all stages."""
    body, method, start, h, stages, motion = (
        step.body,
        step.method,
        step.start,
        step.h,
        step.stages,
        step.motion,
    )
    supports, rates = whole_of(body.supports), method.derivative
    r, q, twist, acceleration = stages.r, stages.q, stages.twist, stages.acceleration
    moved = (body.split, body.held, r, q, twist, acceleration)
    place_stages(start.r, start.q, start.twist, stages.X, rates, h, *moved)
    lacking_motion(supports, method.matrix, h, motion.rate, twist, motion.target)
    place_held_nodes(supports.nodes, body.complete, whole_of(motion), r, q, twist, acceleration)
    if ends is not None:
        scratch = step.work.change[0], step.work.rate[0]
        place_end(whole_of(body), whole_of(motion), whole_of(start), stages.X, *scratch, whole_of(ends))


@lane_kernel
def respond(
    step: StepTask,
    ends: Ends | None,
    strains: StrainMotion | None,
    links: ConstraintArrays | None,
    branches: MaxwellArrays | None,
) -> None:
    """Evaluate strains and section forces at all stages, and the nodal forces of the stresses."""
    elements, points, stages = whole_of(step.body.elements), whole_of(step.points), step.stages
    if links is not None:
        give_stress(whole_of(links.held), links.states.multiplier, points.stress)
    if strains is None:
        scratch = whole_of(step.work.element)
        internal_forces(elements, stages.r, stages.q, stages.twist, points, scratch, stages.internal)
        if stages.rest.shape[0] > 0:
            deduct_rest(elements, stages.rest, stages.rest_rate, points)
    else:
        rates = step.method.derivative
        stage_forces(elements, whole_of(strains), rates, step.h, stages.twist, points, stages.internal)
    if branches is not None:
        add_branch_forces(elements, whole_of(branches), points.strain, points.section_force)
    if ends is not None and strains is None:
        conserve(step, ends, branches)
    if links is not None:
        if ends is not None and strains is not None:
            strains_at_end(strains.start, points.strain, ends.strain)
        keep_stress(whole_of(links.held), points.stress, points.section_force)


@lane_kernel
def conserve(step: StepTask, ends: Ends, branches: MaxwellArrays | None) -> None:
    """Let the section forces do the work that elastic energy changes by from one end of the step to the other."""
    elements, points, h = whole_of(step.body.elements), step.points, step.h
    laws = elements.laws
    end_points = GaussStates(ends.strain, ends.strain_rate, ends.section_force, ends.section_force)
    scratch = whole_of(step.work.element)
    internal_forces(elements, ends.r, ends.q, ends.twist, end_points, scratch, ends.force)
    shift(-1.0, ends.rest, ends.strain)
    if branches is not None:
        relaxing = whole_of(branches)
        stretch_springs(elements, relaxing, points.strain)
        lacking_work(elements, relaxing, points.strain_rate, ends.start_strain, ends.strain, h, ends.defect)
    if laws.present:
        if branches is None:
            ends.defect.fill(0.0)
        middle, across = (points.strain, points.strain_rate), (ends.start_strain, ends.strain)
        add_lacking_work(laws, elements.order, elements.section, middle, *across, h, ends.defect)
    given = (points.strain, points.strain_rate, ends.start_strain, ends.strain)
    conserve_energy(elements, *given, h, ends.defect, points.section_force)


@lane_kernel
def hold(step: StepTask, ends: Ends | None, links: ConstraintArrays | None, final: bool) -> None:
    """Add the forces of joints and springs, and measure what is to be held."""
    if links is not None:
        stages, states = step.stages, whole_of(links.states)
        strain_gaps(whole_of(links.held), step.points.strain, states.gap)
        where = (stages.r, stages.q, stages.twist, stages.internal)
        hold_coordinates(whole_of(links.joints), whole_of(links.laws), states, final, *where)
        if ends is not None:
            end_gaps(whole_of(links), ends.r, ends.q, ends.strain)


@lane_kernel
def gaps_are_open(links: ConstraintArrays | None, count: int, limits: IterationLimits) -> bool:
    """Return whether anything that is held is too far off, and there are iterations left."""
    if links is not None:
        return count < limits.iterations and largest_gap(links.states.gap, links.unit) > GAP
    return False


@lane_kernel
def load(step: StepTask) -> None:
    """Evaluate the loads of all stages, and what their nodes lack in balance."""
    body, stages = step.body, step.stages
    given = (whole_of(body.elements), whole_of(step.loads), whole_of(stages), step.work.no_blocks)
    evaluate_loads(body.loaded, body.mass, body.pattern.diagonal, *given)
    forces = (stages.internal, stages.external, stages.force, stages.residual)
    balance(body.mass, stages.twist, stages.acceleration, *forces)
