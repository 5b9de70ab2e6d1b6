"""Block matrices as bands, in an order of the nodes that makes them narrow, factorised by LAPACK."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compiled import kernel, part
from viscorod.solve import lapack
from viscorod.solve.lapack import Bytes
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.solver import SingularMatrixError
from viscorod.typing import Floats, Integers


class BandFactors(NamedTuple):
    """What compiled code needs to solve.

    Attributes:
        band: LU factors ``(6 N, 3 w + 1)``, real or complex (see ``solve.lapack``); integers: those of LAPACK.
        place: of every block row in the band ``(N,)``.
        work: right side in the order of the band ``(6 N,)``; letter: LAPACK's.
    """

    band: Floats
    integers: Integers
    place: Integers
    work: Floats
    letter: Bytes


@kernel
def fill_band(blocks: Floats, rows: Integers, starts: Integers, place: Integers, band: Floats) -> None:
    """Write a matrix into LAPACK's storage.

    Args:
        blocks: ``(b, 6, 6)``; rows, starts: those of the pattern; place: of every block row in the band ``(N,)``.
        band: output ``(6 N, 3 w + 1)``; LAPACK clears the room for pivoting itself.
    """
    width = (band.shape[1] - 1) // 3
    for k in range(place.shape[0]):
        for j in range(6):
            column = np.uint64(6 * place[k] + j)
            for i in range(width, band.shape[1]):
                band[column, np.uint64(i)] = 0.0
            for slot in range(starts[k], starts[k + 1]):
                first = np.uint64(2 * width + 6 * (place[rows[slot]] - place[k]) - j)
                for i in range(6):
                    band[column, first + np.uint64(i)] = blocks[slot, j, i]


@kernel
def solve_in_order(
    band: Floats, integers: Integers, place: Integers, work: Floats, letter: Bytes, b: Floats
) -> None:
    """Solve in place for ``b (6 N,)`` in the order of the nodes; arguments as in :class:`BandFactors`."""
    for k in range(place.shape[0]):
        for i in range(6):
            work[6 * place[k] + i] = b[6 * k + i]
    lapack.solve(band, integers, letter, work)
    for k in range(place.shape[0]):
        for i in range(6):
            b[6 * k + i] = work[6 * place[k] + i]


@part
def solve(factors: BandFactors, b: Floats) -> None:
    """Solve in place, in compiled code, for ``b (6 N,)`` of the type of the factors."""
    band, integers, place, work, letter = factors
    solve_in_order(band, integers, place, work, letter, b)


class BandSolver:
    """LU factors of a band, see :class:`~viscorod.solve.linear.solver.Solver`.

    Args:
        pattern: of the matrices; dtype: float or complex.

    Attributes:
        factors: for compiled code.
    """

    def __init__(self, pattern: Pattern, dtype: type = float) -> None:
        self.pattern = pattern
        place, reach = narrow_order(pattern)
        self._order = np.argsort(place)
        self.width = 6 * reach + 5
        size = 6 * pattern.size
        self.factors = BandFactors(
            band=np.zeros((size, 3 * self.width + 1), dtype=dtype),
            integers=lapack.pivots(size, self.width),
            place=place,
            work=np.zeros(size, dtype=dtype),
            letter=lapack.NO_TRANSPOSE.copy(),
        )

    @property
    def description(self) -> str:
        """See :class:`~viscorod.solve.linear.solver.Solver`."""
        return f"band of half width {self.width}"

    def factorise(self, blocks: Floats) -> None:
        """See :class:`~viscorod.solve.linear.solver.Solver`."""
        pattern, factors = self.pattern, self.factors
        fill_band(blocks, pattern.rows, pattern.starts, factors.place, factors.band)
        row = lapack.factorise(factors.band, factors.integers) - 1
        if row >= 0:
            raise SingularMatrixError(int(6 * self._order[row // 6] + row % 6))

    def solve(self, b: Floats) -> None:
        """See :class:`~viscorod.solve.linear.solver.Solver`."""
        assert b.flags.c_contiguous  # else a copy would be solved for
        solve_in_order(*self.factors, b.reshape(-1))


def narrow_order(pattern: Pattern) -> tuple[Integers, int]:
    """Return the place of every block row in a narrow band ``(N,)``, and how far apart coupled ones are there.

    The order is the given one or that of Cuthill and McKee, reversed, whichever is narrower.
    """
    identity = np.arange(pattern.size, dtype=np.int64)
    given = _reach(pattern, identity)
    # whatever comes first couples with so many others, all of them after it
    if given < np.diff(pattern.starts).min():
        return identity, given
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    graph = csr_array((np.ones(len(pattern.rows)), pattern.rows, pattern.starts), (pattern.size,) * 2)
    place = np.empty_like(identity)
    place[reverse_cuthill_mckee(graph, symmetric_mode=True)] = identity
    found = _reach(pattern, place)
    return (place, found) if found < given else (identity, given)


def _reach(pattern: Pattern, place: Integers) -> int:
    return int(np.abs(place[pattern.rows] - place[pattern.columns]).max())
