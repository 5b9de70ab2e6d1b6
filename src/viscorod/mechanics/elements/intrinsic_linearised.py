"""The intrinsic element linearised at one state: operators of its section forces, stiffness and damping matrices.

A nodal body increment ``d`` changes strains by ``B d`` with ``B_k = N'_k + N_k [[U~, V~], [0, U~]]``, as twists give
the strain rate. This holds up to the error of the interpolation (compatibility is integrated, not differentiated):
good enough for a Jacobian, and of high order in the mesh. With ``dx1 = d' + ad(x1) d``,

    d(eps_t) = B d' + (L B + B ad) d     L = [[-w~, -v~], [0, -w~]]
    dS = A d + P d'                      A = C B + D (L B + B ad)     P = D B

and with linearised damping ``A = C B + D B0 ad``, ``P = D B0``, where ``B0`` is ``B`` of the unstrained rod. C and D
contain the derivatives of the laws of sections. With ``f_k = sum_g w_g B_k^T S`` the matrices of an element are

    K = sum_g w_g [B^T A + N L2(S) B]      C = sum_g w_g B^T P      L2(S) = [[0, N~], [N~, M~]]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.elements.section_laws import add_law_tangents
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


class ElementMatrices(NamedTuple):
    """Matrices of one element, and scratch at one of its Gauss points.

    Attributes:
        X: maps of attached nodes ``(m, 6, 6)``.
        unstrained, turned, rate, elastic, viscous: ``B0``, ``B ad``, ``L B + B ad``, ``C B`` and ``D (L B + B ad)`` of
            one point ``(6, 6 m)``.
        stiffness, geometric, damping: ``(6 m, 6 m)``, the second of them for the element's own nodes.
        C, D: derivatives of the section force by strains and rates ``(6, 6)``; stress, V, U, V0, U0: of the point.
    """

    X: Floats
    unstrained: Floats
    turned: Floats
    rate: Floats
    elastic: Floats
    viscous: Floats
    stiffness: Floats
    geometric: Floats
    damping: Floats
    C: Floats
    D: Floats
    stress: Floats
    V: Floats
    U: Floats
    V0: Floats
    U0: Floats


@part
def clear_matrices(elements: Elements, e: int, out: ElementMatrices) -> None:
    """Set the matrices of an element to zero, and find the maps of its attached nodes."""
    size = 6 * elements.order[e] + 6
    for i in range(size):
        for j in range(size):
            out.stiffness[i, j] = out.geometric[i, j] = out.damping[i, j] = 0.0
    for k in range(elements.order[e] + 1):
        link = elements.links[e, k]
        if link >= 0:
            link_map(elements.link_positions[link], elements.link_quaternions[link], out.X[k])


@part
def point_strains(elements: Elements, e: int, g: int, strain: Floats, out: ElementMatrices) -> None:
    """Write the strains of one point and those of the reference shape, ``V, U, V0, U0``."""
    for i in range(3):
        out.V0[i], out.U0[i] = elements.reference[e, g, i], elements.reference[e, g, 3 + i]
        out.V[i], out.U[i] = out.V0[i] + strain[e, g, i], out.U0[i] + strain[e, g, 3 + i]


@part
def section_tangents(
    elements: Elements, e: int, g: int, strain: Floats, rate: Floats, out: ElementMatrices
) -> None:
    """Write the derivatives C and D of the section force of one point, those of its law included."""
    of = elements.section[e, g]
    for i in range(6):
        for j in range(6):
            out.C[i, j], out.D[i, j] = elements.stiffness[of, i, j], elements.damping[of, i, j]
    if elements.laws.present:
        add_law_tangents(elements.laws, of, strain[e, g], rate[e, g], out.C, out.D)


@part
def bending_stress(linearised: bool, D: Floats, rate: Floats, section_force: Floats, out: Floats) -> None:
    """Write the stress that acts through the strains: without ``D b`` if damping is linearised."""
    for i in range(6):
        out[i] = section_force[i]
        if linearised:
            for j in range(6):
                out[i] -= D[i, j] * rate[j]


@part
def add_geometric_stiffness(shapes: Floats, weight: float, S: Floats, B: Floats, out: Floats) -> None:
    """Add ``w N_k L2(S) B`` of the element's own nodes, ``L2 = [[0, N~], [N~, M~]]``."""
    for k in range(shapes.shape[0]):
        n = weight * shapes[k]
        for j in range(B.shape[1]):
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                force = S[a] * B[3 + b, j] - S[b] * B[3 + a, j]
                couple = S[a] * B[b, j] - S[b] * B[a, j]
                couple += S[3 + a] * B[3 + b, j] - S[3 + b] * B[3 + a, j]
                out[6 * k + i, j] += n * force
                out[6 * k + 3 + i, j] += n * couple


