"""A collocation step in one compiled call, with its powers, energies and estimated error."""

from __future__ import annotations

import math

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.held_strains import give_stress, keep_stress, strain_gaps
from viscorod.mechanics.elements.internal_force import GaussStates, conserve_energy, energies, internal_forces
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
from viscorod.mechanics.joints.joint_forces import add_frozen_springs, carry_springs, hold_coordinates
from viscorod.mechanics.nodes.inertia import balance
from viscorod.mechanics.nodes.support_rows import in_body, lacking_motion, support_directions
from viscorod.mechanics.rotations.nodal_motion import move_stages, place_stages
from viscorod.solve.linear.substitution import solve
from viscorod.solve.transient.integrators import stage_kernels
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
from viscorod.solve.transient.integrators.midpoint_end import hold_ends, place_end
from viscorod.solve.transient.integrators.stage_data import (
    Discretisation,
    Ends,
    Matrices,
    StageFactors,
    StageInputs,
    Stages,
    Work,
)
from viscorod.solve.transient.integrators.step_error import (
    estimate_error,
    largest_error,
    project_free,
    scale_free,
)
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers


@part
def add_powers(
    nodes: Integers,
    fixed: Floats,
    axes: Floats,
    r0: Floats,
    q0: Floats,
    complete: Floats,
    target: Floats,
    r: Floats,
    q: Floats,
    external: Floats,
    twist: Floats,
    held_power: Floats,
    reaction: Floats,
    rate: Floats,
    G: Floats,
    Z: Floats,
    power: Floats,
) -> None:
    """Write the powers ``(s,)`` [W] of loads ``external (s, n, 6)`` and of supports at all stages.

    Supports: ``held_power (s,)`` of completely held nodes; of the others ``reaction (s, m, 6)`` and, of displacements,
    ``rate (s, m, 6)``. How fast their rotations change follows from the twists; ``G, Z (m, 6, 6)`` are scratch.
    """
    value = np.empty(6)
    psi = np.empty(3)
    for i in range(twist.shape[0]):
        power[i] = held_power[i]
        for k in range(twist.shape[1]):
            for a in range(6):
                power[i] += external[i, k, a] * twist[i, k, a]
        for m in range(nodes.shape[0]):
            if complete[m] == 0.0:
                k = nodes[m]
                support_directions(
                    axes[m], r0[m], q0[m], fixed[m], target[i, m], r[i, k], q[i, k], value, G[m], Z[m], psi
                )
                for a in range(6):
                    speed = rate[i, m, a]
                    if a >= 3 and not in_body(axes[m]):
                        speed = 0.0
                        for b in range(3, 6):
                            speed += G[m, a, b] * twist[i, k, b]
                    power[i] += fixed[m, a] * reaction[i, m, a] * speed


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
    given: StageInputs,
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    force0: Floats,
    h: float,
    tableau: Tableau,
    factors: StageFactors,
    matrices: Matrices,
    stages: Stages,
    ends: Ends | None,
    work: Work,
    motion: StrainMotion | None,
    links: ConstraintArrays | None,
    relaxing: MaxwellArrays | None,
    tolerance: float,
    limit: int,
    known_rate: float,
    powers: Floats,
    elastic: Floats,
    error: Floats,
) -> tuple[int, int, float, float, int, float, int]:
    """Iterate until the estimated error of the stage coordinates is below ``tolerance``; evaluate the result.

    If that succeeds, estimate the error and take account of the energy.

    Args:
        ends: for the midpoint rule; None for the others, whose compiled code leaves this part out.
        motion: strains as states of their own (intrinsic formulation); None: they follow from the poses.
        links: joints, springs and held strains; relaxing: Maxwell branches; None: there are none.
        r0, q0, twist0: start of the step; force0: what accelerates the nodes there ``(n, 6)``; h: step [s].
        tolerance: displacement over length, or rotation [rad]; limit: allowed iterations.
        known_rate: convergence rate of the last step, trusted in the first iteration (1 if unknown).
        powers: output, of loads and viscosity at all stages ``(2, s)`` [W]; elastic: energies there ``(s,)`` [J].
        error: output, the estimated error ``(n, 6)``.

    Returns:
        code, iterations, size of the last change, convergence rate, unknown of the largest change, size and unknown
        of the largest error.
    """
    # all tuples are unpacked here: reading a member further down copies the whole tuple
    (
        elements,
        mass,
        held,
        split,
        nodes,
        fixed,
        axes,
        support_r,
        support_q,
        complete,
        partly,
        loaded,
        length,
        pattern,
    ) = body
    block_rows, block_columns, diagonal = pattern[0], pattern[1], pattern[4]
    target, rate_target, given_r, given_q, given_twist, given_rate = given[:6]
    acting, dead, following, gravity, levers, at_element, shape, point_dead, point_following = given[6:15]
    end_r, end_q = given[15:]
    X, r, q, twist, acceleration, internal, external, force, residual, reaction = stages[:10]
    strain, strain_rate, S, sigma, held_power = stages[10:]
    A_tableau, D, T, T_inverse, eigenvalue, weights = (
        tableau[2],
        tableau[3],
        tableau[4],
        tableau[5],
        tableau[6],
        tableau[8],
    )
    real_factors, pair_factors, real_rows, pair_rows, scales = factors
    C, adjoint, free_directions = matrices[1], matrices[3], matrices[5]
    B, A, P = matrices[6]
    scratch, right, pair_right, rates, rate, vector, change, end_reaction, G, Z, psi, no_blocks = work
    order, element_nodes, element_links, link_positions, link_quaternions = elements[:5]
    section, slots = elements[9], elements[14]
    points = GaussStates(strain, strain_rate, S, sigma)
    several = X.shape[0] > 1
    count_nodes = mass.shape[0]
    if links is not None:
        joint_nodes, kind, geometry, place, stiffness, damping, rest, law = links[:8]
        at_strain, at_point, at_component, strain_place, point_weight = links[8:13]
        address, buffer, near, gradients, joint_A, joint_P, link_scale, unit = links[13:21]
        link_target, link_rate_target, link_end, multiplier, carried = links[21:26]
        link_value, link_rate, link_force, link_energy, link_power, gap, gradient = links[26:]
    if relaxing is not None:
        times, branches, factor, coupling, dashpot, past, start_strain, spring, lost, strain_change = relaxing
    last = size = 0.0
    convergence = known_rate**0.8  # trusted less with every step that does not confirm it
    unknown = count = 0
    code = GOING
    while True:
        final = code == CONVERGED
        place_stages(r0, q0, twist0, X, D, h, split, held, r, q, twist, acceleration)
        lacking_motion(nodes, fixed, axes, A_tableau, h, rate_target, twist, target)
        stage_kernels.place_held_nodes(
            nodes, complete, given_r, given_q, given_twist, given_rate, r, q, twist, acceleration
        )
        if ends is not None:
            r1, q1, twist1, strain1, strain_rate1, S1, strain0, force1, defect = ends
            place_end(
                r0, q0, X, split, held, nodes, complete, end_r, end_q, change[0], rate[0], r1, q1, twist1
            )
        if links is not None:
            give_stress(at_strain, at_point, at_component, strain_place, point_weight, multiplier, sigma)
        if motion is None:
            internal_forces(elements, r, q, twist, points, scratch, internal)
            if relaxing is not None:
                add_branch_forces(order, section, coupling, past, strain, S)
            if ends is not None:
                points1 = GaussStates(strain1, strain_rate1, S1, S1)
                internal_forces(elements, r1, q1, twist1, points1, scratch, force1)
                if relaxing is not None:
                    stretch_springs(order, factor, dashpot, strain, spring)
                    lacking_work(
                        order,
                        section,
                        times,
                        branches,
                        dashpot,
                        spring,
                        strain_rate,
                        strain0,
                        strain1,
                        h,
                        defect,
                    )
                conserve_energy(elements, strain, strain_rate, strain0, strain1, h, defect, S)
        else:
            linearised, start, at_points, linear_rate, T_e, F_e, matrix, side = motion
            stage_forces(
                elements,
                linearised,
                start,
                D,
                h,
                twist,
                at_points,
                linear_rate,
                T_e,
                F_e,
                matrix,
                side,
                strain,
                strain_rate,
                S,
                sigma,
                internal,
            )
            if relaxing is not None:
                add_branch_forces(order, section, coupling, past, strain, S)
        if links is not None:
            keep_stress(at_strain, at_point, at_component, sigma, S)
            strain_gaps(at_strain, at_point, at_component, strain_place, strain, gap)
            hold_coordinates(
                joint_nodes,
                kind,
                geometry,
                place,
                stiffness,
                damping,
                rest,
                law,
                address,
                buffer,
                near,
                link_target,
                multiplier,
                carried,
                final,
                r,
                q,
                twist,
                gradient,
                link_value,
                link_rate,
                link_force,
                link_energy,
                link_power,
                gap,
                internal,
            )
            if ends is not None:
                end_gaps(
                    joint_nodes,
                    kind,
                    geometry,
                    place,
                    at_strain,
                    at_point,
                    at_component,
                    strain_place,
                    near,
                    link_end,
                    r1,
                    q1,
                    strain1,
                    gradient,
                    gap,
                )
        stage_kernels.evaluate_loads(
            loaded,
            mass,
            acting,
            dead,
            following,
            gravity,
            levers,
            at_element,
            shape,
            point_dead,
            point_following,
            order,
            element_nodes,
            element_links,
            link_positions,
            link_quaternions,
            r,
            q,
            external,
            diagonal,
            slots,
            no_blocks,
        )
        balance(mass, twist, acceleration, internal, external, force, residual)
        if links is not None:
            # by the midpoint rule half of what is defect at the end is defect in the middle
            add_gaps(gap, link_scale, 1.0 if ends is None else 0.5, count_nodes, residual)
            if final and count < limit and largest_gap(gap, unit) > GAP:
                code, final = GOING, False
        if final:
            stage_kernels.held_power(nodes, complete, residual, twist, held_power)
        if final or partly:
            stage_kernels.impose(
                nodes, fixed, axes, support_r, support_q, target, r, q, residual, reaction, G, Z, psi
            )
        if not final:
            # projected as the Jacobian is: what stiff sections add here dwarfs all other forces
            stage_kernels.clear(internal)
            add_frozen_forces(elements, B, S, sigma, internal)
            if links is not None:
                add_frozen_springs(joint_nodes, place, gradients, link_force, carried, internal)
            if partly:
                for i in range(internal.shape[0]):
                    project_free(nodes, fixed, free_directions, vector, internal[i])
            stage_kernels.add(internal, residual)
        stage_kernels.clear_held(held, residual)
        if ends is not None:
            hold_ends(
                nodes,
                fixed,
                axes,
                support_r,
                support_q,
                target,
                r1,
                q1,
                vector,
                end_reaction,
                G,
                Z,
                psi,
                residual,
            )
        if final or count == limit:
            break
        stage_kernels.to_modes(residual, T_inverse, real_rows, pair_rows, right, pair_right)
        solve(real_factors, right)
        if several:
            solve(pair_factors, pair_right)
        # the residual is not needed any more: its place is taken by the changes
        size, unknown = stage_kernels.to_changes(right, pair_right, T, scales, held, length, residual)
        count += 1
        code, convergence = judge(count, limit, size, last, convergence, tolerance)
        if code not in (CONVERGED, GOING):
            break
        move_stages(X, residual, split, held)
        stage_kernels.differentiate(D, h, residual, rates)
        carry_stress(elements, A, P, residual, rates, S, sigma)
        if relaxing is not None:
            carry_branches(order, element_nodes, section, coupling, B, residual, strain_change, sigma)
        if links is not None:
            move_multipliers(residual, link_scale, count_nodes, multiplier)
            carry_springs(joint_nodes, place, joint_A, joint_P, residual, rates, link_force, carried)
        last = size
    largest, worst = 0.0, 0
    if code == CONVERGED:
        if relaxing is not None:
            stretch_springs(order, factor, dashpot, strain, spring)
        if several:
            estimate_error(
                X,
                twist,
                twist0,
                force0,
                h,
                eigenvalue,
                weights,
                held,
                mass,
                adjoint,
                nodes,
                fixed,
                free_directions,
                block_rows,
                block_columns,
                C,
                rate,
                vector,
                change,
                error,
            )
            if relaxing is not None:
                stage_kernels.clear(internal)
                add_branch_error(
                    elements,
                    times,
                    branches,
                    dashpot,
                    start_strain,
                    spring,
                    strain,
                    B,
                    weights,
                    eigenvalue / h,
                    h,
                    internal[0],
                )
                project_free(nodes, fixed, free_directions, change, internal[0])
                for k in range(count_nodes):
                    for i in range(6):
                        error[k, i] += internal[0, k, i]
            scale_free(nodes, fixed, real_rows, error, right)
            solve(real_factors, right)
            largest, worst = largest_error(scales, right, length, error)
        add_powers(
            nodes,
            fixed,
            axes,
            support_r,
            support_q,
            complete,
            target,
            r,
            q,
            external,
            twist,
            held_power,
            reaction,
            rate_target,
            G,
            Z,
            powers[0],
        )
        energies(elements, strain, strain_rate, elastic, powers[1])
        if relaxing is not None:
            branch_energies(elements, times, branches, spring, elastic, powers[1], lost)
        if links is not None:
            add_motors(place, link_force, link_rate_target, powers[0])
            for i in range(elastic.shape[0]):
                elastic[i] += link_energy[i]
                powers[1, i] += link_power[i]
    elif code == GOING:
        code = SLOW
    return code, count, size, convergence, unknown, largest, worst
