"""LU factors of a matrix of blocks, however it is factorised.

Groups of block rows are eliminated first. The matrix of one, its *front*, has the ``n`` unknowns of the group before
those that they couple with; it stands column by column, and pivots are sought within the group. What is left of the
matrix is a band, column by column in LAPACK's storage, or goes to a sparse LU behind an address.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.solve.linear.band import BLOCKED, factorise_band
from viscorod.solve.linear.routines import LETTERS, gbtrf, gemm, getrf, trsm
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.solve.linear.plan import Plan

HEAD = 12
"""Pivots begin here among the integers for LAPACK, after its letters and arguments."""

REACH = 8
"""Place among these integers: so many blocks above the diagonal one U of the band has entries."""

GROWTH = 1e3
"""What a group leaves to the rest of the matrix may be so many times its own largest diagonal entry: from a group that
is nearly singular comes more, which is lost again as the rest is eliminated, and with it the accuracy."""

GROWN = -1
"""Code of a factorisation in which more than that came from a group."""


class Factors(NamedTuple):
    """Factors for solutions in compiled code, of the same types for all ways of factorisation.

    Attributes:
        values: LU of the band with reciprocal pivots, or the sparse matrix; real or complex, as the next two.
        fronts: 1 and -1 for BLAS, then the LU of all fronts with reciprocal pivots.
        vector: scratch, a right side of what remains and one of a front.
        integers: arguments and pivots, for LAPACK (int32).
        rows: block rows that remain, in their order ``(M,)``.
        groups, members: as in :attr:`Plan.fronts`.
        rest: half width of the band; address of the sparse LU, 0 if there is none; what it is called with.
    """

    values: Floats
    fronts: Floats
    vector: Floats
    integers: Integers
    rows: Integers
    groups: Integers
    members: Integers
    rest: Integers

    @classmethod
    def of(cls, plan: Plan, kind: type, address: int) -> Factors:
        """Allocate for the type ``kind`` (float, complex)."""
        groups, members, _ = plan.fronts
        remaining, of_fronts, of_groups, largest = plan.sizes
        size = remaining * (3 * plan.width + 1) if plan.banded else 36 * len(plan.ordered.rows)
        fronts: Floats = np.zeros(2 + of_fronts, dtype=kind)
        fronts[:2] = 1.0, -1.0
        integers: Any = np.zeros(HEAD + remaining + of_groups, dtype=np.int32)
        integers[:4] = LETTERS
        return cls(
            values=np.zeros(size, dtype=kind),
            fronts=fronts,
            vector=np.zeros(remaining + largest, dtype=kind),
            integers=integers,
            rows=plan.rows,
            groups=groups,
            members=members,
            rest=np.array([plan.width if plan.banded else 0, address, remaining * (1 + (kind is complex))]),
        )


@part
def _eliminate(front: Floats, units: Floats, n: int, size: int, pivots: Integers, integers: Integers) -> None:
    """Eliminate the first ``n`` of ``size`` unknowns of a front (flat, column by column)."""
    one, minus = units, units[1:]
    no, lower, upper, right = integers, integers[1:], integers[2:], integers[3:]
    integers[4], integers[5], integers[6] = n, size, size - n
    order, stride, others, result = integers[4:], integers[5:], integers[6:], integers[7:]
    getrf(front, (order, order, front, stride, pivots, result))
    if integers[7] != 0 or n == size:
        return
    across, down, rest = front[n * size :], front[n:], front[n * size + n :]
    for j in range(size - n):
        column = across[j * size :]
        for k in range(n):
            other = pivots[k] - 1
            column[k], column[other] = column[other], column[k]
    trsm(front, (lower, lower, no, upper, order, others, one, front, stride, across, stride))
    trsm(front, (right, upper, no, no, others, order, one, front, stride, down, stride))
    gemm(front, (no, no, others, others, order, minus, down, stride, across, stride, one, rest, stride))


@part
def _largest(front: Floats, n: int, size: int) -> float:
    """Return the largest diagonal entry of the first ``n`` unknowns, by the sum of its real and imaginary part."""
    found = 0.0
    for j in range(n):
        x = front[j * size + j]
        found = max(found, abs(x.real) + abs(x.imag))
    return found


@part
def _exceed(front: Floats, n: int, size: int, bound: float) -> bool:
    """Return whether the Schur complement of a group has an entry above ``bound``, or one that is not a number."""
    count = 0
    for j in range(n, size):
        column = front[j * size :]
        for i in range(n, size):
            x = column[i]
            count += not abs(x.real) + abs(x.imag) <= bound
    return count > 0


@part
def _factorise_rest(values: Floats, width: int, pivots: Integers, integers: Integers) -> int:
    """Factorise the band that remains; return 0 or the number of a zero pivot."""
    size = pivots.shape[0]
    if width < BLOCKED:
        return factorise_band(values, width // 6, size, pivots, integers[REACH:])
    integers[REACH] = 2 * (width // 6)
    integers[4], integers[5], integers[6] = size, width, 3 * width + 1
    order, across, stride, result = integers[4:], integers[5:], integers[6:], integers[7:]
    gbtrf(values, (order, order, across, across, values, stride, pivots, result))
    if integers[7] == 0:
        for j in range(size):
            place = j * (3 * width + 1) + 2 * width
            values[place] = 1.0 / values[place]
    return int(integers[7])


@kernel
def reduce(
    blocks: Floats,
    slots: Integers,
    kept: Integers,
    targets: Integers,
    values: Floats,
    fronts: Floats,
    integers: Integers,
    groups: Integers,
    rest: Integers,
) -> int:
    """Factorise a matrix ``blocks (b, 6, 6)``, except for the sparse LU, whose values are written.

    Args:
        blocks: the values.
        slots, kept, targets: where they go to, as in :class:`~viscorod.solve.linear.plan.Plan`.
        values, fronts, integers, groups, rest: see :class:`Factors`.

    Returns:
        0; or at a zero pivot its number (from 1) among the unknowns of the groups, one after the other, and those that
        remain; or :data:`GROWN`.
    """
    for k in range(values.shape[0]):
        values[k] = 0.0
    for c in range(kept.shape[0]):
        s, t = kept[c, 0], kept[c, 1]
        for j in range(6):
            place = targets[t, 0] + j * targets[t, 1]
            for i in range(6):
                values[place + i] = blocks[s, j, i]
    slot = done = 0
    for g in range(groups.shape[0]):
        inner, every = groups[g, 0], groups[g, 1]
        size = 6 * every
        front = fronts[groups[g, 2] : groups[g, 2] + size * size]
        for c in range(every):
            for r in range(every):
                s = slots[slot + c * every + r]
                for j in range(6):
                    place = (6 * c + j) * size + 6 * r
                    for i in range(6):
                        if s < 0 or (c >= inner and r >= inner):
                            front[place + i] = 0.0
                        else:
                            front[place + i] = blocks[s, j, i]
        bound = GROWTH * _largest(front, 6 * inner, size)
        _eliminate(front, fronts, 6 * inner, size, integers[HEAD + done :], integers)
        if integers[7] != 0:
            return int(done + integers[7])
        if _exceed(front, 6 * inner, size, bound):
            return GROWN
        for j in range(6 * inner):
            front[j * size + j] = 1.0 / front[j * size + j]
        for c in range(inner, every):
            for r in range(inner, every):
                t = slots[slot + c * every + r]
                for j in range(6):
                    place = targets[t, 0] + j * targets[t, 1]
                    for i in range(6):
                        values[place + i] += front[(6 * c + j) * size + 6 * r + i]
        slot += every * every
        done += 6 * inner
    if rest[1] != 0:
        return 0
    code = _factorise_rest(values, rest[0], integers[HEAD + done :], integers)
    return int(done + code) if code != 0 else 0
