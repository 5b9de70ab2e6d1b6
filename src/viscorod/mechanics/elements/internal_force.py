"""Internal forces of elements without their tangent, at low cost, for every stage of a step.

The formulas are those of ``strain``, applied instead of assembled: with ``p_k = conj(q~) q_k/|q~|^2`` the strain
rates are

    V_t = c + 2 V x y        U_t = 2 b - y0 U - 2 z0 y + U x y
    c = sum N'_k Q_k v_k     (y0, y) = sum N_k p_k (0, w_k)/2     b = vec sum N'_k p_k (0, w_k)/2

and the nodal forces are the transposed maps of the section force and moment.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.nodes.attached_poses import link_map
from viscorod.mechanics.rotations.rotation import quaternion_product, rotate
from viscorod.typing import Floats, Integers


class Elements(NamedTuple):
    """All elements of a problem in rectangular arrays; ``order`` says how much of a row is used.

    Attributes:
        order: polynomial order of each element ``(e,)``, which has order + 1 nodes and order Gauss points.
        nodes, links: ``(e, most nodes)``, shared node and attachment (or -1) of every element node.
        link_positions, link_quaternions: constant relative poses of the attachments.
        shapes, slopes: basis and its derivative in xi by order ``(orders, points, nodes)``; weights ``(orders,
            points)``.
        half_lengths: half the reference arc length ``(e,)`` [m].
        section: index of the section at every Gauss point ``(e, points)``.
        stiffness, damping: section matrices C and D ``(sections, 6, 6)``; damped: any D is not zero.
        reference: strains of the unstressed shape ``(e, points, 6)``.
        slots: number of the matrix block in the row of node k and the column of node j ``(e, most nodes, most nodes)``.
    """

    order: Integers
    nodes: Integers
    links: Integers
    link_positions: Floats
    link_quaternions: Floats
    shapes: Floats
    slopes: Floats
    weights: Floats
    half_lengths: Floats
    section: Integers
    stiffness: Floats
    damping: Floats
    damped: bool
    reference: Floats
    slots: Integers


class GaussStates(NamedTuple):
    """Strain, its rate, section force ``C eps + D eps_t`` and stress iterate at all Gauss points of some states.

    Arrays ``(s, e, points, 6)``.
    """

    strain: Floats
    strain_rate: Floats
    section_force: Floats
    stress: Floats

    @classmethod
    def of(cls, elements: Elements, states: int, *, carried: bool = False) -> GaussStates:
        """Allocate the arrays, with the section force as the stress unless this is ``carried`` separately."""
        shape = (states, *elements.reference.shape)
        force = np.zeros(shape)
        return cls(np.zeros(shape), np.zeros(shape), force, np.zeros(shape) if carried else force)


class ElementWork(NamedTuple):
    """Scratch for one element of the highest order: poses, twists and forces of its nodes, quaternions, one 6x6 map."""

    r: Floats
    q: Floats
    twist: Floats
    force: Floats
    p: Floats
    X: Floats

    @classmethod
    def of(cls, order: int) -> ElementWork:
        """Allocate the arrays for elements up to ``order``."""
        m = order + 1
        return cls(
            np.empty((m, 3)),
            np.empty((m, 4)),
            np.empty((m, 6)),
            np.empty((m, 6)),
            np.empty((m, 4)),
            np.empty((6, 6)),
        )


@part
def gather(
    i: int,
    count: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    R: Floats,
    Q: Floats,
    T: Floats,
    X: Floats,
) -> None:
    """Write poses and twists of an element's nodes in state ``i``, attachments applied, in one hemisphere.

    Args:
        count: number of nodes; nodes, links: those of the element.
        r, q, twist: of all nodes in all states ``(s, n, ...)``; R, Q, T: outputs; X: scratch.
    """
    for k in range(count):
        n, link = nodes[k], links[k]
        if link < 0:
            for a in range(3):
                R[k, a] = r[i, n, a]
            for a in range(4):
                Q[k, a] = q[i, n, a]
            for a in range(6):
                T[k, a] = twist[i, n, a]
        else:
            rotate(q[i, n], link_positions[link], R[k])
            for a in range(3):
                R[k, a] += r[i, n, a]
            quaternion_product(q[i, n], link_quaternions[link], Q[k])
            link_map(link_positions[link], link_quaternions[link], X)
            for a in range(6):
                T[k, a] = 0.0
                for b in range(6):
                    T[k, a] += X[a, b] * twist[i, n, b]
        if k > 0:
            dot = 0.0
            for a in range(4):
                dot += Q[k, a] * Q[k - 1, a]
            if dot < 0.0:
                for a in range(4):
                    Q[k, a] = -Q[k, a]


@part
def scatter(
    i: int,
    count: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    F: Floats,
    X: Floats,
    force: Floats,
) -> None:
    """Add the forces ``F`` on an element's nodes to those of all nodes in state ``i``, ``(s, n, 6)``."""
    for k in range(count):
        n, link = nodes[k], links[k]
        if link < 0:
            for a in range(6):
                force[i, n, a] += F[k, a]
        else:
            link_map(link_positions[link], link_quaternions[link], X)
            for a in range(6):
                for b in range(6):
                    force[i, n, a] += X[b, a] * F[k, b]


