"""Where the kernels are that the compiled loop of steps calls."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.by_address import address_of
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.nodes.applied_loads import add_nodal_loads
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.mechanics.rotations.rotation import motion_extent
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.linear.factors import Factors
from viscorod.solve.transient.integrators import kernel_results
from viscorod.solve.transient.integrators.loop_data import (
    Addresses,
    LoopModel,
    LoopState,
    LoopSystems,
    Renewal,
)
from viscorod.solve.transient.integrators.predictor import LastStep
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.integrators.record_kernels import Between, ResultFields, StageFields

__all__ = ["find_addresses"]


def find_addresses(
    integrator: Radau,
    model: LoopModel,
    given: LoopState,
    systems: LoopSystems,
    states: Between,
    renewal: Renewal,
    renew: int,
    prepare: int,
) -> Addresses:
    """Return the addresses of all kernels, for the types of an integrator's arrays and of the loop's.

    Args:
        integrator: whose kernels these are; model, given, systems: what the loop works on; states: of its records.
        renewal: of Jacobians.
        renew, prepare: of Python's functions.
    """
    body, tableau, stages = integrator.body, integrator.tableau, integrator.stages
    K, C, mass, _, directions, _ = integrator.matrices
    real, pairs, real_rows, pair_rows, scales = integrator.systems.factors
    now, old, reading, found, h = given.now, given.last, model.reading, states, 1.0
    where = body.supports, directions, body.pattern, scales
    sides = now.r, now.q, body.split, body.held
    last = LastStep(h, old.r, old.q, old.twist, given.kept.X, given.stress)
    begin = ResultFields(given.points[0], given.reactions[0])
    account, target = integrator.account, integrator.actions.motion.target
    at_stages = StageFields(
        stages.twist,
        stages.strain,
        stages.strain_rate,
        stages.stress,
        given.end.reactions,
        account.powers,
    )
    reached = MovingPoses(now.r, now.q, now.twist, given.end.rate)
    places = integrator.systems.real.places
    return Addresses(
        address_of(integrator.trying, kernel_results.ATTEMPTED, lambda: integrator.step_arguments(h)),
        address_of(
            integrator.systems.real.reduction,
            kernel_results.NUMBER,
            lambda: (systems.real, *places, *_factored(real)),
        ),
        address_of(
            integrator.systems.pairs.reduction,
            kernel_results.NUMBER,
            lambda: (systems.pairs[0], *places, *_factored(_first(pairs))),
        ),
        address_of(
            integrator.systems.combination,
            kernel_results.NOTHING,
            lambda: (K, C, mass, h, *where, real_rows, systems.real),
        ),
        address_of(
            integrator.systems.pair_combination,
            kernel_results.NOTHING,
            lambda: (K, C, mass, complex(h), *where, pair_rows[0], systems.pairs[0]),
        ),
        address_of(
            integrator.predictor.extrapolation,
            kernel_results.NOTHING,
            lambda: (tableau, model.gap, last, h, *sides, given.weights, stages.X, given.stages_stress),
        ),
        address_of(integrator.turned, kernel_results.TURNED, lambda: (stages.X[0],)),
        address_of(
            KnownTypes(motion_extent),
            kernel_results.EXTENT,
            lambda: (now.r, now.q, stages.r[0], stages.q[0], stages.twist[0], h),
        ),
        address_of(
            integrator.recorder.ending,
            kernel_results.ENDED,
            lambda: (h, tableau, stages, account, target, reading, given.kept, given.end),
        ),
        address_of(
            integrator.recorder.reading_between,
            kernel_results.NOTHING,
            lambda: (
                np.zeros(1),
                h,
                tableau,
                old,
                reached,
                begin,
                at_stages,
                h,
                reading,
                True,
                True,
                found,
            ),
        ),
        *_renewing(integrator, model, given, renewal),
        renew,
        prepare,
        np.zeros(4),
    )


def _renewing(
    integrator: Radau, model: LoopModel, given: LoopState, known: Renewal
) -> tuple[int, int, int, int, int, int]:
    """Return where the kernels are that renew a Jacobian, 0 where Python does, see :class:`.Renewal`."""
    system = integrator.system
    if not isinstance(system, GeometricSystem) or len(system.groups) != 1 or integrator.supports.moving:
        return 0, 0, 0, 0, 0, 0
    body, now, loads, out = integrator.body, given.now, model.loads, known.out
    matrices, mass, diagonal = model.parts.matrices, integrator.body.mass, integrator.body.pattern.diagonal
    elements = known.elements, known.group, known.fields
    acting = loads.dead[0], loads.following[0], loads.gravity[0], loads.levers[0], mass
    inertia = mass, now.twist, known.ad, out.blocks, out.rate_blocks, diagonal, matrices.adjoint
    held = body.supports, known.target, given.kept.reaction, now.r, now.q, body.pattern
    into = out.blocks, out.rate_blocks, matrices.mass, matrices.directions, known.square[0]
    assembly, collection = system.tangent_kernels

    def address(kernel: KnownTypes, *arguments: object) -> int:
        return address_of(kernel, kernel_results.NOTHING, lambda: arguments)

    return (
        address(integrator.adjoints, now.twist, known.ad),
        address(assembly, *elements, now.r, now.q, now.twist, True, known.ad, True, out),
        address(collection, *elements, matrices.operators),
        address(
            KnownTypes(add_nodal_loads),
            body.loaded,
            now.q,
            *acting,
            True,
            known.external,
            out.blocks,
            diagonal,
        ),
        address(integrator.inertia_terms, *inertia, known.square),
        address(integrator.projection, *held, *into),
    )


def _factored(factors: Factors) -> tuple[object, ...]:
    """Return what a factorisation takes of factors."""
    return factors.values, factors.fronts, factors.integers, factors.groups, factors.rest


def _first(factors: Factors) -> Factors:
    """Return the factors of the first matrix of a stack."""
    values, fronts, vector, integers, rows, groups, members, rest = factors
    return Factors(values[0], fronts[0], vector, integers[0], rows, groups, members, rest[0])
