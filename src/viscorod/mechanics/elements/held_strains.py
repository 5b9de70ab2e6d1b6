"""Strains that are held at their reference values (Liu and Wang section 4) by a multiplier instead of a stiffness.

The multiplier of a strain component at a Gauss point is its section force times the weight of the point. As a separate
unknown it needs no compliance: unshearable, inextensible and Kirchhoff rods are the same element.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.joints.joint_tangent import scale_of
from viscorod.typing import Floats, Integers


class HeldStrains(NamedTuple):
    """All strain components that are held.

    Attributes:
        element, point, component: where ``(h,)``; the element counts as in ``internal_force.Elements``.
        place: number of the multiplier ``(h,)``; weight: of the Gauss point times half the element's length ``(h,)``.
        up, down: blocks (node k, multiplier) and (multiplier, node k) ``(h, most nodes)``.
    """

    element: Integers
    point: Integers
    component: Integers
    place: Integers
    weight: Floats
    up: Integers
    down: Integers

    @classmethod
    def none(cls) -> HeldStrains:
        """Return no strains."""
        whole, table = np.zeros(0, dtype=np.int64), np.zeros((0, 1), dtype=np.int64)
        return cls(whole, whole, whole, whole, np.zeros(0), table, table)


@part
def give_stress(held: HeldStrains, multiplier: Floats, stress: Floats) -> None:
    """Write the multipliers ``(s, places)`` into the stresses ``(s, e, points, 6)`` of some states."""
    element, point, component, place, weight = held[:5]
    for i in range(stress.shape[0]):
        for h in range(element.shape[0]):
            stress[i, element[h], point[h], component[h]] = multiplier[i, place[h]] / weight[h]


@part
def keep_stress(held: HeldStrains, stress: Floats, section_force: Floats) -> None:
    """Set the section forces of held strains to their stresses, since no law gives them."""
    element, point, component = held[:3]
    for i in range(stress.shape[0]):
        for h in range(element.shape[0]):
            e, g, c = element[h], point[h], component[h]
            section_force[i, e, g, c] = stress[i, e, g, c]


@part
def strain_gaps(held: HeldStrains, strain: Floats, gap: Floats) -> None:
    """Write the gaps of the held strains ``(s, e, points, 6)`` that the multipliers must close ``(s, places)``."""
    element, point, component, place = held[:4]
    for i in range(strain.shape[0]):
        for h in range(element.shape[0]):
            gap[i, place[h]] = strain[i, element[h], point[h], component[h]]


@kernel
def add_held_strains(
    held: HeldStrains,
    orders: Integers,
    stiff: float,
    length: float,
    B: Floats,
    scale: Floats,
    K: Floats,
) -> None:
    """Add rows and columns of the multipliers of held strains to a matrix.

    Args:
        orders: of the elements; stiff, length: see ``joint_tangent.scale_of``.
        B: change of the strains per nodal increment ``(e, 6 points, 6 nodes)``.
        scale: output, of all multipliers, as in ``joint_tangent.add_joint_tangent``; K: blocks ``(b, 6, 6)``.
    """
    element, point, component, place, _, up, down = held
    for h in range(element.shape[0]):
        e, number = element[h], place[h]
        row = 6 * point[h] + component[h]
        size = scale_of(number, B[e, row, : 6 * orders[e] + 6], stiff, length)
        scale[number] = size
        for k in range(orders[e] + 1):
            for j in range(6):
                b = size * B[e, row, 6 * k + j]
                K[up[h, k], number % 6, j] += b
                K[down[h, k], j, number % 6] += b
