"""A collocation step in one compiled call: place, respond, hold, load, balance, solve, move, judge, estimate, account.

The stages of a step are coupled (see ``stage_kernels`` for their equations). An iteration places all nodes, lets the
material respond, holds joints, loads, and balances; the imbalance goes through the linear systems of the method
into changes of all stages, which move the nodes and carry the stresses along (simplified Newton iteration, Hairer and
Wanner 1996, IV.8; stresses as iterates of their own, see ``collocation``). The last evaluation, with the stresses that
belong to the poses, is the step.

Parts that a model may lack are None, and the compiled code has nothing of them then: ``ends`` of the midpoint rule,
``strains`` of the intrinsic formulation, ``links`` (joints, springs and held strains), ``branches`` (Maxwell).
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import kernel, lane_kernel
from viscorod.mechanics.elements.held_strains import give_stress, keep_stress, strain_gaps
from viscorod.mechanics.elements.internal_force import (
    Elements,
    GaussStates,
    conserve_energy,
    energies,
    internal_forces,
)
from viscorod.mechanics.elements.intrinsic_element import StrainMotion, stage_forces
from viscorod.mechanics.elements.linearised import add_frozen_forces, carry_stress
from viscorod.mechanics.elements.maxwell_branches import (
    MaxwellArrays,
    add_branch_error,
    add_branch_forces,
    branch_energies,
    carry_branches,
    lacking_work,
    stretch_springs,
)
from viscorod.mechanics.elements.rest_strains import actuator_powers, deduct_rest, shift
from viscorod.mechanics.elements.section_laws import add_lacking_work
from viscorod.mechanics.joints.joint_forces import add_frozen_springs, carry_springs, hold_coordinates
from viscorod.mechanics.nodes.inertia import balance
from viscorod.mechanics.nodes.support_rows import in_body, lacking_motion, support_directions
from viscorod.mechanics.rotations.nodal_motion import move_stages, place_stages
from viscorod.solve.linear.substitution import solve, solve_each
from viscorod.solve.transient.integrators.constraint_arrays import (
    GAP,
    ConstraintArrays,
    add_gaps,
    add_motors,
    end_gaps,
    largest_gap,
    move_multipliers,
)
from viscorod.solve.transient.integrators.iteration_verdict import CONVERGED, GOING, SLOW, judge
from viscorod.solve.transient.integrators.midpoint_end import hold_ends, place_end, strains_at_end
from viscorod.solve.transient.integrators.stage_data import (
    Discretisation,
    Ends,
    IterationLimits,
    Matrices,
    StageFactors,
    StageLoads,
    Stages,
    StepAccount,
    StepParts,
    StepStart,
    SupportMotion,
    Work,
)
from viscorod.solve.transient.integrators.stage_kernels import (
    add,
    clear,
    clear_held,
    differentiate,
    evaluate_loads,
    held_power,
    impose,
    place_held_nodes,
    to_changes,
    to_modes,
)
from viscorod.solve.transient.integrators.step_error import (
    estimate_error,
    largest_error,
    project_free,
    scale_free,
)
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats


@kernel
def largest_turn(X: Floats) -> tuple[float, int]:
    """Return the largest rotation [rad] of coordinates ``(n, 6)``, and its node."""
    largest, node = 0.0, 0
    for k in range(X.shape[0]):
        square = X[k, 3] * X[k, 3] + X[k, 4] * X[k, 4] + X[k, 5] * X[k, 5]
        if square > largest:
            largest, node = square, k
    return math.sqrt(largest), node


@kernel
def try_step(
    body: Discretisation,
    method: Tableau,
    start: StepStart,
    h: float,
    motion: SupportMotion,
    loads: StageLoads,
    parts: StepParts,
    limits: IterationLimits,
    ends: Ends | None,
    strains: StrainMotion | None,
    links: ConstraintArrays | None,
    branches: MaxwellArrays | None,
) -> tuple[int, int, float, float, int, float, int]:
    """Iterate until the estimated error of the stage coordinates is small enough; evaluate the result.

    If that succeeds, estimate the error and take account of the energy.

    Args:
        h: step [s]; motion, loads: of supports and loads at its stages.
        parts: state of the stages, matrices and their factors, the account of the step, and scratch.

    Returns:
        code, iterations, size of the last change, convergence rate, unknown of the largest change, size and unknown
        of the largest error.
    """
    factors, matrices, stages, account, work = parts
    points = GaussStates(stages.strain, stages.strain_rate, stages.section_force, stages.stress)
    last = size = 0.0
    rate = limits.rate**0.8  # trusted less with every step that does not confirm it
    unknown = count = 0
    code = GOING
    while True:
        final = code == CONVERGED
        place(body, method, start, h, motion, stages, work, ends)
        respond(body.elements, method, h, stages, points, work, ends, strains, links, branches)
        hold(links, ends, stages, points, final)
        evaluate_loads(
            body.loaded,
            body.mass,
            body.pattern.diagonal,
            body.elements,
            loads,
            stages,
            work.no_blocks,
        )
        balance(
            body.mass,
            stages.twist,
            stages.acceleration,
            stages.internal,
            stages.external,
            stages.force,
            stages.residual,
        )
        if final and gaps_are_open(links, count, limits):
            code, final = GOING, False
        support(body, motion, stages, work, links, ends, final)
        if not final:
            freeze(body, matrices, stages, points, work, links)
        clear_held(body.held, stages.residual)
        if ends is not None:
            hold_ends(
                body.supports,
                motion.target,
                ends,
                work.vector,
                work.reaction,
                work.directions,
                stages.residual,
            )
        if final or count == limits.iterations:
            break
        size, unknown = solve_stages(body, method, factors, stages, work)
        count += 1
        code, rate = judge(count, limits.iterations, size, last, rate, limits.tolerance)
        if code not in (CONVERGED, GOING):
            break
        move(body, method, h, matrices, stages, points, work, links, branches)
        last = size
    largest, worst = 0.0, 0
    if code == CONVERGED:
        if branches is not None:
            stretch_springs(body.elements, branches, stages.strain)
        largest, worst = estimate(body, method, start, h, matrices, factors, stages, account, work, branches)
        take_account(body, motion, stages, account, work, links, branches)
    elif code == GOING:
        code = SLOW
    return code, count, size, rate, unknown, largest, worst


@lane_kernel
def place(
    body: Discretisation,
    method: Tableau,
    start: StepStart,
    h: float,
    motion: SupportMotion,
    stages: Stages,
    work: Work,
    ends: Ends | None,
) -> None:
    """Put all nodes where their coordinates and the supports say, at all stages."""
    X, r, q, twist, acceleration = stages[:5]
    nodes = body.supports.nodes
    place_stages(
        start.r,
        start.q,
        start.twist,
        X,
        method.derivative,
        h,
        body.split,
        body.held,
        r,
        q,
        twist,
        acceleration,
    )
    lacking_motion(body.supports, method.matrix, h, motion.rate, twist, motion.target)
    place_held_nodes(nodes, body.complete, motion, r, q, twist, acceleration)
    if ends is not None:
        place_end(body, motion, start, X, work.change[0], work.rate[0], ends)


@lane_kernel
def respond(
    elements: Elements,
    method: Tableau,
    h: float,
    stages: Stages,
    points: GaussStates,
    work: Work,
    ends: Ends | None,
    strains: StrainMotion | None,
    links: ConstraintArrays | None,
    branches: MaxwellArrays | None,
) -> None:
    """Evaluate strains and section forces at all stages, and the nodal forces of the stresses."""
    if links is not None:
        give_stress(links.held, links.states.multiplier, points.stress)
    if strains is None:
        internal_forces(elements, stages.r, stages.q, stages.twist, points, work.element, stages.internal)
        if stages.rest.shape[0] > 0:
            deduct_rest(elements, stages.rest, stages.rest_rate, points)
    else:
        stage_forces(elements, strains, method.derivative, h, stages.twist, points, stages.internal)
    if branches is not None:
        add_branch_forces(elements, branches, points.strain, points.section_force)
    if ends is not None and strains is None:
        conserve(elements, h, points, work, ends, branches)
    if links is not None:
        if ends is not None and strains is not None:
            strains_at_end(strains.start, points.strain, ends.strain)
        keep_stress(links.held, points.stress, points.section_force)


@lane_kernel
def conserve(
    elements: Elements,
    h: float,
    points: GaussStates,
    work: Work,
    ends: Ends,
    branches: MaxwellArrays | None,
) -> None:
    """Let the section forces do the work that elastic energy changes by from one end of the step to the other."""
    end_points = GaussStates(ends.strain, ends.strain_rate, ends.section_force, ends.section_force)
    internal_forces(elements, ends.r, ends.q, ends.twist, end_points, work.element, ends.force)
    shift(-1.0, ends.rest, ends.strain)
    if branches is not None:
        stretch_springs(elements, branches, points.strain)
        lacking_work(elements, branches, points.strain_rate, ends.start_strain, ends.strain, h, ends.defect)
    if elements.laws.present:
        if branches is None:
            ends.defect.fill(0.0)
        middle = points.strain, points.strain_rate
        add_lacking_work(
            elements.laws,
            elements.order,
            elements.section,
            middle,
            ends.start_strain,
            ends.strain,
            h,
            ends.defect,
        )
    conserve_energy(
        elements,
        points.strain,
        points.strain_rate,
        ends.start_strain,
        ends.strain,
        h,
        ends.defect,
        points.section_force,
    )


@lane_kernel
def hold(
    links: ConstraintArrays | None, ends: Ends | None, stages: Stages, points: GaussStates, final: bool
) -> None:
    """Add the forces of joints and springs, and measure what is to be held."""
    if links is not None:
        strain_gaps(links.held, points.strain, links.states.gap)
        hold_coordinates(
            links.joints, links.laws, links.states, final, stages.r, stages.q, stages.twist, stages.internal
        )
        if ends is not None:
            end_gaps(links, ends.r, ends.q, ends.strain)


@lane_kernel
def gaps_are_open(links: ConstraintArrays | None, count: int, limits: IterationLimits) -> bool:
    """Return whether anything that is held is too far off, and there are iterations left."""
    if links is not None:
        return count < limits.iterations and largest_gap(links.states.gap, links.unit) > GAP
    return False


@lane_kernel
def support(
    body: Discretisation,
    motion: SupportMotion,
    stages: Stages,
    work: Work,
    links: ConstraintArrays | None,
    ends: Ends | None,
    final: bool,
) -> None:
    """Put the conditions of supports and links into their rows of the residuals; keep reactions."""
    nodes = body.supports.nodes
    if links is not None:
        # by the midpoint rule half of what is defect at the end is defect in the middle
        factor = 1.0 if ends is None else 0.5
        add_gaps(links.states.gap, links.scale, factor, body.mass.shape[0], stages.residual)
    if final:
        held_power(nodes, body.complete, stages.residual, stages.twist, stages.held_power)
    if final or body.partly:
        impose(
            body.supports,
            motion.target,
            stages.r,
            stages.q,
            stages.residual,
            stages.reaction,
            work.directions,
        )


@lane_kernel
def freeze(
    body: Discretisation,
    matrices: Matrices,
    stages: Stages,
    points: GaussStates,
    work: Work,
    links: ConstraintArrays | None,
) -> None:
    """Add what section forces and springs differ from their iterates by, through the frozen operators.

    It is projected as the Jacobian is: what stiff sections add here dwarfs all other forces.
    """
    internal = stages.internal
    clear(internal)
    add_frozen_forces(body.elements, matrices.operators.strain, points.section_force, points.stress, internal)
    if links is not None:
        add_frozen_springs(links.joints, links.operators, links.states, internal)
    if body.partly:
        for i in range(internal.shape[0]):
            project_free(body.supports, matrices.directions.Z, work.vector, internal[i])
    add(internal, stages.residual)


@lane_kernel
def solve_stages(
    body: Discretisation, method: Tableau, factors: StageFactors, stages: Stages, work: Work
) -> tuple[float, int]:
    """Solve for the changes of all stages, which take the place of the residual; return the largest and its unknown."""
    residual = stages.residual
    to_modes(residual, method.to_modes, factors.real_rows, factors.pair_rows, work.real, work.pairs)
    solve(factors.real, work.real)
    solve_each(factors.pairs, work.pairs)
    return to_changes(
        work.real, work.pairs, method.to_stages, factors.scales, body.held, body.length, residual
    )


@lane_kernel
def move(
    body: Discretisation,
    method: Tableau,
    h: float,
    matrices: Matrices,
    stages: Stages,
    points: GaussStates,
    work: Work,
    links: ConstraintArrays | None,
    branches: MaxwellArrays | None,
) -> None:
    """Move the nodes by the changes, and carry stresses, springs and multipliers along."""
    change, rates, operators = stages.residual, work.rates, matrices.operators
    move_stages(stages.X, change, body.split, body.held)
    differentiate(method.derivative, h, change, rates)
    carry_stress(
        body.elements,
        operators.force,
        operators.viscous,
        change,
        rates,
        points.section_force,
        points.stress,
    )
    if branches is not None:
        carry_branches(body.elements, branches, operators.strain, change, points.stress)
    if links is not None:
        move_multipliers(change, links.scale, body.mass.shape[0], links.states.multiplier)
        carry_springs(links.joints, links.operators, change, rates, links.states)


@lane_kernel
def estimate(
    body: Discretisation,
    method: Tableau,
    start: StepStart,
    h: float,
    matrices: Matrices,
    factors: StageFactors,
    stages: Stages,
    account: StepAccount,
    work: Work,
    branches: MaxwellArrays | None,
) -> tuple[float, int]:
    """Estimate the error of the step by the embedded method; return its size and the unknown where it is largest."""
    if stages.X.shape[0] == 1:
        return 0.0, 0
    error, internal = account.error, stages.internal
    estimate_error(body, start, h, method, matrices, stages, work, error)
    if branches is not None:
        clear(internal)
        add_branch_error(
            body.elements,
            branches,
            stages.strain,
            matrices.operators.strain,
            method.error,
            method.real / h,
            h,
            internal[0],
        )
        project_free(body.supports, matrices.directions.Z, work.change, internal[0])
        for k in range(error.shape[0]):
            for i in range(6):
                error[k, i] += internal[0, k, i]
    scale_free(body.supports.nodes, body.supports.fixed, factors.real_rows, error, work.real)
    solve(factors.real, work.real)
    return largest_error(factors.scales, work.real, body.length, error)


@lane_kernel
def take_account(
    body: Discretisation,
    motion: SupportMotion,
    stages: Stages,
    account: StepAccount,
    work: Work,
    links: ConstraintArrays | None,
    branches: MaxwellArrays | None,
) -> None:
    """Write the powers of loads, supports, motors, viscosity and rest strains, and the elastic energy, at all stages.

    What loads dissipate outside is a loss of its own, not work that they take from the model.
    """
    powers, elastic = account.powers, account.elastic
    add_powers(body, motion, stages, work, powers[0])
    for i in range(elastic.shape[0]):
        powers[2, i] = stages.dissipated[i]
        powers[0, i] += powers[2, i]
    energies(body.elements, stages.strain, stages.strain_rate, elastic, powers[1])
    actuator_powers(body.elements, stages.rest_rate, stages.stress, powers[3])
    if branches is not None:
        branch_energies(body.elements, branches, elastic, powers[1])
    if links is not None:
        add_motors(links, powers[0])
        for i in range(elastic.shape[0]):
            elastic[i] += links.states.energy[i]
            powers[1, i] += links.states.power[i]


@lane_kernel
def add_powers(
    body: Discretisation, motion: SupportMotion, stages: Stages, work: Work, power: Floats
) -> None:
    """Write the powers ``(s,)`` [W] of loads and of supports at all stages.

    Supports: those of completely held nodes are known; of the others, reactions times rates of displacements. How fast
    their rotations change follows from the twists.
    """
    supports, directions = body.supports, work.directions
    nodes, fixed, axes = supports[:3]
    twist, external, reaction = stages.twist, stages.external, stages.reaction
    for i in range(twist.shape[0]):
        power[i] = stages.held_power[i]
        for k in range(twist.shape[1]):
            for a in range(6):
                power[i] += external[i, k, a] * twist[i, k, a]
        for m in range(nodes.shape[0]):
            if body.complete[m] == 0.0:
                k = nodes[m]
                target = motion.target[i]
                support_directions(supports, m, target, stages.r[i], stages.q[i], m, directions)
                for a in range(6):
                    speed = motion.rate[i, m, a]
                    if a >= 3 and not in_body(axes[m]):
                        speed = 0.0
                        for b in range(3, 6):
                            speed += directions.G[m, a, b] * twist[i, k, b]
                    power[i] += fixed[m, a] * reaction[i, m, a] * speed