@kernel
def internal_forces(
    elements: Elements,
    r: Floats,
    q: Floats,
    twist: Floats,
    points: GaussStates,
    work: ElementWork,
    force: Floats,
) -> None:
    """Write the internal forces ``sum_g w_g B^T sigma (s, n, 6)`` of some states, and the state of all Gauss points.

    Indices are written out and intermediate vectors are scalars: views of arrays count references, which takes three
    times as long as the arithmetic.

    Args:
        r, q, twist: poses and body twists of all nodes ``(s, n, ...)``; force: in their frames.
        points: outputs except the stress, which is the input of the forces; it may be the array of the section force.
        work: scratch.
    """
    orders, nodes, links, link_positions, link_quaternions, shapes, slopes, weights = elements[:8]
    half_lengths, section, stiffness, damping, damped, reference = elements[8:14]
    R, Q, T, F, p, X = work
    strain, strain_rate, S, sigma = points
    for at in range(force.shape[0]):
        for n in range(force.shape[1]):
            for i in range(6):
                force[at, n, i] = 0.0
        for e in range(orders.shape[0]):
            order = orders[e]
            m = order + 1
            gather(at, m, nodes[e], links[e], link_positions, link_quaternions, r, q, twist, R, Q, T, X)
            for k in range(m):
                for i in range(6):
                    F[k, i] = 0.0
            half = half_lengths[e]
            for g in range(order):
                # r', q~ and q~'; slopes sum to zero: differences to the first node lose no digits far from the origin
                t0 = t1 = t2 = f0 = f1 = f2 = f3 = g0 = g1 = g2 = g3 = 0.0
                for k in range(m):
                    s, n = slopes[order, g, k] / half, shapes[order, g, k]
                    t0 += s * (R[k, 0] - R[0, 0])
                    t1 += s * (R[k, 1] - R[0, 1])
                    t2 += s * (R[k, 2] - R[0, 2])
                    f0 += n * Q[k, 0]
                    f1 += n * Q[k, 1]
                    f2 += n * Q[k, 2]
                    f3 += n * Q[k, 3]
                    g0 += s * (Q[k, 0] - Q[0, 0])
                    g1 += s * (Q[k, 1] - Q[0, 1])
                    g2 += s * (Q[k, 2] - Q[0, 2])
                    g3 += s * (Q[k, 3] - Q[0, 3])
                # i = conj(q~)/|q~|^2, z = i q~', U = 2 vec z, V = R^T r'
                norm2 = f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3
                i0, i1, i2, i3 = f0 / norm2, -f1 / norm2, -f2 / norm2, -f3 / norm2
                double = 2.0 * norm2
                z0 = i0 * g0 - i1 * g1 - i2 * g2 - i3 * g3
                U0 = 2.0 * (i0 * g1 + i1 * g0 + i2 * g3 - i3 * g2)
                U1 = 2.0 * (i0 * g2 + i2 * g0 + i3 * g1 - i1 * g3)
                U2 = 2.0 * (i0 * g3 + i3 * g0 + i1 * g2 - i2 * g1)
                x0, x1, x2 = i2 * t2 - i3 * t1, i3 * t0 - i1 * t2, i1 * t1 - i2 * t0
                V0 = t0 + double * (i0 * x0 + i2 * x2 - i3 * x1)
                V1 = t1 + double * (i0 * x1 + i3 * x0 - i1 * x2)
                V2 = t2 + double * (i0 * x2 + i1 * x1 - i2 * x0)
                # c, (y0, y) and b of the nodal twists
                c0 = c1 = c2 = y0 = y1 = y2 = y3 = b1 = b2 = b3 = 0.0
                for k in range(m):
                    a0, a1, a2, a3 = Q[k, 0], Q[k, 1], Q[k, 2], Q[k, 3]
                    p0 = i0 * a0 - i1 * a1 - i2 * a2 - i3 * a3
                    p1 = i0 * a1 + i1 * a0 + i2 * a3 - i3 * a2
                    p2 = i0 * a2 + i2 * a0 + i3 * a1 - i1 * a3
                    p3 = i0 * a3 + i3 * a0 + i1 * a2 - i2 * a1
                    p[k, 0], p[k, 1], p[k, 2], p[k, 3] = p0, p1, p2, p3
                    v0, v1, v2, w0, w1, w2 = T[k, 0], T[k, 1], T[k, 2], T[k, 3], T[k, 4], T[k, 5]
                    s, n = slopes[order, g, k] / half, 0.5 * shapes[order, g, k]
                    x0, x1, x2 = p2 * v2 - p3 * v1, p3 * v0 - p1 * v2, p1 * v1 - p2 * v0
                    c0 += s * (v0 + double * (p0 * x0 + p2 * x2 - p3 * x1))
                    c1 += s * (v1 + double * (p0 * x1 + p3 * x0 - p1 * x2))
                    c2 += s * (v2 + double * (p0 * x2 + p1 * x1 - p2 * x0))
                    l1 = p0 * w0 - p3 * w1 + p2 * w2
                    l2 = p3 * w0 + p0 * w1 - p1 * w2
                    l3 = -p2 * w0 + p1 * w1 + p0 * w2
                    y0 -= n * (p1 * w0 + p2 * w1 + p3 * w2)
                    y1 += n * l1
                    y2 += n * l2
                    y3 += n * l3
                    b1 += s * l1
                    b2 += s * l2
                    b3 += s * l3
                strain_rate[at, e, g, 0] = c0 + 2.0 * (V1 * y3 - V2 * y2)
                strain_rate[at, e, g, 1] = c1 + 2.0 * (V2 * y1 - V0 * y3)
                strain_rate[at, e, g, 2] = c2 + 2.0 * (V0 * y2 - V1 * y1)
                strain_rate[at, e, g, 3] = b1 - y0 * U0 - 2.0 * z0 * y1 + U1 * y3 - U2 * y2
                strain_rate[at, e, g, 4] = b2 - y0 * U1 - 2.0 * z0 * y2 + U2 * y1 - U0 * y3
                strain_rate[at, e, g, 5] = b3 - y0 * U2 - 2.0 * z0 * y3 + U0 * y2 - U1 * y1
                strain[at, e, g, 0], strain[at, e, g, 1], strain[at, e, g, 2] = V0, V1, V2
                strain[at, e, g, 3], strain[at, e, g, 4], strain[at, e, g, 5] = U0, U1, U2
                of = section[e, g]
                for i in range(6):
                    strain[at, e, g, i] -= reference[e, g, i]
                for i in range(6):
                    total = 0.0
                    for j in range(6):
                        total += stiffness[of, i, j] * strain[at, e, g, j]
                    if damped:
                        for j in range(6):
                            total += damping[of, i, j] * strain_rate[at, e, g, j]
                    S[at, e, g, i] = total
                # B^T sigma: the transposed maps, N on c, (f0, f) on y and 2 M on b
                weight = weights[order, g] * half
                N0, N1, N2 = (
                    weight * sigma[at, e, g, 0],
                    weight * sigma[at, e, g, 1],
                    weight * sigma[at, e, g, 2],
                )
                M0, M1, M2 = (
                    weight * sigma[at, e, g, 3],
                    weight * sigma[at, e, g, 4],
                    weight * sigma[at, e, g, 5],
                )
                f0 = -(M0 * U0 + M1 * U1 + M2 * U2)
                f1 = 2.0 * (N1 * V2 - N2 * V1) - 2.0 * z0 * M0 + M1 * U2 - M2 * U1
                f2 = 2.0 * (N2 * V0 - N0 * V2) - 2.0 * z0 * M1 + M2 * U0 - M0 * U2
                f3 = 2.0 * (N0 * V1 - N1 * V0) - 2.0 * z0 * M2 + M0 * U1 - M1 * U0
                for k in range(m):
                    p0, p1, p2, p3 = p[k, 0], p[k, 1], p[k, 2], p[k, 3]
                    s, n = slopes[order, g, k] / half, 0.5 * shapes[order, g, k]
                    x0, x1, x2 = p2 * N2 - p3 * N1, p3 * N0 - p1 * N2, p1 * N1 - p2 * N0
                    F[k, 0] += s * (N0 - double * (p0 * x0 - p2 * x2 + p3 * x1))
                    F[k, 1] += s * (N1 - double * (p0 * x1 - p3 * x0 + p1 * x2))
                    F[k, 2] += s * (N2 - double * (p0 * x2 - p1 * x1 + p2 * x0))
                    g0, g1, g2, g3 = n * f0, n * f1 + s * M0, n * f2 + s * M1, n * f3 + s * M2
                    F[k, 3] += -p1 * g0 + p0 * g1 + p3 * g2 - p2 * g3
                    F[k, 4] += -p2 * g0 - p3 * g1 + p0 * g2 + p1 * g3
                    F[k, 5] += -p3 * g0 + p2 * g1 - p1 * g2 + p0 * g3
            scatter(at, m, nodes[e], links[e], link_positions, link_quaternions, F, X, force)


