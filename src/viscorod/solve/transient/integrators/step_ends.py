"""The ends of a step of the midpoint rule, in kernels that only runs with it compile."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import far, sharing
from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.internal_force import GaussStates, conserve_energy, internal_forces
from viscorod.mechanics.elements.rest_strains import shift
from viscorod.mechanics.elements.section_laws import add_lacking_work
from viscorod.mechanics.nodes.support_rows import impose
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.midpoint_end import place_end, take_gaps
from viscorod.solve.transient.integrators.step_branches import branch_defect
from viscorod.solve.transient.integrators.step_task import H, StepTask

__all__ = ["conserve", "hold_ends", "place_ends"]

_forces, _impose = far(internal_forces, NOTHING), far(impose, NOTHING)
_branch_defect = sharing(branch_defect, NOTHING)


@kernel
def place_ends(step: StepTask) -> None:
    """Write the poses at the end of the step."""
    scratch = step.work.change[0], step.work.rate[0]
    where = whole_of(step.body), whole_of(step.motion), whole_of(step.start)
    place_end(*where, step.stages.X, *scratch, whole_of(step.ends))


@kernel
def conserve(step: StepTask) -> None:
    """Let the section forces do the work that elastic energy changes by from one end of the step to the other."""
    elements, points, ends, h = whole_of(step.body.elements), step.points, step.ends, step.numbers[H]
    laws, calls = elements.laws, step.calls
    end_points = GaussStates(ends.strain, ends.strain_rate, ends.section_force, ends.section_force)
    at = (step.body.elements, ends.r, ends.q, ends.twist, end_points, step.work.element, ends.force)
    _forces(calls.internal_forces, at)
    shift(-1.0, ends.rest, ends.strain)
    if calls.branch_defect != 0:
        _branch_defect(calls.branch_defect, (step,))
    if laws.present:
        if calls.branch_defect == 0:
            ends.defect.fill(0.0)
        middle, across = (points.strain, points.strain_rate), (ends.start_strain, ends.strain)
        add_lacking_work(laws, elements.order, elements.section, middle, *across, h, ends.defect)
    given = (points.strain, points.strain_rate, ends.start_strain, ends.strain)
    conserve_energy(elements, *given, h, ends.defect, points.section_force)


@kernel
def hold_ends(step: StepTask) -> None:
    """Hold nodes at their targets at the end of the step rather than in its middle."""
    body, ends, work, target = step.body, step.ends, step.work, step.motion.target
    gap, supports = work.vector, whole_of(body.supports)
    for m in range(supports.nodes.shape[0]):
        for a in range(6):
            gap[supports.nodes[m], a] = 0.0
    held = (body.supports, target[0], ends.r[0], ends.q[0], gap, work.reaction, work.directions)
    _impose(step.calls.impose, held)
    take_gaps(supports, gap, step.stages.residual)
