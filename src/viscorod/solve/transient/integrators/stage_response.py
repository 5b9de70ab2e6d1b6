"""What an iteration of a collocation step begins with: nodes are placed, the material responds, loads act.

Kernels that only some models need, or that others call as well, are called through their addresses (see
``step_task``).
"""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import far, sharing
from viscorod.mechanics.compilation.compiled import kernel, lane_kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.internal_force import internal_forces
from viscorod.mechanics.elements.intrinsic_element import stage_forces
from viscorod.mechanics.elements.rest_strains import deduct_rest
from viscorod.mechanics.nodes.inertia import balance
from viscorod.mechanics.nodes.support_rows import lacking_motion
from viscorod.mechanics.rotations.nodal_motion import place_stages
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.stage_kernels import place_held_nodes
from viscorod.solve.transient.integrators.step_branches import add_branches
from viscorod.solve.transient.integrators.step_ends import conserve, place_ends
from viscorod.solve.transient.integrators.step_links import give_links, hold_links
from viscorod.solve.transient.integrators.step_loads import add_moving, add_nodal, add_stations, clear_loads
from viscorod.solve.transient.integrators.step_task import H, StepTask

__all__ = ["load", "place", "respond", "strains_as_states"]

_internal_forces, _deduct_rest = far(internal_forces, NOTHING), far(deduct_rest, NOTHING)
_give_links, _hold_links = sharing(give_links, NOTHING), sharing(hold_links, NOTHING)
_place_ends, _conserve = sharing(place_ends, NOTHING), sharing(conserve, NOTHING)
_add_branches = sharing(add_branches, NOTHING)


@lane_kernel
def place(step: StepTask) -> None:
    """Put all nodes where their coordinates and the supports say, at all stages."""
    body, method, start, stages, motion = step.body, step.method, step.start, step.stages, step.motion
    supports, rates, h = whole_of(body.supports), method.derivative, step.numbers[H]
    r, q, twist, acceleration = stages.r, stages.q, stages.twist, stages.acceleration
    moved = (body.split, body.held, r, q, twist, acceleration)
    place_stages(start.r, start.q, start.twist, stages.X, rates, h, *moved)
    lacking_motion(supports, method.matrix, h, motion.rate, twist, motion.target)
    place_held_nodes(supports.nodes, body.complete, whole_of(motion), r, q, twist, acceleration)
    if step.calls.place_ends != 0:
        _place_ends(step.calls.place_ends, (step,))


@kernel
def strains_as_states(step: StepTask) -> None:
    """Advance strains that are states; evaluate section forces, and the nodal forces of the stresses."""
    stages, path = step.stages, (step.method.derivative, step.numbers[H])
    elements, strains, points = whole_of(step.body.elements), whole_of(step.strains), whole_of(step.points)
    stage_forces(elements, strains, *path, stages.twist, points, stages.internal)


_strains = sharing(strains_as_states, NOTHING)


@lane_kernel
def respond(step: StepTask) -> None:
    """Evaluate strains and section forces at all stages, and the nodal forces of the stresses and of what is held."""
    elements, stages, points, calls = step.body.elements, step.stages, step.points, step.calls
    if calls.give_links != 0:
        _give_links(calls.give_links, (step,))
    if calls.strains != 0:
        _strains(calls.strains, (step,))
    else:
        at = (elements, stages.r, stages.q, stages.twist, points, step.work.element, stages.internal)
        _internal_forces(calls.internal_forces, at)
        if calls.deduct_rest != 0:
            _deduct_rest(calls.deduct_rest, (elements, stages.rest, stages.rest_rate, points))
    if calls.add_branches != 0:
        _add_branches(calls.add_branches, (step,))
    if calls.conserve != 0:
        _conserve(calls.conserve, (step,))
    if calls.hold_links != 0:
        _hold_links(calls.hold_links, (step,))


@lane_kernel
def load(step: StepTask) -> None:
    """Evaluate the loads of all stages, and what their nodes lack in balance."""
    body, stages, calls = step.body, step.stages, step.calls
    clear_loads(stages.external)
    if calls.nodal_loads != 0:
        add_nodal(step)
    if calls.station_load != 0:
        add_stations(step)
    if calls.motion_loads != 0:
        add_moving(step)
    forces = (stages.internal, stages.external, stages.force, stages.residual)
    balance(body.mass, stages.twist, stages.acceleration, *forces)
