"""Where the kernels are that the compiled loop of steps calls."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.mechanics.compilation.by_address import address_of
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
from viscorod.mechanics.elements.branch_memory import BranchRows
from viscorod.mechanics.elements.held_strains import add_held_strains
from viscorod.mechanics.joints.joint_forces import joint_forces
from viscorod.mechanics.joints.joint_tangent import JointSlopes, add_joint_tangent
from viscorod.mechanics.nodes.applied_loads import add_nodal_loads
from viscorod.mechanics.nodes.carried_motion import carry_along
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.nodes.motion_loads import MotionTangent, add_motion_loads
from viscorod.mechanics.nodes.nodes_held_in_part import correct_poses, project_twists
from viscorod.mechanics.nodes.prescribed_motion import prescribed_motion
from viscorod.mechanics.nodes.table_motions import furthest_motion
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.mechanics.rotations.rotation import motion_extent
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.linear.factors import Factors
from viscorod.solve.transient.integrators import kernel_results
from viscorod.solve.transient.integrators.closed_states import Closed, Wanted
from viscorod.solve.transient.integrators.loop_data import (
    Addresses,
    LoopLoads,
    LoopModel,
    LoopState,
    LoopSystems,
    Renewal,
    StepLoop,
)
from viscorod.solve.transient.integrators.loop_link_data import LoopLinks
from viscorod.solve.transient.integrators.predictor import LastStep
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.integrators.record_kernels import Between, ResultFields, StageFields
from viscorod.solve.transient.loop_own_kernels import find_own, own_kernels
from viscorod.solve.transient.motion_scale import PartOfMotion

__all__ = ["NOWHERE", "find_addresses"]

NOWHERE = Addresses._make([0] * len(Addresses._fields))
"""Addresses of kernels that are not known yet."""

_known: dict[tuple[int | bool, ...], Addresses] = {}
"""By kinds of loops: addresses are good for as long as the process lives."""


def find_addresses(
    integrator: Radau,
    model: LoopModel,
    given: LoopState,
    systems: LoopSystems,
    states: Between,
    renewal: Renewal,
    loads: LoopLoads,
    links: LoopLinks,
    loop: Shared[StepLoop],
) -> Addresses:
    """Return the addresses of all kernels, for the types of an integrator's arrays and of the loop's, but of Python's.

    Args:
        integrator: whose kernels these are; model, given, systems: what the loop works on; states: of its records.
        renewal: of Jacobians; loads, links: that the loop knows; loop: all that it works on.
    """
    renews = _renews(integrator)
    supports, moving = integrator.supports, integrator.actions.loads.motion
    there = supports.moving, len(supports.partial) > 0, len(moving.nodes) > 0, len(loads.tables.begins) > 0
    problem = integrator.system.problem
    carried = isinstance(integrator.tolerance, PartOfMotion) and integrator.tolerance.carrier is not None
    joined = problem.constrained, problem.joints.count > 0, len(problem.held.place) > 0
    inside = len(integrator.tableau.exact_inside) > 0
    key = loop.number, renews, integrator.dashpots is None, carried, inside, *there, *joined
    found = _known.get(key)
    if found is None:
        kernels = _of_attempts(integrator, model, given) | _of_systems(integrator, systems)
        kernels |= _of_records(integrator, model, given, states)
        kernels |= _of_branches(integrator) | _of_supports(integrator, model, given)
        kernels |= _of_links(integrator, given, states, renewal, links)
        if len(loads.tables.begins):
            kernels["furthest"] = address_of(
                KnownTypes(furthest_motion), kernel_results.REAL, lambda: (loads.tables, 0.0, 1.0)
            )
        if carried:
            kernels["carry"] = _of_carrying(given)
        kernels |= find_own(own_kernels(integrator), loop)
        if renews:
            kernels |= _of_jacobians(integrator, given, renewal)
        found = _known[key] = NOWHERE._replace(**kernels)
    return found


def _renews(integrator: Radau) -> bool:
    """Return whether compiled code can renew Jacobians, see :class:`.Renewal`."""
    return isinstance(integrator.system, GeometricSystem)


def _of_attempts(integrator: Radau, model: LoopModel, given: LoopState) -> dict[str, int]:
    """Return where a step is predicted, taken and judged."""
    body, tableau, stages = integrator.body, integrator.tableau, integrator.stages
    now, old, h = given.now, given.last, 1.0
    sides = now.r, now.q, body.split, body.held
    last = LastStep(h, h, old.r, old.q, old.twist, given.kept.X, given.stress)
    into = given.weights, stages.X, given.stages_stress
    return {
        "step": address_of(integrator.trying, kernel_results.ATTEMPTED, lambda: integrator.step_arguments(h)),
        "predict": address_of(
            integrator.predictor.extrapolation,
            kernel_results.NOTHING,
            lambda: (tableau, model.gap, last, h, *sides, *into),
        ),
        "place": address_of(integrator.placing, kernel_results.NOTHING, lambda: integrator.step_arguments(h)),
        "turn": address_of(integrator.turned, kernel_results.TURNED, lambda: (stages.X[0],)),
        "extent": address_of(
            KnownTypes(motion_extent),
            kernel_results.EXTENT,
            lambda: (now.r, now.q, stages.r[0], stages.q[0], stages.twist[0], h),
        ),
    }


def _of_carrying(given: LoopState) -> int:
    """Return where the kernel is that carries poses along with a support."""
    now, begun = given.now, given.follows
    where = begun.r, begun.q, now.r, now.q, now.twist
    into = begun.carried_r, begun.carried_q, begun.relative_twist
    return address_of(KnownTypes(carry_along), kernel_results.NOTHING, lambda: (begun.carrier, *where, *into))


def _of_systems(integrator: Radau, systems: LoopSystems) -> dict[str, int]:
    """Return where matrices are made and factorised."""
    own, body, mu = integrator.systems, integrator.body, 1.0
    K, C, mass, _, directions, _ = integrator.matrices
    complex_K = K if integrator.dashpots is None else integrator.dashpots.pair.blocks
    real, pairs, real_rows, pair_rows, scales = own.factors
    where, places = (body.supports, directions, body.pattern, scales), own.real.places
    return {
        "reduce_real": address_of(
            own.real.reduction,
            kernel_results.NUMBER,
            lambda: (systems.real, *places, *_factored(real)),
        ),
        "reduce_pair": address_of(
            own.pairs.reduction,
            kernel_results.NUMBER,
            lambda: (systems.pairs[0], *places, *_factored(_first(pairs))),
        ),
        "combine_real": address_of(
            own.combination,
            kernel_results.NOTHING,
            lambda: (K, C, mass, mu, *where, real_rows, systems.real),
        ),
        "combine_pair": address_of(
            own.pair_combination,
            kernel_results.NOTHING,
            lambda: (complex_K, C, mass, complex(mu), *where, pair_rows[0], systems.pairs[0]),
        ),
    }


def _of_records(integrator: Radau, model: LoopModel, given: LoopState, states: Between) -> dict[str, int]:
    """Return where ends of steps are read, and states within."""
    tableau, stages, account, now = integrator.tableau, integrator.stages, integrator.account, given.now
    reading, target, recorder, h = model.reading, integrator.actions.motion.target, integrator.recorder, 1.0
    begin = ResultFields(given.points[0], given.reactions[0])
    reached = MovingPoses(now.r, now.q, now.twist, given.end.rate)
    fields = stages.twist, stages.strain, stages.strain_rate, stages.stress
    at_stages = StageFields(*fields, given.end.reactions, account.powers)
    step = h, tableau, given.last, reached, begin, at_stages, h, reading
    found = {}
    if len(tableau.exact_inside):
        into = (stages.r, stages.q, stages.twist), 0, 0, (states.r, states.q, states.twist)
        found["go_through"] = address_of(
            recorder.correction, kernel_results.NOTHING, lambda: (np.zeros(1), tableau, *into)
        )
    return found | {
        "end": address_of(
            recorder.ending,
            kernel_results.ENDED,
            lambda: (h, tableau, stages, account, target, reading, given.kept, given.end),
        ),
        "between": address_of(
            recorder.reading_between,
            kernel_results.NOTHING,
            lambda: (np.zeros(1), *step, True, True, states),
        ),
    }


def _of_branches(integrator: Radau) -> dict[str, int]:
    """Return where the kernels of Maxwell branches are, if there are any."""
    dashpots = integrator.dashpots
    if dashpots is None:
        return {}
    points, number = len(dashpots.places), len(dashpots.step.times)
    rows, tableau = BranchRows.of(1, points, number), integrator.tableau
    given, parts = dashpots.stiffen_arguments(integrator.matrices), np.zeros(1)

    def address(kernel: KnownTypes, *arguments: object) -> int:
        return address_of(kernel, kernel_results.NOTHING, lambda: arguments)

    through = tableau.values, tableau.integrals
    return {
        "stiffen_real": address(dashpots.stiffen_real, 1.0, *given, dashpots.real),
        "stiffen_pair": address(dashpots.stiffen_pair, 1j, *given, dashpots.pair),
        "begin_branches": address(dashpots.begin, *dashpots.begin_arguments(1.0)),
        "keep_branches": address(
            dashpots.keep, tableau.weights, integrator.stages.strain, dashpots.step, dashpots.own
        ),
        "read_branches": address(dashpots.read, 0, *dashpots.reading, rows),
        "read_within": address(dashpots.within, parts, 0, *through, *dashpots.reading, rows),
    }


def _of_supports(integrator: Radau, model: LoopModel, given: LoopState) -> dict[str, int]:
    """Return where the kernels of supports are that move, or that hold nodes in part."""
    body, motion, now, found = integrator.body, integrator.actions.motion, given.now, {}
    held, axes = body.supports, (body.supports.axes, body.supports.r0, body.supports.q0)
    last = motion.target[-1], motion.rate[-1]
    if integrator.supports.moving:
        into = motion.r[0], motion.q[0], motion.twist[0], motion.twist_rate[0]
        found["prescribe"] = address_of(
            KnownTypes(prescribed_motion),
            kernel_results.NOTHING,
            lambda: (*axes, *last, np.zeros_like(last[0]), *into),
        )
    if len(integrator.supports.partial):
        where = now.r, now.q, model.reading.directions, now.twist
        found["project_twists"] = address_of(
            KnownTypes(project_twists),
            kernel_results.NOTHING,
            lambda: (held, model.held.rows, *last, model.held.turning, *where),
        )
        if integrator.supports.moving:
            scratch = model.reading.directions, model.held.change
            given_rows = held, model.held.rows, model.held.target
            found["correct"] = address_of(
                KnownTypes(correct_poses),
                kernel_results.NOTHING,
                lambda: (*given_rows, now.r, now.q, *scratch),
            )
        found["kinetic"] = address_of(
            KnownTypes(kinetic_energy), kernel_results.REAL, lambda: (body.mass, now.twist)
        )
    return found


def _of_links(
    integrator: Radau,
    given: LoopState,
    states: Between,
    known: Renewal,
    links: LoopLinks,
) -> dict[str, int]:
    """Return where the kernels of joints, springs and held strains are, if there are any."""
    own, problem, found = integrator.stage_constraints, integrator.system.problem, {}
    if own is None:
        return {}
    now, arrays, out, rows, start = given.now, own.arrays, known.out, links.rows, links.start
    unit, elements = 1.0, integrator.body.elements

    def address(kernel: Callable[..., object], *arguments: object) -> int:
        return address_of(KnownTypes(kernel), kernel_results.NOTHING, lambda: arguments)

    if problem.joints.count:
        alone = links.alone, start.r, start.q, start.twist, links.force
        found["joint_forces"] = address(joint_forces, arrays.joints, links.laws, *alone)
        slopes = JointSlopes(links.alone.near, links.alone.force[0], links.stiffness, links.damping)
        into = arrays.scale, out.blocks, out.rate_blocks, arrays.operators
        where = arrays.joints, now.r, now.q, now.twist, slopes, known.ad
        found["joint_tangent"] = address(add_joint_tangent, *where, unit, unit, *into)
    if len(problem.held.place):
        held = arrays.held, elements.order, unit, unit, integrator.matrices.operators.strain
        found["hold_strains"] = address(add_held_strains, *held, arrays.scale, out.blocks)
    wanted = Wanted(rows.target, rows.target_rate, rows.near)
    closed = Closed(states.r, states.q, states.twist, rows.value, rows.rate)
    shared = own.closed_states.share(integrator.systems).argument
    found["close"] = address_of(
        own.closed_states.closing, kernel_results.REAL, lambda: (shared, wanted, closed, 0, 1, True, True)
    )
    return found


def _of_jacobians(integrator: Radau, given: LoopState, known: Renewal) -> dict[str, int]:
    """Return where the kernels are that renew a Jacobian."""
    system, task = integrator.system, integrator.task
    assert isinstance(system, GeometricSystem)
    body, now, loads, out = integrator.body, given.now, task.loads, known.out
    matrices, mass, diagonal = task.matrices, body.mass, body.pattern.diagonal
    elements = known.elements, system.groups[0], known.fields
    acting = loads.dead[0], loads.following[0], loads.gravity[0], loads.levers[0], mass
    inertia = mass, now.twist, known.ad, out.blocks, out.rate_blocks, diagonal, matrices.adjoint
    held = body.supports, known.target, given.kept.reaction, now.r, now.q, body.pattern
    into = out.blocks, out.rate_blocks, matrices.mass, matrices.directions, known.square[0]
    assembly, collection = system.tangent_kernels

    def address(kernel: KnownTypes, *arguments: object) -> int:
        return address_of(kernel, kernel_results.NOTHING, lambda: arguments)

    pulled = body.loaded, now.q, *acting, True, known.external, out.blocks, diagonal
    found = {}
    if len(loads.motion.nodes):
        moved = loads.motion, loads.motion_factors[0], now.r, now.q, now.twist, known.external
        tangent = MotionTangent(known.ad, out.blocks, out.rate_blocks, diagonal)
        found["add_moving"] = address_of(
            KnownTypes(add_motion_loads), kernel_results.REAL, lambda: (*moved, tangent, loads.motion_work)
        )
    return found | {
        "adjoint": address(integrator.adjoints, now.twist, known.ad),
        "assemble": address(assembly, *elements, now.r, now.q, now.twist, True, known.ad, True, out),
        "collect": address(collection, *elements, matrices.operators),
        "add_loads": address(KnownTypes(add_nodal_loads), *pulled),
        "add_inertia": address(integrator.inertia_terms, *inertia, known.square),
        "project": address(integrator.projection, *held, *into),
    }


def _factored(factors: Factors) -> tuple[object, ...]:
    """Return what a factorisation takes of factors."""
    return factors.values, factors.fronts, factors.integers, factors.groups, factors.rest


def _first(factors: Factors) -> Factors:
    """Return the factors of the first matrix of a stack."""
    values, fronts, vector, integers, rows, groups, members, rest = factors
    return Factors(values[0], fronts[0], vector, integers[0], rows, groups, members, rest[0])
