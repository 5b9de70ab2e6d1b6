"""Joints, springs and held strains in linear dynamics: conditions on displacements, their forces, coordinates."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.solve.constraints.constraint_rows import gradients_of_gaps
from viscorod.solve.constraints.constraints import Constraints, JointState
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.typing import Floats, Integers

__all__ = ["LinearConditions"]


class LinearConditions:
    """Joints, springs and held strains of a model that is linear about a state.

    Args:
        constraints: just measured in the state, with the tangent of springs; state: with multipliers.
        held_rows: orders of all elements and the change of their strains, see ``add_held_strains``.
        basis: displacements that supports allow ``(6 n, free)``.

    Attributes:
        conditions: gradients of the conditions on them, of unit length; None without.
    """

    def __init__(
        self,
        constraints: Constraints,
        state: State,
        held_rows: tuple[Integers, Floats] | None,
        basis: sparse.csc_array,
    ) -> None:
        self.constraints, self.multiplier = constraints, state.multiplier.copy()
        self._basis = basis
        self._gradients = gradients_of_gaps(constraints, state, held_rows)
        self._free = sparse.csr_array(self._gradients @ basis)
        self.conditions = unit_rows(self._free) if constraints.rows else None
        size = np.sqrt(np.asarray(self._free.multiply(self._free).sum(axis=1)).ravel())
        self._unit = 1.0 / np.where(size > 0.0, size, 1.0)
        rows = sparse.diags_array(self._unit) @ self._free
        idle = sparse.diags_array((size == 0.0).astype(float))
        self._gram = SparseLU(rows @ rows.T + idle) if constraints.rows else None
        value, _, gradients = constraints.measure(state)
        self._value, self._force = value, constraints.force.copy()
        self._coordinates = self._along(gradients, len(state.r))
        self._stiffness, self._damping = constraints.slopes

    def _along(self, gradients: Floats, n: int) -> sparse.csr_array:
        """Return the gradients of all coordinates ``(c, 12)`` by displacements of the nodes ``(c, 6 n)``."""
        nodes, count = self.constraints.arrays.nodes, len(gradients)
        present = nodes >= 0
        rows = np.repeat(np.broadcast_to(np.arange(count)[:, None], nodes.shape)[present], 6)
        columns = (6 * nodes[present][:, None] + np.arange(6)).ravel()
        values = gradients.reshape(count, 2, 6)[present].ravel()
        return sparse.csr_array(sparse.coo_array((values, (rows, columns)), shape=(count, 6 * n)))

    def balanced(self, residual: Floats) -> tuple[Floats, Floats]:
        """Return the unbalanced forces ``(6 n,)`` with those of the conditions, and all multipliers ``(places,)``."""
        multiplier = self.multiplier.copy()
        if self._gram is None:
            return residual, multiplier
        free = self._basis.T @ residual
        change = -self._unit * self._gram.solve(self._unit * (self._free @ free))
        multiplier[self.constraints.used] += change
        return residual + self._gradients.T @ change, multiplier

    def joints(self, xi: Floats, x: Floats, multiplier: Floats) -> JointState | None:
        """Return coordinates, rates and forces of joints and springs at displacements and velocities ``(6 n,)``."""
        constraints = self.constraints
        if not constraints.joints.count:
            return None
        change, rate = self._coordinates @ xi, self._coordinates @ x
        force = self._force + self._stiffness * change + self._damping * rate
        held = constraints.is_held
        force[held] = multiplier[constraints.arrays.place[held]]
        return constraints.state_of(self._value + change, rate, force)
