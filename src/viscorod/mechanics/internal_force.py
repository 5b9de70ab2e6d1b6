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
from viscorod.mechanics.strain import element_poses, gauss_point
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


class ElementWork(NamedTuple):
    """Scratch arrays for one element of the highest order."""

    r: Floats
    q: Floats
    twist: Floats
    force: Floats
    p: Floats
    slope: Floats
    frame: Floats
    V: Floats
    U: Floats
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
            np.empty(m),
            np.empty(4),
            np.empty(3),
            np.empty(3),
            np.empty((6, 6)),
        )


@kernel
def strain_rates(
    shape: Floats, slope: Floats, V: Floats, U: Floats, z0: float, p: Floats, twist: Floats, rate: Floats
) -> None:
    """Write the strain rates ``(V_t, U_t)`` that nodal body twists ``(m, 6)`` cause."""
    c0 = c1 = c2 = y0 = y1 = y2 = y3 = b1 = b2 = b3 = 0.0
    double = 2.0 / (p[0, 0] * p[0, 0] + p[0, 1] * p[0, 1] + p[0, 2] * p[0, 2] + p[0, 3] * p[0, 3])
    for k in range(p.shape[0]):
        v0, v1, v2, w0, w1, w2 = twist[k]
        p0, p1, p2, p3 = p[k]
        s, n = slope[k], 0.5 * shape[k]
        t0, t1, t2 = double * (p2 * v2 - p3 * v1), double * (p3 * v0 - p1 * v2), double * (p1 * v1 - p2 * v0)
        c0 += s * (v0 + p0 * t0 + p2 * t2 - p3 * t1)
        c1 += s * (v1 + p0 * t1 + p3 * t0 - p1 * t2)
        c2 += s * (v2 + p0 * t2 + p1 * t1 - p2 * t0)
        l0 = -p1 * w0 - p2 * w1 - p3 * w2
        l1 = p0 * w0 - p3 * w1 + p2 * w2
        l2 = p3 * w0 + p0 * w1 - p1 * w2
        l3 = -p2 * w0 + p1 * w1 + p0 * w2
        y0 += n * l0
        y1 += n * l1
        y2 += n * l2
        y3 += n * l3
        b1 += s * l1
        b2 += s * l2
        b3 += s * l3
    rate[0] = c0 + 2.0 * (V[1] * y3 - V[2] * y2)
    rate[1] = c1 + 2.0 * (V[2] * y1 - V[0] * y3)
    rate[2] = c2 + 2.0 * (V[0] * y2 - V[1] * y1)
    rate[3] = b1 - y0 * U[0] - 2.0 * z0 * y1 + U[1] * y3 - U[2] * y2
    rate[4] = b2 - y0 * U[1] - 2.0 * z0 * y2 + U[2] * y1 - U[0] * y3
    rate[5] = b3 - y0 * U[2] - 2.0 * z0 * y3 + U[0] * y2 - U[1] * y1


