"""Derivatives of the balance of an orbit by body increments, twists and twist rates, at all phases."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.mechanics.nodes.support_rows import Directions
from viscorod.mechanics.rotations.adjoint_maps import adjoint_map, series_of_exponential
from viscorod.solve.formulations.system import State
from viscorod.solve.periodic.orbit import Linearised, Motion
from viscorod.solve.transient.integrators.jacobian import project
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.periodic.orbit_balance import OrbitBalance

__all__ = ["linearised"]

STEP = 1e-30
"""Of complex-step derivatives."""


def linearised(balance: OrbitBalance, motion: Motion) -> Linearised:
    """Return the derivatives of the unbalanced forces of a motion."""
    problem, body, supports, setting = balance.problem, balance.body, balance.supports, motion.setting
    pattern, count, n = problem.pattern, balance.fourier.count, problem.size
    K, C = np.zeros((2, count, len(pattern.rows), 6, 6))
    mass = np.tile(body.mass, (count, 1, 1, 1))
    ad = adjoint_map(motion.twist)
    still, square = np.zeros((n, 6, 6)), np.empty(6)
    shape = (count, *Operators.of(balance.elements).strain.shape)
    B, A, P = (np.zeros(shape) for _ in range(3))
    directions = Directions.of(len(body.complete))
    Z = np.zeros((count, len(supports.partial), 6, 6))
    own = pattern.diagonal[:n]
    gyroscopic = np.swapaxes(_gyroscopic(body.mass, motion.twist) - setting.lack * mass, -1, -2)
    C[:, own] += gyroscopic
    _, of_joints = balance.drive.motion(balance.phases, setting.omega, setting.level)
    for i, load in enumerate(balance.loads_at(setting).states):
        state = motion.states[i]
        balance.system.linearise(
            state, still, motion.points.stress[i], Operators(B[i], A[i], P[i]), K[i], C[i]
        )
        if problem.constrained:
            balance.aim_joints(of_joints, i)
            _add_constraints(balance, state, B[i], K[i], C[i])
        if not load.none or load.sees_motion:
            into = MotionTangent(still, K[i], C[i], pattern.diagonal)
            load.add(problem, (state.r, state.q), state.twist, np.zeros((n, 6)), into)
        if body.partly:
            project(
                body.supports,
                motion.targets[i],
                motion.reaction[i],
                state.r,
                state.q,
                pattern,
                K[i],
                C[i],
                mass[i],
                directions,
                square,
            )
            Z[i] = directions.Z[supports.partial]
    K, C = np.swapaxes(K, -1, -2), np.swapaxes(C, -1, -2)
    return Linearised(K, C, mass, ad, _twist_changes(balance, motion, ad), Z, B, A, P)


def _add_constraints(balance: OrbitBalance, state: State, B: Floats, K: Floats, C: Floats) -> None:
    """Add joints and held strains at one phase, in the units that multipliers have at all of them."""
    problem, constraints = balance.problem, balance.system.constraints
    pattern, n = problem.pattern, problem.size
    constraints.add_forces(state, np.zeros((n, 6)))
    held = (balance.elements.order, B) if len(problem.held.place) else None
    constraints.add_tangent(state, np.zeros((n, 6, 6)), K, C, moving=True, held=held)
    ratio = np.where(constraints.scale != 0.0, balance.scale / constraints.scale, 1.0)
    into_rows = np.ones(6 * pattern.size)
    into_rows[6 * n : 6 * n + len(ratio)] = ratio
    rows = into_rows.reshape(-1, 6)
    K *= rows[pattern.columns][:, :, None] * rows[pattern.rows][:, None, :]


def _twist_changes(balance: OrbitBalance, motion: Motion, ad: Floats) -> Floats:
    """Return ``V_ij = w D_ij T_i T_j^-1 + delta_ij (T_i' T_i^-1 + ad(x_i))``.

    With ``p = T dX`` a change of ``x = T X'`` is ``T dX' + T' dX + ad(x) p``; ``T'`` is a complex-step derivative.
    """
    count, n, body = balance.fourier.count, balance.problem.size, balance.body
    X = motion.X + 1j * STEP * motion.rates
    X[:, body.held != 0.0] = 0.0
    terms = _terms(float(np.abs(motion.X[..., 3:]).max(initial=0.0)))
    _, T = series_of_exponential(X.reshape(-1, 6), np.tile(body.split, count), terms)
    T = T.reshape(count, n, 6, 6)
    back = np.linalg.inv(T.real)
    scaled = motion.setting.omega * balance.D[:, :, None, None, None] * back
    found = np.ascontiguousarray(np.moveaxis(T.real[:, None] @ scaled, 2, 0))
    here = np.arange(count)
    found[:, here, here] += np.swapaxes(T.imag / STEP @ back + ad, 0, 1)
    return found


def _terms(turn: float) -> int:
    """Return how many terms of the series of the exponential round-off leaves of a rotation [rad]."""
    size, terms = 1.0, 2
    while size > 1e-17:
        size *= (1.8 * turn + 1e-3) / terms
        terms += 1
    return terms


def _gyroscopic(mass: Floats, twist: Floats) -> Floats:
    """Return the derivatives ``(N, n, 6, 6)`` of ``L1(x) M x`` by the twists ``(N, n, 6)``, ``L1(x) = -ad(x)^T``."""
    momentum = np.einsum("kij,pkj->pki", mass, twist)
    found = -np.swapaxes(adjoint_map(twist), -1, -2) @ mass
    for k, unit in enumerate(np.eye(6)):
        found[..., k] -= momentum @ adjoint_map(unit)
    return np.asarray(found)
