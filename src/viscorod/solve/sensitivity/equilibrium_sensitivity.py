"""How an equilibrium changes with the arrays of the problem: directly, and by the adjoint.

With the tangent ``K``, in the motions ``Z`` that supports and joints allow, ``Z' K Z y = -Z' dR``. The derivative of a
function of the poses with the gradient ``w`` is ``w . Z y = -(Z K^-T Z' w) . dR``: one transposed solution for any
number of parameters.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.errors import InputError
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.problem.problem import Problem
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.balance import Balance
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.stage_data import Discretisation
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["EquilibriumSensitivity", "require_differentiable"]


class EquilibriumSensitivity:
    """Derivatives of the poses at an equilibrium under all of the loads.

    Args:
        solver: that found it; state: the equilibrium; t: time [s] of its loads, as limits from the left if ``before``.

    Raises:
        InputError: the model has parts whose derivatives are not known here.
    """

    def __init__(self, solver: StaticSolver, state: State, t: float = 0.0, *, before: bool = True) -> None:
        system = solver.system
        require_differentiable(system.problem)
        assert isinstance(system, GeometricSystem)
        tangent = solver.tangent(state, t, before=before)
        self._basis, self._free = tangent.basis, tangent.stiffness.shape[0]
        matrix = tangent.stiffness
        if tangent.gradients is not None:
            held = tangent.gradients * float(np.abs(matrix.diagonal()).mean())
            matrix = sparse.block_array([[matrix, held.T], [held, None]])
        self._factors = SparseLU(matrix)
        self._rows = matrix.shape[0]
        resting = State(state.r, state.q, np.zeros_like(state.twist), state.multiplier)
        body = Discretisation.of(system.problem, system.elements(), solver.supports)
        actions = StepActions(system, solver.supports, body, 1)
        self._balance = Balance(actions, resting, np.zeros_like(state.twist), t, before=before)

    def direct(self, changes: ArrayChanges) -> Floats:
        """Return the body increments ``(n, 6)`` of all nodes per unit of a parameter that changes the arrays so."""
        return -self._solved(self._balance.force(changes), transposed=False)

    def adjoint(self, weights: Floats) -> ArrayChanges:
        """Return the derivatives by the arrays of a function with the ``weights (n, 6)`` by body increments."""
        return self._balance.gradient(-self._solved(weights, transposed=True))

    def _solved(self, forces: Floats, *, transposed: bool) -> Floats:
        right: Floats = np.zeros(self._rows)
        right[: self._free] = self._basis.T @ forces.ravel()
        found = self._factors.solve(right, transposed=transposed)[: self._free]
        return np.asarray(self._basis @ found).reshape(-1, 6)


def require_differentiable(problem: Problem) -> None:
    """Refuse a model with parts whose derivatives by the arrays are not known here.

    Raises:
        InputError: it has held strains, Maxwell branches or loads that are records.
    """
    parts = {
        "held strains": len(problem.held.place) > 0,
        "Maxwell branches": problem.relaxing,
        "loads that are records": bool(problem.records),
    }
    for part, there in parts.items():
        if there:
            raise InputError(
                f"derivatives are not known for models with {part}; take differences of two runs"
            )
