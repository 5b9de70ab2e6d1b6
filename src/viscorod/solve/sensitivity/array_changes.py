"""Changes of the arrays of the discretised problem: what a parameter makes of them, or what a result owes to them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.problem.external_loads import load_count
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["ArrayChanges"]


class ArrayChanges(NamedTuple):
    """One number per entry of the arrays that a parameter can enter through.

    For a parameter they are the derivatives of the arrays by it; for a result, its derivatives by the arrays. The
    derivative of the result by the parameter is their :meth:`product`. Numbers of springs, of laws of sections and of
    laws of loads are not among them.

    Attributes:
        stiffness, damping: of the section matrices C and D ``(sections, 6, 6)``, as in ``Elements``.
        mass: of the nodal inertia ``(n, 6, 6)``.
        reference: of the strains of the unstressed shape ``(elements, points, 6)``; rest strains enter here.
        factors: of the factors of the loads ``(loads,)``, as the model numbers them.
        branches, times: of stiffnesses ``(sections, n, 6, 6)`` and relaxation times ``(n,)`` of Maxwell branches.
    """

    stiffness: Floats
    damping: Floats
    mass: Floats
    reference: Floats
    factors: Floats
    branches: Floats
    times: Floats

    @classmethod
    def none(cls, problem: Problem, elements: Elements) -> ArrayChanges:
        """Return changes that are all zero; set the entries that are not."""
        return cls(
            np.zeros_like(elements.stiffness),
            np.zeros_like(elements.damping),
            np.zeros_like(problem.mass),
            np.zeros_like(elements.reference),
            np.zeros(load_count(problem)),
            np.zeros((len(elements.stiffness), len(problem.relaxation_times), 6, 6)),
            np.zeros(len(problem.relaxation_times)),
        )

    def product(self, other: ArrayChanges) -> float:
        """Return the sum of the products of all entries."""
        return float(sum(np.vdot(mine, its) for mine, its in zip(self, other, strict=True)))

    def add(self, other: ArrayChanges, factor: float = 1.0) -> None:
        """Add a multiple of other changes, in place."""
        for mine, its in zip(self, other, strict=True):
            np.add(mine, factor * its, out=mine)