@kernel
def add_nodal_forces(
    weight: float,
    shape: Floats,
    slope: Floats,
    V: Floats,
    U: Floats,
    z0: float,
    p: Floats,
    S: Floats,
    force: Floats,
) -> None:
    """Add ``weight B^T S`` to the nodal forces ``(m, 6)`` of an element."""
    N0, N1, N2 = weight * S[0], weight * S[1], weight * S[2]
    M0, M1, M2 = weight * S[3], weight * S[4], weight * S[5]
    f0 = -(M0 * U[0] + M1 * U[1] + M2 * U[2])
    f1 = 2.0 * (N1 * V[2] - N2 * V[1]) - 2.0 * z0 * M0 + M1 * U[2] - M2 * U[1]
    f2 = 2.0 * (N2 * V[0] - N0 * V[2]) - 2.0 * z0 * M1 + M2 * U[0] - M0 * U[2]
    f3 = 2.0 * (N0 * V[1] - N1 * V[0]) - 2.0 * z0 * M2 + M0 * U[1] - M1 * U[0]
    double = 2.0 / (p[0, 0] * p[0, 0] + p[0, 1] * p[0, 1] + p[0, 2] * p[0, 2] + p[0, 3] * p[0, 3])
    for k in range(p.shape[0]):
        p0, p1, p2, p3 = p[k]
        s, n = slope[k], 0.5 * shape[k]
        t0, t1, t2 = double * (p2 * N2 - p3 * N1), double * (p3 * N0 - p1 * N2), double * (p1 * N1 - p2 * N0)
        force[k, 0] += s * (N0 - p0 * t0 + p2 * t2 - p3 * t1)
        force[k, 1] += s * (N1 - p0 * t1 + p3 * t0 - p1 * t2)
        force[k, 2] += s * (N2 - p0 * t2 + p1 * t1 - p2 * t0)
        g0, g1, g2, g3 = n * f0, n * f1 + s * M0, n * f2 + s * M1, n * f3 + s * M2
        force[k, 3] += -p1 * g0 + p0 * g1 + p3 * g2 - p2 * g3
        force[k, 4] += -p2 * g0 - p3 * g1 + p0 * g2 + p1 * g3
        force[k, 5] += -p3 * g0 + p2 * g1 - p1 * g2 + p0 * g3


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

    Args:
        r, q, twist: poses and body twists of all nodes.
        points: outputs, but with ``mixed`` the stress is given; otherwise it becomes the section force.
        work: scratch.
    """
    force[:, :] = 0.0
    X = work.X
    V, U = work.V, work.U
    for e in range(elements.order.shape[0]):
        order = elements.order[e]
        m = order + 1
        nodes, links = elements.nodes[e, :m], elements.links[e, :m]
        re, qe, te, fe = work.r[:m], work.q[:m], work.twist[:m], work.force[:m]
        p, slope = work.p[:m], work.slope[:m]
        element_poses(nodes, links, elements.link_positions, elements.link_quaternions, r, q, re, qe)
        for k in range(m):
            n = nodes[k]
            for i in range(6):
                te[k, i] = twist[n, i]
                fe[k, i] = 0.0
            if links[k] >= 0:
                link_map(elements.link_positions[links[k]], elements.link_quaternions[links[k]], X)
                for i in range(6):
                    te[k, i] = 0.0
                    for j in range(6):
                        te[k, i] += X[i, j] * twist[n, j]
        half = elements.half_lengths[e]
        for g in range(order):
            shape = elements.shapes[order, g, :m]
            for k in range(m):
                slope[k] = elements.slopes[order, g, k] / half
            z0 = gauss_point(shape, slope, re, qe, V, U, p, work.frame)
            C = elements.stiffness[elements.section[e, g]]
            eps, rate, S = points.strain[e, g], points.strain_rate[e, g], points.section_force[e, g]
            reference = elements.reference[e, g]
            for i in range(3):
                eps[i] = V[i] - reference[i]
                eps[3 + i] = U[i] - reference[3 + i]
            strain_rates(shape, slope, V, U, z0, p, te, rate)
            for i in range(6):
                S[i] = 0.0
                for j in range(6):
                    S[i] += C[i, j] * eps[j]
            if elements.damped:
                D = elements.damping[elements.section[e, g]]
                for i in range(6):
                    for j in range(6):
                        S[i] += D[i, j] * rate[j]
            sigma = points.stress[e, g]
            if not mixed:
                for i in range(6):
                    sigma[i] = S[i]
            add_nodal_forces(elements.weights[order, g] * half, shape, slope, V, U, z0, p, sigma, fe)
        for k in range(m):
            n = nodes[k]
            if links[k] < 0:
                for i in range(6):
                    force[n, i] += fe[k, i]
            else:
                link_map(elements.link_positions[links[k]], elements.link_quaternions[links[k]], X)
                for i in range(6):
                    for j in range(6):
                        force[n, i] += X[j, i] * fe[k, j]


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
