"""Forces and tangents of geometric elements: one pass over the Gauss points of all elements of one order.

The element is described in ``strain``; here its section forces are turned into nodal forces, and their derivative is
assembled into the band.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.attachment import link_map, map_columns, map_rows
from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.geometric_stiffness import add_geometric_stiffness
from viscorod.mechanics.strain import (
    element_poses,
    gauss_point,
    strain_operator,
    strain_rate_operator,
)
from viscorod.typing import Floats, Integers


@kernel
def strains(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    shapes: Floats,
    slopes: Floats,
    half_lengths: Floats,
    r: Floats,
    q: Floats,
    out: Floats,
    frames: Floats,
) -> None:
    """Evaluate ``(V, U)`` at every Gauss point of equal-order elements into ``out`` (elements, points, 6).

    ``frames`` (elements, points, 4) receives the unit quaternions of the sections.
    """
    m = nodes.shape[1]
    re = np.empty((m, 3))
    qe = np.empty((m, 4))
    p = np.empty((m, 4))
    slope = np.empty(m)
    for e in range(nodes.shape[0]):
        element_poses(nodes[e], links[e], link_positions, link_quaternions, r, q, re, qe)
        for g in range(shapes.shape[0]):
            for k in range(m):
                slope[k] = slopes[g, k] / half_lengths[e]
            gauss_point(shapes[g], slope, re, qe, out[e, g, 0:3], out[e, g, 3:6], p, frames[e, g])


@kernel
def assemble(
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    shapes: Floats,
    slopes: Floats,
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    stiffness: Floats,
    damping: Floats,
    damped: bool,
    reference: Floats,
    stress: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    moving: bool,
    rate_map: Floats,
    with_tangent: bool,
    force: Floats,
    band: Floats,
    diagonal: int,
    strain: Floats,
    strain_rate: Floats,
    section_force: Floats,
    operator: Floats,
) -> None:
    """Add the internal forces of equal-order elements, and their tangent, in one pass over the Gauss points.

    Args:
        nodes, links: ``(elements, m)``, shared node and attachment (or -1) of every element node.
        link_positions, link_quaternions: constant relative poses of the attachments.
        shapes, slopes: basis and its derivative in xi at the Gauss points ``(points, m)``; ``weights`` ``(points,)``.
        half_lengths: half the reference arc length of each element [m].
        section: index of the section at every Gauss point ``(elements, points)``.
        stiffness, damping: section matrices C and D ``(sections, 6, 6)``; ``damped`` False skips D.
        reference: strains of the unstressed shape ``(elements, points, 6)``.
        stress: section force used in the geometric stiffness (the mixed iterate) ``(elements, points, 6)``.
        r, q, twist: nodal positions, unit quaternions and body twists; ``moving`` False means that all twists vanish.
        rate_map: d(twist)/d(increment) of every node ``(n, 6, 6)``; read only if ``damped and moving``.
        force: ``(n, 6)``, internal force in body frames is added.
        band: ``(6 n, columns)``, row j holds column j of the matrix, entry (i, j) at ``band[j, diagonal + i - j]``.
        strain, strain_rate, section_force: outputs ``(elements, points, 6)``: (V, U) - reference, its rate, C eps
            + D eps_t.
        operator: output ``(elements, points, 6, 6 m)``, change of the section force per nodal increment (with the
            tangent).

    model.md section 4: ``f = sum_g w_g B^T (C eps + D eps_t)``.
    """
    m = nodes.shape[1]
    size = 6 * m
    points = shapes.shape[0]
    re = np.empty((m, 3))
    qe = np.empty((m, 4))
    te = np.zeros((m, 6))
    p = np.empty((m, 4))
    slope = np.empty(m)
    frame = np.empty(4)
    V = np.empty(3)
    U = np.empty(3)
    Q = np.empty((m, 3, 3))
    L = np.empty((m, 4, 3))
    B = np.empty((6, size))
    E = np.empty((6, size))
    fe = np.empty(size)
    KT = np.empty((size, size))  # transposed element matrix: material part, then geometric part
    GT = np.empty((size, size))
    X = np.empty((m, 6, 6))
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
    viscous = damped and moving
    for e in range(nodes.shape[0]):
        element_poses(nodes[e], links[e], link_positions, link_quaternions, r, q, re, qe)
        linked = False
        for k in range(m):
            if links[e, k] >= 0:
                linked = True
                link_map(link_positions[links[e, k]], link_quaternions[links[e, k]], X[k])
        if viscous:
            for k in range(m):
                n = nodes[e, k]
                if links[e, k] < 0:
                    for i in range(6):
                        te[k, i] = twist[n, i]
                else:
                    for i in range(6):
                        te[k, i] = 0.0
                        for j in range(6):
                            te[k, i] += X[k, i, j] * twist[n, j]
        fe[:] = 0.0
        KT[:, :] = 0.0
        GT[:, :] = 0.0
        jacobian = half_lengths[e]
        for g in range(points):
            weight = weights[g] * jacobian
            shape = shapes[g]
            for k in range(m):
                slope[k] = slopes[g, k] / jacobian
            z0 = gauss_point(shape, slope, re, qe, V, U, p, frame)
            strain_operator(shape, slope, V, U, z0, p, Q, L, B)
            if linked:
                for k in range(m):
                    if links[e, k] >= 0:
                        map_columns(B, 6 * k, X[k])
            C = stiffness[section[e, g]]
            D = damping[section[e, g]]
            eps = strain[e, g]
            rate = strain_rate[e, g]
            S = section_force[e, g]
            for i in range(3):
                eps[i] = V[i] - reference[e, g, i]
                eps[3 + i] = U[i] - reference[e, g, 3 + i]
            for i in range(6):
                S[i] = 0.0
                rate[i] = 0.0
                for j in range(6):
                    S[i] += C[i, j] * eps[j]
            if viscous:
                for k in range(m):
                    for j in range(6):
                        t = twist[nodes[e, k], j]
                        for i in range(6):
                            rate[i] += B[i, 6 * k + j] * t
                for i in range(6):
                    for j in range(6):
                        S[i] += D[i, j] * rate[j]
            for i in range(6):
                s = weight * S[i]
                for j in range(size):
                    fe[j] += s * B[i, j]
            if not with_tangent:
                continue
            A = operator[e, g]
            for i in range(6):
                for j in range(size):
                    A[i, j] = 0.0
                for a in range(6):
                    c = C[i, a]
                    if c != 0.0:
                        for j in range(size):
                            A[i, j] += c * B[a, j]
            if viscous:
                strain_rate_operator(shape, slope, V, U, z0, p, Q, L, te, rate_work, E)
                for k in range(m):
                    col = 6 * k
                    if links[e, k] >= 0:
                        map_columns(E, col, X[k])
                    T = rate_map[nodes[e, k]]
                    for i in range(6):
                        for a in range(6):
                            t = B[i, col + a]
                            for j in range(6):
                                E[i, col + j] += t * T[a, j]
                for i in range(6):
                    for a in range(6):
                        d = D[i, a]
                        if d != 0.0:
                            for j in range(size):
                                A[i, j] += d * E[a, j]
            for j in range(size):
                for a in range(6):
                    t = weight * A[a, j]
                    for i in range(size):
                        KT[j, i] += t * B[a, i]
            add_geometric_stiffness(weight, shape, slope, V, U, z0, p, Q, L, stress[e, g], stiffness_work, GT)
        if linked and with_tangent:
            for k in range(m):
                if links[e, k] >= 0:
                    map_columns(GT, 6 * k, X[k])
                    map_rows(GT, 6 * k, X[k])
        for k in range(m):
            n = nodes[e, k]
            for i in range(6):
                force[n, i] += fe[6 * k + i]
            if with_tangent:
                for other in range(m):
                    first = diagonal + 6 * (nodes[e, other] - n)
                    for j in range(6):
                        target = band[6 * n + j]
                        material = KT[6 * k + j]
                        turned = GT[6 * k + j]
                        for i in range(6):
                            target[first - j + i] += material[6 * other + i] + turned[6 * other + i]


@kernel
def update_stress(
    nodes: Integers, section_force: Floats, operator: Floats, increment: Floats, stress: Floats
) -> None:
    """Carry the section force of the last iterate along the Newton increment: ``stress = S + A dx``.

    This is the mixed (stress as an independent iterate) Newton step with the stress eliminated point by point.
    """
    m = nodes.shape[1]
    x = np.empty(6 * m)
    for e in range(nodes.shape[0]):
        for k in range(m):
            for i in range(6):
                x[6 * k + i] = increment[nodes[e, k], i]
        for g in range(operator.shape[1]):
            for i in range(6):
                total = section_force[e, g, i]
                for j in range(6 * m):
                    total += operator[e, g, i, j] * x[j]
                stress[e, g, i] = total


@kernel
def elastic_energy(
    weights: Floats, half_lengths: Floats, section: Integers, stiffness: Floats, strain: Floats
) -> float:
    """Return the elastic energy [J], ``1/2 int eps.C eps``, from the strains at the Gauss points."""
    total = 0.0
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            C = stiffness[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                for j in range(6):
                    total += 0.5 * weight * strain[e, g, i] * C[i, j] * strain[e, g, j]
    return total


@kernel
def viscous_loss(
    weights: Floats,
    half_lengths: Floats,
    section: Integers,
    damping: Floats,
    strain: Floats,
    earlier: Floats,
    duration: float,
) -> float:
    """Return the energy [J] lost between two strain states, ``int d_eps.D d_eps / duration`` (never negative).

    The mean rate of the step stands for the rate: of second order, and blind to ringing of the rates about their mean.
    """
    total = 0.0
    d = np.empty(6)
    for e in range(strain.shape[0]):
        for g in range(strain.shape[1]):
            D = damping[section[e, g]]
            weight = weights[g] * half_lengths[e]
            for i in range(6):
                d[i] = strain[e, g, i] - earlier[e, g, i]
            for i in range(6):
                for j in range(6):
                    total += weight * d[i] * D[i, j] * d[j] / duration
    return total
