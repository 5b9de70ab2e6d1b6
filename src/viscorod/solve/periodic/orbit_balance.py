"""The balance of a whole model at all phases of a periodic motion.

Unknowns are the coordinates ``X_i`` of all nodes at the phases, seen from the poses at which the model rests (see
``mechanics.rotations.nodal_motion``), and the multipliers of joints and held strains there. Twists follow exactly from
the trigonometric polynomial of the coordinates, ``x_i = T(X_i) w sum_j D_ij X_j``, accelerations as ``w sum_j D_ij
x_j``, with the angular frequency ``w``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.mechanics.nodes.inertia import add_coriolis
from viscorod.mechanics.nodes.prescribed_motion import prescribed_motion
from viscorod.mechanics.nodes.support_rows import Directions
from viscorod.mechanics.nodes.support_rows import impose as impose_supports
from viscorod.mechanics.rotations.nodal_motion import coordinates
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State, System
from viscorod.solve.periodic.drive import Drive
from viscorod.solve.periodic.fourier import Fourier
from viscorod.solve.periodic.orbit import Frozen, Linearised, Motion, Orbit, Setting
from viscorod.solve.periodic.orbit_derivatives import linearised
from viscorod.solve.periodic.orbit_kernels import add_to_orbit, place_orbit
from viscorod.solve.periodic.orbit_loads import OrbitLoads
from viscorod.solve.periodic.orbit_sections import OrbitSections
from viscorod.solve.problem.external_loads import ExternalLoads, LoadState
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.transient.integrators.stage_data import Discretisation
from viscorod.typing import Floats, Integers

__all__ = ["OrbitBalance"]


class _Poses(NamedTuple):
    """Of all nodes at all phases: positions ``(N, n, 3)``, quaternions, twists and their rates ``(N, n, 6)``."""

    r: Floats
    q: Floats
    twist: Floats
    acceleration: Floats


class OrbitBalance:
    """Balances a model over a period.

    Args:
        system: the model; base: where it rests under its loads at t = 0, which stay.
        drive: what moves it; fourier: the phases; before: the loads are those just before t = 0, else just after.

    Attributes:
        sections: strains and section forces at the phases.
        scale: of multipliers, as those of the matrix are ``(places,)``.

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
        self.scale: Floats = np.ones(len(constraints.gap))
        self.use(fourier)
        if problem.constrained:  # scales of multipliers follow from the stiffness where the model rests
            self.linearised(self.moved(self.resting(), Setting(1.0, 0.0)))
            self.scale = constraints.scale.copy()

    def use(self, fourier: Fourier) -> None:
        """Take other phases."""
        self.fourier, self.phases, self.D = fourier, fourier.phases, fourier.derivative()
        self.sections = OrbitSections(self.system, self.supports, fourier)
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
        problem, sections, omega = self.problem, self.sections, setting.omega
        n = problem.size
        rates = omega * np.tensordot(self.D, orbit.X, axes=1)
        of_supports, of_joints = self.drive.motion(self.phases, omega, setting.level)
        targets = self._still_targets + of_supports[0]
        poses = self._poses(orbit, rates, omega, targets, of_supports)
        r, q, twist, _ = poses
        states = [State(r[i], q[i], twist[i], orbit.multiplier[i].copy()) for i in range(len(r))]
        force, spring = sections.internal(r, q, twist, orbit.multiplier, omega, frozen)
        size = self._largest(force)
        external, outside = self.loads_at(setting).add(problem, r, q, twist)
        gaps, motors, dampers = self._add_joints(states, of_joints, force)
        force -= external
        inertia = self._inertia(poses, setting.lack)
        force += inertia
        add_coriolis(self._masses, twist.reshape(-1, 6), force.reshape(-1, 6))
        scaled = (self.scale * gaps).reshape(len(r), -1, 6)
        residual = np.concatenate([force, scaled], axis=1)
        reaction = self._impose_supports(targets, states, residual)
        if frozen is not None:
            residual[:, :n] += sections.through(frozen)
        residual[:, self._complete] = 0.0
        return Motion(
            setting,
            orbit.X,
            rates,
            states,
            twist,
            poses.acceleration,
            GaussStates(*(part.copy() for part in sections.points)),
            residual,
            force,
            targets,
            reaction,
            spring,
            np.array([motors, dampers, outside]),
            np.einsum("pki,pki->p", external, twist) + outside,
            max(size, self._largest(inertia)),
            frozen,
        )

    def linearised(self, motion: Motion) -> Linearised:
        """Return the derivatives of the unbalanced forces of a motion."""
        return linearised(self, motion)

    @property
    def _complete(self) -> Integers:
        """The nodes that are held in all motions."""
        return self.supports.set.nodes[self.supports.complete]

    def _poses(
        self,
        orbit: Orbit,
        rates: Floats,
        omega: float,
        targets: Floats,
        of_supports: tuple[Floats, Floats, Floats],
    ) -> _Poses:
        """Return poses of all nodes at all phases, where coordinates and complete supports put them."""
        base, body = self.base, self.body
        r, q, twist, known = self._held(targets, of_supports)
        free = np.flatnonzero(body.held == 0.0)
        place_orbit(base.r, base.q, orbit.X, rates, body.split, free, r, q, twist)
        acceleration = omega * np.tensordot(self.D, twist, axes=1)
        acceleration[:, self._complete] = known
        return _Poses(r, q, twist, acceleration)

    def _inertia(self, poses: _Poses, lack: float) -> Floats:
        """Return mass times acceleration ``(N, n, 6)``, less the damping that is taken away."""
        momentum = np.einsum("kij,pkj->pki", self.body.mass, poses.twist)
        return np.asarray(np.einsum("kij,pkj->pki", self.body.mass, poses.acceleration) - lack * momentum)

    def _add_joints(
        self, states: list[State], of_joints: tuple[Floats, Floats], force: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Add the forces of joints; return gaps ``(N, places)``, powers of motors and of dampers ``(N,)`` [W]."""
        count, constraints, at = self.fourier.count, self.system.constraints, self.problem.held
        gaps, motors, dampers = np.zeros((count, len(self.scale))), np.zeros(count), np.zeros(count)
        for i in range(count if self.problem.constrained else 0):
            self.aim_joints(of_joints, i)
            constraints.gap[at.place] = self.sections.points.strain[i, at.element, at.point, at.component]
            constraints.add_forces(states[i], force[i])
            gaps[i] = constraints.gap
            motors[i], dampers[i] = constraints.motor_power(), self._damper_power()
        return gaps, motors, dampers

    def _impose_supports(self, targets: Floats, states: list[State], residual: Floats) -> Floats:
        """Put gaps of partial supports in place of forces that they hold; return reactions ``(N, m, 6)``."""
        reaction = np.zeros_like(targets)
        if self.body.partly:
            directions = Directions.of(len(targets[0]))
            for i, state in enumerate(states):
                impose_supports(
                    self.supports.nodes, targets[i], state.r, state.q, residual[i], reaction[i], directions
                )
        return reaction

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

    def load_of(self, given: dict[int, float]) -> LoadState:
        """Return the loads at rest with the given factors of some of the loads that drive the motion, 0 of others."""
        others = {int(k): 0.0 for k in self.drive.loads if k >= 0}
        return self.loads.at(0.0, self._before, given=others | given)

    def loads_at(self, setting: Setting) -> OrbitLoads:
        """Return the loads at all phases."""
        factors = self.drive.factors(self.phases, setting.omega, setting.level)
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

    def aim_joints(self, motion: tuple[Floats, Floats], i: int) -> None:
        """Set where motors are to be at phase ``i``, and how fast."""
        constraints = self.system.constraints
        constraints.target[:] = self._joint_targets + motion[0][i]
        constraints.target_rate[:] = motion[1][i]

    def _damper_power(self) -> float:
        """Return the power that dampers of joints take [W], in the state measured last."""
        constraints = self.system.constraints
        a, rate = constraints.arrays, constraints.rate
        lost = float(np.sum(np.where((a.law < 0) & (a.place < 0), a.damping, 0.0) * rate**2))
        for c in np.flatnonzero(a.law >= 0):
            lost += constraints.laws.power(int(a.law[c]), float(rate[c]))
        return lost

    def _largest(self, force: Floats) -> float:
        """Return the largest force times the length, or moment, of ``(N, n, 6)``."""
        parts = np.abs(force[..., :3]).max(initial=0.0), np.abs(force[..., 3:]).max(initial=0.0)
        return max(float(parts[0]) * self.problem.length, float(parts[1]))


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
