"""Direct solution of linear systems of blocks: factorise once, solve from Python or from compiled code."""

from __future__ import annotations

import itertools
from functools import partial
from typing import Any, TypeVar

import numpy as np
from scipy import sparse

from viscorod.mechanics.compilation.callback import Callback
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.solve.linear.factors import GROWN, Factors, reduce
from viscorod.solve.linear.plan import Plan
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.linear.substitution import substitute
from viscorod.typing import Floats

DIAGONAL = 0.01
"""SuperLU keeps to the diagonal, and so to the ordered fill, where its entry has this share of the largest below."""

Vector = TypeVar("Vector", bound=np.ndarray)


class DirectSolver:
    """Solves ``A x = b`` for one matrix after the other with the same pattern of ``N`` block rows.

    Args:
        plan: how; real and complex matrices share it. Where a group of block rows that it eliminates first turns out
            to be singular by itself, or nearly so, the solver goes over to :attr:`Plan.plain` for good.
        kind: float or complex, the type of matrices and right sides.

    Attributes:
        plan: the present one; places: where blocks go to, for :func:`~viscorod.solve.linear.factors.reduce`.
        factors: for :func:`~viscorod.solve.linear.substitution.solve` in compiled code. Its arrays stay the same while
            the plan does: look here again after a factorisation.
    """

    plan: Plan
    factors: Factors

    def __init__(self, plan: Plan, kind: type = float) -> None:
        self._kind = kind
        self.reduction, self._substitute = KnownTypes(reduce), KnownTypes(substitute)
        self._take(plan)

    def _take(self, plan: Plan) -> None:
        self.plan = plan
        self._sparse = None if plan.banded else _SparseLU(plan, self._kind)
        self.factors = Factors.of(plan, self._kind, self._sparse.callback.address if self._sparse else 0)
        self.places = plan.fronts[2], plan.kept, plan.targets

    @property
    def description(self) -> str:
        """The factorisation in words."""
        return self.plan.description

    def factorise(self, blocks: Floats) -> None:
        """Factorise a matrix with the values ``blocks (b, 6, 6)``, which are not changed.

        Raises:
            SingularMatrixError: a pivot is exactly zero.
        """
        values, fronts, _, integers, _, groups, _, rest = self.factors
        if blocks.dtype != self._kind or not blocks.flags.c_contiguous:
            blocks = np.ascontiguousarray(blocks, dtype=self._kind)
        code = self.reduction.call(blocks, *self.places, values, fronts, integers, groups, rest)
        if code != 0:
            if not np.isfinite(blocks).all():
                self.factors.values.fill(np.nan)  # nor are solutions finite
            elif code == GROWN or code <= self._condensed:
                self._take(self.plan.plain)
                self.factorise(blocks)
                return
            else:
                raise SingularMatrixError(self.plan.unknown(code - 1 - self._condensed))
        if self._sparse is not None:
            self._sparse.factorise(self.factors.values)

    def solve(self, b: Vector, *, transposed: bool = False) -> Vector:
        """Solve ``A x = b``, or ``A' x = b`` (not conjugated), in place for a contiguous ``(6 N,)`` or ``(N, 6)``."""
        assert b.flags.c_contiguous  # else a copy would be solved for
        if transposed:  # compiled only where it is asked for
            from viscorod.solve.linear.transposed import substitute_transposed

            substitute_transposed(*self.transposed_factors, b.reshape(-1))
        else:
            known = self._substitute.call if b.dtype == self._kind else substitute
            known(*self.factors, b.reshape(-1))
        self.check()
        return b

    @property
    def transposed_factors(self) -> Factors:
        """The factors for solutions of the transposed system."""
        rest = self.factors.rest.copy()
        rest[1] = self._sparse.transposed.address if self._sparse else 0
        return self.factors._replace(rest=rest)

    def check(self) -> None:
        """Raise what went wrong in solutions within compiled code."""
        if self._sparse is not None:
            self._sparse.callback.check()
            self._sparse.transposed.check()

    @property
    def _condensed(self) -> int:
        """Number of unknowns that are eliminated first."""
        return 6 * int(self.factors.groups[:, 0].sum())


class _SparseLU:
    """SuperLU of what remains of a matrix; ``callback`` and ``transposed`` solve for a right side."""

    def __init__(self, plan: Plan, kind: type) -> None:
        self._plan, self._kind = plan, kind
        rows, _, starts = plan.ordered[:3]
        # every block column is six columns, each with the rows of all its blocks
        index = [
            np.tile((6 * rows[begin:end, None] + np.arange(6)).ravel(), 6)
            for begin, end in itertools.pairwise(starts)
        ]
        self._index = np.concatenate(index).astype(np.int32)
        self._starts = np.concatenate([[0], np.cumsum(np.repeat(6 * np.diff(starts), 6))]).astype(np.int32)
        self._lu: Any = None
        self.callback = Callback(partial(self._solve, "N"))
        self.transposed = Callback(partial(self._solve, "T"))

    def factorise(self, values: Floats) -> None:
        """Factorise the matrix with these values, in columns."""
        from scipy.sparse.linalg import splu

        size = len(self._starts) - 1
        self._lu = None
        if not np.isfinite(values).all():
            return  # nor are solutions
        matrix = sparse.csc_matrix((values, self._index, self._starts), shape=(size, size))
        try:
            self._lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=DIAGONAL)
        except RuntimeError:  # SuperLU does not say where
            raise SingularMatrixError(self._plan.unknown(_null_vector(matrix))) from None

    def _solve(self, way: str, numbers: Floats) -> None:
        b: Any = numbers.view(self._kind)
        b[:] = np.nan if self._lu is None else self._lu.solve(b, way)


def _null_vector(matrix: Any) -> int:
    """Return the largest component of a vector that a singular matrix takes to zero, by inverse iteration."""
    from scipy.sparse.linalg import splu

    shift = 1e-10 * abs(matrix).max() or 1.0
    lu = splu(matrix + shift * sparse.eye_array(matrix.shape[0], format="csc"), permc_spec="NATURAL")
    x = np.random.default_rng(0).normal(size=matrix.shape[0]).astype(matrix.dtype)
    for _ in range(3):
        x = lu.solve(x / np.abs(x).max())
    return int(np.argmax(np.abs(x)))
