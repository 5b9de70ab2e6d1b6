"""Steady rotations in positions and rotations: poses of the nodes and the angular speed about a line in space.

Nodes have the twists of a rigid rotation, ``x_k = Omega x1_k(H_k)``, so strains do not change and the balance is

    f_int(H) + L1(x) M x - f_ext(H) = 0.

A body increment d changes the twist by ``ad(x) d``; with it the derivative is the stiffness matrix K of the small
motions about the rotation, gyroscopic and centrifugal parts included.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.internal_force import GaussStates, energies
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.element_forces import GeometricForces
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.statics.stability import circulatory
from viscorod.solve.steady.rigid_rotation import RotationAxis, coriolis, rigid_twists
from viscorod.solve.steady.stability import FULL, FirstOrder, SecondOrder, basis_inverse, first_order
from viscorod.solve.steady.steady_checks import SupportKind, no_loads, support_kind
from viscorod.solve.steady.steady_equations import Balance, Measure, imbalance
from viscorod.solve.transient.integrators import jacobian
from viscorod.typing import Floats


class GeometricSteady:
    """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`; the last unknown is the angular speed.

    Args:
        system, supports: the model; supports turn with it.
        loads: that stay as they are while it turns.
        line: the line about which it turns.
        state: first guess of the poses, overwritten; rate: of the angular speed [rad/s].
    """

    def __init__(
        self,
        system: System,
        supports: SupportState,
        loads: LoadState,
        line: RotationAxis,
        state: State,
        rate: float,
    ) -> None:
        self.system, self.supports, self.loads, self.line = system, supports, loads, line
        self.problem = system.problem
        self.elements = system.elements()
        self._forces = GeometricForces(self.system, self.elements)
        self._points = GaussStates.of(self.elements, 1)
        self._carried: Floats | None = None
        n = self.problem.size
        self._internal = np.zeros((n, 6))
        self._matrix = Matrix(self.problem.pattern)
        self._K, self._C = np.zeros((2, *self._matrix.blocks.shape))
        self._operators = Operators.of(self.elements)
        self._state, self.rate = state, rate

    def state(self) -> State:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        at = self._state
        at.twist[:] = rigid_twists(at.r, at.q, [0.0] * 3, self.rate * self.line.direction, self.line.centre)
        return at

    def set_spin(self, value: float) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        self.rate = value

    def scales(self) -> Floats:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        length = self.problem.length
        return np.append(np.tile([length, length, length, 1.0, 1.0, 1.0], self.problem.size), self.rate)

    def balance(self) -> Balance:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        state, supports, n = self.state(), self.supports, self.problem.size
        residual, gap = self.residual()
        inertial = coriolis(self.problem.mass, state.twist)
        stress = self._points.section_force[0] if self._carried is None else self._carried
        self._linearise(state, stress)
        self._matrix.blocks[:] = self._K
        supports.impose(state, residual, self._matrix, tangent=True)
        column = np.zeros(6 * n)
        # inertial forces are quadratic in the angular speed
        by_rate = 2.0 / self.rate * inertial - self._external_by_rate(state)
        column[supports.free_rows()] = supports.free_basis(state).T @ by_rate.ravel()
        matrix = sparse.csr_array(sparse.hstack([self._matrix.sparse(), sparse.csr_array(column[:, None])]))
        return Balance(residual.ravel(), matrix if 6 * n > FULL else matrix.toarray(), gap)

    def residual(self) -> tuple[Floats, float]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`; supports keep their reactions."""
        state, problem = self.state(), self.problem
        self._evaluate(state)
        external = self._external(state)
        inertial = coriolis(problem.mass, state.twist)
        residual = self._internal - external + inertial
        left = residual.copy()
        self.supports.impose(state, left, self._matrix, tangent=False)
        left = self.supports.unbalanced(left)
        forces = self._internal, external, inertial
        whole = float(problem.mass[:, 0, 0].mean()) * problem.length * self.rate**2
        return residual, imbalance(left, forces, whole, problem.length)

    def measure(self, kind: Measure) -> tuple[float, Floats]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        state, mass = self.state(), self.problem.mass
        self._evaluate(state)
        inertial = coriolis(mass, state.twist).ravel()
        T, rate = kinetic_energy(mass, state.twist), self.rate
        W, internal = self.elastic_energy(), self._internal.ravel()
        if kind == "spin":
            return rate, np.append(np.zeros(6 * len(mass)), 1.0)
        if kind == "energy":
            return T + W, np.append(internal - inertial, 2.0 * T / rate)
        if kind == "momentum":
            return 2.0 * T / rate, np.append(-2.0 / rate * inertial, 2.0 * T / rate**2)
        return W, np.append(internal, 0.0)

    def elastic_energy(self) -> float:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        elastic, dissipated = np.empty((2, 1))
        energies(self.elements, self._points.strain, self._points.strain_rate, elastic, dissipated)
        return float(elastic[0]) + self.system.constraints.energy

    def update(self, change: Floats) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`.

        Section forces are carried along by the frozen operator (mixed Newton, as in statics).
        """
        e, increment = self.elements, change[:-1].reshape(-1, 6)
        if self._carried is None:
            self._carried = np.zeros_like(e.reference)
        local = increment[e.nodes].reshape(len(e.nodes), -1)
        for a, count in enumerate(6 * e.order):
            carried = self._operators.force[a, :count, : count + 6] @ local[a, : count + 6]
            self._carried[a, : e.order[a]] = self._points.section_force[0, a, : e.order[a]] + carried.reshape(
                -1, 6
            )
        retract(self._state.r, self._state.q, increment, self._state.r, self._state.q)
        self.rate += float(change[-1])

    def save(self) -> object:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        return self._state.copy(), self.rate

    def restore(self, kept: object) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        assert isinstance(kept, tuple)
        self._state, self.rate = kept[0].copy(), kept[1]
        self._carried = None

    def fields(self) -> tuple[Floats, Floats]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        self._evaluate(self.state())
        return self._points.strain[0].copy(), self._points.section_force[0].copy()

    def small_motions(self) -> FirstOrder:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        state = self.state()
        self.balance()
        ad = self._linearise(state, self._points.section_force[0])
        stiffness, damping = (self.problem.pattern.sparse(blocks) for blocks in (self._K, self._C))
        mass = sparse.csr_array(sparse.block_diag(list(self.problem.mass), format="csr"))
        # drag at the velocities of the rotation is a circulatory force for those who turn along
        skew = circulatory(self.loads) or self.loads.sees_motion
        small = SecondOrder(mass, damping, stiffness, ad, skew)
        copies = self._copies(state)
        return first_order(small, self.supports, state, self.line, copies, self.problem.length, self.rate)

    def _evaluate(self, state: State) -> None:
        """Evaluate strains and elastic forces; without twists, whose strain rates are round-off."""
        resting = State(state.r, state.q, np.zeros_like(state.twist))
        self._forces.evaluate(resting, self._points, self._internal)
        self.system.constraints.add_forces(
            state, self._internal
        )  # of springs, which are alike all around the axis

    def _linearise(self, state: State, stress: Floats) -> Floats:
        """Fill the blocks ``K`` and ``C``; returns ``ad(x)`` of every node."""
        n = self.problem.size
        ad, product = np.zeros((n, 6, 6)), np.zeros((n, 6, 6))
        jacobian.adjoint(state.twist, ad)
        self._K.fill(0.0)
        self._C.fill(0.0)
        self._forces.linearise(state, ad, stress, self._operators, self._K, self._C)
        if self.problem.joints.count:
            self.system.constraints.add_tangent(state, ad, self._K, self._C, moving=True, held=None)
        self._external(state, MotionTangent(ad, self._K, self._C, self.problem.pattern.diagonal))
        jacobian.add_inertia(
            self.problem.mass,
            state.twist,
            ad,
            self._K,
            self._C,
            self.problem.pattern.diagonal,
            product,
            np.empty((6, 6)),
        )
        return ad

    def _external(self, state: State, tangent: MotionTangent | None = None) -> Floats:
        """Return the loads ``(n, 6)``; with ``tangent`` their derivative is subtracted from its blocks."""
        external = np.zeros((self.problem.size, 6))
        self.loads.add(self.problem, (state.r, state.q), state.twist, external, tangent)
        return external

    def _external_by_rate(self, state: State) -> Floats:
        """Return the derivative of the loads by the angular speed ``(n, 6)``; twists are proportional to it."""
        change = np.zeros((self.problem.size, 6))
        if self.loads.sees_motion:
            C = np.zeros_like(self._C)
            diagonal = self.problem.pattern.diagonal
            self.loads.add(
                self.problem,
                (state.r, state.q),
                state.twist,
                np.zeros_like(change),
                MotionTangent(np.zeros((0, 6, 6)), np.zeros_like(C), C, diagonal),
            )
            change -= np.einsum("kji,kj->ki", C[diagonal[: len(change)]], state.twist / self.rate)
        return change

    def _copies(self, state: State) -> Floats:
        """Return velocity fields ``(c, 6)`` that take the rotation to copies of itself: free turns and travels."""
        supports, kind, unloaded = self.supports, support_kind(self.problem), no_loads(self.loads)
        turns = np.hstack([np.zeros((3, 3)), np.eye(3)])
        if unloaded and kind is SupportKind.FREE:
            return np.vstack([turns, np.eye(6)[:3]])
        if unloaded and kind is SupportKind.JOINT:
            arm = state.r[supports.set.nodes[0]] - self.line.centre
            if np.linalg.norm(np.cross(arm, self.line.direction)) < 1e-9 * supports.problem.length:
                return turns
        about = np.concatenate([np.zeros(3), self.line.direction])
        field = rigid_twists(state.r, state.q, [0.0] * 3, self.line.direction, self.line.centre).ravel()
        basis = supports.free_basis(state)
        left = field - basis @ (basis_inverse(basis, supports.free_rows()) @ field)
        return np.zeros((0, 6)) if np.abs(left).max() > 1e-9 * np.abs(field).max() else about[None]
