"""The matrix that an analysis assembles, factorises and solves with."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan
from viscorod.solve.linear.scaling import scale_blocks
from viscorod.typing import Floats


def unit_of(length: float) -> float:
    """Return the unit [m] in which displacements of a model are measured where a matrix is factorised."""
    return 1.0 if 0.1 < length < 10.0 else float(2.0 ** round(np.log2(length)))


class Matrix:
    """A real matrix of 6x6 blocks.

    Args:
        pattern: which blocks it has.
        length: of the model [m].
        plan: returns how it is factorised, for most matrices never are; None: as is best without condensing.

    Attributes:
        blocks: its values ``(b, 6, 6)``, entry (i, j) of block s at ``blocks[s, j, i]``.
        scales: of the unknowns ``(6 N,)``. Displacements are measured in a length near that of the model, so that
            pivoting compares like with like; near one metre this changes nothing, and they are not ``scaled``.
    """

    def __init__(self, pattern: Pattern, length: float = 1.0, plan: Callable[[], Plan] | None = None) -> None:
        unit = unit_of(length)
        self.pattern = pattern
        self.blocks: Floats = np.zeros((len(pattern.rows), 6, 6))
        self.scales: Floats = np.ones(6 * pattern.size)
        self.scaled = unit != 1.0
        if self.scaled:
            self.scales.reshape(-1, 6)[:, :3] = unit
        self._plan = plan

    @cached_property
    def solver(self) -> DirectSolver:
        """The direct solver, made when it is first needed."""
        return DirectSolver(Plan.of(self.pattern) if self._plan is None else self._plan())

    def clear(self) -> None:
        """Set all entries to zero."""
        self.blocks.fill(0.0)

    def factorise(self) -> None:
        """Factorise the matrix; its values do not count any more.

        Raises:
            SingularMatrixError: a pivot is exactly zero.
        """
        if self.scaled:
            scale_blocks(self.pattern.rows, self.pattern.columns, self.scales, self.blocks)
        self.solver.factorise(self.blocks)

    def solve(self, right_side: Floats, *, transposed: bool = False) -> Floats:
        """Solve in place with the factors, or their transpose, for ``(6 N,)`` or ``(N, 6)``; return that."""
        scales = self.scales.reshape(right_side.shape)
        if self.scaled:
            right_side *= scales
        self.solver.solve(right_side, transposed=transposed)
        if self.scaled:
            right_side *= scales
        return right_side

    def sparse(self) -> sparse.csc_array:
        """Return the (not yet factorised) matrix as a sparse array."""
        return self.pattern.sparse(self.blocks)
