"""Solutions with the LU factors of a matrix of blocks in compiled code, however it was factorised."""

from __future__ import annotations

from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.solve.linear.band import solve_band, subtract
from viscorod.solve.linear.factors import HEAD, REACH, Factors
from viscorod.typing import Floats, Integers


@part
def _forward(front: Floats, n: int, size: int, pivots: Integers, x: Floats) -> None:
    """Eliminate the first ``n`` of ``size`` unknowns of a front from the right side ``x``."""
    for j in range(n):
        other = pivots[j] - 1
        value = x[other]
        x[other] = x[j]
        x[j] = value
    for p in range(0, n, 6):
        below = min(p + 6, n)
        for j in range(p, below - 1):
            for i in range(j + 1, below):
                x[i] -= front[j * size + i] * x[j]
        _subtract(front[p * size + below :], size, below - p, x[p:], size - below, x[below:])


@part
def _backward(front: Floats, n: int, size: int, x: Floats) -> None:
    """Solve for the first ``n`` of ``size`` unknowns ``x`` of a front; the others are known."""
    for p in range(n, size, 6):
        _subtract(front[p * size :], size, min(6, size - p), x[p:], n, x)
    for p in range((n - 1) // 6 * 6, -1, -6):
        beyond = min(p + 6, n)
        for j in range(beyond - 1, p - 1, -1):
            x[j] *= front[j * size + j]
            for i in range(p, j):
                x[i] -= front[j * size + i] * x[j]
        _subtract(front[p * size :], size, beyond - p, x[p:], p, x)


@part
def _subtract(columns: Floats, size: int, number: int, values: Floats, count: int, x: Floats) -> None:
    """Do what :func:`subtract` does with a ``number`` of columns, six at most."""
    if number == 6:
        subtract(columns, size, values, count, x)
        return
    for j in range(number):
        column, value = columns[j * size :], values[j]
        for i in range(count):
            x[i] -= column[i] * value


@part
def take(b: Floats, numbers: Integers, count: int, x: Floats) -> None:
    """Write the first ``count`` of some unknowns of ``b`` into ``x``, one after the other."""
    for k in range(count):
        x[k] = b[numbers[k]]


@part
def put(x: Floats, numbers: Integers, count: int, b: Floats) -> None:
    """Undo :func:`take`."""
    for k in range(count):
        b[numbers[k]] = x[k]


@part
def add(x: Floats, numbers: Integers, count: int, b: Floats) -> None:
    """Add what :func:`put` writes."""
    for k in range(count):
        b[numbers[k]] += x[k]


@kernel
def substitute(
    values: Floats,
    fronts: Floats,
    vector: Floats,
    integers: Integers,
    rows: Integers,
    groups: Integers,
    members: Integers,
    rest: Integers,
    b: Floats,
) -> None:
    """Solve in place for ``b (6 N,)``; the others are those of :class:`~viscorod.solve.linear.factors.Factors`."""
    remaining = rest[3]
    take(b, rows, remaining, vector)
    x = vector[remaining:]
    member = done = 0
    for g in range(groups.shape[0]):
        n, size = groups[g, 0], groups[g, 1]
        own, around = members[member:], members[member + n :]
        take(b, own, n, x)
        for k in range(n, size):
            x[k] = 0.0
        _forward(fronts[groups[g, 2] :], n, size, integers[HEAD + done :], x)
        put(x, own, n, b)
        add(x[n:], around, size - n, vector)
        member += size
        done += n
    if rest[1] == 0:
        solve_band(values, rest[0], rest[4], remaining, integers[HEAD + done :], integers[REACH], vector)
    else:
        call(rest[1], vector.ctypes, rest[2])
    member = 0
    for g in range(groups.shape[0]):
        n, size = groups[g, 0], groups[g, 1]
        own, around = members[member:], members[member + n :]
        take(b, own, n, x)
        take(vector, around, size - n, x[n:])
        _backward(fronts[groups[g, 2] :], n, size, x)
        put(x, own, n, b)
        member += size
    put(vector, rows[remaining:], remaining, b)
    for k in range(2 * remaining, rows.shape[0]):
        b[rows[k]] = 0.0


@part
def solve(factors: Factors, b: Floats) -> None:
    """Solve in place, in compiled code, for ``b (6 N,)``, real or complex as the factors are.

    Where a sparse LU fails, the solution is NaN and :meth:`~viscorod.solve.linear.direct.DirectSolver.check` says why.
    """
    values, fronts, vector, integers, rows, groups, members, rest = factors
    substitute(values, fronts, vector, integers, rows, groups, members, rest, b)


@part
def solve_each(factors: Factors, b: Floats) -> None:
    """Do what :func:`solve` does with each matrix of a stack and its right side, ``b (p, 6 N)``."""
    values, fronts, vector, integers, rows, groups, members, rest = factors
    for m in range(b.shape[0]):
        substitute(values[m], fronts[m], vector, integers[m], rows, groups, members, rest[m], b[m])
