"""LU factors of narrow bands of 6 x 6 blocks in LAPACK's storage, and solutions with those of any band.

LAPACK's own factorisation (dgbtrf) pays a call per column for bands below 32, and takes no notice of the blocks: a
column of the place ``o`` within its block has ``o`` entries fewer below the diagonal than the band is wide. The pivots
are the same. Two columns are eliminated at a time, so that the rest of the band is read and written half as often.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import part
from viscorod.typing import Floats, Integers

__all__ = ["BLOCKED", "factorise_band", "solve_band", "subtract"]


BLOCKED = 32
"""LAPACK's band LU works on blocks of so many columns; below, it has a call per column, and this one is faster."""


@part
def _pivot(column: Floats, below: int) -> int:
    """Bring the largest of an entry and those ``below`` up, divide these by it; return how far it was, -1 if zero."""
    found = 0
    largest = abs(column[0].real) + abs(column[0].imag)
    for i in range(1, below + 1):
        size = abs(column[i].real) + abs(column[i].imag)
        if size > largest:
            largest, found = size, i
    if largest == 0.0:
        return -1
    pivot = column[found]
    column[found] = column[0]
    column[0] = 1.0 / pivot
    for i in range(1, below + 1):
        column[i] *= column[0]
    return found


@part
def _swap(column: Floats, distance: int) -> None:
    """Exchange an entry and the one at a distance below."""
    x = column[distance]
    column[distance] = column[0]
    column[0] = x


@part
def factorise_band(values: Floats, far: int, n: int, pivots: Integers, reach: Integers) -> int:
    """Factorise a band in place.

    Args:
        values: in LAPACK's storage for ``6 far + 5`` diagonals on each side, ``n`` columns (a multiple of 6); then LU
            with reciprocal pivots.
        far: so many blocks from the diagonal one there is something.
        pivots: rows, from 1 ``(n,)``.
        reach: of one entry, so many blocks above the diagonal one U has entries then.

    Returns:
        0, or the number of a zero pivot, from 1.
    """
    width = 6 * far + 5
    stride = 3 * width + 1
    reach[0] = far
    end = 0  # of the columns in which the rows so far have entries
    for j in range(0, n, 2):
        below = min(width - j % 6, n - 1 - j)
        place = j * stride + 2 * width
        p = _pivot(values[place:], below)
        if p < 0:
            return j + 1
        first = values[place + 1 :]
        column = values[place + stride - 1 :]
        _swap(column, p)
        x = column[0]
        for i in range(below):
            column[1 + i] -= first[i] * x
        below -= 1
        q = _pivot(column[1:], below)
        if q < 0:
            return j + 2
        second = column[2:]
        pivots[j], pivots[j + 1] = j + p + 1, j + q + 2
        over = max(j + p, j + 1 + q) // 6 + far
        reach[0] = max(reach[0], over - j // 6)
        end = max(end, min(6 * over + 6, n))
        _swap(first, q)  # for a while, as in the columns
        beside = first[1:]
        for k in range(j + 2, end):
            column = values[place + (k - j) * (stride - 1) :]
            _swap(column, p)
            _swap(column[1:], q)
            x = column[0]
            y = column[1] - first[0] * x
            column[1] = y
            rest = column[2:]
            for i in range(below):
                rest[i] = (rest[i] - beside[i] * x) - second[i] * y
        _swap(first, q)
    return 0


@part
def subtract(columns: Floats, size: int, values: Floats, count: int, x: Floats) -> None:
    """Subtract six columns of a matrix times six values from ``count`` entries of ``x``; the columns begin there."""
    a, b, c = columns, columns[size:], columns[2 * size :]
    d, e, f = columns[3 * size :], columns[4 * size :], columns[5 * size :]
    u, v, w, r, s, t = values[0], values[1], values[2], values[3], values[4], values[5]
    for i in range(count):
        x[i] -= (a[i] * u + b[i] * v + c[i] * w) + (d[i] * r + e[i] * s + f[i] * t)


@part
def solve_band(values: Floats, width: int, n: int, pivots: Integers, reach: int, b: Floats) -> None:
    """Solve in place for ``b (n,)``; see :func:`factorise_band`.

    LAPACK's own loops pay a call per column, much for narrow bands.
    """
    stride = 3 * width + 1
    for j in range(n):
        other = pivots[j] - 1
        x = b[other]
        b[other] = b[j]
        b[j] = x
        column = values[j * stride + 2 * width + 1 :]
        after = b[j + 1 :]
        for i in range(min(width - j % 6, n - 1 - j)):
            after[i] -= column[i] * x
    for p in range(n - 6, -1, -6):
        for j in range(p + 5, p - 1, -1):
            column = values[j * stride + 2 * width - (j - p) :]
            x = b[j] * column[j - p]
            b[j] = x
            for i in range(j - p):
                b[p + i] -= column[i] * x
        first = max(0, p - 6 * reach)
        subtract(values[p * stride + 2 * width - (p - first) :], stride - 1, b[p:], p - first, b[first:])
