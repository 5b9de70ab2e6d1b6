"""Internal forces of elements without their tangent: cheap enough to be evaluated at every stage of a step.

The formulas are those of ``strain``, applied instead of assembled: with ``p_k = conj(q~) q_k/|q~|^2`` the strain
rates are

    V_t = c + 2 V x y        U_t = 2 b - y0 U - 2 z0 y + U x y
    c = sum N'_k Q_k v_k     (y0, y) = sum N_k p_k (0, w_k)/2     b = vec sum N'_k p_k (0, w_k)/2

and the nodal forces are the transposed maps of the section force and moment.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.attachment import link_map
from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.rotation import quaternion_product, rotate
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


class Points(NamedTuple):
    """Strain, its rate, section force ``C eps + D eps_t`` and stress iterate at all Gauss points ``(e, points, 6)``."""

    strain: Floats
    strain_rate: Floats
    section_force: Floats
    stress: Floats

    @classmethod
    def of(cls, elements: Elements) -> Points:
        """Allocate."""
        shape = elements.reference.shape
        return cls(np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape))


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
        """Allocate for elements up to ``order``."""
        m = order + 1
        return cls(
            np.empty((m, 3)),
            np.empty((m, 4)),
            np.empty((m, 6)),
            np.empty((m, 6)),
            np.empty((m, 4)),
            np.empty((6, 6)),
        )


@kernel
def gather(elements: Elements, e: int, r: Floats, q: Floats, twist: Floats, work: ElementWork) -> None:
    """Put poses and twists of the nodes of element ``e`` into ``work``, attachments applied, in one hemisphere."""
    R, Q, T = work.r, work.q, work.twist
    for k in range(elements.order[e] + 1):
        n, link = elements.nodes[e, k], elements.links[e, k]
        if link < 0:
            for i in range(3):
                R[k, i] = r[n, i]
            for i in range(4):
                Q[k, i] = q[n, i]
            for i in range(6):
                T[k, i] = twist[n, i]
        else:
            rotate(q[n], elements.link_positions[link], R[k])
            for i in range(3):
                R[k, i] += r[n, i]
            quaternion_product(q[n], elements.link_quaternions[link], Q[k])
            link_map(elements.link_positions[link], elements.link_quaternions[link], work.X)
            for i in range(6):
                T[k, i] = 0.0
                for j in range(6):
                    T[k, i] += work.X[i, j] * twist[n, j]
        if k > 0:
            dot = 0.0
            for i in range(4):
                dot += Q[k, i] * Q[k - 1, i]
            if dot < 0.0:
                for i in range(4):
                    Q[k, i] = -Q[k, i]


@kernel
def scatter(elements: Elements, e: int, work: ElementWork, force: Floats) -> None:
    """Add the nodal forces of element ``e`` to those of all nodes ``(n, 6)``."""
    for k in range(elements.order[e] + 1):
        n, link = elements.nodes[e, k], elements.links[e, k]
        if link < 0:
            for i in range(6):
                force[n, i] += work.force[k, i]
        else:
            link_map(elements.link_positions[link], elements.link_quaternions[link], work.X)
            for i in range(6):
                for j in range(6):
                    force[n, i] += work.X[j, i] * work.force[k, j]


@kernel
def internal_forces(
    elements: Elements,
    r: Floats,
    q: Floats,
    twist: Floats,
    points: Points,
    mixed: bool,
    work: ElementWork,
    force: Floats,
) -> None:
    """Write the internal forces ``sum_g w_g B^T sigma (n, 6)``, in body frames, and the state of all Gauss points.

    Indices are written out and intermediate vectors are scalars: views of arrays count references, which takes three
    times as long as the arithmetic.

    Args:
        r, q, twist: poses and body twists of all nodes.
        points: outputs, but with ``mixed`` the stress is given; otherwise it becomes the section force.
        work: scratch.
    """
    R, Q, T, F, p = work.r, work.q, work.twist, work.force, work.p
    shapes, slopes, weights = elements.shapes, elements.slopes, elements.weights
    reference, section = elements.reference, elements.section
    stiffness, damping, damped = elements.stiffness, elements.damping, elements.damped
    strain, strain_rate, S, sigma = points.strain, points.strain_rate, points.section_force, points.stress
    force[:, :] = 0.0
    for e in range(elements.order.shape[0]):
        order = elements.order[e]
        m = order + 1
        gather(elements, e, r, q, twist, work)
        for k in range(m):
            for i in range(6):
                F[k, i] = 0.0
        half = elements.half_lengths[e]
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
            strain_rate[e, g, 0] = c0 + 2.0 * (V1 * y3 - V2 * y2)
            strain_rate[e, g, 1] = c1 + 2.0 * (V2 * y1 - V0 * y3)
            strain_rate[e, g, 2] = c2 + 2.0 * (V0 * y2 - V1 * y1)
            strain_rate[e, g, 3] = b1 - y0 * U0 - 2.0 * z0 * y1 + U1 * y3 - U2 * y2
            strain_rate[e, g, 4] = b2 - y0 * U1 - 2.0 * z0 * y2 + U2 * y1 - U0 * y3
            strain_rate[e, g, 5] = b3 - y0 * U2 - 2.0 * z0 * y3 + U0 * y2 - U1 * y1
            strain[e, g, 0], strain[e, g, 1], strain[e, g, 2] = V0, V1, V2
            strain[e, g, 3], strain[e, g, 4], strain[e, g, 5] = U0, U1, U2
            of = section[e, g]
            for i in range(6):
                strain[e, g, i] -= reference[e, g, i]
            for i in range(6):
                total = 0.0
                for j in range(6):
                    total += stiffness[of, i, j] * strain[e, g, j]
                if damped:
                    for j in range(6):
                        total += damping[of, i, j] * strain_rate[e, g, j]
                S[e, g, i] = total
                if not mixed:
                    sigma[e, g, i] = total
            # B^T sigma: the transposed maps, N on c, (f0, f) on y and 2 M on b
            weight = weights[order, g] * half
            N0, N1, N2 = weight * sigma[e, g, 0], weight * sigma[e, g, 1], weight * sigma[e, g, 2]
            M0, M1, M2 = weight * sigma[e, g, 3], weight * sigma[e, g, 4], weight * sigma[e, g, 5]
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
        scatter(elements, e, work, force)


@kernel
def conserve_energy(
    elements: Elements, strain: Floats, strain_rate: Floats, start: Floats, end: Floats, h: float, S: Floats
) -> None:
    """Change section forces at the middle of a step so that their work is exactly the change of elastic energy.

    With ``d = h eps_t`` of the middle, ``S + alpha C d`` works ``W(end) - W(start)`` over ``d`` for one ``alpha``
    (Gonzalez 1996, the discrete gradient, point by point); ``alpha`` is of second order in the step. Viscous parts of
    ``S`` keep their work, ``eps_t.D eps_t``.

    Args:
        strain, strain_rate: in the middle ``(e, points, 6)``; start, end: strains at the ends of the step.
        h: step [s]; S: section forces, changed.
    """
    for e in range(elements.order.shape[0]):
        for g in range(elements.order[e]):
            C = elements.stiffness[elements.section[e, g]]
            lacking = 0.0
            square = 0.0
            for i in range(6):
                for j in range(6):
                    d = h * strain_rate[e, g, j]
                    mean = 0.5 * (start[e, g, i] + end[e, g, i])
                    lacking += C[i, j] * (mean * (end[e, g, j] - start[e, g, j]) - strain[e, g, i] * d)
                    square += C[i, j] * h * strain_rate[e, g, i] * d
            # where the strain stands still there is no work to correct
            if abs(lacking) < square:
                for i in range(6):
                    for j in range(6):
                        S[e, g, i] += lacking / square * C[i, j] * h * strain_rate[e, g, j]


@kernel
def energies(elements: Elements, points: Points) -> tuple[float, float]:
    """Return the elastic energy [J] and the dissipated power [W], ``int eps.C eps / 2`` and ``int eps_t.D eps_t``."""
    elastic = 0.0
    power = 0.0
    for e in range(elements.order.shape[0]):
        order = elements.order[e]
        for g in range(order):
            C = elements.stiffness[elements.section[e, g]]
            D = elements.damping[elements.section[e, g]]
            weight = elements.weights[order, g] * elements.half_lengths[e]
            eps, rate = points.strain[e, g], points.strain_rate[e, g]
            for i in range(6):
                for j in range(6):
                    elastic += 0.5 * weight * eps[i] * C[i, j] * eps[j]
                    power += weight * rate[i] * D[i, j] * rate[j]
    return elastic, power
