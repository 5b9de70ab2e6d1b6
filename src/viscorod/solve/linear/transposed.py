"""Solutions of the transposed system with the LU factors of a matrix of blocks, however it was factorised.

A front with the pivots ``P`` of its group is ``[[P L, 0], [down, 1]] [[1, 0], [0, S]] [[U, across], [0, 1]]``. So its
transposed system is solved by ``U' y = b`` and ``b2 - across' y`` first, by ``S'`` for what remains, and by
``L' P' x = y - down' x2`` at last: every column of the factors is a scalar product.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.callback import call
from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.solve.linear.factors import HEAD
from viscorod.solve.linear.substitution import add, put, take
from viscorod.typing import Floats, Integers

__all__ = ["substitute_transposed"]


@part
def _solve_band(values: Floats, width: int, n: int, pivots: Integers, b: Floats) -> None:
    """Solve with the transposed LU of a band in place."""
    stride = 3 * width + 1
    for j in range(n):
        first = max(0, j - 2 * width)
        column = values[j * stride + 2 * width - (j - first) :]
        total = b[j]
        for i in range(j - first):
            total -= column[i] * b[first + i]
        b[j] = total * column[j - first]
    for j in range(n - 1, -1, -1):
        column = values[j * stride + 2 * width :]
        total = b[j]
        for i in range(1, min(width, n - 1 - j) + 1):
            total -= column[i] * b[j + i]
        other = pivots[j] - 1
        b[j] = b[other]
        b[other] = total


@part
def _forward(front: Floats, n: int, size: int, x: Floats) -> None:
    """Solve ``U' y = b`` for the first ``n`` of ``size`` unknowns of a front; take ``across' y`` from the others."""
    for j in range(size):
        total = x[j]
        for i in range(min(j, n)):
            total -= front[j * size + i] * x[i]
        x[j] = total * front[j * size + j] if j < n else total


@part
def _backward(front: Floats, n: int, size: int, pivots: Integers, x: Floats) -> None:
    """Solve ``L' P' x = y - down' x2`` for the first ``n`` of ``size`` unknowns of a front; the others are known."""
    for j in range(n - 1, -1, -1):
        total = x[j]
        for i in range(j + 1, size):
            total -= front[j * size + i] * x[i]
        x[j] = total
    for j in range(n - 1, -1, -1):
        other = pivots[j] - 1
        value = x[other]
        x[other] = x[j]
        x[j] = value


@kernel
def substitute_transposed(
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
    """Solve ``A' x = b (6 N,)`` in place; the others are those of :class:`~viscorod.solve.linear.factors.Factors`.

    A sparse LU is called at the address in ``rest``, which has to be that of its transposed solution.
    """
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
        _forward(fronts[groups[g, 2] :], 6 * inner, 6 * every, x)
        put(x, own, inner, b)
        add(x[6 * inner :], around, every - inner, vector)
        member += every
        done += 6 * inner
    if rest[1] == 0:
        _solve_band(values, rest[0], remaining, integers[HEAD + done :], vector)
    else:
        call(rest[1], vector.ctypes, rest[2])
    member = done = 0
    for g in range(groups.shape[0]):
        inner, every = groups[g, 0], groups[g, 1]
        own, around = members[member:], members[member + inner :]
        take(b, own, inner, x)
        take(vector, around, every - inner, x[6 * inner :])
        _backward(fronts[groups[g, 2] :], 6 * inner, 6 * every, integers[HEAD + done :], x)
        put(x, own, inner, b)
        member += every
        done += 6 * inner
    put(vector, rows, count, b)