@part
def conserve_energy(
    elements: Elements,
    strain: Floats,
    strain_rate: Floats,
    start: Floats,
    end: Floats,
    h: float,
    others: Floats,
    S: Floats,
) -> None:
    """Change section forces at the middle of a step so that their work is exactly the change of elastic energy.

    With ``d = h eps_t`` of the middle, the work of ``S + alpha C d`` over ``d`` is ``W(end) - W(start)`` for one
    ``alpha`` (Gonzalez 1996, the discrete gradient, point by point); ``alpha`` is of second order in the step. The
    viscous part of ``S`` keeps its work, ``eps_t.D eps_t``.

    Args:
        strain, strain_rate: in the middle ``(1, e, points, 6)``; start, end: strains at the ends of the step, likewise.
        h: step [s]; others: energy defect of other parts of ``S`` ``(e, points)`` [J/m].
        S: section forces, changed.
    """
    orders, section, C = elements[0], elements[9], elements[10]
    for e in range(orders.shape[0]):
        for g in range(orders[e]):
            of = section[e, g]
            lacking = others[e, g]
            square = 0.0
            for i in range(6):
                for j in range(6):
                    d = h * strain_rate[0, e, g, j]
                    mean = 0.5 * (start[0, e, g, i] + end[0, e, g, i])
                    work = mean * (end[0, e, g, j] - start[0, e, g, j])
                    lacking += C[of, i, j] * (work - strain[0, e, g, i] * d)
                    square += C[of, i, j] * h * strain_rate[0, e, g, i] * d
            # where the strain is constant there is no work to correct
            if abs(lacking) < square:
                for i in range(6):
                    for j in range(6):
                        S[0, e, g, i] += lacking / square * C[of, i, j] * h * strain_rate[0, e, g, j]


@kernel
def energies(
    elements: Elements, strain: Floats, strain_rate: Floats, elastic: Floats, dissipated: Floats
) -> None:
    """Write the elastic energies [J], ``int eps.C eps / 2``, and dissipated powers [W], ``int eps_t.D eps_t``.

    Args:
        strain, strain_rate: of some states ``(s, e, points, 6)``; elastic, dissipated: outputs ``(s,)``.
    """
    orders, weights, half_lengths = elements[0], elements[7], elements[8]
    section, C, D = elements[9], elements[10], elements[11]
    for at in range(strain.shape[0]):
        energy = 0.0
        power = 0.0
        for e in range(orders.shape[0]):
            order = orders[e]
            for g in range(order):
                of = section[e, g]
                weight = weights[order, g] * half_lengths[e]
                for i in range(6):
                    for j in range(6):
                        energy += 0.5 * weight * strain[at, e, g, i] * C[of, i, j] * strain[at, e, g, j]
                        power += weight * strain_rate[at, e, g, i] * D[of, i, j] * strain_rate[at, e, g, j]
        elastic[at], dissipated[at] = energy, power
