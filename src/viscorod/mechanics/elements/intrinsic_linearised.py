"""The intrinsic element linearised at one state: operators of its section forces, stiffness and damping matrices.

A nodal body increment ``d`` changes strains by ``B d`` with ``B_k = N'_k + N_k [[U~, V~], [0, U~]]``, as twists give
the strain rate. This holds up to the error of the interpolation (compatibility is integrated, not differentiated):
good enough for a Jacobian, and of high order in the mesh. With ``dx1 = d' + ad(x1) d``,

    d(eps_t) = B d' + (L B + B ad) d     L = [[-w~, -v~], [0, -w~]]
    dS = A d + P d'                      A = C B + D (L B + B ad)     P = D B

and with linearised damping ``A = C B + D B0 ad``, ``P = D B0``, where ``B0`` is ``B`` of the unstrained rod.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.attached_poses import link_map, map_columns, map_rows
from viscorod.typing import Floats


@part
def strain_motion_operator(
    shapes: Floats, slopes: Floats, half: float, m: int, V: Floats, U: Floats, B: Floats
) -> None:
    """Write ``B_k = N'_k + N_k [[U~, V~], [0, U~]]`` of all nodes ``(6, 6 m)`` for total strains ``V, U``."""
    for i in range(6):
        for j in range(6 * m):
            B[i, j] = 0.0
    for k in range(m):
        n, first = shapes[k], 6 * k
        for i in range(6):
            B[i, first + i] = slopes[k] / half
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            B[i, first + a] -= n * U[b]
            B[i, first + b] += n * U[a]
            B[3 + i, first + 3 + a] -= n * U[b]
            B[3 + i, first + 3 + b] += n * U[a]
            B[i, first + 3 + a] -= n * V[b]
            B[i, first + 3 + b] += n * V[a]


@part
def adjoint_columns(B: Floats, k: int, adjoint: Floats, out: Floats) -> None:
    """Write the six columns of node ``k`` of ``B ad(x1)``."""
    for i in range(6):
        for j in range(6):
            total = 0.0
            for a in range(6):
                total += B[i, 6 * k + a] * adjoint[a, j]
            out[i, 6 * k + j] = total


