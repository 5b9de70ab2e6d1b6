"""Internal forces of elements without their tangent, at low cost, for every stage of a step.

The formulas are those of ``variation``, applied instead of assembled: the flat increments of a Gauss point are those
of the nodal twists, ``c = sum N'_k Q_k v_k``, ``y = sum N_k L_k w_k``, ``b = sum N'_k L_k w_k``, and the nodal forces
are the transposed maps of the forces conjugate to them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.section_laws import SectionLaws, add_law_force, stored_and_lost
from viscorod.mechanics.elements.variation import (
    conjugate_forces,
    first_variation,
    flat_turn,
    node_in_section,
    section_in_node,
    strain_measures,
    turning_moment,
)
from viscorod.mechanics.nodes.attached_poses import attached_pose, attached_twist, shared_wrench
from viscorod.mechanics.rotations.vectors import (
    difference,
    plus,
    plus4,
    product,
    put,
    put4,
    put_stage,
    quaternion,
    same_hemisphere,
    scaled4,
    stage_quaternion,
    stage_vector,
    vector,
)
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
        laws: of the sections, beside C and D.
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
    laws: SectionLaws


class GaussStates(NamedTuple):
    """Strain, its rate, section force ``C eps + D eps_t + s`` and stress iterate at all Gauss points of some states.

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
    """Scratch for one element of the highest order: poses, twists and forces of its nodes, quaternions ``p``."""

    r: Floats
    q: Floats
    twist: Floats
    force: Floats
    p: Floats

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
) -> None:
    """Write poses and twists of an element's nodes in state ``i``, attachments applied, in one hemisphere.

    Args:
        count: number of nodes; nodes, links: those of the element.
        r, q, twist: of all nodes in all states ``(s, n, ...)``; R, Q, T: outputs.
    """
    before = (0.0, (0.0, 0.0, 0.0))
    for k in range(count):
        n, link = nodes[k], links[k]
        place, turn = stage_vector(r, i, n, 0), stage_quaternion(q, i, n)
        v, w = stage_vector(twist, i, n, 0), stage_vector(twist, i, n, 3)
        if link >= 0:
            d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
            place, turn = attached_pose(d, own, place, turn)
            v, w = attached_twist(d, own, v, w)
        before = turn = same_hemisphere(before, turn)
        put(R, k, 0, place)
        put4(Q, k, turn)
        put(T, k, 0, v)
        put(T, k, 3, w)


@part
def scatter(
    i: int,
    count: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    F: Floats,
    force: Floats,
) -> None:
    """Add the forces ``F`` on an element's nodes to those of all nodes in state ``i``, ``(s, n, 6)``."""
    for k in range(count):
        n, link = nodes[k], links[k]
        f, m = vector(F, k, 0), vector(F, k, 3)
        if link >= 0:
            f, m = shared_wrench(vector(link_positions, link, 0), quaternion(link_quaternions, link), f, m)
        put_stage(force, i, n, 0, plus(stage_vector(force, i, n, 0), 1.0, f))
        put_stage(force, i, n, 3, plus(stage_vector(force, i, n, 3), 1.0, m))


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

    Args:
        r, q, twist: poses and body twists of all nodes ``(s, n, ...)``; force: in their frames.
        points: outputs except the stress, which is the input of the forces; it may be the array of the section force.
        work: scratch.
    """
    orders, nodes, links, link_positions, link_quaternions, shapes, slopes, weights = elements[:8]
    half_lengths, section, stiffness, damping, damped, reference, _, laws = elements[8:]
    R, Q, T, F, P = work
    strain, strain_rate, S, sigma = points
    none = (0.0, (0.0, 0.0, 0.0))
    for at in range(force.shape[0]):
        for n in range(force.shape[1]):
            for i in range(6):
                force[at, n, i] = 0.0
        for e in range(orders.shape[0]):
            order = orders[e]
            m = order + 1
            gather(at, m, nodes[e], links[e], link_positions, link_quaternions, r, q, twist, R, Q, T)
            for k in range(m):
                for i in range(6):
                    F[k, i] = 0.0
            half = half_lengths[e]
            for g in range(order):
                t, f, df = (0.0, 0.0, 0.0), none, none
                for k in range(m):
                    # slopes sum to zero: differences to the first node lose no digits far from the origin
                    s = slopes[order, g, k] / half
                    t = plus(t, s, difference(vector(R, k, 0), vector(R, 0, 0)))
                    f = plus4(f, shapes[order, g, k], quaternion(Q, k))
                    df = plus4(df, s, plus4(quaternion(Q, k), -1.0, quaternion(Q, 0)))
                V, U, z0, inverse = strain_measures(t, f, df)
                c, y, b = (0.0, 0.0, 0.0), none, none
                for k in range(m):
                    p = product(inverse, quaternion(Q, k))
                    put4(P, k, p)
                    s, turn = slopes[order, g, k] / half, flat_turn(p, vector(T, k, 3))
                    c = plus(c, s, node_in_section(p, vector(T, k, 0)))
                    y, b = plus4(y, shapes[order, g, k], turn), plus4(b, s, turn)
                V_rate, U_rate = first_variation(V, U, z0, (c, y, b))
                of = section[e, g]
                for i in range(3):
                    strain[at, e, g, i] = V[i] - reference[e, g, i]
                    strain[at, e, g, 3 + i] = U[i] - reference[e, g, 3 + i]
                    strain_rate[at, e, g, i], strain_rate[at, e, g, 3 + i] = V_rate[i], U_rate[i]
                for i in range(6):
                    total = 0.0
                    for j in range(6):
                        total += stiffness[of, i, j] * strain[at, e, g, j]
                    if damped:
                        for j in range(6):
                            total += damping[of, i, j] * strain_rate[at, e, g, j]
                    S[at, e, g, i] = total
                if laws.present:
                    add_law_force(laws, of, strain[at, e, g], strain_rate[at, e, g], S[at, e, g])
                weight = weights[order, g] * half
                N = weight * sigma[at, e, g, 0], weight * sigma[at, e, g, 1], weight * sigma[at, e, g, 2]
                M = weight * sigma[at, e, g, 3], weight * sigma[at, e, g, 4], weight * sigma[at, e, g, 5]
                Fc, Fy, Fb = conjugate_forces(V, U, z0, N, M)
                for k in range(m):
                    p, s = quaternion(P, k), slopes[order, g, k] / half
                    moment = turning_moment(p, plus4(scaled4(s, Fb), shapes[order, g, k], Fy))
                    put(F, k, 0, plus(vector(F, k, 0), s, section_in_node(p, Fc)))
                    put(F, k, 3, plus(vector(F, k, 3), 1.0, moment))
            scatter(at, m, nodes[e], links[e], link_positions, link_quaternions, F, force)


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

    Those of the laws of sections are added.

    Args:
        strain, strain_rate: of some states ``(s, e, points, 6)``; elastic, dissipated: outputs ``(s,)``.
    """
    orders, weights, half_lengths = elements[0], elements[7], elements[8]
    section, C, D, laws = elements[9], elements[10], elements[11], elements.laws
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
                if laws.present:
                    stored, lost = stored_and_lost(laws, of, strain[at, e, g], strain_rate[at, e, g])
                    energy, power = energy + weight * stored, power + weight * lost
        elastic[at], dissipated[at] = energy, power
