"""Functions of the compiled collocation step that loop over all stages: supports, loads, right sides, changes.

Unknowns are the coordinates ``X_i`` of all nodes at the stages, seen from the poses at the start of the step (see
``mechanics.rotations.nodal_motion``). Twists follow exactly, ``x_i = T(X_i) sum_j d_ij X_j / h``, accelerations as
``sum_j d_ij (x_j - x_0)/h``, and each stage has to be in balance,

    R_i = M x_i' + L1(x_i) M x_i + f_int - f_ext = 0.

With body increments ``dx = (increment)' + ad(x) increment``, and ``M, C, K`` from the frozen Jacobian, the linear
system of all stages decouples in the eigenvectors of ``D``: one real and some complex matrices
``(mu/h)^2 M + (mu/h) C + K`` of the size of the model (Hairer and Wanner 1996, IV.8, for the second-order form).

Arrays have the stages ``s`` first. Functions take the arrays they need only: every argument costs compile time.
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import part
from viscorod.solve.transient.integrators.stage_data import SupportMotion
from viscorod.typing import Floats, Integers


@part
def place_held_nodes(
    nodes: Integers,
    complete: Floats,
    motion: SupportMotion,
    r: Floats,
    q: Floats,
    twist: Floats,
    acceleration: Floats,
) -> None:
    """Put completely held nodes where their supports are: the given motion ``(s, m, ...)`` into ``(s, n, ...)``."""
    for i in range(r.shape[0]):
        for m in range(nodes.shape[0]):
            if complete[m] != 0.0:
                k = nodes[m]
                for a in range(3):
                    r[i, k, a] = motion.r[i, m, a]
                for a in range(4):
                    q[i, k, a] = motion.q[i, m, a]
                for a in range(6):
                    twist[i, k, a] = motion.twist[i, m, a]
                    acceleration[i, k, a] = motion.twist_rate[i, m, a]


@part
def held_power(nodes: Integers, complete: Floats, residual: Floats, twist: Floats, power: Floats) -> None:
    """Write the power ``(s,)`` [W] that completely held nodes take, from the unbalanced forces ``(s, n, 6)`` there."""
    for i in range(twist.shape[0]):
        power[i] = 0.0
        for m in range(nodes.shape[0]):
            if complete[m] != 0.0:
                for a in range(6):
                    power[i] += residual[i, nodes[m], a] * twist[i, nodes[m], a]


@part
def clear_held(held: Floats, values: Floats) -> None:
    """Set the rows of completely held nodes to zero in ``(s, N, 6)``."""
    for i in range(values.shape[0]):
        for k in range(held.shape[0]):
            if held[k] != 0.0:
                for a in range(6):
                    values[i, k, a] = 0.0


@part
def clear(values: Floats) -> None:
    """Set ``(s, n, 6)`` to zero."""
    for i in range(values.shape[0]):
        for k in range(values.shape[1]):
            for a in range(6):
                values[i, k, a] = 0.0


@part
def add(values: Floats, out: Floats) -> None:
    """Add ``(s, n, 6)`` to ``out``."""
    for i in range(values.shape[0]):
        for k in range(values.shape[1]):
            for a in range(6):
                out[i, k, a] += values[i, k, a]


@part
def to_modes(
    residual: Floats, T: Floats, rows: Floats, pair_rows: Floats, real: Floats, pairs: Floats
) -> None:
    """Write the right sides ``-T R`` of the real and the complex systems, rows scaled.

    Args:
        residual: ``(s, N, 6)``; T: ``to_modes`` of the method.
        rows, pair_rows: scales ``(6 N,)`` of the real system and ``(p, 6 N)`` of the complex ones.
        real, pairs: outputs ``(6 N,)`` and ``(p, 6 N)``.
    """
    for k in range(residual.shape[1]):
        for a in range(6):
            row = 6 * k + a
            one = 0.0
            for j in range(residual.shape[0]):
                one -= T[0, j] * residual[j, k, a]
            real[row] = rows[row] * one
            for m in range(pairs.shape[0]):
                re = im = 0.0
                for j in range(residual.shape[0]):
                    value = residual[j, k, a]
                    re -= T[2 * m + 1, j] * value
                    im -= T[2 * m + 2, j] * value
                pairs[m, row] = complex(pair_rows[m, row] * re, pair_rows[m, row] * im)


@part
def to_changes(
    real: Floats, pairs: Floats, T: Floats, scales: Floats, held: Floats, length: float, change: Floats
) -> tuple[float, int]:
    """Write the changes of all stages from the solutions; return size and unknown of the largest.

    Args:
        real, pairs: solutions ``(6 N,)`` and ``(p, 6 N)``; T: ``to_stages`` of the method; scales: of the unknowns.
        length: displacements are measured in it; infinity is returned if any change is undefined.
        change: output ``(s, N, 6)``, zero at nodes that are ``held (n,)``; only the nodes' size counts.
    """
    largest, where = 0.0, 0
    for k in range(change.shape[1]):
        for i in range(change.shape[0]):
            for a in range(6):
                row = 6 * k + a
                value = T[i, 0] * real[row]
                for m in range(pairs.shape[0]):
                    value += T[i, 2 * m + 1] * pairs[m, row].real + T[i, 2 * m + 2] * pairs[m, row].imag
                value *= scales[row]
                if k >= held.shape[0]:
                    change[i, k, a] = value
                    continue
                if held[k] != 0.0:
                    value = 0.0
                change[i, k, a] = value
                size = abs(value) / length if a < 3 else abs(value)
                if not size <= 1e300:
                    return math.inf, row
                if size > largest:
                    largest, where = size, row
    return largest, where


@part
def differentiate(D: Floats, h: float, values: Floats, out: Floats) -> None:
    """Write the rates ``sum_j d_ij values_j / h`` of stage values ``(s, N, 6)`` of nodes, ``out (s, n, 6)``."""
    for i in range(values.shape[0]):
        for k in range(out.shape[1]):
            for a in range(6):
                total = 0.0
                for j in range(values.shape[0]):
                    total += D[i, j] * values[j, k, a]
                out[i, k, a] = total / h
