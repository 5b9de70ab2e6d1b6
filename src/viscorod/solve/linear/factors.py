"""LU factors of a matrix of blocks, however it is factorised.

Groups of block rows are eliminated first. The matrix of one, its *front*, has the ``n`` unknowns of the group before
those that they couple with; it stands column by column, and pivots are sought within the group. What is left of the
matrix is a band, column by column in LAPACK's storage, or goes to a sparse LU behind an address.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.solve.linear.band import factorise_band
from viscorod.solve.linear.plan import BLOCKED, Plan
from viscorod.solve.linear.routines import LETTERS, gbtrf, gemm, getrf, trsm
from viscorod.typing import Floats, Integers

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
        rows: equations that remain, in their order, their unknowns, and all unknowns that are zero.
        groups, members: as in :attr:`Plan.fronts`.
        rest: half width of the band; address of the sparse LU, 0 if there is none; what it is called with; number of
            unknowns that remain; of those in a block.
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
        (groups, members, _), unknowns, block = plan.fronts, plan.unknowns, plan.unknowns.size
        remaining = block * len(plan.rows)
        size = remaining * (3 * plan.width + 1) if plan.banded else block**2 * len(plan.ordered.rows)
        fronts: Floats = np.zeros(2 + int(np.sum(groups[:, 1] ** 2)), dtype=kind)
        fronts[:2] = 1.0, -1.0
        integers: Any = np.zeros(HEAD + remaining + int(groups[:, 0].sum()), dtype=np.int32)
        rows = unknowns.equations[plan.rows].ravel(), unknowns.numbers[plan.rows].ravel(), unknowns.others
        called_with = remaining * (1 + (kind is complex))
        integers[:4] = LETTERS
        return cls(
            values=np.zeros(size, dtype=kind),
            fronts=fronts,
            vector=np.zeros(remaining + int(groups[:, 1].max(initial=0)), dtype=kind),
            integers=integers,
            rows=np.concatenate(rows),
            groups=groups,
            members=members,
            rest=np.array([plan.width if plan.banded else 0, address, called_with, remaining, block]),
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
def _factorise_rest(values: Floats, width: int, block: int, pivots: Integers, integers: Integers) -> int:
    """Factorise the band that remains; return 0 or the number of a zero pivot."""
    size = pivots.shape[0]
    far = (width - 5) // block
    if width < BLOCKED:
        return factorise_band(values, far, block, size, pivots, integers[REACH:])
    integers[REACH] = 2 * far
    integers[4], integers[5], integers[6] = size, width, 3 * width + 1
    order, across, stride, result = integers[4:], integers[5:], integers[6:], integers[7:]
    gbtrf(values, (order, order, across, across, values, stride, pivots, result))
    if integers[7] == 0:
        for j in range(size):
            place = j * (3 * width + 1) + 2 * width
            values[place] = 1.0 / values[place]
    return int(integers[7])


@part
def _put_block(
    blocks: Floats, slot: int, components: Integers, row: int, column: int, at: int, step: int, values: Floats
) -> None:
    """Write the entries of a block that are solved for to ``values[at + j step + i]``."""
    count = components.shape[2]
    if count == 6:
        for j in range(6):
            place = at + j * step
            for i in range(6):
                values[place + i] = blocks[slot, j, i]
        return
    for j in range(count):
        place, b = at + j * step, components[1, column, j]
        for i in range(count):
            values[place + i] = blocks[slot, b, components[0, row, i]]


@part
def _put_front(
    blocks: Floats,
    components: Integers,
    slots: Integers,
    first: int,
    n: int,
    size: int,
    front: Floats,
) -> None:
    """Write the matrix of a group of ``n`` of ``size`` unknowns, whose slots begin at ``first``; none beside it."""
    count = components.shape[2]
    inner, every = n // count, size // count
    for c in range(every):
        for r in range(every):
            s = first + c * every + r
            at = count * (c * size + r)
            if slots[s, 0] >= 0 and (c < inner or r < inner):
                _put_block(blocks, slots[s, 0], components, slots[s, 1], slots[s, 2], at, size, front)
            else:
                for j in range(count):
                    for i in range(count):
                        front[at + j * size + i] = 0.0


@kernel
def reduce(
    blocks: Floats,
    components: Integers,
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
        components, slots, kept, targets: where they go to, as in :class:`~viscorod.solve.linear.plan.Plan`.
        values, fronts, integers, groups, rest: see :class:`Factors`.

    Returns:
        0; or at a zero pivot its number (from 1) among the unknowns of the groups, one after the other, and those that
        remain; or :data:`GROWN`.
    """
    for k in range(values.shape[0]):
        values[k] = 0.0
    for c in range(kept.shape[0]):
        t = kept[c, 1]
        _put_block(
            blocks, kept[c, 0], components, kept[c, 2], kept[c, 3], targets[t, 0], targets[t, 1], values
        )
    count = components.shape[2]
    slot = done = 0
    for g in range(groups.shape[0]):
        n, size = groups[g, 0], groups[g, 1]
        inner, every = n // count, size // count
        front = fronts[groups[g, 2] : groups[g, 2] + size * size]
        _put_front(blocks, components, slots, slot, n, size, front)
        bound = GROWTH * _largest(front, n, size)
        _eliminate(front, fronts, n, size, integers[HEAD + done :], integers)
        if integers[7] != 0:
            return int(done + integers[7])
        if _exceed(front, n, size, bound):
            return GROWN
        for j in range(n):
            front[j * size + j] = 1.0 / front[j * size + j]
        for c in range(inner, every):
            for r in range(inner, every):
                t = slots[slot + c * every + r, 0]
                for j in range(count):
                    place = targets[t, 0] + j * targets[t, 1]
                    for i in range(count):
                        values[place + i] += front[(count * c + j) * size + count * r + i]
        slot += every * every
        done += n
    if rest[1] != 0:
        return 0
    code = _factorise_rest(values, rest[0], count, integers[HEAD + done :], integers)
    return int(done + code) if code != 0 else 0
