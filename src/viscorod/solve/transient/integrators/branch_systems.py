"""Maxwell branches in the linear systems of a collocation step: their complex modulus at each eigenvalue."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays, add_section_stiffness
from viscorod.mechanics.nodes.support_rows import Directions, SupportedNodes
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.transient.integrators.jacobian import project_blocks

__all__ = ["Stiffened", "stiffen"]


class Stiffened(NamedTuple):
    """The stiffness with branches at one eigenvalue, real or complex.

    Attributes:
        blocks: of the matrix ``(b, 6, 6)``; modulus: of the branches of each section ``(sections, 6, 6)``.
        old: scratch ``(6,)``.
    """

    blocks: np.ndarray
    modulus: np.ndarray
    old: np.ndarray

    @classmethod
    def of(cls, blocks: int, sections: int, kind: type[float] | type[complex]) -> Stiffened:
        """Allocate."""
        shapes: tuple[tuple[int, ...], ...] = (blocks, 6, 6), (sections, 6, 6), (6,)
        return cls(*(np.zeros(shape, dtype=kind) for shape in shapes))


@kernel
def stiffen(
    mu: complex,
    K: np.ndarray,
    operator: np.ndarray,
    elements: Elements,
    branches: MaxwellArrays,
    supports: SupportedNodes,
    directions: Directions,
    pattern: Pattern,
    out: Stiffened,
) -> None:
    """Write ``K + sum_g w_g B^T (sum_j C_j mu tau_j/(1 + mu tau_j)) B``, rows of supported nodes projected.

    Args:
        mu: eigenvalue over the step [1/s], real or complex like ``out``.
        K: projected blocks without the branches ``(b, 6, 6)``; operator: ``B``, see ``linearised``.
        directions: of the supports, by which they were projected.
    """
    blocks, modulus, times, stiffness = out.blocks, out.modulus, branches.times, branches.branches
    for of in range(modulus.shape[0]):
        for a in range(6):
            for b in range(6):
                modulus[of, a, b] = 0.0
    for j in range(times.shape[0]):
        response = mu * times[j] / (1.0 + mu * times[j])
        for of in range(modulus.shape[0]):
            for a in range(6):
                for b in range(6):
                    modulus[of, a, b] += response * stiffness[of, j, a, b]
    for s in range(blocks.shape[0]):
        for j in range(6):
            for i in range(6):
                blocks[s, j, i] = 0.0
    add_section_stiffness(elements, modulus, operator, blocks)
    project_blocks(supports, directions, pattern.starts, pattern.across, blocks, out.old)
    for s in range(blocks.shape[0]):
        for j in range(6):
            for i in range(6):
                blocks[s, j, i] += K[s, j, i]
