"""The estimated error of a collocation step: right sides of its equation, and its size."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import lane_kernel, part
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.nodes.support_rows import SupportedNodes
from viscorod.solve.transient.integrators.step_task import H, StepTask
from viscorod.typing import Floats, Integers


@part
def project_free(supports: SupportedNodes, Z: Floats, free: Floats, out: Floats) -> None:
    """Project the forces ``(n, 6)`` on supported nodes on their free directions ``Z``; ``free (n, 6)`` is scratch."""
    nodes, fixed = supports.nodes, supports.fixed
    for m in range(nodes.shape[0]):
        k = nodes[m]
        for a in range(6):
            total = 0.0
            for b in range(6):
                total += Z[m, b, a] * out[k, b]
            free[0, a] = total if fixed[m, a] == 0.0 else 0.0
        for a in range(6):
            out[k, a] = free[0, a]


@lane_kernel
def error_sides(step: StepTask, out: Floats) -> None:
    """Write both right sides of :func:`estimate_error` before the damping matrix joins them ``(n, 6)``.

    ``p = sum e_i X_i/h`` into ``work.rate`` and ``F + M (sum e_i (x_i - x_0)/h + mu p) - M ad(x) p`` into ``out``.
    """
    X, twist, mass, held, weights = (
        step.stages.X,
        step.stages.twist,
        step.body.mass,
        step.body.held,
        step.method.error,
    )
    rate, v, adjoint, h, mu = (
        step.work.rate,
        step.work.vector,
        step.matrices.adjoint,
        step.numbers[H],
        step.method.real,
    )
    begun, force = step.start.twist, step.start.force
    for k in range(X.shape[1]):
        for a in range(6):
            p, d = begun[k, a], 0.0
            for i in range(X.shape[0]):
                p += weights[i] * X[i, k, a] / h
                d += weights[i] * (twist[i, k, a] - begun[k, a]) / h
            rate[k, a] = 0.0 if held[k] != 0.0 else p
            v[k, a] = d + mu / h * p
        for a in range(6):
            total = force[k, a]
            for b in range(6):
                total += mass[k, a, b] * v[k, b] - adjoint[k, a, b] * rate[k, b]
            out[k, a] = total


@part
def add_damping(rows: Integers, columns: Integers, C: Floats, rate: Floats, out: Floats) -> None:
    """Add ``C rate`` to ``out (n, 6)``; ``rows, columns`` are those of the blocks ``C (b, 6, 6)``."""
    nodes = out.shape[0]
    for s in range(C.shape[0]):
        row, column = rows[s], columns[s]
        if row < nodes and column < nodes:
            for j in range(6):
                p = rate[column, j]
                for i in range(6):
                    out[row, i] += C[s, j, i] * p


@part
def scale_free(nodes: Integers, fixed: Floats, rows: Floats, out: Floats, right: Floats) -> None:
    """Write the right side ``(6 N,)``: the scaled ``out (n, 6)``, zero at held components and for multipliers."""
    for i in range(6 * out.shape[0], right.shape[0]):
        right[i] = 0.0
    for k in range(out.shape[0]):
        for a in range(6):
            right[6 * k + a] = rows[6 * k + a] * out[k, a]
    for m in range(nodes.shape[0]):
        for a in range(6):
            if fixed[m, a] != 0.0:
                right[6 * nodes[m] + a] = 0.0


@part
def largest_error(scales: Floats, solution: Floats, length: float, out: Floats) -> tuple[float, int]:
    """Write the scaled solution ``(n, 6)``; return its size and the unknown it is at."""
    largest, where = 0.0, 0
    for k in range(out.shape[0]):
        for a in range(6):
            value = scales[6 * k + a] * solution[6 * k + a]
            out[k, a] = value
            value = abs(value) / length if a < 3 else abs(value)
            if not value <= largest:
                largest, where = value, 6 * k + a
    return largest, where


@lane_kernel
def estimate_error(step: StepTask, out: Floats) -> None:
    """Write the right side of the equation of the estimated error of the poses ``(n, 6)`` (body components).

    ``(mu M ex + C0 ex + K0 eX, mu eX - ex) = (F + M sum e_i (x_i - x_0)/h, x_0 + sum e_i X_i/h)`` with ``mu = real/h``,
    reduced to the poses, where the real matrix is factorised already (Hairer and Wanner 1996, IV.8.17 to 8.20).
    """
    body, matrices, work = step.body, step.matrices, step.work
    error_sides(step, out)
    project_free(whole_of(body.supports), matrices.directions.Z, work.change, out)
    add_damping(body.pattern.rows, body.pattern.columns, matrices.C, work.rate, out)
