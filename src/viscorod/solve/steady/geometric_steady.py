"""Steady rotations in positions and rotations: poses of the nodes and the angular speed about a line in space.

Nodes have the twists of a rigid rotation, ``x_k = Omega x1_k(H_k)``, so strains do not change and the balance is

    f_int(H) + L1(x) M x - f_ext(H) = 0.

A body increment d changes the twist by ``ad(x) d``; with it the derivative is the stiffness matrix K of the small
motions about the rotation, gyroscopic and centrifugal parts included.

Joints and held strains are conditions beside the balance, whose multipliers are unknowns like the poses; the ground of
a joint turns with the model, as supports do. Maxwell branches are relaxed: strains do not change.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.internal_force import GaussStates, energies
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.constraint_rows import gradients_of_gaps
from viscorod.solve.constraints.free_block import free_block
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.element_forces import GeometricForces
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.statics.stability import circulatory
from viscorod.solve.statics.static_solver import position_noise
from viscorod.solve.steady.branch_springs import branch_springs
from viscorod.solve.steady.continuation import LARGEST_GAP
from viscorod.solve.steady.free_motions import FreeMotions
from viscorod.solve.steady.lossless_motions import LosslessMotions
from viscorod.solve.steady.rigid_rotation import RotationAxis, coriolis, rigid_twists
from viscorod.solve.steady.stability import FULL, FirstOrder, SecondOrder, first_order
from viscorod.solve.steady.steady_checks import SupportKind, no_loads, support_kind
from viscorod.solve.steady.steady_equations import Balance, Measure, Tangent, imbalance
from viscorod.solve.transient.integrators import jacobian
from viscorod.typing import Floats, Integers

FREE = 1e9
"""Answer to forces, of unit size like these, beyond which something moves freely, or may do."""


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
        carried = len(self.problem.held.place) > 0 or self.problem.relaxing
        self._points = GaussStates.of(self.elements, 1, carried=carried)
        self._carried: Floats | None = None
        n = self.problem.size
        self.system.constraints.update(0.0)
        self._internal = np.zeros((n, 6))
        self._matrix = Matrix(self.problem.pattern, self.problem.length, lambda: self.problem.plan)
        self._K, self._C = np.zeros((2, *self._matrix.blocks.shape))
        self._operators = Operators.of(self.elements)
        self._random = np.random.default_rng(1).standard_normal((len(self._matrix.scales) // 6, 6))
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
        nodes = np.tile([length, length, length, 1.0, 1.0, 1.0], self.problem.size)
        return np.concatenate([nodes, np.ones(6 * self.problem.multipliers), [self.rate]])

    def balance(self) -> Balance:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        state, supports, n = self.state(), self.supports, self.problem.size
        residual = self._imposed(state)
        column = np.zeros(residual.size)
        # inertial forces are quadratic in the angular speed
        inertial = coriolis(self.problem.mass, state.twist)
        by_rate = 2.0 / self.rate * inertial - self._external_by_rate(state)
        column[supports.free_rows()] = supports.free_basis(state).T @ by_rate.ravel()
        matrix = sparse.csr_array(sparse.hstack([self._matrix.sparse(), sparse.csr_array(column[:, None])]))
        return Balance(residual.ravel(), matrix if 6 * n > FULL else matrix.toarray())

    def change_at_spin(self) -> Floats | None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`.

        With the factors of statics, once the answer to random forces has shown that nothing moves freely.
        """
        n, matrix = 6 * self.problem.size, self._matrix
        residual = self._imposed(self.state())
        sizes = self.scales()[:-1].reshape(-1, 6)
        rows, columns = matrix.pattern.rows, matrix.pattern.columns
        largest: Floats = np.zeros_like(residual)
        np.maximum.at(largest, rows, np.abs(matrix.blocks * sizes[columns, :, None]).max(axis=1))
        try:
            matrix.factorise()
        except SingularMatrixError:
            return None
        answer = matrix.solve(self._random * largest)
        if not np.abs((answer / sizes).ravel()[:n]).max() < FREE:
            return None
        return np.append(matrix.solve(-residual).ravel(), 0.0)

    def _imposed(self, state: State) -> Floats:
        """Return the residual ``(N, 6)`` with supports, conditions and all; fills the matrix with its derivative."""
        forces, _, _ = self._unbalanced(state)
        stress = self._points.section_force[0] if self._carried is None else self._carried
        self._linearise(state, stress)
        self._matrix.blocks[:] = self._K
        constraints = self.system.constraints
        residual = np.concatenate([forces, (constraints.scale * constraints.gap).reshape(-1, 6)])
        self.supports.impose(state, residual, self._matrix, tangent=True)
        return residual

    def _unbalanced(self, state: State) -> tuple[Floats, Floats, Floats]:
        """Return what is left of the balance before supports, loads and inertial forces ``(n, 6)``."""
        self._evaluate(state)
        external, inertial = self._external(state), coriolis(self.problem.mass, state.twist)
        return self._internal - external + inertial, external, inertial

    def residual(self) -> tuple[Floats, float]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`; supports keep their reactions."""
        state, problem = self.state(), self.problem
        residual, external, inertial = self._unbalanced(state)
        left = residual.copy()
        self.supports.impose(state, left, self._matrix, tangent=False)
        left = self.supports.unbalanced(left)
        forces = self._internal, external, inertial
        whole = float(problem.mass[:, 0, 0].mean()) * problem.length * self.rate**2
        whole = max(whole, position_noise(problem, state.r) / LARGEST_GAP)  # slow rotations drown in it
        constraints = self.system.constraints
        opened = float((np.abs(constraints.gap) / constraints.unit).max(initial=0.0))
        return residual, max(imbalance(left, forces, whole, problem.length), opened)

    def measure(self, kind: Measure) -> tuple[float, Floats]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        mass, rate = self.problem.mass, self.rate
        conditions = np.zeros(6 * self.problem.multipliers)

        def slope(by_poses: Floats, by_rate: float) -> Floats:
            return np.concatenate([by_poses, conditions, [by_rate]])

        if kind == "spin":
            return rate, slope(np.zeros(6 * len(mass)), 1.0)
        state = self.state()
        self._evaluate(state)
        inertial = coriolis(mass, state.twist).ravel()
        T = kinetic_energy(mass, state.twist)
        W, internal = self.elastic_energy(), self._internal.ravel()
        if kind == "energy":
            return T + W, slope(internal - inertial, 2.0 * T / rate)
        if kind == "momentum":
            return 2.0 * T / rate, slope(-2.0 / rate * inertial, 2.0 * T / rate**2)
        return W, slope(internal, 0.0)

    def elastic_energy(self) -> float:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        elastic, dissipated = np.empty((2, 1))
        energies(self.elements, self._points.strain, self._points.strain_rate, elastic, dissipated)
        return float(elastic[0]) + self.system.constraints.energy

    def update(self, change: Floats) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`.

        Section forces are carried along by the frozen operator (mixed Newton, as in statics).
        """
        e, state, held = self.elements, self._state, self.problem.held
        whole = change[:-1].reshape(-1, 6)
        increment = whole[: self.problem.size]
        if self._carried is None:
            self._carried = np.zeros_like(e.reference)
        local = increment[e.nodes].reshape(len(e.nodes), 6 * e.nodes.shape[1])
        for order in np.unique(e.order):
            some = np.flatnonzero(e.order == order)
            operators = self._operators.force[some, : 6 * order, : 6 * order + 6]
            carried = np.matmul(operators, local[some, : 6 * order + 6, None]).reshape(len(some), order, 6)
            self._carried[some, :order] = self._points.section_force[0, some, :order] + carried
        state.multiplier = state.multiplier + self.system.multiplier_change(whole)
        self._carried[held.element, held.point, held.component] = state.multiplier[held.place] / held.weight
        retract(state.r, state.q, np.ascontiguousarray(increment), state.r, state.q)
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

    def small_motions(self) -> FirstOrder | LosslessMotions:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        lossless = self._lossless_motions()
        return first_order(*self.motions_of_second_order(), self.rate) if lossless is None else lossless

    def _lossless_motions(self) -> LosslessMotions | None:
        """Return the small motions if nothing damps or drives them and their stiffness is positive, else None.

        A node that is held completely leaves no motions that only copy the rotation.
        """
        problem, supports = self.problem, self.supports
        held = len(supports.complete) > 0 and len(supports.partial) == 0 and not self.system.constraints.rows
        if not held or problem.relaxing or circulatory(self.loads) or self.loads.sees_motion:
            return None
        try:
            np.linalg.cholesky(problem.mass)
        except np.linalg.LinAlgError:
            return None
        state = self.state()
        self._evaluate(state)
        self._linearise(state, self._points.section_force[0])
        inertia = np.zeros_like(self._K)
        inertia[problem.pattern.diagonal[: problem.size]] = problem.mass
        part = free_block(problem)
        basis = supports.free_basis(state)
        basis.data *= part.unit
        return LosslessMotions.of(
            part.matrix(inertia), part.matrix(self._C), part.matrix(self._K), sparse.csc_array(basis)
        )

    def motions_of_second_order(self) -> tuple[SecondOrder, FreeMotions, list[Floats]]:
        """Return the small motions before supports, those that are free, and the motions to copies of the rotation."""
        state = self.state()
        self._evaluate(state)
        ad = self._linearise(state, self._points.section_force[0])
        size = 6 * self.problem.size
        stiffness, damping = (
            sparse.csr_array(self.problem.pattern.sparse(blocks)[:size, :size])
            for blocks in (self._K, self._C)
        )
        mass = sparse.csr_array(sparse.block_diag(list(self.problem.mass), format="csr"))
        constraints = self.system.constraints
        gradients = gradients_of_gaps(constraints, state, self._held_rows()) if constraints.rows else None
        # drag at the velocities of the rotation is a circulatory force for those who turn along
        skew = circulatory(self.loads) or self.loads.sees_motion
        relaxing = branch_springs(self.system, self._operators)
        small = SecondOrder(mass, damping, stiffness, ad, skew, gradients, relaxing)
        unit = np.where(self.supports.free_rows() % 6 < 3, self.problem.length, 1.0)
        free = FreeMotions.of(self.supports, state, unit, gradients)
        copies = [
            rigid_twists(state.r, state.q, c[:3], c[3:], self.line.centre).ravel()
            for c in self._copies(state, free)
        ]
        return small, free, copies

    def tangent(self) -> Tangent:
        """Return the matrices of small motions in body increments of all nodes at the present state."""
        self.balance()
        state, n = self.state(), self.problem.size
        forces, _ = self.residual()
        self._linearise(state, self._points.section_force[0])
        size, constraints = 6 * n, self.system.constraints
        stiffness, damping = (
            sparse.csr_array(self.problem.pattern.sparse(blocks)[:size, :size])
            for blocks in (self._K, self._C)
        )
        self._matrix.blocks[:] = self._K
        imposed = np.concatenate([forces, (constraints.scale * constraints.gap).reshape(-1, 6)])
        self.supports.impose(state, imposed, self._matrix, tangent=True)
        rows = sparse.csr_array(self._matrix.sparse().tocsr()[self.supports.free_rows()][:, :size])
        gradients = gradients_of_gaps(constraints, state, self._held_rows()) if constraints.rows else None
        return Tangent(stiffness, damping, rows, forces, gradients)

    @property
    def may_be_copied(self) -> bool:
        """True if turning or moving all in space makes a copy of the rotation that supports allow."""
        state = self.state()
        unit = np.where(self.supports.free_rows() % 6 < 3, self.problem.length, 1.0)
        return len(self._copies(state, FreeMotions.of(self.supports, state, unit, None))) > 0

    def _evaluate(self, state: State) -> None:
        """Evaluate strains, elastic forces and gaps; without twists, whose strain rates are round-off."""
        system, held = self.system, self.problem.held
        if system.relaxation is not None:
            system.relaxation.known = False  # relaxed at every shape that is tried
        resting = State(state.r, state.q, np.zeros_like(state.twist), state.multiplier)
        self._forces.evaluate(resting, self._points, self._internal)
        system.constraints.gap[held.place] = self._points.strain[0, held.element, held.point, held.component]
        # springs to the ground are alike all around the axis, and their dampers see the rotation
        system.constraints.add_forces(state, self._internal)

    def _held_rows(self) -> tuple[Integers, Floats] | None:
        return (self.elements.order, self._operators.strain) if len(self.problem.held.place) else None

    def _linearise(self, state: State, stress: Floats) -> Floats:
        """Fill the blocks ``K`` and ``C``; returns ``ad(x)`` of every node."""
        n = self.problem.size
        ad, product = np.zeros((n, 6, 6)), np.zeros((n, 6, 6))
        jacobian.adjoint(state.twist, ad)
        self._K.fill(0.0)
        self._C.fill(0.0)
        self._forces.linearise(state, ad, stress, self._operators, self._K, self._C)
        if self.problem.constrained:
            self.system.constraints.add_tangent(
                state, ad, self._K, self._C, moving=True, held=self._held_rows()
            )
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

    def _copies(self, state: State, free: FreeMotions) -> Floats:
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
        left = field - free.basis @ (free.inverse @ field)
        return np.zeros((0, 6)) if np.abs(left).max() > 1e-9 * np.abs(field).max() else about[None]