@kernel
def linearise_intrinsic(
    elements: Elements,
    linearised: bool,
    strain: Floats,
    point_twist: Floats,
    viscous_rate: Floats,
    adjoint: Floats,
    section_force: Floats,
    operators: Operators,
    K: Floats,
    C: Floats,
) -> None:
    """Write the operators and add the matrices of all elements to two arrays of blocks.

    Args:
        linearised: damping is linearised.
        strain, point_twist, viscous_rate, section_force: at the Gauss points ``(e, points, 6)``.
        adjoint: ``ad(x1)`` of every node ``(n, 6, 6)``.
        operators: outputs; K, C: blocks ``(b, 6, 6)`` as in ``geometric_element.assemble``.
    """
    most = elements.nodes.shape[1]
    V, U, V0, U0 = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    X = np.zeros((most, 6, 6))
    B0, turned, rate = np.empty((6, 6 * most)), np.empty((6, 6 * most)), np.empty((6, 6 * most))
    AB, viscous = np.empty((6, 6 * most)), np.empty((6, 6 * most))
    stiffness, damping = np.empty((6 * most, 6 * most)), np.empty((6 * most, 6 * most))
    geometric = np.empty((6 * most, 6 * most))
    S, x = np.empty(6), np.empty(6)
    for e in range(elements.order.shape[0]):
        order = elements.order[e]
        m = order + 1
        size = 6 * m
        half = elements.half_lengths[e]
        stiffness[:, :] = 0.0
        geometric[:, :] = 0.0
        damping[:, :] = 0.0
        for k in range(m):
            link = elements.links[e, k]
            if link >= 0:
                link_map(elements.link_positions[link], elements.link_quaternions[link], X[k])
        for g in range(order):
            shapes, slopes = elements.shapes[order, g, :m], elements.slopes[order, g, :m]
            for i in range(3):
                V0[i], U0[i] = elements.reference[e, g, i], elements.reference[e, g, 3 + i]
                V[i], U[i] = V0[i] + strain[e, g, i], U0[i] + strain[e, g, 3 + i]
            for i in range(6):
                S[i], x[i] = section_force[e, g, i], point_twist[e, g, i]
            of = elements.section[e, g]
            D = elements.damping[of]
            B = operators.strain[e, 6 * g : 6 * g + 6, :size]
            A = operators.force[e, 6 * g : 6 * g + 6, :size]
            P = operators.viscous[e, 6 * g : 6 * g + 6, :size]
            weight = elements.weights[order, g] * half
            strain_motion_operator(shapes, slopes, half, m, V, U, B)
            if linearised:
                strain_motion_operator(shapes, slopes, half, m, V0, U0, B0)
                for i in range(6):
                    for j in range(6):
                        S[i] -= D[i, j] * viscous_rate[e, g, j]
            # geometric stiffness N_k L2(S) B of the element's own nodes
            for k in range(m):
                n = weight * shapes[k]
                for j in range(size):
                    for i in range(3):
                        a, b = (i + 1) % 3, (i + 2) % 3
                        force = S[a] * B[3 + b, j] - S[b] * B[3 + a, j]
                        couple = S[a] * B[b, j] - S[b] * B[a, j]
                        couple += S[3 + a] * B[3 + b, j] - S[3 + b] * B[3 + a, j]
                        geometric[6 * k + i, j] += n * force
                        geometric[6 * k + 3 + i, j] += n * couple
            for k in range(m):
                if elements.links[e, k] >= 0:
                    map_columns(B, 6 * k, X[k])
                    if linearised:
                        map_columns(B0, 6 * k, X[k])
            for i in range(6):
                for j in range(size):
                    total = 0.0
                    for a in range(6):
                        total += elements.stiffness[of, i, a] * B[a, j]
                    A[i, j] = AB[i, j] = total
            if elements.damped:
                acting = B0 if linearised else B
                for k in range(m):
                    adjoint_columns(acting, k, adjoint[elements.nodes[e, k]], turned)
                for i in range(3):
                    a, b = (i + 1) % 3, (i + 2) % 3
                    for j in range(size):
                        rate[i, j], rate[3 + i, j] = turned[i, j], turned[3 + i, j]
                        if not linearised:
                            rate[i, j] -= x[3 + a] * B[b, j] - x[3 + b] * B[a, j]
                            rate[i, j] -= x[a] * B[3 + b, j] - x[b] * B[3 + a, j]
                            rate[3 + i, j] -= x[3 + a] * B[3 + b, j] - x[3 + b] * B[3 + a, j]
                for i in range(6):
                    for j in range(size):
                        total = through = 0.0
                        for a in range(6):
                            total += D[i, a] * acting[a, j]
                            through += D[i, a] * rate[a, j]
                        P[i, j] = total
                        viscous[i, j] = through
                        A[i, j] += through
                for i in range(size):
                    for a in range(6):
                        c = weight * acting[a, i]
                        if c != 0.0:
                            for j in range(size):
                                damping[i, j] += c * P[a, j]
                                stiffness[i, j] += c * viscous[a, j]
            for i in range(size):
                for a in range(6):
                    c = weight * B[a, i]
                    if c != 0.0:
                        for j in range(size):
                            stiffness[i, j] += c * AB[a, j]
        for k in range(m):
            if elements.links[e, k] >= 0:
                map_columns(geometric[:size, :size], 6 * k, X[k])
                map_rows(geometric[:size, :size], 6 * k, X[k])
        for k in range(m):
            for other in range(m):
                slot = elements.slots[e, other, k]
                for j in range(6):
                    for i in range(6):
                        row, column = 6 * other + i, 6 * k + j
                        K[slot, j, i] += stiffness[row, column] + geometric[row, column]
                        C[slot, j, i] += damping[row, column]
