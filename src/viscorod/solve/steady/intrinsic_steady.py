"""Steady rotations in body twists and strains (AWP 20): no pose enters.

At all Gauss points and nodes

    B(eps) x1 = 0        L1(x1) M x1 + B(eps)^T C eps = f

with full damping; with linearised damping (AWP 22) the balance has ``B(0)^T D B(0) x1`` besides, the power of which
vanishes in unforced steady motions: ``x1' = E^T x1`` (AWP 33). The same matrices give the small motions about the
state. The strain of a held component is none of the unknowns; its section force is (AWP: a zero compliance).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.problem import Problem
from viscorod.solve.steady.rigid_rotation import RotationAxis, coriolis, gyroscopic
from viscorod.solve.steady.stability import FirstOrder
from viscorod.solve.steady.steady_equations import Balance, Measure, imbalance
from viscorod.solve.steady.steady_poses import poses_about
from viscorod.solve.steady.strain_rates import StrainRates, force_map, strain_map
from viscorod.solve.transient.integrators import jacobian
from viscorod.typing import Floats


class IntrinsicSteady:
    """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`; unknowns are all twists and strains.

    Args:
        problem, elements: the model; linearised: damping is.
        free: which components of the nodal twists are unknown ``(n, 6)``; the others stay as they are.
        following: wrenches that are carried along ``(n, 6)``, body components.
        joint: node whose angular velocity counts as the spin; still: whether the mass centre must not travel.
        line: the line about which poses are to turn.
        state: twists of the first guess, and the pose from which poses are found; strain: its strains.
        relaxation: Maxwell branches of the sections.
    """

    def __init__(
        self,
        problem: Problem,
        elements: Elements,
        *,
        linearised: bool,
        free: np.ndarray,
        following: Floats,
        joint: int,
        still: bool,
        line: RotationAxis,
        state: State,
        strain: Floats,
        relaxation: DashpotMemory | None = None,
    ) -> None:
        self.problem, self.elements, self.linearised = problem, elements, linearised
        self.relaxation = relaxation
        self.rates = StrainRates(elements, problem.size)
        self.free = np.flatnonzero(free.ravel())
        self.following, self.joint, self.still, self.line = following, joint, still, line
        self._guess = state.copy()
        self.twist, self.strain = state.twist.copy(), strain[self.rates.used]
        held = np.zeros(elements.reference.shape, dtype=bool)
        held[problem.held.element, problem.held.point, problem.held.component] = True
        self.held = held[self.rates.used]
        self.strain[self.held] = 0.0
        self.reaction = np.zeros_like(self.strain)  # section forces of held strains
        self._columns = np.concatenate([np.arange(self.strain.size), self.strain.size + self.free])

    # the unknowns in order: strains, or section forces of those that are held, then free twists

    def balance(self) -> Balance:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        rates, force, inertial = self._rates_and_forces()
        residual = np.concatenate([rates.ravel(), (force + inertial - self.following).ravel()])[self._columns]
        matrix = self._matrix()[np.ix_(self._columns, self._columns)]
        if self.still:
            # a body that is free may travel along its axis as well: no momentum there
            p = np.einsum("nij,nj->ni", self.problem.mass, self.twist)
            travel = np.zeros_like(self.twist)
            travel[:, 3:] = p[:, :3]
            travel += np.einsum("nij,nj->ni", self.problem.mass[:, :, :3], self.twist[:, 3:])
            row = np.concatenate([np.zeros(self.strain.size), travel.ravel()])[self._columns]
            matrix = np.vstack([matrix, row])
            residual = np.append(residual, float(np.sum(p[:, :3] * self.twist[:, 3:])))
        return Balance(residual, matrix)

    def change_at_spin(self) -> Floats | None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        return None

    def measure(self, kind: Measure) -> tuple[float, Floats]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        mass, w = self.problem.mass, self.twist[self.joint, 3:]
        spin = float(np.linalg.norm(w))
        by_strain, by_twist = np.zeros_like(self.strain), np.zeros_like(self.twist)
        by_spin = np.zeros_like(self.twist)
        by_spin[self.joint, 3:] = w / spin
        T, momentum = kinetic_energy(mass, self.twist), np.einsum("nij,nj->ni", mass, self.twist)
        sections, weights = self.rates.response(self.strain), self.rates.weights
        stress, W = weights[:, None] * sections.force, float(weights @ sections.energy)
        if kind == "spin":
            value, by_twist = spin, by_spin
        elif kind == "energy":
            value, by_twist, by_strain = T + W, momentum, stress
        elif kind == "momentum":
            value, by_twist = 2.0 * T / spin, 2.0 * momentum / spin - 2.0 * T / spin**2 * by_spin
        else:
            value, by_strain = W, stress
        return value, np.concatenate([by_strain.ravel(), by_twist.ravel()])[self._columns]

    def set_spin(self, value: float) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        self.twist = self.twist * (value / float(np.linalg.norm(self.twist[self.joint, 3:])))

    def scales(self) -> Floats:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        length = self.problem.length
        spin = max(float(np.linalg.norm(self.twist[self.joint, 3:])), 1e-300)
        strains = np.tile([1.0, 1.0, 1.0, 1.0 / length, 1.0 / length, 1.0 / length], (len(self.strain), 1))
        inertial = float(self.problem.mass[:, 0, 0].sum()) * spin**2 * length
        forces = np.tile(np.repeat([inertial, inertial * length], 3), (len(self.strain), 1))
        strains[self.held] = forces[self.held]
        twists = np.tile([spin * length] * 3 + [spin] * 3, len(self.twist))
        sizes: Floats = np.concatenate([strains.ravel(), twists])[self._columns]
        return sizes

    def update(self, change: Floats) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        count = self.strain.size
        moved = change[:count].reshape(-1, 6)
        self.strain = self.strain + np.where(self.held, 0.0, moved)
        self.reaction = self.reaction + np.where(self.held, moved, 0.0)
        twist = self.twist.ravel().copy()
        twist[self.free] += change[count:]
        self.twist = twist.reshape(-1, 6)

    def save(self) -> object:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        return self.twist.copy(), self.strain.copy(), self.reaction.copy()

    def restore(self, kept: object) -> None:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        assert isinstance(kept, tuple)
        self.twist, self.strain, self.reaction = (part.copy() for part in kept)

    def state(self) -> State:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`; poses follow from the strains."""
        r, q = poses_about(
            self.problem,
            self.elements,
            self.fields()[0],
            self._guess,
            self.joint,
            self.twist[self.joint],
            self.line,
        )
        held, reaction = self.problem.held, np.zeros(self.elements.reference.shape)
        reaction[self.rates.used] = self.reaction
        multiplier = np.zeros(6 * self.problem.multipliers)
        multiplier[held.place] = held.weight * reaction[held.element, held.point, held.component]
        return State(r, q, self.twist.copy(), multiplier)

    def fields(self) -> tuple[Floats, Floats]:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        strain, force = np.zeros((2, *self.elements.reference.shape))
        strain[self.rates.used] = self.strain
        at_points = self.rates.response(self.strain).force + self.reaction
        if self.linearised:
            at_points += np.einsum("gij,gj->gi", self.rates.D, self.rates.unstrained @ self.twist.ravel())
        force[self.rates.used] = at_points
        return strain, force

    def small_motions(self) -> FirstOrder:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        count, n = self.strain.size, self.problem.size
        mass = np.eye(count + 6 * n)
        for k, block in enumerate(self.problem.mass):
            first = count + 6 * k
            mass[first : first + 6, first : first + 6] = block
        matrix = self._matrix(viscous=True)
        matrix[count:] *= -1.0
        pick = np.ix_(self._columns, self._columns)
        mass, matrix = mass[pick], matrix[pick]
        size = len(matrix)
        tried, allowed = self._allowed(matrix)
        relaxing = self.relaxation is not None
        if self.relaxation is not None:
            matrix = self._with_branches(matrix, self.relaxation)
            dashpots = np.eye(len(matrix) - size)
            mass, tried, allowed = (
                scipy.linalg.block_diag(part, dashpots) for part in (mass, tried, allowed)
            )

        def increments(s: complex, z: np.ndarray) -> np.ndarray:
            return self._increments(s, (allowed @ z)[:size])

        magnitude = np.abs(tried).T @ np.abs(matrix) @ np.abs(allowed)
        return FirstOrder(
            tried.T @ mass @ allowed, tried.T @ matrix @ allowed, magnitude, increments, relaxing=relaxing
        )

    def _with_branches(self, matrix: Floats, relaxation: DashpotMemory) -> Floats:
        """Add Maxwell branches, relaxed in the rotation: ``alpha' = (e - alpha)/tau``, ``S = C_j (e - alpha)``."""
        count, size = self.strain.size, len(matrix)
        B, weighted = self.rates.at(self.strain), self.rates.weights[:, None, None]
        seen = np.diag((~self.held).ravel().astype(float))
        branches = np.moveaxis(relaxation.branches, 1, 0)
        whole = np.zeros((size + len(branches) * count,) * 2)
        whole[:size, :size] = matrix
        for j, (C, tau) in enumerate(zip(branches, relaxation.times, strict=True)):
            through = np.einsum("gai,gab->igb", B, weighted * C[self.rates.section])
            through = through.reshape(-1, count)[self.free]
            own = slice(size + j * count, size + (j + 1) * count)
            whole[count:size, :count] -= through @ seen
            whole[count:size, own] = through
            whole[own, :count] = seen / tau
            whole[own, own] = -np.eye(count) / tau
        return whole

    def _allowed(self, matrix: Floats) -> tuple[Floats, Floats]:
        """Return the motions that test the equations, and those that held strains allow, as columns.

        Without held strains these are all. The rates of held strains ``H e + B x`` vanish with strains e and twists x
        that change: ``x = Z y - B^+ H e``. Section forces of held strains do no work on Z.
        """
        if not self.held.any():
            return np.eye(len(matrix)), np.eye(len(matrix))
        held = np.concatenate([self.held.ravel(), np.zeros(len(self.free), dtype=bool)])
        strains = np.flatnonzero(~held[: self.strain.size])
        twists = np.arange(self.strain.size, len(held))
        by_strain, by_twist = matrix[np.ix_(held, strains)], matrix[np.ix_(held, twists)]
        Z = scipy.linalg.null_space(by_twist)
        shape = len(held), len(strains) + Z.shape[1]
        tried, allowed = np.zeros((2, *shape))
        for columns in (tried, allowed):
            columns[strains, np.arange(len(strains))] = 1.0
            columns[np.ix_(twists, np.arange(len(strains), shape[1]))] = Z
        allowed[np.ix_(twists, np.arange(len(strains)))] = -np.linalg.pinv(by_twist) @ by_strain
        return tried, allowed

    def _increments(self, s: complex, z: np.ndarray) -> np.ndarray:
        """Return the body increments ``d (6 n,)`` with which twists change by ``s d + ad(x) d``."""
        count, n = self.strain.size, self.problem.size
        whole = np.zeros(count + 6 * n, dtype=complex)
        whole[self._columns] = z
        ad = np.zeros((n, 6, 6))
        jacobian.adjoint(self.twist, ad)
        # s may be an eigenvalue of ad where all moves as one: then the part without that motion
        found = np.linalg.pinv(s * np.eye(6) + ad, rcond=1e-9) @ whole[count:].reshape(n, 6, 1)
        return np.asarray(found.ravel())

    def residual(self) -> tuple[Floats, float]:
        """Return the balance of the nodes ``(n, 6)`` before supports, and its gap."""
        rates, force, inertial = self._rates_and_forces()
        return force + inertial - self.following, self._gap(rates, force, inertial)

    def elastic_energy(self) -> float:
        """See :class:`~viscorod.solve.steady.steady_equations.SteadyEquations`."""
        return self.measure("elastic")[0]

    def _rates_and_forces(self) -> tuple[Floats, Floats, Floats]:
        """Return strain rates ``(m, 6)``, internal forces (without viscous ones of full damping) and inertial ones."""
        x, weights = self.twist.ravel(), self.rates.weights[:, None]
        B = self.rates.at(self.strain)
        section = self.rates.response(self.strain).force + self.reaction
        force = np.einsum("gij,gi->j", B, weights * section)
        if self.linearised:
            B0 = self.rates.unstrained
            force += np.einsum("gij,gi->j", B0, weights * np.einsum("gij,gj->gi", self.rates.D, B0 @ x))
        return B @ x, force.reshape(-1, 6), coriolis(self.problem.mass, self.twist)

    def _matrix(self, *, viscous: bool = False) -> Floats:
        """Return the derivative of strain rates and forces by strains and twists.

        Args:
            viscous: include the viscous forces of full damping, which vanish in a steady state but resist small
                motions.
        """
        rates, n = self.rates, self.problem.size
        count = self.strain.size
        B = rates.at(self.strain)
        at_points = rates.shapes @ self.twist.ravel()
        # L = [[-w~, -v~], [0, -w~]]: eps_t by eps
        L = -strain_map(np.hstack([at_points[:, :3], at_points[:, 3:]]))
        unheld = ~self.held[:, None, :]  # unknowns that are strains
        L *= unheld
        matrix = np.zeros((count + 6 * n, count + 6 * n))
        flat = B.reshape(count, 6 * n)
        block = matrix[:count, :count].reshape(len(L), 6, len(L), 6)
        each = np.arange(len(L))
        block[each, :, each, :] = L
        matrix[:count, count:] = flat
        weighted = rates.weights[:, None, None]
        sections = rates.response(self.strain)
        by_unknown = sections.C * unheld + np.eye(6) * ~unheld
        through = np.einsum("gai,gab->gib", B, weighted * by_unknown)
        bending = force_map(sections.force + self.reaction) * unheld
        through += np.einsum("gai,gab->gib", rates.shapes, weighted * bending)
        damping = np.zeros((6 * n, 6 * n))
        if self.linearised:
            B0 = rates.unstrained.reshape(count, 6 * n)
            damping = B0.T @ (weighted * rates.D @ rates.unstrained).reshape(count, 6 * n)
        elif viscous:
            damping = flat.T @ (weighted * sections.D @ B).reshape(count, 6 * n)
            through += np.einsum("gai,gab->gib", B, weighted * sections.D @ L)
        matrix[count:, :count] = through.transpose(1, 0, 2).reshape(6 * n, count)
        matrix[count:, count:] = damping
        for k, block_ in enumerate(gyroscopic(self.problem.mass, self.twist)):
            rows = slice(count + 6 * k, count + 6 * k + 6)
            matrix[rows, rows] += block_
        return matrix

    def _gap(self, rates: Floats, force: Floats, inertial: Floats) -> float:
        left = (force + inertial - self.following).ravel()
        held = np.ones(left.size, dtype=bool)
        held[self.free] = False
        left[held] = 0.0
        length, mass = self.problem.length, self.problem.mass
        spin = float(np.linalg.norm(self.twist[self.joint, 3:]))
        whole = float(mass[:, 0, 0].mean()) * length * spin**2
        forces = force, inertial, self.following
        balance = imbalance(left.reshape(-1, 6), forces, whole, length)
        return max(
            balance,
            float(np.abs(rates[:, :3]).max()) / spin,
            float(np.abs(rates[:, 3:]).max()) * length / spin,
        )
