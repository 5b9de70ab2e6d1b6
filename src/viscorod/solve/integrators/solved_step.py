"""A collocation step in one compiled call, and what it tells: powers and energy, error, fields between the stages."""

from __future__ import annotations

from viscorod.mechanics.compiled import inlined, kernel
from viscorod.mechanics.internal_force import energies
from viscorod.solve import lapack
from viscorod.solve.integrators.iteration import CONVERGED, newton
from viscorod.solve.integrators.stage_data import Body, Ends, Factors, Given, Matrices, Stages, Work
from viscorod.solve.integrators.stages import points_of
from viscorod.solve.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers


@inlined
def account(body: Body, given: Given, stages: Stages, powers: Floats) -> float:
    """Write powers of loads and viscosity at all stages ``(2, s)`` [W]; return the elastic energy [J] of the last."""
    elastic = 0.0
    for i in range(stages.X.shape[0]):
        power = 0.0
        for k in range(stages.twist.shape[1]):
            for a in range(6):
                power += stages.external[i, k, a] * stages.twist[i, k, a]
        power += stages.held_power[i]
        for m in range(body.nodes.shape[0]):
            if body.complete[m] == 0.0:
                for a in range(6):
                    power += body.fixed[m, a] * stages.reaction[i, m, a] * given.rate[i, m, a]
        elastic, dissipated = energies(body.elements, points_of(stages, i))
        powers[0, i], powers[1, i] = power, dissipated
    return elastic


@inlined
def estimate_error(
    body: Body,
    twist0: Floats,
    force0: Floats,
    h: float,
    tableau: Tableau,
    matrices: Matrices,
    factors: Factors,
    stages: Stages,
    work: Work,
    out: Floats,
) -> tuple[float, int]:
    """Write the estimated error of the poses ``(n, 6)`` (body components); return its size and the unknown it is at.

    ``(mu M ex + C0 ex + K0 eX, mu eX - ex) = (F + M sum e_i (x_i - x_0)/h, x_0 + sum e_i X_i/h)`` with ``mu = real/h``,
    reduced to the poses, where the real matrix is factorised already.
    """
    X, twist = stages.X, stages.twist
    n = X.shape[1]
    s = X.shape[0]
    mu = tableau.real / h
    e = tableau.error
    rate = work.rate
    v = work.vector
    for k in range(n):
        for a in range(6):
            p, d = twist0[k, a], 0.0
            for i in range(s):
                p += e[i] * X[i, k, a] / h
                d += e[i] * (twist[i, k, a] - twist0[k, a]) / h
            rate[k, a] = 0.0 if body.held[k] != 0.0 else p
            v[k, a] = d + mu * p
    for k in range(n):
        M, A = body.mass[k], matrices.adjoint[k]
        for a in range(6):
            total = force0[k, a]
            for b in range(6):
                total += M[a, b] * v[k, b] - A[a, b] * rate[k, b]
            out[k, a] = total
    for m in range(body.nodes.shape[0]):
        k = body.nodes[m]
        for a in range(6):
            total = 0.0
            for b in range(6):
                total += matrices.Z[m, b, a] * out[k, b]
            work.change[0, a] = total if body.fixed[m, a] == 0.0 else 0.0
        for a in range(6):
            out[k, a] = work.change[0, a]
    width = (matrices.C.shape[1] - 1) // 2
    size = 6 * n
    for j in range(size):
        p = rate[j // 6, j % 6]
        if p != 0.0:
            for i in range(max(0, j - width), min(size, j + width + 1)):
                out[i // 6, i % 6] += matrices.C[j, width + i - j] * p
    for i in range(size):
        work.real[i] = factors.real_rows[i] * out[i // 6, i % 6]
    for m in range(body.nodes.shape[0]):
        for a in range(6):
            if body.fixed[m, a] != 0.0:
                work.real[6 * body.nodes[m] + a] = 0.0
    lapack.solve(factors.real, factors.real_integers, factors.letter, work.real)
    largest, where = 0.0, 0
    for i in range(size):
        value = factors.columns[i] * work.real[i]
        out[i // 6, i % 6] = value
        value = abs(value) / body.length if i % 6 < 3 else abs(value)
        if not value <= largest:
            largest, where = value, i
    return largest, where


@kernel
def follow(weights: Floats, start: Floats, values: Floats, places: Integers, out: Floats) -> None:
    """Interpolate Gauss-point fields between the stages of a step.

    Args:
        weights: of the stages at the wanted instants ``(k, s)``; the start has the rest of one.
        start: field at the start of the step ``(m, 6)``, in the order of results; values: at the stages
            ``(s, e, points, 6)``.
        places: where the points of the results are in ``(e, points)`` flattened.
        out: ``(k, m, 6)``.
    """
    top = values.shape[2]
    for k in range(weights.shape[0]):
        for g in range(places.shape[0]):
            e, point = places[g] // top, places[g] % top
            for a in range(6):
                total = start[g, a]
                for i in range(weights.shape[1]):
                    total += weights[k, i] * (values[i, e, point, a] - start[g, a])
                out[k, g, a] = total


@kernel
def try_step(
    body: Body,
    given: Given,
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    force0: Floats,
    h: float,
    tableau: Tableau,
    factors: Factors,
    matrices: Matrices,
    stages: Stages,
    ends: Ends,
    work: Work,
    tolerance: float,
    limit: int,
    known_rate: float,
    powers: Floats,
    error: Floats,
) -> tuple[int, int, float, float, int, float, int, float]:
    """Solve the stages; if that succeeds, estimate the error and take account of the energy.

    Args:
        force0: what accelerates the nodes at the start ``(n, 6)``; the rest as in the functions called.

    Returns:
        what ``iteration.newton`` returns, size and unknown of the largest error, elastic energy of the last stage [J].
    """
    code, count, size, rate, unknown = newton(
        body,
        given,
        r0,
        q0,
        twist0,
        h,
        tableau,
        factors,
        matrices.operators,
        stages,
        ends,
        work,
        tolerance,
        limit,
        known_rate,
    )
    largest, worst, elastic = 0.0, 0, 0.0
    if code == CONVERGED:
        if stages.X.shape[0] > 1:
            largest, worst = estimate_error(
                body, twist0, force0, h, tableau, matrices, factors, stages, work, error
            )
        elastic = account(body, given, stages, powers)
    return code, count, size, rate, unknown, largest, worst, elastic
