"""Elements linearised at one state: operators of their section forces, and their stiffness and damping matrices.

At fixed ``C, D`` the section forces of a Gauss point vary by

    dS = C B d + D (E d + B dx1),     dx1 = (d)' + ad(x1) d

with nodal body increments ``d``, the strain operator ``B`` and the change ``E`` of the strain rate at constant twists
(see ``strain``), so ``dS = A d + P d'`` with ``A = C B + D (E + B ad)`` and ``P = D B``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.attachment import link_map, map_columns, map_rows
from viscorod.mechanics.compiled import kernel, part
from viscorod.mechanics.geometric_stiffness import add_geometric_stiffness
from viscorod.mechanics.internal_force import Elements
from viscorod.mechanics.strain import element_poses, gauss_point, strain_operator, strain_rate_operator
from viscorod.typing import Floats


class Operators(NamedTuple):
    """``B``, ``A`` and ``P`` of all elements ``(e, 6 points, 6 nodes)``, rows of a Gauss point together."""

    strain: Floats
    force: Floats
    viscous: Floats

    @classmethod
    def of(cls, elements: Elements) -> Operators:
        """Allocate."""
        count, points, _ = elements.reference.shape
        shape = (count, 6 * points, 6 * (points + 1))
        return cls(np.zeros(shape), np.zeros(shape), np.zeros(shape))


@kernel
def linearise(
    elements: Elements,
    r: Floats,
    q: Floats,
    twist: Floats,
    turning: Floats,
    section_force: Floats,
    operators: Operators,
    K: Floats,
    C: Floats,
) -> None:
    """Write the operators and add the matrices of all elements to two bands.

    Args:
        r, q, twist: poses and body twists of all nodes; turning: ``ad(x1)`` of every node ``(n, 6, 6)``.
        section_force: ``(e, points, 6)``, for the geometric stiffness.
        operators: outputs.
        K, C: bands of width 2 w + 1, row j holds column j: derivative of the internal forces by increments (which turn
            with the node) and by their rates.
    """
    most = elements.nodes.shape[1]
    width = (K.shape[1] - 1) // 2
    re_all, qe_all, te_all = np.empty((most, 3)), np.empty((most, 4)), np.empty((most, 6))
    p_all, slope_all = np.empty((most, 4)), np.empty(most)
    frame, V, U = np.empty(4), np.empty(3), np.empty(3)
    Q_all, L_all = np.empty((most, 3, 3)), np.empty((most, 4, 3))
    E_all = np.empty((6, 6 * most))
    X_all = np.empty((most, 6, 6))
    weighted = np.zeros((6 * (most - 1), 6 * most))
    material, damping = np.zeros((6 * most, 6 * most)), np.zeros((6 * most, 6 * most))
    geometric = np.empty((6 * most, 6 * most))
    rate_work = (
        np.empty(3),
        np.empty(4),
        np.empty(4),
        np.empty((3, 4)),
        np.empty((3, 4)),
        np.empty((3, 4)),
        np.empty((4, 3)),
    )
    stiffness_work = (
        np.empty((4, 4)),
        np.empty((4, 4)),
        np.empty(4),
        np.empty((4, 3)),
        np.empty((4, 3)),
        np.empty((3, 3)),
        np.empty(3),
        np.empty(4),
    )
    for e in range(elements.order.shape[0]):
        order = elements.order[e]
        m = order + 1
        size = 6 * m
        nodes, links = elements.nodes[e, :m], elements.links[e, :m]
        re, qe, te, p, slope = re_all[:m], qe_all[:m], te_all[:m], p_all[:m], slope_all[:m]
        Q, L, E = Q_all[:m], L_all[:m], E_all[:, :size]
        element_poses(nodes, links, elements.link_positions, elements.link_quaternions, r, q, re, qe)
        linked = False
        for k in range(m):
            for i in range(6):
                te[k, i] = twist[nodes[k], i]
            if links[k] >= 0:
                linked = True
                link_map(elements.link_positions[links[k]], elements.link_quaternions[links[k]], X_all[k])
                for i in range(6):
                    te[k, i] = 0.0
                    for j in range(6):
                        te[k, i] += X_all[k, i, j] * twist[nodes[k], j]
        half = elements.half_lengths[e]
        geometric[:, :] = 0.0
        for g in range(order):
            shape = elements.shapes[order, g, :m]
            for k in range(m):
                slope[k] = elements.slopes[order, g, k] / half
            B = operators.strain[e, 6 * g : 6 * g + 6, :size]
            A = operators.force[e, 6 * g : 6 * g + 6, :size]
            P = operators.viscous[e, 6 * g : 6 * g + 6, :size]
            z0 = gauss_point(shape, slope, re, qe, V, U, p, frame)
            strain_operator(shape, slope, V, U, z0, p, Q, L, B)
            weight = elements.weights[order, g] * half
            add_geometric_stiffness(
                weight,
                shape,
                slope,
                V,
                U,
                z0,
                p,
                Q,
                L,
                section_force[e, g],
                stiffness_work,
                geometric[:size, :size],
            )
            if linked:
                for k in range(m):
                    if links[k] >= 0:
                        map_columns(B, 6 * k, X_all[k])
            section = elements.section[e, g]
            add_product(elements.stiffness[section], B, True, A)
            if elements.damped:
                D = elements.damping[section]
                strain_rate_operator(shape, slope, V, U, z0, p, Q, L, te, rate_work, E)
                for k in range(m):
                    if links[k] >= 0:
                        map_columns(E, 6 * k, X_all[k])
                    T = turning[nodes[k]]
                    for i in range(6):
                        for a in range(6):
                            b = B[i, 6 * k + a]
                            for j in range(6):
                                E[i, 6 * k + j] += b * T[a, j]
                add_product(D, E, False, A)
                add_product(D, B, True, P)
            for i in range(6):
                for j in range(size):
                    weighted[6 * g + i, j] = weight * B[i, j]
        for i in range(6 * order, weighted.shape[0]):
            weighted[i] = 0.0
        # transposed element matrices: all Gauss points at once
        np.dot(operators.force[e].T, weighted, material)
        if elements.damped:
            np.dot(operators.viscous[e].T, weighted, damping)
        if linked:
            for k in range(m):
                if links[k] >= 0:
                    map_columns(geometric[:size, :size], 6 * k, X_all[k])
                    map_rows(geometric[:size, :size], 6 * k, X_all[k])
        for k in range(m):
            for j in range(6):
                column = 6 * k + j
                row_K, row_C = K[6 * nodes[k] + j], C[6 * nodes[k] + j]
                for other in range(m):
                    first = width + 6 * (nodes[other] - nodes[k]) - j
                    for i in range(6):
                        row_K[first + i] += material[column, 6 * other + i] + geometric[column, 6 * other + i]
                    if elements.damped:
                        for i in range(6):
                            row_C[first + i] += damping[column, 6 * other + i]


@part
def add_product(C: Floats, B: Floats, first: bool, out: Floats) -> None:
    """Add ``C B`` to ``out (6, columns)``, or write it if ``first``; zeros of ``C`` cost nothing."""
    for i in range(6):
        if first:
            for j in range(B.shape[1]):
                out[i, j] = 0.0
        for a in range(6):
            c = C[i, a]
            if c != 0.0:
                for j in range(B.shape[1]):
                    out[i, j] += c * B[a, j]


@part
def add_frozen_forces(
    elements: Elements, B: Floats, section_force: Floats, stress: Floats, force: Floats
) -> None:
    """Add ``sum_g w_g B^T (S - sigma)`` with the frozen ``B`` to the nodal forces ``(s, n, 6)`` of all stages."""
    orders, nodes, weights, half_lengths = elements[0], elements[1], elements[7], elements[8]
    for stage in range(force.shape[0]):
        for e in range(orders.shape[0]):
            order = orders[e]
            for g in range(order):
                weight = weights[order, g] * half_lengths[e]
                for a in range(6):
                    excess = weight * (section_force[stage, e, g, a] - stress[stage, e, g, a])
                    for k in range(order + 1):
                        n = nodes[e, k]
                        for i in range(6):
                            force[stage, n, i] += excess * B[e, 6 * g + a, 6 * k + i]


@part
def carry_stress(
    elements: Elements,
    A: Floats,
    P: Floats,
    change: Floats,
    rate: Floats,
    section_force: Floats,
    stress: Floats,
) -> None:
    """Carry the stress along a change of all poses: ``sigma = S + A d + P d'`` with the frozen operators.

    Args:
        change, rate: body increments of the nodes at all stages ``(s, n, 6)`` and their rates [1/s].
        section_force: of the poses before the change ``(s, e, points, 6)``; stress: output.
    """
    orders, nodes, damped = elements[0], elements[1], elements[12]
    for stage in range(change.shape[0]):
        for e in range(orders.shape[0]):
            order = orders[e]
            for g in range(order):
                for a in range(6):
                    total = section_force[stage, e, g, a]
                    row = 6 * g + a
                    for k in range(order + 1):
                        n = nodes[e, k]
                        for i in range(6):
                            total += A[e, row, 6 * k + i] * change[stage, n, i]
                        if damped:
                            for i in range(6):
                                total += P[e, row, 6 * k + i] * rate[stage, n, i]
                    stress[stage, e, g, a] = total
