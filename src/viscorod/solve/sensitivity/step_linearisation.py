"""The exact linearisation of one collocation step: how its end follows its start and the arrays of the problem.

With the poses ``H_i = H_0 exp(X_i)``, twists ``x_i = T(X_i) sum_j d_ij X_j / h`` and accelerations
``sum_j d_ij (x_j - x_0)/h`` of the stages, small changes of the start (body increments ``p_0`` of the poses, ``dx_0``
of the twists) and of the coordinates make

    p_i = exp(-ad X_i) p_0 + T_i dX_i        dx_i = T_i sum_j d_ij dX_j / h + W_i dX_i

with ``W_i = d(T(X) X_t)/dX``, and the balances of all stages stay fulfilled: one linear system for all ``dX_j``, with
the Jacobian of these stages in place of the frozen one of the iteration. Both maps of the exponential are power series
of ``ad X``, which converge fast for the rotations of a step (up to 2 rad); ``W`` is their complex-step derivative.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import sparse

from viscorod.errors import InputError
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.balance import Balance, adjoint_map
from viscorod.solve.sensitivity.equilibrium_sensitivity import require_differentiable
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["StepLinearisation", "require_linearisable"]

_TERMS = 30
"""Of the series: the next one is below round-off for rotations of 3 rad."""
_STEP = 1e-30
"""Of complex-step derivatives."""


class StepLinearisation:
    """The linearisation of the step that an integrator has attempted, and not accepted yet.

    Columns of arrays are independent changes. Rows are those of all nodes, ``6 n``; nodes that supports hold do not
    change. Multipliers of joints and held strains are unknowns of every stage, and no part of the state.

    Args:
        integrator: after an attempt that converged; actions: of the same model on a system of its own, see
            ``actions_of``.
        end: of the step [s]; before: whether loads there are limits from the left.

    Attributes:
        balances: of all stages; mass: of all nodes ``(6 n, 6 n)``.
    """

    def __init__(self, integrator: Collocation, actions: StepActions, end: float, *, before: bool) -> None:
        method, stages, links = integrator.tableau, integrator.stages, integrator.stage_constraints
        h, last = end - integrator.t, len(method.nodes) - 1
        self._rates = method.derivative / h
        nodes = np.repeat(integrator.body.held == 0.0, 6)
        self._size, multipliers = len(nodes), 6 * integrator.system.problem.multipliers
        self._moves = nodes[:, None]
        self._free = np.concatenate([nodes, np.ones(multipliers, dtype=bool)])
        self.mass = block_diagonal(integrator.body.mass)
        times = [integrator.t + c * h for c in method.nodes[:-1]] + [end]
        self.balances: list[Balance] = []
        self._carry: list[sparse.csr_array] = []
        self._T: list[sparse.csr_array] = []
        self._W: list[sparse.csr_array] = []
        actions.system.constraints.near[:] = integrator.system.constraints.near
        for i, t in enumerate(times):
            multiplier = integrator.state.multiplier if links is None else links.arrays.states.multiplier[i]
            state = State(stages.r[i].copy(), stages.q[i].copy(), stages.twist[i].copy(), multiplier.copy())
            left = before and i == last
            self.balances.append(Balance(actions, state, stages.acceleration[i].copy(), t, before=left))
            maps = _maps(stages.X[i], np.tensordot(self._rates[i], stages.X, axes=1))
            for known, blocks in zip((self._carry, self._T, self._W), maps, strict=True):
                known.append(block_diagonal(blocks))
        self._factors = SparseLU(self._stage_jacobian())

    def forward(
        self, pose: Floats, twist: Floats, changes: Sequence[ArrayChanges | None] = ()
    ) -> tuple[Floats, Floats]:
        """Return the changes of poses and twists at the end ``(6 n, k)`` that those at the start lead to.

        Args:
            pose, twist: at the start ``(6 n, k)``.
            changes: of the arrays of the problem that belong to the columns; none by default.
        """
        pose, twist = self._only_free(pose), self._only_free(twist)
        start = self._rates.sum(axis=1)
        right = []
        for i, balance in enumerate(self.balances):
            force = balance.pose[:, : self._size] @ (self._carry[i] @ pose)
            force[: self._size] -= start[i] * (self.mass @ twist)
            for k, change in enumerate(changes):
                if change is not None:
                    force[:, k] += balance.force(change).ravel()
            right.append(-force)
        found = [part[: self._size] for part in self._unpacked(self._factors.solve(self._packed(right)))]
        rate = sum(d * x for d, x in zip(self._rates[-1], found, strict=True))
        end_pose = self._carry[-1] @ pose + self._T[-1] @ found[-1]
        return self._only_free(end_pose), self._only_free(self._T[-1] @ rate + self._W[-1] @ found[-1])

    def backward(self, pose: Floats, twist: Floats) -> tuple[Floats, Floats, ArrayChanges]:
        """Return the derivatives by the start ``(6 n, 1)``, and by the arrays, of a function of the end.

        Args:
            pose, twist: derivatives of the function by the poses and twists at the end ``(6 n, 1)``.
        """
        pose, twist = self._only_free(pose), self._only_free(twist)
        by_rate = self._T[-1].T @ twist
        right = [d * by_rate for d in self._rates[-1]]
        right[-1] = right[-1] + self._T[-1].T @ pose + self._W[-1].T @ twist
        none = np.zeros((len(self._free) - self._size, 1))
        right = [np.concatenate([part, none]) for part in right]
        forces = self._unpacked(self._factors.solve(self._packed(right), transposed=True))
        start_pose, start_twist = self._carry[-1].T @ pose, np.zeros_like(twist)
        gradient: ArrayChanges | None = None
        for i, (balance, start) in enumerate(zip(self.balances, self._rates.sum(axis=1), strict=True)):
            start_pose = start_pose - self._carry[i].T @ (balance.pose[:, : self._size].T @ forces[i])
            start_twist += start * (self.mass.T @ forces[i][: self._size])
            by_arrays = balance.gradient(-forces[i].reshape(-1, 6))
            if gradient is None:
                gradient = by_arrays
            else:
                gradient.add(by_arrays)
        assert gradient is not None
        return self._only_free(start_pose), self._only_free(start_twist), gradient

    def _stage_jacobian(self) -> sparse.csc_array:
        """Return the derivatives of the balances of all stages by all coordinates, of free nodes, node by node."""
        d, stages = self._rates, len(self.balances)
        multipliers = len(self._free) - self._size
        none, ones = sparse.csr_array((multipliers, multipliers)), sparse.eye_array(multipliers)
        rows = []
        for i, balance in enumerate(self.balances):
            row = []
            for j in range(stages):
                speed = sum(d[i, k] * d[k, j] * self._T[k] for k in range(stages)) + d[i, j] * self._W[j]
                block = self.mass @ speed + d[i, j] * (balance.twist @ self._T[i])
                if i == j:
                    block = block + balance.twist @ self._W[i]
                block = sparse.block_diag([block, none])
                if i == j:
                    block = block + balance.pose @ sparse.block_diag([self._T[i], ones])
                row.append(sparse.csr_array(block)[self._free][:, self._free])
            rows.append(row)
        whole = sparse.csc_array(sparse.block_array(rows))
        self._order = np.arange(whole.shape[0]).reshape(stages, -1, 6).swapaxes(0, 1).ravel()
        return sparse.csc_array(whole[self._order][:, self._order])

    def _packed(self, parts: Sequence[Floats]) -> Floats:
        return np.concatenate([part[self._free] for part in parts])[self._order]

    def _unpacked(self, values: Floats) -> list[Floats]:
        """Undo :meth:`_packed`, with zeros at held nodes."""
        whole = np.empty_like(values)
        whole[self._order] = values
        found = []
        for part in np.split(whole, len(self.balances)):
            full = np.zeros((len(self._free), values.shape[1]))
            full[self._free] = part
            found.append(full)
        return found

    def _only_free(self, values: Floats) -> Floats:
        return np.asarray(values * self._moves)


def require_linearisable(integrator: Collocation) -> None:
    """Refuse an integrator or a model whose steps cannot be linearised here.

    Raises:
        InputError: it is not a collocation method that ends with its last stage, in the geometric formulation, or the
            model has supports that hold a part of a node, or what has no derivatives in statics.
    """
    problem = integrator.system.problem
    require_differentiable(problem)
    parts = {
        "supports that leave motions of their place free": len(integrator.supports.partial) > 0,
        "the midpoint rule": integrator.ends is not None,
        "the intrinsic formulation": not isinstance(integrator.system, GeometricSystem)
        or integrator.forces.motion is not None,
    }
    for part, there in parts.items():
        if there:
            raise InputError(
                f"derivatives of motions are not known with {part}; take differences of two runs"
            )


def _maps(X: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
    """Return ``exp(-ad X)``, ``T(X)`` and ``d(T(X) X_t)/dX`` of coordinates that change at ``rate (n, 6)``."""
    carry, tangent = _series(X)
    change = np.empty_like(carry)
    for k, unit in enumerate(np.eye(6)):
        slope = _series(X + 1j * _STEP * unit)[1].imag / _STEP
        change[:, :, k] = np.einsum("nij,nj->ni", slope, rate)
    return carry, tangent, change


def _series(X: Floats) -> tuple[Floats, Floats]:
    """Return the series ``sum (-ad X)^k / k!`` and ``sum (-ad X)^k / (k + 1)!`` ``(n, 6, 6)``."""
    ad = -adjoint_map(X)
    term = np.broadcast_to(np.eye(6, dtype=X.dtype), ad.shape)
    carry, tangent = term.copy(), term.copy()
    for k in range(1, _TERMS + 1):
        term = term @ ad / k
        carry += term
        tangent += term / (k + 1)
    return carry, tangent
