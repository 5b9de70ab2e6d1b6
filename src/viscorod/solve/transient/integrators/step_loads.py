"""External loads at the stages of a collocation step, by the kernels that Python calls for single states as well."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import far
from viscorod.mechanics.compilation.compiled import lane_kernel, part
from viscorod.mechanics.nodes.applied_loads import add_nodal_loads, add_station_load
from viscorod.mechanics.nodes.attached_poses import ElementNodes, PointWrench
from viscorod.mechanics.nodes.motion_loads import MotionTangent, add_motion_loads
from viscorod.solve.transient.integrators.kernel_results import NOTHING, REAL
from viscorod.solve.transient.integrators.step_task import StepTask
from viscorod.typing import Floats

__all__ = ["add_moving", "add_nodal", "add_stations", "clear_loads"]

_nodal, _station = far(add_nodal_loads, NOTHING), far(add_station_load, NOTHING)
_moving = far(add_motion_loads, REAL)


@part
def clear_loads(external: Floats) -> None:
    """Set ``(s, n, 6)`` to zero."""
    for i in range(external.shape[0]):
        for k in range(external.shape[1]):
            for a in range(6):
                external[i, k, a] = 0.0


@lane_kernel
def add_nodal(step: StepTask) -> None:
    """Add the wrenches at nodes and gravity, in body components."""
    body, loads, q, external = step.body, step.loads, step.stages.q, step.stages.external
    none, diagonal, mass = step.work.no_blocks, body.pattern.diagonal, body.mass
    acting, dead, following, gravity = loads.acting, loads.dead, loads.following, loads.gravity
    for i in range(acting.shape[0]):
        if acting[i] != 0.0:
            given = (dead[i], following[i], gravity[i], loads.levers[i])
            into = (none.shape[0] > 0, external[i], none, diagonal)  # there is nothing to be differentiated
            _nodal(step.calls.nodal_loads, (body.loaded, q[i], *given, mass, *into))


@lane_kernel
def add_stations(step: StepTask) -> None:
    """Add the wrenches within elements."""
    elements, loads, stages, none = step.body.elements, step.loads, step.stages, step.work.no_blocks
    order, nodes, links, slots = elements.order, elements.nodes, elements.links, elements.slots
    positions, quaternions = elements.link_positions, elements.link_quaternions
    where, shape, dead, following = loads.element, loads.shape, loads.point_dead, loads.point_following
    r, q, external, wanted = stages.r, stages.q, stages.external, none.shape[0] > 0
    for i in range(where.shape[0]):
        for load in range(where.shape[1]):
            e = where[i, load]
            if e < 0:
                continue
            m = order[e] + 1
            own = ElementNodes(nodes[e, :m], links[e, :m], positions, quaternions)
            wrench = PointWrench(shape[i, load, :m], dead[i, load], following[i, load])
            into = (wanted, external[i], none, slots[e], loads.station_work)
            _station(step.calls.station_load, (own, wrench, r[i], q[i], *into))


@lane_kernel
def add_moving(step: StepTask) -> None:
    """Add the loads that see motion, and write the power that they dissipate."""
    loads, stages, none = step.loads, step.stages, step.work.no_blocks
    factors, r, q, twist, external = loads.motion_factors, stages.r, stages.q, stages.twist, stages.external
    dissipated, tangent = stages.dissipated, MotionTangent(none, none, none, step.body.pattern.diagonal)
    for i in range(factors.shape[0]):
        into = (external[i], tangent, loads.motion_work)
        dissipated[i] = _moving(
            step.calls.motion_loads, (loads.motion, factors[i], r[i], q[i], twist[i], *into)
        )
