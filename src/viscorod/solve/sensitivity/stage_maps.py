"""Small changes of the stages of a step in compiled code: how twists follow poses, and how balances follow both.

With poses ``H_i = H_0 exp(X_i)`` of the stages, small changes make body increments ``p_i = c_i + T_i dX_i`` with
``c_i = exp(-ad X_i) p_0``, and those of the twists ``x_i = T(X_i) X_i,t`` are, with ``r_ij = d_ij/h``,

    dx_i = T_i sum_j r_ij T_j^-1 (p_j - c_j) + W_i T_i^-1 (p_i - c_i)        W_i = d(T(X) X_t)/dX

Both exponential maps are power series of ``a = -ad X``, which converge fast for the rotations of a step (up to 2 rad).
Since ``a y`` changes by ``ad(y) dX``, the terms of W follow from each other as those of T do.

Arrays have the stages ``s`` first, then the nodes; each kernel has its transpose beside it.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.typing import Floats, Integers

__all__ = [
    "add_balances",
    "add_balances_transposed",
    "follow_twists",
    "follow_twists_transposed",
    "stage_maps",
]

SMALL = 1e-17
"""Of the last term of a series that counts."""
TERMS = 60


@part
def _turn_back(X: Floats, y: Floats) -> None:
    """Multiply the columns of ``y (6, k)`` by ``-ad X``, in place."""
    for j in range(y.shape[1]):
        a, b, c, d, e, f = y[0, j], y[1, j], y[2, j], y[3, j], y[4, j], y[5, j]
        y[0, j] = X[5] * b - X[4] * c + X[2] * e - X[1] * f
        y[1, j] = X[3] * c - X[5] * a + X[0] * f - X[2] * d
        y[2, j] = X[4] * a - X[3] * b + X[1] * d - X[0] * e
        y[3, j] = X[5] * e - X[4] * f
        y[4, j] = X[3] * f - X[5] * d
        y[5, j] = X[4] * d - X[3] * e


@part
def _add_adjoint(x: Floats, out: Floats) -> None:
    """Add the last three columns of ``ad(x) = [[w~, v~], [0, w~]]`` of ``x (6, 1)``."""
    for first in (0, 3):
        a, b, c = x[first, 0], x[first + 1, 0], x[first + 2, 0]
        out[first, 1] -= c
        out[first, 2] += b
        out[first + 1, 0] += c
        out[first + 1, 2] -= a
        out[first + 2, 0] -= b
        out[first + 2, 1] += a


@part
def _invert(a: Floats, row: int, out: Floats) -> None:
    """Write the inverse of the 3x3 block of ``a (6, 6)`` on the diagonal from ``row`` on."""
    r = row
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            p, q = (m + 1) % 3, (m + 2) % 3
            out[r + m, r + i] = a[r + j, r + p] * a[r + k, r + q] - a[r + j, r + q] * a[r + k, r + p]
    size = 0.0
    for m in range(3):
        size += a[r, r + m] * out[r + m, r]
    for i in range(3):
        for j in range(3):
            out[r + i, r + j] /= size


@kernel
def stage_maps(
    X: Floats,
    speed: Floats,
    split: Floats,
    held: Floats,
    carry: Floats,
    tangent: Floats,
    back: Floats,
    turning: Floats,
) -> None:
    """Write the maps of all nodes at all stages ``(s, n, 6, 6)``.

    Args:
        X, speed: coordinates and their rates ``(s, n, 6)``.
        split: nodes with displacement and rotation apart (see ``nodal_motion``); held: whose poses are prescribed:
            their maps are zero ``(n,)``.
        carry, tangent, back, turning: outputs ``exp(-ad X)``, ``T``, its inverse, and ``W T^-1``.
    """
    # all these matrices are [[A, B], [0, A]]: the last three columns tell everything
    term, slope, twisted = np.empty((6, 3)), np.empty((6, 3)), np.empty((3, 3))
    whole, mean, turn, rate, about = (
        np.empty((6, 3)),
        np.empty((6, 3)),
        np.empty((6, 3)),
        np.empty((6, 1)),
        np.empty(6),
    )
    for s in range(X.shape[0]):
        for n in range(X.shape[1]):
            c, t, b, u = carry[s, n], tangent[s, n], back[s, n], turning[s, n]
            for i in range(6):
                for j in range(6):
                    c[i, j] = t[i, j] = b[i, j] = u[i, j] = 0.0
            if held[n] != 0.0:
                continue
            apart = split[n] != 0.0
            for i in range(6):
                about[i] = 0.0 if apart and i < 3 else X[s, n, i]
                rate[i, 0] = speed[s, n, i]
                for j in range(3):
                    one = 1.0 if i == 3 + j else 0.0
                    term[i, j], whole[i, j], mean[i, j] = one, one, one
                    slope[i, j], turn[i, j] = 0.0, 0.0
            for i in range(3):
                for j in range(3):
                    twisted[i, j] = 0.0
            for k in range(1, TERMS):
                _turn_back(about, slope)
                _add_adjoint(rate, slope)
                _turn_back(about, rate)
                _turn_back(about, term)
                largest, part_of, less = 0.0, 1.0 / k, 1.0 / (k + 1)
                for i in range(6):
                    rate[i, 0] *= part_of
                    for j in range(3):
                        term[i, j] *= part_of
                        slope[i, j] *= part_of
                        whole[i, j] += term[i, j]
                        mean[i, j] += term[i, j] * less
                        turn[i, j] += slope[i, j] * less
                        if i >= 3:
                            largest = max(largest, abs(term[i, j]))
                        elif apart:
                            twisted[i, j] += slope[i, j]
                if largest < SMALL and k > 2:
                    break
            for i in range(3):
                for j in range(3):
                    c[i, j] = c[3 + i, 3 + j] = whole[3 + i, j]
                    c[i, 3 + j] = whole[i, j]
                    t[i, j] = t[3 + i, 3 + j] = mean[3 + i, j]
                    t[i, 3 + j] = mean[i, j]
            if apart:
                for i in range(3):
                    for m in range(3):
                        t[i, m] = c[i, m]
                        j, k = (m + 1) % 3, (m + 2) % 3
                        # - exp(-theta~) a~
                        c[i, 3 + m] = c[i, k] * X[s, n, j] - c[i, j] * X[s, n, k]
            _invert(t, 0, b)
            _invert(t, 3, b)
            if not apart:
                for i in range(3):
                    for j in range(3):
                        term[i, j] = 0.0
                        for m in range(3):
                            term[i, j] += t[i, 3 + m] * b[3 + m, 3 + j]
                for i in range(3):
                    for j in range(3):
                        for m in range(3):
                            b[i, 3 + j] -= b[i, m] * term[m, j]
            for i in range(3):
                for j in range(3):
                    for m in range(3):
                        u[3 + i, 3 + j] += turn[3 + i, m] * b[3 + m, 3 + j]
                        if apart:
                            u[i, 3 + j] += twisted[i, m] * b[3 + m, 3 + j]
                        else:
                            u[i, j] += turn[3 + i, m] * b[m, j]
                            u[i, 3 + j] += turn[3 + i, m] * b[m, 3 + j] + turn[i, m] * b[3 + m, 3 + j]


@kernel
def follow_twists(
    rates: Floats, tangent: Floats, back: Floats, turning: Floats, p: Floats, scratch: Floats, out: Floats
) -> None:
    """Write how twists follow from increments of poses ``p (s, n, 6)`` at the stages."""
    stages, nodes = out.shape[0], out.shape[1]
    for n in range(nodes):
        for j in range(stages):
            for a in range(6):
                total = 0.0
                for b in range(6):
                    total += back[j, n, a, b] * p[j, n, b]
                scratch[j, a] = total
        for i in range(stages):
            for b in range(6):
                total = 0.0
                for j in range(stages):
                    total += rates[i, j] * scratch[j, b]
                scratch[stages, b] = total
            for a in range(6):
                total = 0.0
                for b in range(6):
                    total += tangent[i, n, a, b] * scratch[stages, b] + turning[i, n, a, b] * p[i, n, b]
                out[i, n, a] = total


@kernel
def follow_twists_transposed(
    rates: Floats, tangent: Floats, back: Floats, turning: Floats, x: Floats, scratch: Floats, out: Floats
) -> None:
    """Add the transpose of :func:`follow_twists` times ``x (s, n, 6)``."""
    stages, nodes = x.shape[0], x.shape[1]
    for n in range(nodes):
        for i in range(stages):
            for b in range(6):
                total = 0.0
                for a in range(6):
                    total += tangent[i, n, a, b] * x[i, n, a]
                    out[i, n, b] += turning[i, n, a, b] * x[i, n, a]
                scratch[i, b] = total
        for j in range(stages):
            for a in range(6):
                total = 0.0
                for i in range(stages):
                    total += rates[i, j] * scratch[i, a]
                for b in range(6):
                    out[j, n, b] += back[j, n, a, b] * total


@kernel
def add_balances(
    rows: Integers,
    columns: Integers,
    K: Floats,
    C: Floats,
    mass: Floats,
    p: Floats,
    x: Floats,
    acceleration: Floats,
    out: Floats,
) -> None:
    """Add ``K p + C x + M a`` of all stages to ``out (s, N, 6)``.

    Args:
        rows, columns: of the blocks ``K, C (s, b, 6, 6)``; mass: of the nodes ``(s, n, 6, 6)``.
        p: increments of poses and multipliers ``(s, N, 6)``; x, acceleration: of the nodes ``(s, n, 6)``.
    """
    nodes = mass.shape[1]
    for s in range(out.shape[0]):
        for b in range(rows.shape[0]):
            row, column = rows[b], columns[b]
            for j in range(6):
                one = p[s, column, j]
                two = x[s, column, j] if column < nodes else 0.0
                for i in range(6):
                    out[s, row, i] += K[s, b, j, i] * one + C[s, b, j, i] * two
        for n in range(nodes):
            for i in range(6):
                total = 0.0
                for j in range(6):
                    total += mass[s, n, i, j] * acceleration[s, n, j]
                out[s, n, i] += total


@kernel
def add_balances_transposed(
    rows: Integers,
    columns: Integers,
    K: Floats,
    C: Floats,
    mass: Floats,
    y: Floats,
    by_pose: Floats,
    by_twist: Floats,
    by_acceleration: Floats,
) -> None:
    """Add the transposes of :func:`add_balances` times ``y (s, N, 6)`` to its ``p, x, acceleration``."""
    nodes = mass.shape[1]
    for s in range(y.shape[0]):
        for b in range(rows.shape[0]):
            row, column = rows[b], columns[b]
            for j in range(6):
                one = two = 0.0
                for i in range(6):
                    one += K[s, b, j, i] * y[s, row, i]
                    two += C[s, b, j, i] * y[s, row, i]
                by_pose[s, column, j] += one
                if column < nodes:
                    by_twist[s, column, j] += two
        for n in range(nodes):
            for j in range(6):
                total = 0.0
                for i in range(6):
                    total += mass[s, n, i, j] * y[s, n, i]
                by_acceleration[s, n, j] += total
