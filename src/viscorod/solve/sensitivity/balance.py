"""The balance of all nodes at one state, and its derivatives by the motion and by the arrays of the problem.

The balance is ``R = M x' + L1(x) M x + f_int - f_ext`` with ``f_int = sum_g w_g B^T S`` and ``S = C eps + D eps'``. It
is linear in the arrays, so that its derivatives by them are those formulas once more, with other stresses and masses.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.elements.section_laws import BY_RATE, BY_STRAIN
from viscorod.mechanics.nodes.inertia import add_coriolis
from viscorod.mechanics.rotations.adjoint_maps import adjoint_map, skew
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.problem.external_loads import load_count
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.problem.law_responses import law_responses
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["Balance", "gyroscopic"]


class Balance:
    """The balance at one state.

    Args:
        actions: loads and supports of a model without Maxwell branches and loads that are records, on a system that
            nothing else works with.
        state: poses, twists and multipliers; acceleration: rates of the body twists ``(n, 6)``.
        t, before: time [s] of the loads, and whether as limits from the left.

    Attributes:
        residual: the balance, and scaled gaps of what multipliers hold ``(N, 6)``.
        blocks: its derivatives by body increments of the poses at constant twists, and by scaled multipliers.
        pose: the same as a matrix ``(6 N, 6 N)``; twist: derivatives by the twists ``(6 n, 6 n)``.
    """

    def __init__(
        self, actions: StepActions, state: State, acceleration: Floats, t: float, *, before: bool
    ) -> None:
        self.actions, self.state, self.t, self.before = actions, state, t, before
        system = actions.system
        assert isinstance(system, GeometricSystem)
        problem = self.problem = system.problem
        self.elements = elements = system.elements()
        constraints, n, pattern = system.constraints, problem.size, problem.pattern
        constraints.update(t, before)
        system.impose_rest(Imposed(1.0, t, before))
        carried = len(problem.held.place) > 0 or system.imposed.changes
        points, internal = GaussStates.of(elements, 1, carried=carried), np.zeros((n, 6))
        system.element_forces(elements, 1).evaluate(state, points, internal)
        self.strain, self.strain_rate = points.strain[0].copy(), points.strain_rate[0].copy()
        self._tangent = elements.stiffness[elements.section] + self._law_tangent()
        operators = Operators.of(elements)
        self.blocks, C = np.zeros((2, len(pattern.rows), 6, 6))
        still = np.zeros((n, 6, 6))  # increments of the twists count by themselves
        system.linearise(state, still, points.section_force[0], operators, self.blocks, C)
        self.B = operators.strain
        constraints.add_forces(state, internal)
        held = (elements.order, self.B) if len(problem.held.place) else None
        constraints.add_tangent(state, still, self.blocks, C, moving=True, held=held)
        external = np.zeros((n, 6))
        actions.add_loads(t, state, external, before=before)
        actions.add_load_stiffness(t, state, still, self.blocks, C, before=before)
        at = problem.held
        constraints.gap[at.place] = self.strain[at.element, at.point, at.component]
        self.scale = constraints.scale.copy()
        self.weights = elements.half_lengths[:, None] * elements.weights[elements.order]
        self._fall = acceleration.copy()  # gravity is an acceleration of the whole model the other way
        self._fall[:, :3] -= np.einsum("nji,j->ni", matrices(state.q), actions.loads.at(t, before).gravity)
        inertia = np.einsum("nij,nj->ni", problem.mass, acceleration) + _coriolis(problem.mass, state.twist)
        gaps = (self.scale * constraints.gap).reshape(-1, 6)
        self.residual: Floats = np.concatenate([internal - external + inertia, gaps])
        self.pose = pattern.sparse(self.blocks)
        size = 6 * n
        self.twist = pattern.sparse(C)[:size, :size] + block_diagonal(gyroscopic(problem.mass, state.twist))

    def force(self, changes: ArrayChanges) -> Floats:
        """Return the change ``(N, 6)`` of :attr:`residual` with the arrays, at constant motion and multipliers."""
        elements = self.elements
        dC, dD = (m[elements.section] for m in (changes.stiffness, changes.damping))
        stress = np.einsum("egij,egj->egi", dC, self.strain) + np.einsum(
            "egij,egj->egi", dD, self.strain_rate
        )
        stress -= np.einsum("egij,egj->egi", self._tangent, changes.reference)
        stress *= self.weights[:, :, None]
        nodal = np.einsum("era,er->ea", self.B, stress.reshape(len(stress), -1))
        found: Floats = np.zeros((self.problem.size, 6))
        np.add.at(found, elements.nodes, nodal.reshape(*elements.nodes.shape, 6))
        x, dM = self.state.twist, changes.mass
        found += np.einsum("nij,nj->ni", dM, self._fall)
        found += _coriolis(dM, x)
        for load in np.flatnonzero(changes.factors):
            found -= changes.factors[load] * self.unit_load(int(load))
        gaps, held = np.zeros_like(self.scale), self.problem.held
        gaps[held.place] = -changes.reference[held.element, held.point, held.component]
        return np.concatenate([found, (self.scale * gaps).reshape(-1, 6)])

    def gradient(self, weights: Floats) -> ArrayChanges:
        """Return the derivatives of the sum of ``weights (N, 6)`` times :attr:`residual` by the arrays."""
        elements, problem, held = self.elements, self.problem, self.problem.held
        gaps, weights = self.scale * weights[problem.size :].ravel(), weights[: problem.size]
        found = ArrayChanges.none(problem, elements)
        at_elements: Floats = weights[elements.nodes].reshape(len(elements.nodes), -1)
        virtual = np.einsum("era,ea->er", self.B, at_elements).reshape(self.strain.shape)
        virtual *= self.weights[:, :, None]
        np.add.at(found.stiffness, elements.section, virtual[..., :, None] * self.strain[..., None, :])
        np.add.at(found.damping, elements.section, virtual[..., :, None] * self.strain_rate[..., None, :])
        found.reference[:] = -np.einsum("egji,egj->egi", self._tangent, virtual)
        found.reference[held.element, held.point, held.component] -= gaps[held.place]
        x = self.state.twist
        found.mass[:] = weights[:, :, None] * self._fall[:, None, :]
        found.mass[:] -= np.einsum("nij,nj->ni", adjoint_map(x), weights)[:, :, None] * x[:, None, :]
        for load in range(len(found.factors)):
            found.factors[load] = -float(np.vdot(weights, self.unit_load(load)))
        return found

    def unit_load(self, load: int) -> Floats:
        """Return the forces ``(n, 6)`` of one load with the factor 1."""
        given = dict.fromkeys(range(load_count(self.problem)), 0.0) | {load: 1.0}
        found: Floats = np.zeros((self.problem.size, 6))
        self.actions.add_loads(self.t, self.state, found, before=self.before, given=given)
        return found

    def _law_tangent(self) -> Floats:
        """Return the derivatives of the laws of sections by the strains ``(elements, points, 6, 6)``."""
        elements = self.elements
        values = law_responses(elements.laws, elements.section, self.strain, self.strain_rate)
        return values[..., BY_STRAIN:BY_RATE].reshape(*self.strain.shape, 6)


def gyroscopic(mass: Floats, x: Floats) -> Floats:
    """Return the derivatives ``(..., n, 6, 6)`` of ``L1(x) M x`` by twists ``x (..., n, 6)``, ``L1(x) = -ad(x)^T``."""
    momentum = (mass @ x[..., None])[..., 0]
    found: Floats = -np.swapaxes(adjoint_map(x), -1, -2) @ mass
    linear, angular = skew(momentum[..., :3]), skew(momentum[..., 3:])
    found[..., :3, 3:] -= linear
    found[..., 3:, :3] -= linear
    found[..., 3:, 3:] -= angular
    return found


def _coriolis(mass: Floats, x: Floats) -> Floats:
    """Return ``L1(x) M x`` of all nodes ``(n, 6)``."""
    found = np.zeros_like(x)
    add_coriolis(mass, x, found)
    return found
