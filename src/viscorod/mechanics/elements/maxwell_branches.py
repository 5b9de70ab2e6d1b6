"""Generalised Maxwell rods: section forces with a memory, at the Gauss points.

Beside the stiffness C, each branch j has a stiffness ``C_j`` (symmetric, positive semi-definite) and a relaxation time
``tau_j``: a spring and a dashpot in series,

    S = C eps + D eps_t + sum_j C_j beta_j      beta_j = eps - alpha_j      tau_j alpha_j' = beta_j

with the strain ``alpha_j`` of the dashpot and ``beta_j`` of the spring. Branches store ``1/2 int beta_j.C_j beta_j``
and lose ``int beta_j.C_j beta_j/tau_j >= 0`` (proposed by Linn, Lang and Tuganov 2013; under a constant strain
the forces are those of a Prony series, ``C + sum C_j exp(-t/tau_j)``).

A collocation method with the matrix ``A`` solves the equations of the dashpots within the step exactly as it solves
those of motion, and they are linear: ``beta_j = F_j (eps - alpha_j0)`` at the stages, ``F_j = (1 + h/tau_j A)^-1``.
So the section forces of all stages are ``S_i = ... + sum_k E_ik eps_k - P_i`` with ``E_ik = sum_j (F_j)_ik C_j`` of
each section and the contribution of the past, ``P_i``, which is constant in the iteration: its cost does not grow with
the number of branches. For an eigenvector of ``A^-1`` with the eigenvalue ``lambda`` the branches are the complex
modulus at ``s = lambda/h``, ``sum_j C_j s tau_j/(1 + s tau_j)``, which the linear systems of a step contain.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.typing import Floats


class MaxwellArrays(NamedTuple):
    """Maxwell branches of all elements in a step of a collocation method; stages come first.

    Attributes:
        times: of relaxation ``(n,)`` [s]; branches: stiffnesses ``(sections, n, 6, 6)``.
        factor: ``F_j (n, s, s)``; coupling: ``E (sections, s, s, 6, 6)``.
        start: strains of the dashpots at the start ``(n, e, points, 6)``; past: ``P (s, e, points, 6)``.
        start_strain: of the sections at the start ``(e, points, 6)``.
        spring: strains of the springs ``(s, n, e, points, 6)``; power: lost by the branches ``(s, n)`` [W].
        change: scratch, changes of the strains ``(s, 6)``.
    """

    times: Floats
    branches: Floats
    factor: Floats
    coupling: Floats
    start: Floats
    past: Floats
    start_strain: Floats
    spring: Floats
    power: Floats
    change: Floats

    @classmethod
    def of(cls, elements: Elements, times: Floats, branches: Floats, stages: int) -> MaxwellArrays:
        """Allocate the arrays for a method with ``stages``."""
        points, n, s = elements.reference.shape, len(times), stages
        return cls(
            times,
            branches,
            np.zeros((n, s, s)),
            np.zeros((len(branches), s, s, 6, 6)),
            np.zeros((n, *points)),
            np.zeros((s, *points)),
            np.zeros(points),
            np.zeros((s, n, *points)),
            np.zeros((s, n)),
            np.zeros((s, 6)),
        )

    @classmethod
    def none(cls) -> MaxwellArrays:
        """Return those of a model without branches."""
        shapes: tuple[tuple[int, ...], ...] = (
            *((0,), (0, 0, 6, 6), (0, 0, 0), (0, 0, 0, 6, 6), (0, 0, 0, 6), (0, 0, 0, 6), (0, 0, 6)),
            *((0, 0, 0, 0, 6), (0, 0), (0, 6)),
        )
        return cls._make(map(np.zeros, shapes))


@part
def add_branch_forces(elements: Elements, branches: MaxwellArrays, strain: Floats, S: Floats) -> None:
    """Add the forces of the branches to the section forces ``(s, e, points, 6)`` of the stages."""
    orders, section, coupling, past = elements.order, elements.section, branches.coupling, branches.past
    stages = strain.shape[0]
    for e in range(orders.shape[0]):
        for g in range(orders[e]):
            of = section[e, g]
            for i in range(stages):
                for a in range(6):
                    total = -past[i, e, g, a]
                    for k in range(stages):
                        for b in range(6):
                            total += coupling[of, i, k, a, b] * strain[k, e, g, b]
                    S[i, e, g, a] += total


@part
def carry_branches(
    elements: Elements, branches: MaxwellArrays, B: Floats, change: Floats, stress: Floats
) -> None:
    """Update the stress ``(s, e, points, 6)`` of the branches by a change of all poses (see ``linearised``).

    Args:
        B: change of the strains per nodal increment ``(e, 6 points, 6 nodes)``.
        change: body increments of the nodes at all stages ``(s, n, 6)``.
    """
    orders, nodes, section = elements.order, elements.nodes, elements.section
    coupling, strain_change = branches.coupling, branches.change
    stages = stress.shape[0]
    for e in range(orders.shape[0]):
        order = orders[e]
        for g in range(order):
            of = section[e, g]
            for i in range(stages):
                for a in range(6):
                    total = 0.0
                    for k in range(order + 1):
                        n = nodes[e, k]
                        for b in range(6):
                            total += B[e, 6 * g + a, 6 * k + b] * change[i, n, b]
                    strain_change[i, a] = total
            for i in range(stages):
                for a in range(6):
                    total = 0.0
                    for k in range(stages):
                        for b in range(6):
                            total += coupling[of, i, k, a, b] * strain_change[k, b]
                    stress[i, e, g, a] += total


@part
def stretch_springs(elements: Elements, branches: MaxwellArrays, strain: Floats) -> None:
    """Write the strains of the springs at the stages, ``beta_j = F_j (eps - alpha_j0)``."""
    orders, factor, start, spring = elements.order, branches.factor, branches.start, branches.spring
    stages = strain.shape[0]
    for i in range(stages):
        for j in range(start.shape[0]):
            for e in range(orders.shape[0]):
                for g in range(orders[e]):
                    for a in range(6):
                        total = 0.0
                        for k in range(stages):
                            total += factor[j, i, k] * (strain[k, e, g, a] - start[j, e, g, a])
                        spring[i, j, e, g, a] = total


@part
def lacking_work(
    elements: Elements,
    arrays: MaxwellArrays,
    strain_rate: Floats,
    start_strain: Floats,
    end_strain: Floats,
    h: float,
    lacking: Floats,
) -> None:
    """Write the energy defect of the branches in a step of the midpoint rule: energy stored and lost less work done.

    Args:
        strain_rate: in the middle ``(1, e, points, 6)``; start_strain, end_strain: at the ends of the step, likewise.
        h: step [s]; lacking: output ``(e, points)`` [J/m].
    """
    orders, section, times, branches = elements.order, elements.section, arrays.times, arrays.branches
    start, spring = arrays.start, arrays.spring
    for e in range(orders.shape[0]):
        for g in range(orders[e]):
            of = section[e, g]
            total = 0.0
            for j in range(start.shape[0]):
                for a in range(6):
                    for b in range(6):
                        slip = h / times[j] * spring[0, j, e, g, b]
                        gained = end_strain[0, e, g, b] - start_strain[0, e, g, b] - slip
                        first = start_strain[0, e, g, a] - start[j, e, g, a]
                        last = end_strain[0, e, g, a] - start[j, e, g, a]
                        last -= h / times[j] * spring[0, j, e, g, a]
                        lost = spring[0, j, e, g, a] * (slip - h * strain_rate[0, e, g, b])
                        total += branches[of, j, a, b] * (0.5 * (first + last) * gained + lost)
            lacking[e, g] = total


@part
def branch_energies(elements: Elements, arrays: MaxwellArrays, elastic: Floats, dissipated: Floats) -> None:
    """Add the energy stored in branches to ``elastic (s,)`` [J] and the power they lose to ``dissipated (s,)`` [W].

    The power that each branch loses is kept, ``power (s, n)`` [W].
    """
    times, branches, spring, power = arrays.times, arrays.branches, arrays.spring, arrays.power
    orders, weights, half_lengths, section = elements[0], elements[7], elements[8], elements[9]
    for i in range(spring.shape[0]):
        for j in range(spring.shape[1]):
            total = 0.0
            for e in range(orders.shape[0]):
                for g in range(orders[e]):
                    of = section[e, g]
                    weight = weights[orders[e], g] * half_lengths[e]
                    for a in range(6):
                        for b in range(6):
                            beta = spring[i, j, e, g, a] * spring[i, j, e, g, b]
                            total += weight * branches[of, j, a, b] * beta
            elastic[i] += 0.5 * total
            power[i, j] = total / times[j]
            dissipated[i] += power[i, j]


@part
def add_branch_error(
    elements: Elements,
    arrays: MaxwellArrays,
    strain: Floats,
    B: Floats,
    weights: Floats,
    mu: float,
    h: float,
    out: Floats,
) -> None:
    """Add the contribution of the branches to the right side ``(n, 6)`` of the equation of the estimated error.

    With ``rho_j = beta_j0/tau_j + sum_i e_i (alpha_ji - alpha_j0)/h``, the estimate for the dashpots, it is
    ``sum_g w_g B^T sum_j C_j tau_j rho_j/(1 + mu tau_j)`` after these are eliminated.

    Args:
        B: change of the strains per nodal increment; weights: ``e`` of the method; mu: its real eigenvalue over ``h``.
    """
    times, branches, start = arrays.times, arrays.branches, arrays.start
    start_strain, spring = arrays.start_strain, arrays.spring
    orders, nodes, point_weights, half_lengths, section = (
        elements[0],
        elements[1],
        elements[7],
        elements[8],
        elements[9],
    )
    for e in range(orders.shape[0]):
        order = orders[e]
        for g in range(order):
            of = section[e, g]
            weight = point_weights[order, g] * half_lengths[e]
            for j in range(times.shape[0]):
                scale = weight * times[j] / (1.0 + mu * times[j])
                for b in range(6):
                    begin = start[j, e, g, b]
                    rho = (start_strain[e, g, b] - begin) / times[j]
                    for i in range(spring.shape[0]):
                        rho += weights[i] / h * (strain[i, e, g, b] - spring[i, j, e, g, b] - begin)
                    rho *= scale
                    for a in range(6):
                        force = branches[of, j, a, b] * rho
                        if force != 0.0:
                            for k in range(order + 1):
                                n = nodes[e, k]
                                for c in range(6):
                                    out[n, c] += force * B[e, 6 * g + a, 6 * k + c]


@kernel
def add_section_stiffness(elements: Elements, modulus: Floats, B: Floats, blocks: Floats) -> None:
    """Add ``sum_g w_g B^T modulus B`` to the blocks ``(b, 6, 6)`` of a matrix.

    Args:
        modulus: section matrices ``(sections, 6, 6)``, real or complex like ``blocks``.
        B: change of the strains per nodal increment ``(e, 6 points, 6 nodes)``.
    """
    orders, weights, half_lengths = elements[0], elements[7], elements[8]
    section, slots = elements[9], elements[14]
    for e in range(orders.shape[0]):
        order = orders[e]
        for g in range(order):
            of = section[e, g]
            weight = weights[order, g] * half_lengths[e]
            for column in range(order + 1):
                for j in range(6):
                    for a in range(6):
                        force = weight * modulus[of, a, 0] * B[e, 6 * g, 6 * column + j]
                        for b in range(1, 6):
                            force += weight * modulus[of, a, b] * B[e, 6 * g + b, 6 * column + j]
                        for row in range(order + 1):
                            slot = slots[e, row, column]
                            for i in range(6):
                                blocks[slot, j, i] += B[e, 6 * g + a, 6 * row + i] * force
