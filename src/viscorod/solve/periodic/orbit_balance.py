"""The balance of a whole model at all phases of a periodic motion, and its derivatives by the motion.

Unknowns are the coordinates ``X_i`` of all nodes at the phases, seen from the poses at which the model rests (see
``mechanics.rotations.nodal_motion``), and the multipliers of joints and held strains there. Twists follow exactly from
the trigonometric polynomial of the coordinates, ``x_i = T(X_i) w sum_j D_ij X_j``, accelerations as ``w sum_j D_ij
x_j``, with the angular frequency ``w``. Maxwell branches are linear in the strains: ``beta = w tau D (1 + w tau D)^-1
eps`` at all phases, which is their complex modulus at every harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.elements.internal_force import ElementWork, GaussStates, energies, internal_forces
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.inertia import add_coriolis
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.mechanics.nodes.prescribed_motion import prescribed_motion
from viscorod.mechanics.nodes.support_rows import Directions
from viscorod.mechanics.nodes.support_rows import impose as impose_supports
from viscorod.mechanics.rotations.adjoint_maps import adjoint_map, series_of_exponential
from viscorod.mechanics.rotations.nodal_motion import coordinates
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State, System
from viscorod.solve.periodic.drive import Drive
from viscorod.solve.periodic.fourier import Fourier
from viscorod.solve.periodic.orbit_kernels import add_to_orbit, place_orbit
from viscorod.solve.periodic.orbit_loads import OrbitLoads
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.transient.integrators.jacobian import project
from viscorod.solve.transient.integrators.stage_data import Discretisation
from viscorod.typing import Floats

STEP = 1e-30
"""Of complex-step derivatives."""

__all__ = ["Linearised", "Motion", "Orbit", "OrbitBalance", "Setting"]


class Setting(NamedTuple):
    """Angular frequency [rad/s], level of the drive, and a damping [1/s] that is taken away, times the mass."""

    omega: float
    level: float
    lack: float = 0.0


@dataclass
class Orbit:
    """Coordinates ``(N, n, 6)`` and multipliers ``(N, places)`` at all phases."""

    X: Floats
    multiplier: Floats


@dataclass
class Motion:
    """What follows from an orbit: states, Gauss points and forces at all phases (first index).

    Attributes:
        X, rates: coordinates of the nodes and their rates ``(N, n, 6)``.
        residual: unbalanced forces and scaled gaps ``(N, N_b, 6)``, in the directions that supports leave free; what
            supports hold has gaps there. force: the unbalanced forces of all nodes ``(N, n, 6)``, body axes.
        targets: of supports ``(N, m, 6)``; reaction: along their axes ``(N, m, 6)``.
        spring: strains of the springs of Maxwell branches ``(branches, N, e, points, 6)``.
        gaps: targets and rates of joints ``(N, c)``; powers: of motors, lost by dampers, lost outside ``(3, N)`` [W].
        drive: power of all loads ``(N,)`` [W]; size: of the largest internal or inertial force, times the length [N m].
        frozen: stresses of their own that it was computed with.
    """

    setting: Setting
    X: Floats
    rates: Floats
    states: list[State]
    twist: Floats
    acceleration: Floats
    points: GaussStates
    residual: Floats
    force: Floats
    targets: Floats
    reaction: Floats
    spring: Floats
    powers: Floats
    drive: Floats
    size: float
    frozen: Frozen | None


class Frozen(NamedTuple):
    """Stresses ``(N, e, points, 6)`` as iterates of their own, with the derivatives by which they are carried."""

    stress: Floats
    linear: Linearised


class Linearised(NamedTuple):
    """Derivatives of the balance by body increments (K), twists (C) and their rates (M), at all phases.

    Attributes:
        K, C: blocks of the pattern as matrices ``(N, b, 6, 6)``; M: ``(N, n, 6, 6)``; rows projected on what supports
            leave free. ad: of the twists ``(N, n, 6, 6)``.
        V: changes of the twists at all phases by body increments at all others ``(n, N, N, 6, 6)``, of the
            trigonometric polynomials of the coordinates.
        Z: body increments of the nodes of partial supports ``(N, partial, 6, 6)``.
        strain, force, viscous: operators of all elements ``(N, e, 6 points, 6 nodes)``: changes of the strains, and of
            section forces, by body increments at constant twists and by twists.
    """

    K: Floats
    C: Floats
    M: Floats
    ad: Floats
    V: Floats
    Z: Floats
    strain: Floats
    force: Floats
    viscous: Floats


class OrbitBalance:
    """Balances a model over a period.

    Args:
        system: the model; base: where it rests under its loads at t = 0, which stay.
        drive: what moves it; fourier: the phases; before: the loads are those just before t = 0, else just after.

    Raises:
        InputError: it has parts that periodic motions do not know.
    """

    def __init__(
        self, system: System, base: State, drive: Drive, fourier: Fourier, *, before: bool = True
    ) -> None:
        _require_known(system)
        assert isinstance(system, GeometricSystem)
        self.problem = problem = system.problem
        self.system, self.supports = GeometricSystem(problem), SupportState(problem)
        self.system.constraints.near[:] = system.constraints.near
        self.base, self.drive = base, drive
        self.elements = self.system.elements()
        self.body = Discretisation.of(problem, self.elements, self.supports)
        self.loads = ExternalLoads(problem)
        constraints = self.system.constraints
        self._before = before
        constraints.update(0.0, before)
        self.supports.update(0.0, before)
        self.system.impose_rest(Imposed(1.0, 0.0, before))
        self._still_targets = self.supports.target.copy()
        self._joint_targets = constraints.target.copy()
        self._work = ElementWork.of(self.elements.nodes.shape[1] - 1)
        self.scale: Floats = np.ones(len(constraints.gap))
        self.use(fourier)
        if problem.constrained:  # scales of multipliers follow from the stiffness where the model rests
            self.linearised(self.moved(self.resting(), Setting(1.0, 0.0)))
            self.scale = constraints.scale.copy()

    def use(self, fourier: Fourier) -> None:
        """Take other phases."""
        self.fourier, self.phases, self.D = fourier, fourier.phases, fourier.derivative()
        self._points = GaussStates.of(self.elements, fourier.count, carried=True)
        self._masses = np.tile(self.body.mass, (fourier.count, 1, 1))
        self._loaded: list[OrbitLoads] = []
        self._still: tuple[Floats, Floats] | None = None

    def resting(self) -> Orbit:
        """Return the orbit that does not move."""
        count, problem = self.fourier.count, self.problem
        multiplier = np.tile(self.base.multiplier, (count, 1))
        return Orbit(np.zeros((count, problem.size, 6)), multiplier)

    def added(self, orbit: Orbit, change: Floats) -> Orbit:
        """Return an orbit after changes ``(N, N_b, 6)``: body increments and scaled multipliers."""
        n, base, body = self.problem.size, self.base, self.body
        X, scratch = np.zeros_like(orbit.X), (np.empty((1, 3)), np.empty((1, 4)), np.zeros((2, 6)))
        free = np.flatnonzero(body.held == 0.0)
        add_to_orbit(base.r, base.q, orbit.X, np.ascontiguousarray(change), body.split, free, *scratch, X)
        multiplier = orbit.multiplier + self.scale * change[:, n:].reshape(len(X), -1)[:, : len(self.scale)]
        return Orbit(X, multiplier)

    def between(self, motion: Motion, other: Motion) -> Floats:
        """Return the changes ``(N, N_b, 6)`` from one motion to another: body increments and scaled multipliers."""
        count, problem = self.fourier.count, self.problem
        found = np.zeros((count, problem.pattern.size, 6))
        for i, (one, two) in enumerate(zip(motion.states, other.states, strict=True)):
            for k in np.flatnonzero(self.body.held == 0.0):
                coordinates(one.r[k], one.q[k], two.r[k], two.q[k], False, found[i, k])
            scaled = (two.multiplier - one.multiplier) / self.scale
            found[i, problem.size :] = scaled.reshape(-1, 6)
        return found

    def moved(self, orbit: Orbit, setting: Setting, frozen: Frozen | None = None) -> Motion:
        """Return the motion of an orbit, with its unbalanced forces.

        With stresses of their own their differences from those of the strains are forces through frozen operators: only
        strains, never stiffness times strains, are linearised about other poses (see ``collocation``).
        """
        problem, body, supports, base = self.problem, self.body, self.supports, self.base
        count, n, omega = self.fourier.count, self.problem.size, setting.omega
        rates = omega * np.tensordot(self.D, orbit.X, axes=1)
        of_supports, of_joints = self.drive.motion(self.phases, omega, setting.level)
        targets = self._still_targets + of_supports[0]
        held = supports.set.nodes[supports.complete]
        r, q, twist, known = self._held(targets, of_supports)
        free = np.flatnonzero(body.held == 0.0)
        place_orbit(base.r, base.q, orbit.X, rates, body.split, free, r, q, twist)
        acceleration = omega * np.tensordot(self.D, twist, axes=1)
        acceleration[:, held] = known
        states = [State(r[i], q[i], twist[i], orbit.multiplier[i].copy()) for i in range(count)]
        internal, spring = self._internal(r, q, twist, orbit.multiplier, omega, frozen)
        powers, gaps = np.zeros((3, count)), np.zeros((count, len(self.scale)))
        force, size = internal, self._largest(internal)
        constraints = self.system.constraints
        external, powers[2] = self._loads(omega, setting.level).add(problem, r, q, twist)
        drive = np.einsum("pki,pki->p", external, twist) + powers[2]
        for i in range(count if problem.constrained else 0):
            self._aim_joints(of_joints, i)
            at = problem.held
            constraints.gap[at.place] = self._points.strain[i, at.element, at.point, at.component]
            constraints.add_forces(states[i], force[i])
            gaps[i] = constraints.gap
            powers[0, i], powers[1, i] = self._joint_powers()
        force -= external
        momentum = np.einsum("kij,pkj->pki", body.mass, twist)
        inertia = np.einsum("kij,pkj->pki", body.mass, acceleration) - setting.lack * momentum
        size = max(size, self._largest(inertia))
        force += inertia
        add_coriolis(self._masses, twist.reshape(-1, 6), force.reshape(-1, 6))
        scaled = (self.scale * gaps).reshape(count, -1, 6)
        residual = np.concatenate([force, scaled], axis=1)
        reaction = np.zeros_like(targets)
        if body.partly:
            directions = Directions.of(len(targets[0]))
            for i in range(count):
                impose_supports(supports.nodes, targets[i], r[i], q[i], residual[i], reaction[i], directions)
        if frozen is not None:
            residual[:, :n] += self._through(frozen)
        residual[:, held] = 0.0
        points = GaussStates(*(part.copy() for part in self._points))
        return Motion(
            setting,
            orbit.X,
            rates,
            states,
            twist,
            acceleration,
            points,
            residual,
            force,
            targets,
            reaction,
            spring,
            powers,
            drive,
            size,
            frozen,
        )

    def _held(
        self, targets: Floats, motion: tuple[Floats, Floats, Floats]
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Return poses and twists of all nodes, at rest but for complete supports, and twist rates of these."""
        supports, base, count = self.supports, self.base, self.fourier.count
        complete = supports.complete
        held = supports.set.nodes[complete]
        known = np.zeros((count, len(complete), 6))
        twist = np.zeros((count, self.problem.size, 6))
        if self._still is not None:
            return self._still[0].copy(), self._still[1].copy(), twist, known
        r, q = np.tile(base.r, (count, 1, 1)), np.tile(base.q, (count, 1, 1))
        if len(complete):
            own = [np.ascontiguousarray(part[:, complete]) for part in (targets, *motion[1:])]
            fixed = np.empty((len(complete), 3)), np.empty((len(complete), 4))
            moving, rate = np.empty((len(complete), 6)), np.empty((len(complete), 6))
            where = supports.set.axes[complete], supports.r0[complete], supports.q0[complete]
            for i in range(count):
                prescribed_motion(*where, own[0][i], own[1][i], own[2][i], *fixed, moving, rate)
                r[i, held], q[i, held], twist[i, held], known[i] = *fixed, moving, rate
        if not self.drive.moving:
            self._still = r.copy(), q.copy()
        return r, q, twist, known

    def linearised(self, motion: Motion) -> Linearised:
        """Return the derivatives of the unbalanced forces of a motion."""
        problem, body, supports = self.problem, self.body, self.supports
        pattern, count, n = problem.pattern, self.fourier.count, self.problem.size
        constraints, blocks = self.system.constraints, len(problem.pattern.rows)
        K, C = np.zeros((2, count, blocks, 6, 6))
        mass = np.tile(body.mass, (count, 1, 1, 1))
        ad = adjoint_map(motion.twist)
        still, square = np.zeros((n, 6, 6)), np.empty(6)
        shape = (count, *Operators.of(self.elements).strain.shape)
        B, A, P = (np.zeros(shape) for _ in range(3))
        directions = Directions.of(len(body.complete))
        Z = np.zeros((count, len(supports.partial), 6, 6))
        own = pattern.diagonal[:n]
        gyroscopic = np.swapaxes(_gyroscopic(body.mass, motion.twist) - motion.setting.lack * mass, -1, -2)
        C[:, own] += gyroscopic
        _, of_joints = self.drive.motion(self.phases, motion.setting.omega, motion.setting.level)
        into_rows = np.ones(6 * pattern.size)
        for i, load in enumerate(self._loads(motion.setting.omega, motion.setting.level).states):
            state = motion.states[i]
            operators = Operators(B[i], A[i], P[i])
            self.system.linearise(state, still, motion.points.stress[i], operators, K[i], C[i])
            if problem.constrained:
                self._aim_joints(of_joints, i)
                constraints.add_forces(state, np.zeros((n, 6)))
                held = (self.elements.order, B[i]) if len(problem.held.place) else None
                constraints.add_tangent(state, still, K[i], C[i], moving=True, held=held)
                ratio = np.where(constraints.scale != 0.0, self.scale / constraints.scale, 1.0)
                into_rows[6 * n : 6 * n + len(ratio)] = ratio
                rows = into_rows.reshape(-1, 6)
                K[i] *= rows[pattern.columns][:, :, None] * rows[pattern.rows][:, None, :]
            if not load.none or load.sees_motion:
                into = MotionTangent(still, K[i], C[i], pattern.diagonal)
                load.add(problem, (state.r, state.q), state.twist, np.zeros((n, 6)), into)
            if body.partly:
                project(
                    body.supports,
                    motion.targets[i],
                    motion.reaction[i],
                    state.r,
                    state.q,
                    pattern,
                    K[i],
                    C[i],
                    mass[i],
                    directions,
                    square,
                )
                Z[i] = directions.Z[supports.partial]
        K, C = np.swapaxes(K, -1, -2), np.swapaxes(C, -1, -2)
        return Linearised(K, C, mass, ad, self._twist_changes(motion, ad), Z, B, A, P)

    def _twist_changes(self, motion: Motion, ad: Floats) -> Floats:
        """Return ``V_ij = w D_ij T_i T_j^-1 + delta_ij (T_i' T_i^-1 + ad(x_i))``.

        With ``p = T dX`` a change of ``x = T X'`` is ``T dX' + T' dX + ad(x) p``; ``T'`` is a complex-step derivative.
        """
        count, n = self.fourier.count, self.problem.size
        X = motion.X + 1j * STEP * motion.rates
        X[:, self.body.held != 0.0] = 0.0
        terms = _terms(float(np.abs(motion.X[..., 3:]).max(initial=0.0)))
        _, T = series_of_exponential(X.reshape(-1, 6), np.tile(self.body.split, count), terms)
        T = T.reshape(count, n, 6, 6)
        back = np.linalg.inv(T.real)
        scaled = motion.setting.omega * self.D[:, :, None, None, None] * back
        found = np.ascontiguousarray(np.moveaxis(T.real[:, None] @ scaled, 2, 0))
        here = np.arange(count)
        found[:, here, here] += np.swapaxes(T.imag / STEP @ back + ad, 0, 1)
        return found

    def carried(self, stress: Floats, linear: Linearised, change: Floats, omega: float) -> Floats:
        """Return section forces ``(N, e, points, 6)`` after body increments ``(N, N_b, 6)``, to first order."""
        elements, n = self.elements, self.problem.size
        poses = np.ascontiguousarray(change[:, :n])
        twists = np.einsum("kpqij,qkj->pki", linear.V, poses)
        at = [part[:, elements.nodes].reshape(len(part), len(elements.nodes), -1) for part in (poses, twists)]
        own = (linear.force @ at[0][..., None] + linear.viscous @ at[1][..., None])[..., 0]
        found = stress + own.reshape(stress.shape)
        memory = self.system.relaxation
        if memory is not None:
            strain = (linear.strain @ at[0][..., None])[..., 0].reshape(stress.shape)
            for j, response in enumerate(self.responses(omega)):
                modulus = memory.branches[elements.section, j]
                found += np.einsum("egij,pegj->pegi", modulus, np.tensordot(response, strain, axes=1))
        return np.asarray(found)

    def _through(self, frozen: Frozen) -> Floats:
        """Return the forces ``(N, n, 6)`` of what stresses lack, through frozen operators."""
        elements, points, supports = self.elements, self._points, self.supports
        lacking = (points.section_force - frozen.stress) * self._weights()[..., None]
        lacking[:, self.problem.held.element, self.problem.held.point, self.problem.held.component] = 0.0
        flat = lacking.reshape(*lacking.shape[:2], -1, 1)
        nodal = (np.swapaxes(frozen.linear.strain, -1, -2) @ flat)[..., 0]
        nodal = nodal.reshape(*nodal.shape[:2], -1, 6)
        found = np.zeros((len(nodal), self.problem.size, 6))
        for e, nodes in enumerate(elements.nodes):
            for k in range(int(elements.order[e]) + 1):
                found[:, nodes[k]] += nodal[:, e, k]
        for number, k in enumerate(supports.partial):
            node = int(supports.set.nodes[k])
            along = np.einsum("pij,pi->pj", frozen.linear.Z[:, number], found[:, node])
            found[:, node] = np.where(supports.set.fixed[k] != 0.0, 0.0, along)
        return found

    def responses(self, omega: float) -> Floats:
        """Return by what the strains at all phases give those of the springs of all branches ``(branches, N, N)``."""
        times, D = self.problem.relaxation_times, omega * self.D
        unit = np.eye(len(D))
        return np.array([np.linalg.solve(unit + tau * D, tau * D) for tau in times]).reshape(-1, *D.shape)

    def losses(self, motion: Motion) -> Floats:
        """Return the power lost to viscosity, dampers and outside at all phases ``(N,)`` [W]."""
        elastic, lost = np.empty((2, self.fourier.count))
        energies(self.elements, motion.points.strain, motion.points.strain_rate, elastic, lost)
        lost = lost + motion.powers[1] + motion.powers[2]
        if self.system.relaxation is not None:
            branches, section = self.system.relaxation.branches, self.elements.section
            weights = self._weights()
            for j, tau in enumerate(self.problem.relaxation_times):
                stretched = motion.spring[j]
                power = np.einsum(
                    "pegi,egij,pegj,eg->p", stretched, branches[section, j], stretched, weights, optimize=True
                )
                lost = lost + power / tau
        return np.asarray(lost)

    def put_in(self, motion: Motion) -> Floats:
        """Return the power that loads, supports and motors put in at all phases ``(N,)`` [W]."""
        nodes = self.supports.set.nodes
        by_supports = np.einsum("pki,pki->p", motion.force[:, nodes], motion.twist[:, nodes])
        lack = motion.setting.lack * np.einsum("pki,kij,pkj->p", motion.twist, self.body.mass, motion.twist)
        return np.asarray(motion.drive + motion.powers[0] + by_supports + lack)

    def unit_powers(self, motion: Motion) -> Floats:
        """Return the power of each input over its own force or motion ``(N, k)``: the rate conjugate to a force."""
        drive, problem = self.drive, self.problem
        found = np.zeros((self.fourier.count, len(drive.signals)))
        r, q = (np.array([getattr(state, name) for state in motion.states]) for name in ("r", "q"))
        for k, number in enumerate(drive.loads):
            if number < 0:
                continue
            for size, sign in ((1.0, 1.0), (0.0, -1.0)):
                given = self._others({int(number): size})
                load = self.loads.at(0.0, self._before, given=given)
                external, _ = OrbitLoads.of([load] * self.fourier.count).add(problem, r, q, motion.twist)
                found[:, k] += sign * np.einsum("pki,pki->p", external, motion.twist)
        return found

    def _largest(self, force: Floats) -> float:
        """Return the largest force times the length, or moment, of ``(N, n, 6)``."""
        parts = np.abs(force[..., :3]).max(initial=0.0), np.abs(force[..., 3:]).max(initial=0.0)
        return max(float(parts[0]) * self.problem.length, float(parts[1]))

    def _others(self, given: dict[int, float]) -> dict[int, float]:
        return {int(k): 0.0 for k in self.drive.loads if k >= 0} | given

    def _weights(self) -> Floats:
        elements = self.elements
        return np.asarray(elements.half_lengths[:, None] * elements.weights[elements.order])

    def _loads(self, omega: float, level: float) -> OrbitLoads:
        factors = self.drive.factors(self.phases, omega, level)
        for known in self._loaded:
            if np.array_equal(known.factors, factors):
                return known
        states = []
        for row in factors:
            given = {int(k): float(f) for k, f in zip(self.drive.loads, row, strict=True) if k >= 0}
            states.append(self.loads.at(0.0, self._before, given=given))
        found = OrbitLoads.of(states, factors)
        self._loaded = [found, *self._loaded[:1]]  # one level and that by which the drive is told from it
        return found

    def _aim_joints(self, motion: tuple[Floats, Floats], i: int) -> None:
        constraints = self.system.constraints
        constraints.target[:] = self._joint_targets + motion[0][i]
        constraints.target_rate[:] = motion[1][i]

    def _joint_powers(self) -> tuple[float, float]:
        """Return the power of motors, and that which dampers take [W], in the state measured last."""
        constraints = self.system.constraints
        a, rate = constraints.arrays, constraints.rate
        lost = float(np.sum(np.where((a.law < 0) & (a.place < 0), a.damping, 0.0) * rate**2))
        for c in np.flatnonzero(a.law >= 0):
            lost += constraints.laws.power(int(a.law[c]), float(rate[c]))
        return constraints.motor_power(), lost

    def _internal(
        self,
        r: Floats,
        q: Floats,
        twist: Floats,
        multiplier: Floats,
        omega: float,
        frozen: Frozen | None,
    ) -> tuple[Floats, Floats]:
        """Return internal forces ``(N, n, 6)`` and strains of the springs of branches; write the Gauss points."""
        points, elements, held = self._points, self.elements, self.problem.held
        force = np.zeros_like(twist)
        memory, spring = self.system.relaxation, np.zeros((0, *points.strain.shape))
        simple = memory is None and not len(held.place)
        if frozen is not None:
            points.stress[:] = frozen.stress
        own = points._replace(stress=points.section_force) if simple and frozen is None else points
        internal_forces(elements, r, q, twist, own, self._work, force)
        if simple:
            if frozen is None:
                points.stress[:] = points.section_force
            return force, spring
        forces = points.section_force.copy()
        if memory is not None:
            spring = np.tensordot(self.responses(omega), points.strain, axes=1)
            for j in range(len(memory.times)):
                modulus = memory.branches[elements.section, j]
                forces += np.einsum("egij,pegj->pegi", modulus, spring[j])
        at = held.element, held.point, held.component
        forces[:, *at] = multiplier[:, held.place] / held.weight
        points.stress[:] = forces if frozen is None else frozen.stress
        points.stress[:, *at] = forces[:, *at]
        internal_forces(elements, r, q, twist, points, self._work, force)
        points.section_force[:] = forces
        return force, spring


