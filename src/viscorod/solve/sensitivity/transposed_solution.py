"""The transposed system of all stages of a step in compiled code: GMRES, with what it applies and preconditions with.

It does what :class:`~viscorod.solve.sensitivity.stage_solver.StageSolver` does call by call for any number of stages:
here of three, which have one real matrix and one complex one, and without Maxwell branches.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.solve.linear.factors import Factors
from viscorod.solve.linear.transposed import substitute_transposed
from viscorod.solve.sensitivity.stage_maps import add_balances_transposed, follow_twists_transposed
from viscorod.typing import Floats, Integers

__all__ = ["Preconditioner", "StageSystem", "Workspace", "solve_transposed", "through_twists"]


class StageSystem(NamedTuple):
    """How the balances of all stages follow from increments of poses; see ``stage_maps``.

    Attributes:
        rates: ``(s, s)`` [1/s]; tangent, back, turning: maps ``(s, n, 6, 6)``.
        rows, columns: of the blocks ``K, C (s, b, 6, 6)``; mass: ``(s, n, 6, 6)``.
    """

    rates: Floats
    tangent: Floats
    back: Floats
    turning: Floats
    rows: Integers
    columns: Integers
    K: Floats
    C: Floats
    mass: Floats


class Preconditioner(NamedTuple):
    """The matrices of a step, of the mean Jacobian of its stages.

    Attributes:
        to_stages, to_modes: of the method ``(3, 3)``; scales: of the unknowns ``(6 N,)``; units: per component.
        real_rows, complex_rows: scales of the equations ``(6 N,)``.
        real_factors, complex_factors: of the matrices, with transposed solutions.
    """

    to_stages: Floats
    to_modes: Floats
    scales: Floats
    units: Floats
    real_rows: Floats
    complex_rows: Floats
    real_factors: Factors
    complex_factors: Factors


class Workspace(NamedTuple):
    """Scratch.

    Attributes:
        basis: ``(m + 1, 18 N)``; projected: ``(m + 1, m)``; turns: ``(m, 2)``; goal: ``(m + 1,)``.
        vector, result: ``(s, N, 6)``; twist, acceleration: ``(s, n, 6)``; scratch: ``(s + 1, 6)``.
        one, pair: right sides ``(6 N,)``, real and complex.
    """

    basis: Floats
    projected: Floats
    turns: Floats
    goal: Floats
    vector: Floats
    result: Floats
    twist: Floats
    acceleration: Floats
    scratch: Floats
    one: Floats
    pair: Floats

    @classmethod
    def of(cls, shape: tuple[int, ...], nodes: int, most: int) -> Workspace:
        """Allocate for unknowns ``(s, N, 6)``, of so many nodes, and at most so many iterations."""
        stages, places, _ = shape
        size, each = 6 * stages * places, (stages, nodes, 6)
        return cls(
            np.zeros((most + 1, size)),
            np.zeros((most + 1, most)),
            np.zeros((most, 2)),
            np.zeros(most + 1),
            np.zeros(shape),
            np.zeros(shape),
            np.zeros(each),
            np.zeros(each),
            np.zeros((stages + 1, 6)),
            np.zeros(6 * places),
            np.zeros(6 * places, dtype=complex),
        )


@part
def _dot(a: Floats, b: Floats) -> float:
    """Return the sum of products of two flat arrays, in eight sums, so that they go side by side."""
    n = a.shape[0]
    t0 = t1 = t2 = t3 = t4 = t5 = t6 = t7 = 0.0
    whole = n - n % 8
    for i in range(0, whole, 8):
        t0 += a[i] * b[i]
        t1 += a[i + 1] * b[i + 1]
        t2 += a[i + 2] * b[i + 2]
        t3 += a[i + 3] * b[i + 3]
        t4 += a[i + 4] * b[i + 4]
        t5 += a[i + 5] * b[i + 5]
        t6 += a[i + 6] * b[i + 6]
        t7 += a[i + 7] * b[i + 7]
    for i in range(whole, n):
        t0 += a[i] * b[i]
    return ((t0 + t1) + (t2 + t3)) + ((t4 + t5) + (t6 + t7))


@part
def _apply(
    system: StageSystem, y: Floats, twist: Floats, acceleration: Floats, scratch: Floats, out: Floats
) -> None:
    """Write the transpose of ``K p + C x + M a`` times ``y (s, N, 6)``, where twists follow the increments."""
    for s in range(out.shape[0]):
        for k in range(out.shape[1]):
            for i in range(6):
                out[s, k, i] = 0.0
        for k in range(twist.shape[1]):
            for i in range(6):
                twist[s, k, i] = acceleration[s, k, i] = 0.0
    add_balances_transposed(
        system.rows, system.columns, system.K, system.C, system.mass, y, out, twist, acceleration
    )
    for j in range(twist.shape[0]):
        for i in range(twist.shape[0]):
            rate = system.rates[i, j]
            for k in range(twist.shape[1]):
                for a in range(6):
                    twist[j, k, a] += rate * acceleration[i, k, a]
    follow_twists_transposed(system.rates, system.tangent, system.back, system.turning, twist, scratch, out)


@kernel
def through_twists(
    system: StageSystem,
    weights: Floats,
    carry: Floats,
    held: Floats,
    y: Floats,
    work: Workspace,
    pose: Floats,
    twist: Floats,
) -> None:
    """Write what a function owes to the start of a step, ``pose, twist (n, 6)``, through the twists of its stages.

    Args:
        weights: derivatives of the function by the twists of the stages ``(s, n, 6)``.
        carry: maps of increments at the start ``(s, n, 6, 6)``; held: nodes whose poses are prescribed ``(n,)``.
        y: derivatives by the balances ``(s, N, 6)``.
    """
    by_twist, by_acceleration, unused, scratch = work.twist, work.acceleration, work.vector, work.scratch
    stages, nodes = by_twist.shape[0], by_twist.shape[1]
    for s in range(stages):
        for n in range(nodes):
            for a in range(6):
                by_twist[s, n, a] = weights[s, n, a]
                by_acceleration[s, n, a] = 0.0
    add_balances_transposed(
        system.rows, system.columns, system.K, system.C, system.mass, y, unused, by_twist, by_acceleration
    )
    for n in range(nodes):
        for a in range(6):
            total = 0.0
            for i in range(stages):
                for j in range(stages):
                    total += system.rates[i, j] * by_acceleration[i, n, a]
                    by_twist[j, n, a] += system.rates[i, j] * by_acceleration[i, n, a]
            twist[n, a] = 0.0 if held[n] != 0.0 else -total
            pose[n, a] = 0.0
    for s in range(stages):
        for n in range(unused.shape[1]):
            for a in range(6):
                unused[s, n, a] = 0.0
    follow_twists_transposed(
        system.rates, system.tangent, system.back, system.turning, by_twist, scratch, unused
    )
    for n in range(nodes):
        if held[n] == 0.0:
            for s in range(stages):
                for i in range(6):
                    for j in range(6):
                        pose[n, j] -= carry[s, n, i, j] * unused[s, n, i]


@part
def _precondition(by: Preconditioner, weights: Floats, real: Floats, pair: Floats, out: Floats) -> None:
    """Write the transposed solution with the matrices of the step for ``weights (3, N, 6)``."""
    modes, stages = by.to_modes, by.to_stages
    for k in range(weights.shape[1]):
        for a in range(6):
            at = 6 * k + a
            scale = by.scales[at]
            w0, w1, w2 = weights[0, k, a] * scale, weights[1, k, a] * scale, weights[2, k, a] * scale
            real[at] = stages[0, 0] * w0 + stages[1, 0] * w1 + stages[2, 0] * w2
            one = stages[0, 1] * w0 + stages[1, 1] * w1 + stages[2, 1] * w2
            two = stages[0, 2] * w0 + stages[1, 2] * w1 + stages[2, 2] * w2
            pair[at] = complex(one, -two)
    values, fronts, vector, integers, rows, groups, members, rest = by.real_factors
    substitute_transposed(values, fronts, vector, integers, rows, groups, members, rest, real)
    its, its_fronts, its_vector, its_integers, rows, groups, members, its_rest = by.complex_factors
    substitute_transposed(its, its_fronts, its_vector, its_integers, rows, groups, members, its_rest, pair)
    for k in range(weights.shape[1]):
        for a in range(6):
            at = 6 * k + a
            m0, both = real[at] * by.real_rows[at], pair[at] * by.complex_rows[at]
            m1, m2 = both.real, -both.imag
            for s in range(3):
                out[s, k, a] = modes[0, s] * m0 + modes[1, s] * m1 + modes[2, s] * m2


@part
def _flatten(values: Floats, units: Floats, out: Floats) -> None:
    """Write ``values (s, N, 6)`` as one row, in units that make all components alike."""
    at = 0
    for s in range(values.shape[0]):
        for k in range(values.shape[1]):
            for a in range(6):
                out[at] = values[s, k, a] * units[a]
                at += 1


@part
def _unflatten(row: Floats, units: Floats, out: Floats) -> None:
    """Undo :func:`_flatten`."""
    at = 0
    for s in range(out.shape[0]):
        for k in range(out.shape[1]):
            for a in range(6):
                out[s, k, a] = row[at] / units[a]
                at += 1


@part
def _divide(row: Floats, by: float) -> None:
    for i in range(row.shape[0]):
        row[i] /= by


@part
def _orthogonalise(basis: Floats, H: Floats, count: int) -> float:
    """Take from the vector after the ``count``-th what the basis has of it, into ``H``; return what is left of it."""
    new, n = basis[count + 1], basis.shape[1]
    for j in range(count + 1):
        H[j, count] = 0.0
    for _ in range(2):  # what one projection leaves, the second removes
        for j in range(count + 1):
            along = _dot(basis[j], new)
            H[j, count] += along
            for i in range(n):
                new[i] -= along * basis[j, i]
    return math.sqrt(_dot(new, new))


@part
def _turn(H: Floats, turns: Floats, goal: Floats, count: int, below: float) -> float:
    """Make the column ``count`` of ``H``, and ``below`` it, triangular by plane rotations; return its last entry."""
    for j in range(count):
        c, s = turns[j, 0], turns[j, 1]
        one, two = H[j, count], H[j + 1, count]
        H[j, count], H[j + 1, count] = c * one + s * two, c * two - s * one
    length = math.hypot(H[count, count], below)
    c, s = H[count, count] / length, below / length
    turns[count, 0], turns[count, 1] = c, s
    H[count, count] = length
    goal[count], goal[count + 1] = c * goal[count], -s * goal[count]
    return length


@part
def _combine(basis: Floats, H: Floats, goal: Floats, count: int) -> None:
    """Solve with the triangle of ``count`` columns, and leave the combination of the basis in its first row."""
    for j in range(count - 1, -1, -1):
        for i in range(j + 1, count):
            goal[j] -= H[j, i] * goal[i]
        goal[j] /= H[j, j]
    for at in range(basis.shape[1]):
        total = 0.0
        for j in range(count):
            total += goal[j] * basis[j, at]
        basis[0, at] = total


@kernel
def solve_transposed(
    system: StageSystem,
    by: Preconditioner,
    work: Workspace,
    right: Floats,
    left: float,
    enough: float,
    out: Floats,
) -> int:
    """Solve for ``out (3, N, 6)``, of the right side ``right``; return the iterations, or -1 if it was not solved.

    Saad and Schultz (1986), preconditioned from the left.

    Args:
        left: part of the right side, after preconditioning, where the iteration ends; enough: that does at the end.
    """
    basis, H, goal = work.basis, work.projected, work.goal
    _precondition(by, right, work.one, work.pair, work.result)
    _flatten(work.result, by.units, basis[0])
    size, count = math.sqrt(_dot(basis[0], basis[0])), 0
    if size == 0.0:
        _unflatten(basis[0], by.units, out)
        return 0
    _divide(basis[0], size)
    goal[0] = size
    while abs(goal[count]) > left * size:
        if count == H.shape[1]:
            if abs(goal[count]) > enough * size:
                return -1
            break
        _unflatten(basis[count], by.units, work.vector)
        _apply(system, work.vector, work.twist, work.acceleration, work.scratch, work.result)
        _precondition(by, work.result, work.one, work.pair, work.vector)
        _flatten(work.vector, by.units, basis[count + 1])
        norm = _orthogonalise(basis, H, count)
        length = _turn(H, work.turns, goal, count, norm)
        count += 1
        if norm <= 1e-15 * length:
            break
        _divide(basis[count], norm)
    _combine(basis, H, goal, count)
    _unflatten(basis[0], by.units, out)
    return count
