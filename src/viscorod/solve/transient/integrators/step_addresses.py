"""Where the kernels are that a collocation step calls: of those that its model needs, and of no others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from viscorod.mechanics.compilation.by_address import address_of
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
from viscorod.mechanics.elements.internal_force import energies, internal_forces
from viscorod.mechanics.elements.rest_strains import deduct_rest
from viscorod.mechanics.nodes.applied_loads import add_nodal_loads, add_station_load
from viscorod.mechanics.nodes.attached_poses import ElementNodes, PointWrench
from viscorod.mechanics.nodes.motion_loads import MotionTangent, add_motion_loads
from viscorod.mechanics.nodes.support_rows import impose
from viscorod.solve.linear.substitution import substitute
from viscorod.solve.transient.integrators import step_branches, step_ends, step_links
from viscorod.solve.transient.integrators.kernel_results import NOTHING, REAL
from viscorod.solve.transient.integrators.stage_response import strains_as_states
from viscorod.solve.transient.integrators.step_account import support_powers
from viscorod.solve.transient.integrators.step_task import StepCalls, StepTask

__all__ = ["needed_kernels", "step_calls"]

Arguments = tuple[Any, ...]

_known: dict[Any, StepCalls] = {}
"""By types of all arrays, and by what there is: addresses are good for as long as the process lives."""


def step_calls(shared: Shared[StepTask]) -> StepCalls:
    """Return the addresses of the kernels that the step of a model needs; in pure Python they say what there is.

    Args:
        shared: the step, whose own calls are not looked at.
    """
    task = shared.bundle
    needed = needed_kernels(task)
    key = shared.number, tuple(needed)
    found = _known.get(key)
    if found is None:
        own = _own(task)
        here: Arguments = (shared.argument,)
        addresses: dict[str, int] = {}
        for name, kernel in needed.items():
            result, arguments = own.get(name, (NOTHING, None))
            addresses[name] = address_of(KnownTypes(kernel), result, arguments or (lambda: here))
        found = _known[key] = StepCalls(**addresses)
    return found


def needed_kernels(task: StepTask) -> dict[str, Callable[..., Any]]:
    """Return the kernels that a step calls, by their names among the calls."""
    found: dict[str, Callable[..., Any]] = {
        "internal_forces": internal_forces,
        "impose": impose,
        "substitute": substitute,
        "energies": energies,
    }
    loads, states = task.loads, len(task.strains.start) > 0
    if states:
        del found["internal_forces"]
        found["strains"] = strains_as_states
    elif len(task.stages.rest):
        found["deduct_rest"] = deduct_rest
    if len(task.method.pairs):
        found["substitute_pair"] = substitute
    if len(task.body.loaded):
        found["nodal_loads"] = add_nodal_loads
    if loads.element.shape[1]:
        found["station_load"] = add_station_load
    if loads.motion_factors.shape[1]:
        found["motion_loads"] = add_motion_loads
    if not task.body.complete.all():
        found["support_powers"] = support_powers
    relaxing, between = len(task.branches.times) > 0, len(task.ends.r) > 0
    if len(task.links.worst):
        found |= _named(step_links)
    if relaxing:
        found |= _named(step_branches)
    if between:
        found |= _named(step_ends)
    if not between or states:  # strains that are states are not extrapolated from poses
        found.pop("conserve", None)
        found.pop("branch_defect", None)
    return found


def _named(module: Any) -> dict[str, Callable[..., Any]]:
    return {name: getattr(module, name) for name in module.__all__}


def _own(task: StepTask) -> dict[str, tuple[Any, Callable[[], Arguments]]]:
    """Return the results and arguments of kernels that take something else than the step."""
    body, loads, stages, work = task.body, task.loads, task.stages, task.work
    real, pairs, none, diagonal = task.factors.real, task.factors.pairs, work.no_blocks, body.pattern.diagonal
    r, q, twist, out = stages.r, stages.q, stages.twist, stages.external
    elements, strains = body.elements, (stages.strain, stages.strain_rate)

    def nodal() -> Arguments:
        given = loads.dead[0], loads.following[0], loads.gravity[0], loads.levers[0]
        return body.loaded, q[0], *given, body.mass, False, out[0], none, diagonal

    def station() -> Arguments:
        where = elements.nodes[0], elements.links[0], elements.link_positions, elements.link_quaternions
        wrench = PointWrench(loads.shape[0, 0], loads.point_dead[0, 0], loads.point_following[0, 0])
        into = False, out[0], none, elements.slots[0], loads.station_work
        return ElementNodes(*where), wrench, r[0], q[0], *into

    def moving() -> Arguments:
        into = out[0], MotionTangent(none, none, none, diagonal), loads.motion_work
        return loads.motion, loads.motion_factors[0], r[0], q[0], twist[0], *into

    def supported() -> Arguments:
        into = stages.residual[0], stages.reaction[0], work.directions
        return body.supports, task.motion.target[0], r[0], q[0], *into

    def pair() -> Arguments:
        values, fronts, vector, integers, rows, groups, members, rest = pairs
        first = values[0], fronts[0], vector, integers[0], rows, groups, members, rest[0]
        return *first, work.pairs[0]

    return {
        "internal_forces": (
            NOTHING,
            lambda: (elements, r, q, twist, task.points, work.element, stages.internal),
        ),
        "deduct_rest": (NOTHING, lambda: (elements, stages.rest, stages.rest_rate, task.points)),
        "nodal_loads": (NOTHING, nodal),
        "station_load": (NOTHING, station),
        "motion_loads": (REAL, moving),
        "impose": (NOTHING, supported),
        "substitute": (NOTHING, lambda: (*real, work.real)),
        "substitute_pair": (NOTHING, pair),
        "energies": (NOTHING, lambda: (elements, *strains, task.account.elastic, task.account.powers[1])),
    }