def _terms(turn: float) -> int:
    """Return how many terms of the series of the exponential round-off leaves of a rotation [rad]."""
    size, terms = 1.0, 2
    while size > 1e-17:
        size *= (1.8 * turn + 1e-3) / terms
        terms += 1
    return terms


def _gyroscopic(mass: Floats, twist: Floats) -> Floats:
    """Return the derivatives ``(N, n, 6, 6)`` of ``L1(x) M x`` by the twists ``(N, n, 6)``, ``L1(x) = -ad(x)^T``."""
    momentum = np.einsum("kij,pkj->pki", mass, twist)
    found = -np.swapaxes(adjoint_map(twist), -1, -2) @ mass
    for k, unit in enumerate(np.eye(6)):
        found[..., k] -= momentum @ adjoint_map(unit)
    return np.asarray(found)


def _require_known(system: System) -> None:
    """Refuse what periodic motions do not know.

    Raises:
        InputError: the model has such parts, by name.
    """
    if not isinstance(system, GeometricSystem):
        raise InputError("periodic motions are computed in the geometric formulation; leave formulation out")
    supports = SupportState(system.problem)
    parts = {
        "rest strains that change with time": system.imposed.changes,
        "supports that hold velocities along axes of the section": bool(supports.set.in_body.any()),
        "motors about several axes of a ball joint": len(system.constraints.ball_motors.coordinates) > 0,
    }
    for part, there in parts.items():
        if there:
            raise InputError(
                f"periodic motions are not known with {part}: they would not come back to the same motion after a "
                "period; take them out of the model, or compute the motion with simulate"
            )
