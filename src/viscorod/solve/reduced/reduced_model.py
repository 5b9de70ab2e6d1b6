"""Everything of a reduced motion that does not change in time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import Snapshot
from viscorod.solve.modes.undamped import Undamped
from viscorod.solve.problem.external_loads import NO_LOADS
from viscorod.solve.problem.problem import Problem
from viscorod.solve.reduced.held_directions import HeldDirections
from viscorod.solve.reduced.motion_basis import MotionBasis, motion_basis, shape_of_strain
from viscorod.solve.reduced.point_operators import PointOperators
from viscorod.solve.reduced.quadratic_model import QuadraticModel, TestedBalance
from viscorod.solve.reduced.reduced_loads import ReducedLoads
from viscorod.solve.reduced.shape_from_strains import ShapeFromStrains
from viscorod.typing import Floats

__all__ = ["ReducedModel", "start_strain"]


def start_strain(system: System, state: State) -> Floats:
    """Return the strains at the Gauss points ``(m, 6)`` that a motion from a state begins with."""
    if system.given_strain is not None:
        return system.given_strain
    system.assemble(state, NO_LOADS, None, tangent=False, moving=False)
    return system.gauss_points().strain


@dataclass(frozen=True)
class ReducedModel:
    """Reduced equations with what turns their unknowns into fields of the rods.

    Attributes:
        system, supports: the whole model; equations: between velocities and strains.
        held: directions in which supports hold; balance: of momentum tested with them.
        shape: poses from strains; start: strains at the start ``(m, 6)``.
    """

    system: System
    supports: SupportState
    operators: PointOperators
    equations: QuadraticModel
    held: HeldDirections
    balance: TestedBalance
    shape: ShapeFromStrains
    start: Floats

    @classmethod
    def of(
        cls,
        system: System,
        supports: SupportState,
        undamped: Undamped,
        state: State,
        count: int,
        *,
        linearised: bool,
    ) -> ReducedModel:
        """Reduce a model to a number of vibration modes, for motions from a state.

        Args:
            undamped: modes of the unstressed shape, ``count`` or more.
        """
        problem, operators = system.problem, PointOperators.of(system)
        start = start_strain(system, state)
        exact = shape_of_strain(operators, undamped, start[None])
        held = HeldDirections.of(supports, operators, undamped)
        exact = np.hstack([exact, held.allowed(supports, state.twist).reshape(-1, 1)])
        basis = motion_basis(problem, operators, undamped, count, exact, ReducedLoads(problem).patterns())
        equations = QuadraticModel.of(problem, operators, basis, linearised=linearised)
        balance = equations.tested(problem, operators, held.velocity)
        return cls(system, supports, operators, equations, held, balance, ShapeFromStrains(system), start)

    @property
    def problem(self) -> Problem:
        """The whole model in arrays."""
        return self.system.problem

    @property
    def basis(self) -> MotionBasis:
        """Velocities and strains."""
        return self.equations.basis

    @cached_property
    def unit(self) -> Floats:
        """The size of the model for displacements, 1 rad for rotations ``(6,)``."""
        return np.repeat([self.problem.length, 1.0], 3)

    @cached_property
    def moved(self) -> Floats:
        """Small motions of the nodes by strains ``(6 n, k)``, of the velocities that are not rigid."""
        basis = self.basis
        return basis.velocity[:, basis.rigid :] / basis.omega[basis.rigid :]

    def begun(self, state: State) -> Floats:
        """Return ``(q1, q2)`` that come nearest to the start of a motion from a state."""
        basis = self.basis
        twist = self.held.allowed(self.supports, state.twist)
        momenta = np.einsum("nij,nj->ni", self.problem.mass, twist).ravel()
        stress = np.einsum("gij,gj->gi", self.operators.stiffness, self.start)
        return np.concatenate([basis.velocity.T @ momenta, np.einsum("kgi,gi->k", basis.strain, stress)])

    def twists(self, q1: Floats) -> Floats:
        """Return the body twists ``(..., n, 6)`` of velocities ``(..., k)``."""
        found = q1 @ self.basis.velocity.T
        return np.asarray(found.reshape(*q1.shape[:-1], self.problem.size, 6))

    def root_twists(self, q1: Floats) -> Floats:
        """Return the body twists of the roots ``(s, roots, 6)`` of velocities ``(s, k)``."""
        return np.asarray(np.moveaxis(self._root_velocity @ q1.T, 2, 0))

    @cached_property
    def _root_velocity(self) -> Floats:
        nodes = [root.node for root in self.shape.roots]
        found: Floats = self.basis.velocity.reshape(self.problem.size, 6, -1)[nodes]
        return found

    def strains(self, q2: Floats) -> Floats:
        """Return strains at the Gauss points ``(..., m, 6)``."""
        return np.asarray(np.tensordot(q2, self.basis.strain, 1))

    def errors(self, change: Floats, h: float) -> Floats:
        """Return displacements over the size of the model and rotations ``(n, 6)`` that a change of ``y`` means.

        That of a velocity is what it moves in a radian of its vibration, and within ``h`` [s] if it is rigid.
        """
        basis = self.basis
        k, rigid, flexible = basis.velocity.shape[1], basis.rigid, self.moved.shape[1]
        by_strain = self.moved @ change[k : k + flexible]
        by_velocity = self.moved @ change[rigid:k] + h * (basis.velocity[:, :rigid] @ change[:rigid])
        return np.maximum(np.abs(by_strain), np.abs(by_velocity)).reshape(-1, 6) / self.unit

    def sections(self, y: Floats, change: Floats) -> tuple[Floats, Floats, Floats]:
        """Return strains, their rates in the law of damping and section forces at the Gauss points ``(m, 6)``."""
        k, gauss = self.equations.sizes[0], self.system.gauss_positions()
        strain = self.strains(y[k:])
        rate = self.strains(self.equations.stress_rate(y[:k], change[k:]))
        elastic = np.einsum("gij,gj->gi", gauss.stiffness, strain)
        return strain, rate, elastic + np.einsum("gij,gj->gi", gauss.damping, rate)

    def snapshot(self, state: State, y: Floats, change: Floats, external: Floats) -> Snapshot:
        """Return everything in a state.

        Args:
            state: poses and twists of the nodes; y: ``(q1, q2)``; change: their rates; external: wrenches ``(n, 6)``.
        """
        equations, k = self.equations, self.equations.sizes[0]
        strain, rate, force = self.sections(y, change)
        forces = equations.reactions(self.balance, y, change, external)
        reaction = self.held.reactions(self.supports, forces, state.q)
        kinetic, elastic = 0.5 * float(y[:k] @ y[:k]), 0.5 * float(y[k:] @ y[k:])
        return Snapshot(state, strain, rate, force, reaction, kinetic, elastic)
