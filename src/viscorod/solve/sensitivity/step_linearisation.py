"""The exact linearisation of one collocation step: how its end follows its start and the arrays of the problem.

With the poses ``H_i = H_0 exp(X_i)``, twists ``x_i = T(X_i) sum_j d_ij X_j / h`` and accelerations
``sum_j d_ij (x_j - x_0)/h`` of the stages, small changes make body increments ``p_i = c_i + T_i dX_i`` of the poses
with ``c_i = exp(-ad X_i) p_0``, and

    dx_i = sum_j V_ij (p_j - c_j)        V_ij = d_ij/h T_i T_j^-1 + delta_ij W_i T_i^-1        W_i = d(T(X) X_t)/dX

The balances of all stages stay fulfilled: one linear system for the ``p_i`` that supports allow, with the Jacobian of
these stages in place of the frozen one of the iteration. Both maps of the exponential are power series of ``ad X``,
which converge fast for the rotations of a step (up to 2 rad); ``W`` is their complex-step derivative.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from viscorod.errors import InputError
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.balance import Balance, adjoint_map
from viscorod.solve.sensitivity.equilibrium_sensitivity import allowed_tangent, require_differentiable
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["StepLinearisation", "require_linearisable", "series_of_exponential"]

_TERMS = 30
"""Of the series: the next one is below round-off for rotations of 3 rad."""
_STEP = 1e-30
"""Of complex-step derivatives."""


class StepLinearisation:
    """The linearisation of the step that an integrator has attempted, and not accepted yet.

    Columns of arrays are independent changes. Rows are those of all nodes, ``6 n``; changes are ones that supports
    allow. Multipliers of joints and held strains are unknowns of every stage, and no part of the state.

    Args:
        integrator: after an attempt that converged; actions: of the same model on a system of its own, see
            ``actions_of``.
        end: of the step [s]; before: whether loads there are limits from the left.

    Attributes:
        balances: of all stages.
    """

    def __init__(self, integrator: Collocation, actions: StepActions, end: float, *, before: bool) -> None:
        method, stages, links = integrator.tableau, integrator.stages, integrator.stage_constraints
        h, last, body = end - integrator.t, len(method.nodes) - 1, integrator.body
        rates = method.derivative / h
        self._starts, self._mass = rates.sum(axis=1), body.mass
        self._held = body.held != 0.0
        actions.system.constraints.near[:] = integrator.system.constraints.near
        times = [integrator.t + c * h for c in method.nodes[:-1]] + [end]
        self.balances: list[Balance] = []
        tangents, self._basis = [], []
        for i, t in enumerate(times):
            multiplier = integrator.state.multiplier if links is None else links.arrays.states.multiplier[i]
            state = State(stages.r[i].copy(), stages.q[i].copy(), stages.twist[i].copy(), multiplier.copy())
            left = before and i == last
            self.balances.append(Balance(actions, state, stages.acceleration[i].copy(), t, before=left))
            tangent, basis = allowed_tangent(actions, self.balances[-1])
            tangents.append(tangent)
            self._basis.append(basis)
        speeds = np.einsum("ij,jna->ina", rates, stages.X)
        maps = [_maps(X, speed, body.split) for X, speed in zip(stages.X, speeds, strict=True)]
        self._carry = np.array([carry for carry, _, _ in maps])
        back = np.array([np.linalg.inv(T) for _, T, _ in maps])
        self._V = np.einsum("ij,inab,jnbc->ijnac", rates, np.array([T for _, T, _ in maps]), back)
        for i, (_, _, W) in enumerate(maps):
            self._V[i, i] += W @ back[i]
        self._A = np.einsum("il,ljnab->ijnab", rates, self._V)
        self._factors = SparseLU(self._stage_jacobian(tangents))
        self._turned = _turned_corrections(actions, self.balances[-1].state, end)

    def forward(
        self, pose: Floats, twist: Floats, changes: Sequence[ArrayChanges | None] = ()
    ) -> tuple[Floats, Floats]:
        """Return the changes of poses and twists at the end ``(6 n, k)`` that those at the start lead to.

        Args:
            pose, twist: at the start ``(6 n, k)``.
            changes: of the arrays of the problem that belong to the columns; none by default.
        """
        pose, twist = self._free(pose), self._free(twist)
        carried = self._carry @ self._nodal(pose)
        rates, accelerations = self._V @ carried, self._A @ carried
        speed, right = self._nodal(twist), []
        for i, balance in enumerate(self.balances):
            pushed = self._mass @ (accelerations[i].sum(axis=0) + self._starts[i] * speed)
            force = -(pushed.reshape(pose.shape) + balance.twist @ rates[i].sum(axis=0).reshape(pose.shape))
            force = np.concatenate([force, np.zeros((self._basis[i].shape[0] - len(force), pose.shape[1]))])
            for k, change in enumerate(changes):
                if change is not None:
                    force[:, k] += balance.force(change).ravel()
            right.append(-(self._basis[i].T @ force))
        found = np.split(self._factors.solve(np.concatenate(right)), len(right))
        poses = [(basis @ part)[: len(pose)] for basis, part in zip(self._basis, found, strict=True)]
        moved = np.array([self._nodal(part) for part in poses]) - carried
        rate = (self._V[-1] @ moved).sum(axis=0) + self._turned @ self._nodal(poses[-1])
        return poses[-1], rate.reshape(pose.shape)

    def backward(self, pose: Floats, twist: Floats) -> tuple[Floats, Floats, ArrayChanges]:
        """Return the derivatives by the start ``(6 n, 1)``, and by the arrays, of a function of the end.

        Args:
            pose, twist: derivatives of the function by the poses and twists at the end ``(6 n, 1)``.
        """
        by_poses = np.swapaxes(self._V[-1], -1, -2) @ self._nodal(twist)
        by_carried = -by_poses
        by_poses[-1] += self._nodal(pose) + np.swapaxes(self._turned, -1, -2) @ self._nodal(twist)
        right = [
            basis[: len(pose)].T @ by.reshape(pose.shape)
            for basis, by in zip(self._basis, by_poses, strict=True)
        ]
        found = np.split(self._factors.solve(np.concatenate(right), transposed=True), len(right))
        start_twist, gradient = np.zeros_like(twist), None
        for i, (balance, basis, part) in enumerate(zip(self.balances, self._basis, found, strict=True)):
            force = basis @ part
            nodal = force[: len(pose)]
            pushed = np.swapaxes(self._mass, -1, -2) @ self._nodal(nodal)
            start_twist += self._starts[i] * pushed.reshape(pose.shape)
            by_carried += np.swapaxes(self._V[i], -1, -2) @ self._nodal(balance.twist.T @ nodal)
            by_carried += np.swapaxes(self._A[i], -1, -2) @ pushed
            by_arrays = balance.gradient(-force.reshape(-1, 6))
            if gradient is None:
                gradient = by_arrays
            else:
                gradient.add(by_arrays)
        assert gradient is not None
        start_pose = (np.swapaxes(self._carry, -1, -2) @ by_carried).sum(axis=0)
        return self._free(start_pose.reshape(pose.shape)), self._free(start_twist), gradient

    def _stage_jacobian(self, tangents: Sequence[sparse.csc_array]) -> sparse.csc_array:
        """Return the derivatives of the balances of all stages by the motions that are allowed there."""
        rows, stages = [], range(len(tangents))
        for i, balance in enumerate(self.balances):
            row = []
            for j in stages:
                block = balance.twist @ block_diagonal(self._V[i, j]) + block_diagonal(
                    self._mass @ self._A[i, j]
                )
                left, right = (basis[: block.shape[0]] for basis in (self._basis[i], self._basis[j]))
                allowed = left.T @ block @ right
                row.append(allowed + tangents[i] if i == j else allowed)
            rows.append(row)
        return sparse.csc_array(sparse.block_array(rows))

    def _nodal(self, values: Floats) -> Floats:
        """Return values of all nodes ``(n, 6, k)``."""
        return values.reshape(-1, 6, values.shape[1])

    def _free(self, values: Floats) -> Floats:
        """Return values of all nodes ``(6 n, k)``, with zeros for those that are held completely."""
        return np.asarray(np.where(np.repeat(self._held, 6)[:, None], 0.0, values))


def require_linearisable(integrator: Collocation) -> None:
    """Refuse an integrator or a model whose steps cannot be linearised here.

    Raises:
        InputError: it is not a collocation method that ends with its last stage, in the geometric formulation, or the
            model has supports that hold rotations of a node in part, or what has no derivatives in statics.
    """
    problem = integrator.system.problem
    require_differentiable(problem)
    parts = {
        "supports that hold rotations of their place in part, or velocities along its own axes": _turn_in_part(
            integrator.supports
        ),
        "the midpoint rule": integrator.ends is not None,
        "rest strains that change with time": integrator.system.imposed.changes,
        "the intrinsic formulation": not isinstance(integrator.system, GeometricSystem)
        or integrator.forces.motion is not None,
    }
    for part, there in parts.items():
        if there:
            raise InputError(
                f"derivatives of motions are not known with {part}; take differences of two runs"
            )


def _turn_in_part(supports: SupportState) -> bool:
    """Return whether any support holds rotations in part: twists at the end of steps are then corrected for them."""
    held = supports.set.fixed[supports.partial]
    return bool(held[:, 3:].any() or supports.set.in_body[supports.partial].any())


def _turned_corrections(actions: StepActions, state: State, end: float) -> Floats:
    """Return how corrections of twists at the end of a step change with the poses there ``(n, 6, 6)``.

    Moving supports that hold displacements correct velocities by what their motion differs from its polynomial: vectors
    that are constant in space, and turn back as the node turns.
    """
    found: Floats = np.zeros((len(state.r), 6, 6))
    if len(actions.supports.partial):
        corrected = state.copy()
        actions.move_supports(end, before=True)
        actions.supports.project_twists(corrected)
        change = np.zeros_like(state.twist)
        change[:, 3:] = corrected.twist[:, :3] - state.twist[:, :3]
        found[:, :3, 3:] = adjoint_map(change)[:, 3:, 3:]
    return found


def _maps(X: Floats, rate: Floats, split: Floats) -> tuple[Floats, Floats, Floats]:
    """Return ``exp(-ad X)``, ``T(X)`` and ``d(T(X) X_t)/dX`` ``(n, 6, 6)`` of coordinates with a ``rate (n, 6)``.

    Those of nodes that are ``split`` have displacement and rotation apart (see ``nodal_motion``).
    """
    carry, tangent = series_of_exponential(X, split)
    change = np.empty_like(carry)
    for k, unit in enumerate(np.eye(6)):
        slope = series_of_exponential(X + 1j * _STEP * unit, split)[1].imag / _STEP
        change[:, :, k] = np.einsum("nij,nj->ni", slope, rate)
    return carry, tangent, change


def series_of_exponential(X: Floats, split: Floats, terms: int = _TERMS) -> tuple[Floats, Floats]:
    """Return ``exp(-ad X)`` and ``T(X)``, the series of ``(-ad X)^k`` over ``k!`` and ``(k + 1)!`` ``(n, 6, 6)``.

    Those of nodes that are ``split`` have displacement and rotation apart (see ``nodal_motion``).
    """
    apart = split != 0.0
    turning = X.copy()
    turning[apart, :3] = 0.0
    ad = -adjoint_map(turning)
    term = np.broadcast_to(np.eye(6, dtype=X.dtype), ad.shape)
    carry, tangent = term.copy(), term.copy()
    for k in range(1, terms + 1):
        term = term @ ad / k
        carry += term
        tangent += term / (k + 1)
    tangent[apart, :3, :3] = carry[apart, :3, :3]
    carry[apart, :3, 3:] = -carry[apart, :3, :3] @ adjoint_map(X[apart])[:, :3, 3:]
    return carry, tangent
