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
        for j in range(p, p + 5):
            for i in range(j + 1, p + 6):
                x[i] -= front[j * size + i] * x[j]
        below = p + 6
        subtract(front[p * size + below :], size, x[p:], size - below, x[below:])


@part
def _backward(front: Floats, n: int, size: int, x: Floats) -> None:
    """Solve for the first ``n`` of ``size`` unknowns ``x`` of a front; the others are known."""
    for p in range(n, size, 6):
        subtract(front[p * size :], size, x[p:], n, x)
    for p in range(n - 6, -1, -6):
        for j in range(p + 5, p - 1, -1):
            x[j] *= front[j * size + j]
            for i in range(p, j):
                x[i] -= front[j * size + i] * x[j]
        subtract(front[p * size :], size, x[p:], p, x)


@part
def take(b: Floats, rows: Integers, count: int, x: Floats) -> None:
    """Write the first ``count`` of some block rows of ``b`` into ``x``, one after the other."""
    for k in range(count):
        at = 6 * rows[k]
        for a in range(6):
            x[6 * k + a] = b[at + a]


@part
def put(x: Floats, rows: Integers, count: int, b: Floats) -> None:
    """Undo :func:`take`."""
    for k in range(count):
        at = 6 * rows[k]
        for a in range(6):
            b[at + a] = x[6 * k + a]


@part
def add(x: Floats, rows: Integers, count: int, b: Floats) -> None:
    """Add what :func:`put` writes."""
    for k in range(count):
        at = 6 * rows[k]
        for a in range(6):
            b[at + a] += x[6 * k + a]


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
    count = rows.shape[0]
    remaining = 6 * count
    take(b, rows, count, vector)
    x = vector[remaining:]
    member = done = 0
    for g in range(groups.shape[0]):
        inner, every = groups[g, 0], groups[g, 1]
        own, around = members[member:], members[member + inner :]
        take(b, own, inner, x)
        for k in range(6 * inner, 6 * every):
            x[k] = 0.0
        _forward(fronts[groups[g, 2] :], 6 * inner, 6 * every, integers[HEAD + done :], x)
        put(x, own, inner, b)
        add(x[6 * inner :], around, every - inner, vector)
        member += every
        done += 6 * inner
    if rest[1] == 0:
        solve_band(values, rest[0], remaining, integers[HEAD + done :], integers[REACH], vector)
    else:
        call(rest[1], vector.ctypes, rest[2])
    member = 0
    for g in range(groups.shape[0]):
        inner, every = groups[g, 0], groups[g, 1]
        own, around = members[member:], members[member + inner :]
        take(b, own, inner, x)
        take(vector, around, every - inner, x[6 * inner :])
        _backward(fronts[groups[g, 2] :], 6 * inner, 6 * every, x)
        put(x, own, inner, b)
        member += every
    put(vector, rows, count, b)


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
