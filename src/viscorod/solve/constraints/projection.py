"""Velocities that joints, motors and held strains allow.

A position-level constraint ``g(x) = 0`` asks velocities for ``G x1 = g_t``. The correction is the smallest one as a
matrix with the constraints' rows measures it: the mass at a start, where it is an impulse, and the factorised matrix of
the last step for what is recorded, whose rows may be some steps old; so it is repeated until nothing is left.

Steps go on from velocities as they leave them. Their error does not add up, because positions are held; while a
correction in any other measure than the mass would do work, step after step.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import Snapshot
from viscorod.typing import Floats

TOLERANCE = 1e-12
"""Gap over the length (in rad, or strain) that passes for none; rates are measured in that of the fastest node."""
OPEN = 1e-8
"""Held strain of a state to start from that is closed: steps leave less, other formulations and meshes more."""
MOST = 30


def start_consistently(system: System, supports: SupportState, state: State) -> None:
    """Give ``state`` velocities that the constraints allow, changed by an impulse of least kinetic energy.

    Strains that are held, and are open in a state of another formulation or mesh, are closed before.

    Raises:
        SingularMatrixError: constraints contradict each other.
    """
    constraints = system.constraints
    if constraints.rows == 0:
        return
    apart = np.abs(constraints.gaps(state)[constraints.held.place]).max(initial=0.0) > OPEN
    gap = np.abs(constraints.rate_gaps(state)) / constraints.unit
    if not apart and gap.max() <= TOLERANCE * constraints.speed(state):
        return
    system.assemble_mass(state)
    residual = np.zeros((system.problem.pattern.size, 6))
    supports.impose(state, residual, system.matrix, tangent=True)
    system.matrix.factorise()
    if apart:
        close_gaps(constraints, state, system.matrix.solve)
    else:
        project_velocities(constraints, state, system.matrix.solve)


def with_allowed_velocities(
    constraints: Constraints, snapshot: Snapshot, solve: Callable[[Floats], Floats]
) -> tuple[Snapshot, float]:
    """Return a snapshot at the end of a step with allowed velocities, and the largest rate of a gap that is left.

    Args:
        constraints: measured and driven at the time of the snapshot; solve: see :func:`project_velocities`.
    """
    state = snapshot.state.copy()
    left = project_velocities(constraints, state, solve)
    joints = snapshot.joints
    if joints is not None:
        joints = joints._replace(rate=constraints.measure(state)[1])
    return snapshot._replace(state=state, joints=joints), left


def close_gaps(constraints: Constraints, state: State, solve: Callable[[Floats], Floats]) -> float:
    """Move ``state`` until joints and held strains are closed, then project its velocities.

    For states between the stages of a step, which polynomials give.

    Returns:
        the largest gap that is left, in its unit.
    """

    def move(change: Floats) -> None:
        retract(state.r, state.q, change, state.r, state.q)

    left = _remove_gaps(constraints, lambda: constraints.gaps(state), move, solve)
    project_velocities(constraints, state, solve)
    return left


def project_velocities(constraints: Constraints, state: State, solve: Callable[[Floats], Floats]) -> float:
    """Change the velocities of ``state`` to ones that the constraints allow.

    Args:
        solve: with a factorised matrix that has the rows of the constraints, for ``(N, 6)``.

    Returns:
        what is left, over the velocity of the fastest node.
    """

    def gaps() -> Floats:
        return constraints.rate_gaps(state) / constraints.speed(state)

    def change_twists(change: Floats) -> None:
        state.twist += constraints.speed(state) * change

    return _remove_gaps(constraints, gaps, change_twists, solve)


def _remove_gaps(
    constraints: Constraints,
    gaps: Callable[[], Floats],
    change: Callable[[Floats], None],
    solve: Callable[[Floats], Floats],
) -> float:
    """Change nodes ``(n, 6)`` until the gaps ``(places,)`` are gone or do not fall any more; return the largest."""
    if constraints.rows == 0:
        return 0.0
    problem, last = constraints.problem, np.inf
    for _ in range(MOST):
        gap = gaps()
        size = float((np.abs(gap) / constraints.unit).max())
        if size <= TOLERANCE or size > 0.9 * last:
            break
        last = size
        right = np.zeros((problem.pattern.size, 6))
        right[problem.size :] = -(constraints.scale * gap).reshape(-1, 6)
        change(np.ascontiguousarray(solve(right)[: problem.size]))
    return size
