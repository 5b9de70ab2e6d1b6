"""The simplified Newton iteration of a collocation step, in compiled code from beginning to end."""

from __future__ import annotations

import math

from viscorod.mechanics.compiled import inlined
from viscorod.mechanics.linearised import Operators, carry_stress
from viscorod.mechanics.motion import move_stages
from viscorod.solve import lapack
from viscorod.solve.integrators.stage_data import Body, Ends, Factors, Given, Stages, Work
from viscorod.solve.integrators.stages import evaluate
from viscorod.solve.integrators.tableau import Tableau
from viscorod.typing import Floats

CONVERGED, SLOW, DIVERGED, NOT_FINITE = 0, 1, 2, 3


@inlined
def solve_stages(
    tableau: Tableau, h: float, factors: Factors, operators: Operators, stages: Stages, body: Body, work: Work
) -> tuple[float, int]:
    """Do one simplified Newton step from the present residuals; return size and unknown of the largest change."""
    X, residual = stages.X, stages.residual
    s, n = X.shape[0], X.shape[1]
    T, Ti = tableau.to_stages, tableau.to_modes
    for k in range(n):
        for a in range(6):
            row = 6 * k + a
            real = re = im = 0.0
            for j in range(s):
                value = residual[j, k, a]
                real -= Ti[0, j] * value
                if s > 1:
                    re -= Ti[1, j] * value
                    im -= Ti[2, j] * value
            work.real[row] = factors.real_rows[row] * real
            if s > 1:
                work.complex[row] = factors.complex_rows[row] * complex(re, im)
    lapack.solve(factors.real, factors.real_integers, factors.letter, work.real)
    if s > 1:
        lapack.solve_complex(factors.complex, factors.complex_integers, factors.letter, work.complex)
    largest, where = 0.0, 0
    change = residual  # not needed any more
    for k in range(n):
        for i in range(s):
            for a in range(6):
                row = 6 * k + a
                value = T[i, 0] * work.real[row]
                if s > 1:
                    z = work.complex[row]
                    value += T[i, 1] * z.real + T[i, 2] * z.imag
                value *= factors.columns[row]
                if body.held[k] != 0.0:
                    value = 0.0
                change[i, k, a] = value
                size = abs(value) / body.length if a < 3 else abs(value)
                if not size <= 1e300:
                    return math.inf, row
                if size > largest:
                    largest, where = size, row
    move_stages(X, change, body.split, body.held)
    D = tableau.derivative
    for i in range(s):
        for k in range(n):
            for a in range(6):
                total = 0.0
                for j in range(s):
                    total += D[i, j] * change[j, k, a]
                work.rate[k, a] = total / h
        carry_stress(
            body.elements, operators, change[i], work.rate, stages.section_force[i], stages.stress[i]
        )
    return largest, where


@inlined
def newton(
    body: Body,
    given: Given,
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    h: float,
    tableau: Tableau,
    factors: Factors,
    operators: Operators,
    stages: Stages,
    ends: Ends,
    work: Work,
    tolerance: float,
    limit: int,
    known_rate: float,
) -> tuple[int, int, float, float, int]:
    """Iterate until the estimated error of the stage coordinates is below ``tolerance``; evaluate the result.

    Args:
        tolerance: displacement over length, or rotation [rad]; limit: allowed iterations.
        known_rate: convergence rate of the last step, trusted in the first iteration (1 if unknown).

    Returns:
        code, iterations, size of the last change, convergence rate, unknown of the largest change.
    """
    last = size = 0.0
    rate = known_rate**0.8  # trusted less with every step that does not confirm it
    unknown = count = 0
    code = SLOW
    done = False
    while True:
        evaluate(body, given, r0, q0, twist0, h, tableau, operators, stages, ends, work, done)
        if done or count == limit:
            break
        size, unknown = solve_stages(tableau, h, factors, operators, stages, body, work)
        count += 1
        if not size <= 1e3:
            code = DIVERGED if size <= 1e300 else NOT_FINITE
            break
        if count > 1:
            rate = max(size / last, 1e-3) if count == 2 else math.sqrt(rate * max(size / last, 1e-6))
            if rate >= 0.99 and size > tolerance:
                code = DIVERGED
                break
            left = limit - count
            if rate < 1.0 and size * rate**left / (1.0 - rate) > tolerance and left < limit - 2:
                break
        if size == 0.0 or (rate < 1.0 and size * rate / (1.0 - rate) <= tolerance):
            code = CONVERGED
            done = True
        last = size
    return code, count, size, rate, unknown
