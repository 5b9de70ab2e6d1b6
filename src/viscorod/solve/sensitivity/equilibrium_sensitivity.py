"""How an equilibrium changes with the arrays of the problem: directly, and by the adjoint.

With the tangent ``K`` of nodes and multipliers, in the motions ``Z`` that supports allow, ``Z' K Z y = -Z' dR``. The
derivative of a function of the poses with the gradient ``w`` is ``w . Z y = -(Z (Z' K Z)^-T Z' w) . dR``: one
transposed solution for any number of parameters.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.errors import InputError
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.balance import Balance
from viscorod.solve.sensitivity.known_models import require_differentiable
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.stage_data import Discretisation
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["EquilibriumSensitivity", "actions_of", "allowed_tangent"]


class EquilibriumSensitivity:
    """Derivatives of the poses at an equilibrium under all of the loads.

    Args:
        solver: that found it; state: the equilibrium; t: time [s] of its loads, as limits from the left if ``before``.

    Raises:
        InputError: the model has parts whose derivatives are not known here.
    """

    def __init__(self, solver: StaticSolver, state: State, t: float = 0.0, *, before: bool = True) -> None:
        require_differentiable(solver.system.problem)
        resting = State(state.r, state.q, np.zeros_like(state.twist), state.multiplier)
        actions = actions_of(solver.system)
        self._balance = Balance(actions, resting, np.zeros_like(state.twist), t, before=before)
        matrix, self._basis = allowed_tangent(actions, self._balance)
        self._factors = SparseLU(matrix)

    def direct(self, changes: ArrayChanges) -> Floats:
        """Return the body increments ``(n, 6)`` of all nodes per unit of a parameter that changes the arrays so."""
        found = -self._solved(self._balance.force(changes), transposed=False)
        return found[: self._balance.problem.size]

    def adjoint(self, weights: Floats) -> ArrayChanges:
        """Return the derivatives by the arrays of a function with the ``weights (n, 6)`` by body increments."""
        none = np.zeros((self._balance.problem.multipliers, 6))
        return self._balance.gradient(-self._solved(np.concatenate([weights, none]), transposed=True))

    def _solved(self, forces: Floats, *, transposed: bool) -> Floats:
        found = self._factors.solve(self._basis.T @ forces.ravel(), transposed=transposed)
        return np.asarray(self._basis @ found).reshape(-1, 6)


def actions_of(system: System) -> StepActions:
    """Return the loads and supports of a model on a system of its own, for :class:`Balance`.

    Raises:
        InputError: it is not the geometric formulation.
    """
    if not isinstance(system, GeometricSystem):
        raise InputError(
            "derivatives are known in the geometric formulation only; take differences of two results"
        )
    own, supports = GeometricSystem(system.problem), SupportState(system.problem)
    own.constraints.near[:] = system.constraints.near
    return StepActions(own, supports, Discretisation.of(system.problem, own.elements(), supports), 1)


def allowed_tangent(actions: StepActions, balance: Balance) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Return the derivative of a balance by the motions that supports allow and by multipliers; and these motions.

    Returns:
        ``(free, free)``; ``(6 N, free)``, from motions and scaled multipliers to body increments and these.
    """
    problem, supports = actions.system.problem, actions.supports
    matrix = Matrix(problem.pattern, problem.length)
    matrix.blocks[:] = balance.blocks
    supports.update(balance.t, balance.before)
    stiffness, basis = supports.reduce_tangent(balance.state, balance.residual.copy(), matrix)
    if not problem.multipliers:
        return sparse.csc_array(stiffness), basis
    size, ones = 6 * problem.size, sparse.eye_array(6 * problem.multipliers)
    rows = [
        [stiffness, basis.T @ balance.pose[:size, size:]],
        [balance.pose[size:, :size] @ basis, balance.pose[size:, size:]],
    ]
    return sparse.csc_array(sparse.block_array(rows)), sparse.csc_array(sparse.block_diag([basis, ones]))
