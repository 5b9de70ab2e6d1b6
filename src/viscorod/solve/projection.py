"""Velocities that joints, motors and held strains allow: what a step leaves over is projected away.

A position-level constraint ``g(x) = 0`` asks velocities for ``G x1 = g_t``. The correction is the smallest one as a
matrix with the constraints' rows measures it: the mass at a start, where it is an impulse, and the factorised matrix of
the last step later on, whose rows may be some steps old; so it is repeated until nothing is left.
"""

from __future__ import annotations

import numpy as np

from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System

TOLERANCE = 1e-12
"""Rate of a constraint, over that of the fastest node, that passes for none."""
MOST = 30


def start_consistently(system: System, supports: SupportState, state: State) -> None:
    """Give ``state`` velocities that the constraints allow, changed by an impulse of least kinetic energy.

    Raises:
        SingularMatrixError: constraints contradict each other.
    """
    constraints = system.constraints
    if constraints.rows == 0:
        return
    if np.abs(constraints.rate_gaps(state)).max() <= TOLERANCE * constraints.speed(state):
        return
    system.assemble_mass(state)
    residual = np.zeros((system.problem.pattern.size, 6))
    supports.impose(state, residual, system.matrix, tangent=True)
    system.matrix.factorise()
    project_twists(system, state)


def project_twists(system: System, state: State) -> None:
    """Remove what the velocities of ``state`` lack, with the factors of the system's matrix."""
    constraints, n = system.constraints, system.problem.size
    if constraints.rows == 0:
        return
    last = np.inf
    for _ in range(MOST):
        gap = constraints.rate_gaps(state)
        size = float(np.abs(gap).max())
        if size <= TOLERANCE * constraints.speed(state) or size > 0.9 * last:
            break
        last = size
        right = np.zeros((system.problem.pattern.size, 6))
        right[n:] = -(constraints.scale * gap).reshape(-1, 6)
        state.twist += system.matrix.solve(right)[:n]