@part
def share_columns(elements: Elements, e: int, X: Floats, B: Floats) -> None:
    """Turn the columns of attached nodes into those of the shared nodes."""
    for k in range(elements.order[e] + 1):
        if elements.links[e, k] >= 0:
            map_columns(B, 6 * k, X[k])


@part
def rate_change(linearised: bool, B: Floats, x: Floats, turned: Floats, out: Floats) -> None:
    """Write ``L B + B ad`` from ``turned``, ``B ad`` (``B0 ad`` alone if linearised), at the twist ``x (6,)``."""
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(B.shape[1]):
            out[i, j], out[3 + i, j] = turned[i, j], turned[3 + i, j]
            if not linearised:
                out[i, j] -= x[3 + a] * B[b, j] - x[3 + b] * B[a, j]
                out[i, j] -= x[a] * B[3 + b, j] - x[b] * B[3 + a, j]
                out[3 + i, j] -= x[3 + a] * B[3 + b, j] - x[3 + b] * B[3 + a, j]


@part
def times_section(C: Floats, B: Floats, size: int, out: Floats) -> None:
    """Write ``C B`` for the first ``size`` columns."""
    for i in range(6):
        for j in range(size):
            total = 0.0
            for a in range(6):
                total += C[i, a] * B[a, j]
            out[i, j] = total


@part
def add_product(weight: float, B: Floats, A: Floats, size: int, out: Floats) -> None:
    """Add ``w B^T A`` for the first ``size`` columns."""
    for i in range(size):
        for a in range(6):
            c = weight * B[a, i]
            if c != 0.0:
                for j in range(size):
                    out[i, j] += c * A[a, j]


@part
def add_element(elements: Elements, e: int, matrices: ElementMatrices, K: Floats, C: Floats) -> None:
    """Add the matrices of an element to the blocks ``(b, 6, 6)`` of all."""
    m = elements.order[e] + 1
    size = 6 * m
    geometric = matrices.geometric
    for k in range(m):
        if elements.links[e, k] >= 0:
            map_columns(geometric[:size, :size], 6 * k, matrices.X[k])
            map_rows(geometric[:size, :size], 6 * k, matrices.X[k])
    for k in range(m):
        for other in range(m):
            slot = elements.slots[e, other, k]
            for j in range(6):
                for i in range(6):
                    row, column = 6 * other + i, 6 * k + j
                    K[slot, j, i] += matrices.stiffness[row, column] + geometric[row, column]
                    C[slot, j, i] += matrices.damping[row, column]


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
    one, square, small = (6, 6 * most), (6 * most, 6 * most), (6, 6)
    at = ElementMatrices(
        np.zeros((most, 6, 6)), np.zeros(one), np.zeros(one), np.zeros(one), np.zeros(one), np.zeros(one),
        np.zeros(square), np.zeros(square), np.zeros(square), np.zeros(small), np.zeros(small), np.zeros(6),
        np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3),
    )  # fmt: skip
    for e in range(elements.order.shape[0]):
        order, half = elements.order[e], elements.half_lengths[e]
        m = order + 1
        size = 6 * m
        clear_matrices(elements, e, at)
        for g in range(order):
            shapes, slopes = elements.shapes[order, g, :m], elements.slopes[order, g, :m]
            weight = elements.weights[order, g] * half
            B = operators.strain[e, 6 * g : 6 * g + 6, :size]
            A = operators.force[e, 6 * g : 6 * g + 6, :size]
            P = operators.viscous[e, 6 * g : 6 * g + 6, :size]
            B0 = at.unstrained[:, :size]
            point_strains(elements, e, g, strain, at)
            section_tangents(elements, e, g, strain, viscous_rate, at)
            bending_stress(linearised, at.D, viscous_rate[e, g], section_force[e, g], at.stress)
            strain_motion_operator(shapes, slopes, half, m, at.V, at.U, B)
            strain_motion_operator(shapes, slopes, half, m, at.V0, at.U0, B0)
            add_geometric_stiffness(shapes, weight, at.stress, B, at.geometric)
            share_columns(elements, e, at.X, B)
            share_columns(elements, e, at.X, B0)
            times_section(at.C, B, size, at.elastic)
            add_product(weight, B, at.elastic, size, at.stiffness)
            times_section(at.C, B, size, A)
            if elements.damped:
                acting = B0 if linearised else B
                for k in range(m):
                    adjoint_columns(acting, k, adjoint[elements.nodes[e, k]], at.turned)
                rate_change(linearised, B, point_twist[e, g], at.turned, at.rate)
                times_section(at.D, acting, size, P)
                times_section(at.D, at.rate, size, at.viscous)
                add_product(weight, acting, P, size, at.damping)
                add_product(weight, acting, at.viscous, size, at.stiffness)
                for i in range(6):
                    for j in range(size):
                        A[i, j] += at.viscous[i, j]
        add_element(elements, e, at, K, C)
