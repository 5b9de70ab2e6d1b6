"""Operators of the section forces of all elements at one state, which collocation methods keep for several steps.

With the present ``C, D``, those of laws included, the section forces of a Gauss point vary by

    dS = C B d + D (E d + B dx1),     dx1 = (d)' + ad(x1) d

with nodal body increments ``d``, the strain operator ``B`` and the change ``E`` of the strain rate at constant twists
(see ``tangent_lanes``), so ``dS = A d + P d'`` with ``A = C B + D (E + B ad)`` and ``P = D B``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.gauss_batch import ElementGroup, PointFields
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.lanes import LANES
from viscorod.mechanics.elements.section_laws import add_law_tangents
from viscorod.mechanics.nodes.attached_poses import link_map, map_columns
from viscorod.mechanics.rotations.vectors import put_stage, stage_vector
from viscorod.typing import Floats


class Operators(NamedTuple):
    """``B``, ``A`` and ``P`` of all elements ``(e, 6 points, 6 nodes)``, rows of a Gauss point together."""

    strain: Floats
    force: Floats
    viscous: Floats

    @classmethod
    def of(cls, elements: Elements) -> Operators:
        """Allocate the arrays."""
        count, points, _ = elements.reference.shape
        shape = (count, 6 * points, 6 * (points + 1))
        return cls(np.zeros(shape), np.zeros(shape), np.zeros(shape))


@kernel
def collect(elements: Elements, group: ElementGroup, fields: PointFields, operators: Operators) -> None:
    """Write the operators of a group of elements after an assembly with the tangent.

    Increments of attached nodes are those of their own nodes in the assembly; here they become those of the shared
    nodes.

    Args:
        fields: of the assembly, with the change of the strain; operators: outputs.
    """
    links, section, damping, laws = elements.links, elements.section, elements.damping, elements.laws
    strain_columns, force_columns = fields.strain_operator, fields.operator
    B, A, P = operators
    points = group.order
    X, C, D = np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6))
    for number in range(group.size * points):
        batch, lane = divmod(number, LANES)
        e, g = divmod(number, points)
        e += group.first
        of = section[e, g]
        for i in range(6):
            for j in range(6):
                D[i, j] = damping[of, i, j]
        if laws.present:
            add_law_tangents(laws, of, fields.strain[e, g], fields.strain_rate[e, g], C, D)
        for k in range(points + 1):
            for i in range(6):
                for j in range(6):
                    row, column = 6 * g + i, 6 * k + j
                    B[e, row, column] = strain_columns[batch, k, j, i, lane]
                    A[e, row, column] = force_columns[batch, k, j, i, lane]
                    if group.damped:
                        total = 0.0
                        for a in range(6):
                            total += D[i, a] * strain_columns[batch, k, j, a, lane]
                        P[e, row, column] = total
    for e in range(group.first, group.first + group.size):
        for k in range(points + 1):
            link = links[e, k]
            if link >= 0:
                link_map(elements.link_positions[link], elements.link_quaternions[link], X)
                map_columns(B[e], 6 * k, X)
                map_columns(A[e], 6 * k, X)
                map_columns(P[e], 6 * k, X)


@part
def add_frozen_forces(
    elements: Elements, B: Floats, section_force: Floats, stress: Floats, force: Floats
) -> None:
    """Add ``sum_g w_g B^T (S - sigma)`` with the frozen ``B`` to the nodal forces ``(s, n, 6)`` of all stages."""
    orders, nodes, weights, half_lengths = elements[0], elements[1], elements[7], elements[8]
    for stage in range(force.shape[0]):
        for e in range(orders.shape[0]):
            order = orders[e]
            for k in range(order + 1):
                n, c = nodes[e, k], 6 * k
                # six sums beside each other: one would wait for every addition of its own
                f0, f1, f2 = stage_vector(force, stage, n, 0)
                f3, f4, f5 = stage_vector(force, stage, n, 3)
                for g in range(order):
                    weight = weights[order, g] * half_lengths[e]
                    for a in range(6):
                        excess = weight * (section_force[stage, e, g, a] - stress[stage, e, g, a])
                        row = 6 * g + a
                        f0 += excess * B[e, row, c]
                        f1 += excess * B[e, row, c + 1]
                        f2 += excess * B[e, row, c + 2]
                        f3 += excess * B[e, row, c + 3]
                        f4 += excess * B[e, row, c + 4]
                        f5 += excess * B[e, row, c + 5]
                put_stage(force, stage, n, 0, (f0, f1, f2))
                put_stage(force, stage, n, 3, (f3, f4, f5))


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
    """Update the stress by a change of all poses: ``sigma = S + A d + P d'`` with the frozen operators.

    Args:
        change, rate: body increments of the nodes at all stages ``(s, n, 6)`` and their rates [1/s].
        section_force: of the poses before the change ``(s, e, points, 6)``; stress: output.
    """
    orders, nodes, damped = elements[0], elements[1], elements[12]
    for e in range(orders.shape[0]):
        order = orders[e]
        for g in range(order):
            row = 6 * g
            for stage in range(change.shape[0]):
                s0, s1, s2 = (
                    section_force[stage, e, g, 0],
                    section_force[stage, e, g, 1],
                    section_force[stage, e, g, 2],
                )
                s3, s4, s5 = (
                    section_force[stage, e, g, 3],
                    section_force[stage, e, g, 4],
                    section_force[stage, e, g, 5],
                )
                for k in range(order + 1):
                    n = nodes[e, k]
                    for i in range(6):
                        c, x = 6 * k + i, change[stage, n, i]
                        s0 += A[e, row, c] * x
                        s1 += A[e, row + 1, c] * x
                        s2 += A[e, row + 2, c] * x
                        s3 += A[e, row + 3, c] * x
                        s4 += A[e, row + 4, c] * x
                        s5 += A[e, row + 5, c] * x
                    if damped:
                        for i in range(6):
                            c, x = 6 * k + i, rate[stage, n, i]
                            s0 += P[e, row, c] * x
                            s1 += P[e, row + 1, c] * x
                            s2 += P[e, row + 2, c] * x
                            s3 += P[e, row + 3, c] * x
                            s4 += P[e, row + 4, c] * x
                            s5 += P[e, row + 5, c] * x
                out = stress[stage, e, g]
                out[0], out[1], out[2], out[3], out[4], out[5] = s0, s1, s2, s3, s4, s5
