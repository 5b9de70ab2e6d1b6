"""Records of an analysis: plain arrays at nodes and Gauss points, ready to become a data set."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from viscorod.mechanics.nodes.attached_poses import link_map
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.rotations.quaternion import product
from viscorod.mechanics.rotations.rotation import rotate_rows
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats


class StationReader:
    """Turns nodal states into fields at the stations.

    These are the element nodes of every rod, attachments applied, and after them the mass centres and named points of
    rigid bodies.
    """

    def __init__(self, problem: Problem) -> None:
        stations, bodies = problem.stations, problem.bodies
        self.nodes = np.concatenate([stations.nodes, bodies.nodes])
        count, rods = len(self.nodes), len(stations.nodes)
        self._offset = np.zeros((count, 3))
        self._offset[rods:] = bodies.arms
        self._turn = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        self._turn[rods:] = bodies.turns
        self._map = np.tile(np.eye(6), (count, 1, 1))
        for k in np.flatnonzero(stations.links >= 0):
            link = stations.links[k]
            self._offset[k] = problem.link_positions[link]
            self._turn[k] = problem.link_quaternions[link]
        beside = self._offset[rods:].any(axis=1) | self._turn[rods:, 1:].any(axis=1)
        moved = np.flatnonzero(np.append(stations.links >= 0, beside))
        for k in moved:
            link_map(self._offset[k], self._turn[k], self._map[k])
        self._linked = len(moved) > 0

    @property
    def places(self) -> tuple[Floats, Floats]:
        """Positions ``(stations, 3)`` [m] and orientations ``(stations, 4)`` of the stations in node axes."""
        return self._offset, self._turn

    def read(self, r: Floats, q: Floats, twist: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return positions [m], unit quaternions, global velocities [m/s] and body angular velocities [rad/s].

        Args:
            r, q, twist: nodal states ``(..., n, 3)``, ``(..., n, 4)``, ``(..., n, 6)``.
        """
        r, q, twist = r[..., self.nodes, :], q[..., self.nodes, :], twist[..., self.nodes, :]
        if self._linked:
            r = r + _rotate(q, np.broadcast_to(self._offset, r.shape).copy())
            q = product(q, np.broadcast_to(self._turn, q.shape))
            twist = np.einsum("nij,...nj->...ni", self._map, twist)
        return r, q, _rotate(q, twist[..., :3]), twist[..., 3:].copy()


def _rotate(q: Floats, a: Floats) -> Floats:
    """Rotate body vectors ``a (..., 3)`` by unit quaternions ``q (..., 4)``."""
    out = np.empty(a.shape)
    rotate_rows(
        np.ascontiguousarray(q).reshape(-1, 4), np.ascontiguousarray(a).reshape(-1, 3), out.reshape(-1, 3)
    )
    return out


class Progressing(Protocol):
    """Energies of an integrator after a step, for the energy account."""

    kinetic: float
    elastic: float
    work: float
    loss: float
    outside: float
    actuator: float

    @property
    def branch_loss(self) -> Floats:
        """Energy dissipated by each Maxwell branch ``(n,)`` [J], part of ``loss``."""


class StepShare(NamedTuple):
    """What happened in a part of a step [J]: work, viscous loss, loss of loads outside, work of rest strains."""

    work: float
    loss: float
    outside: float
    actuator: float


@dataclass
class EnergyAccount:
    """Energies so far [J].

    ``outside`` is what loads dissipated; ``actuator`` the work of what changes rest strains; ``numerical`` closes the
    balance;
    ``branches`` are dissipated by each Maxwell branch, parts of ``viscous``.
    """

    kinetic: float = 0.0
    elastic: float = 0.0
    viscous: float = 0.0
    external: float = 0.0
    start: float = 0.0
    outside: float = 0.0
    actuator: float = 0.0
    branches: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def numerical(self) -> float:
        """T + W + D - P - (T + W)_0: energy that the time integration produced (negative: lost)."""
        given = self.external + self.actuator + self.start
        return self.kinetic + self.elastic + self.viscous + self.outside - given

    def copy(self) -> EnergyAccount:
        """Return an independent copy."""
        copied = EnergyAccount.__new__(EnergyAccount)
        vars(copied).update(vars(self))
        return copied

    def add(self, step: Progressing) -> None:
        """Add a step."""
        self.kinetic, self.elastic = step.kinetic, step.elastic
        self.external += step.work
        self.viscous += step.loss
        self.outside += step.outside
        self.actuator += step.actuator
        self.branches = self.branches + step.branch_loss

    def between(
        self, end: EnergyAccount, part: float, kinetic: float, step: StepShare, branch_loss: Floats
    ) -> EnergyAccount:
        """Return the account at a ``part`` of the step that led from here to ``end``, with what happened up to there.

        The remainder is known at the ends of steps only, and linear between; the elastic energy is what the balance
        leaves.
        """
        viscous, external, outside, actuator = (
            self.viscous + step.loss,
            self.external + step.work,
            self.outside + step.outside,
            self.actuator + step.actuator,
        )
        remainder = (1.0 - part) * self.numerical + part * end.numerical
        given = external + actuator + self.start
        elastic = max(remainder - (kinetic + viscous + outside - given), 0.0)
        branches = self.branches + branch_loss
        return EnergyAccount(kinetic, elastic, viscous, external, self.start, outside, actuator, branches)


class Snapshot(NamedTuple):
    """The state of everything at one instant.

    Attributes:
        state: nodal poses and twists; strain, strain_rate, section_force: at the Gauss points in order ``(m, 6)``.
        reaction: global wrenches of the supports ``(supports, 6)``.
        kinetic, elastic: energies [J]; joints: their coordinates, None if there are none.
        branch_power: lost by Maxwell branches per length at the Gauss points ``(m,)`` [W/m], None if there are none.
        branch_strain: of their springs ``(m, n, 6)``, likewise.
    """

    state: State
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    reaction: Floats
    kinetic: float
    elastic: float
    joints: JointState | None = None
    branch_power: Floats | None = None
    branch_strain: Floats | None = None

    @classmethod
    def of(cls, state: State, system: System, supports: SupportState, kinetic: float = 0.0) -> Snapshot:
        """Take the snapshot of the last assembly."""
        points = system.gauss_points()
        return cls(
            state.copy(),
            points.strain,
            points.strain_rate,
            points.section_force,
            supports.global_reactions(state),
            kinetic,
            system.elastic_energy(),
            system.constraints.state(),
            system.branch_power(),
            system.branch_strain(),
        )

    def blend(self, end: Snapshot, part: float, state: State, system: System) -> Snapshot:
        """Return the state at a ``part`` of the way to ``end``: nodal ``state`` given, the rest linear in time.

        The elastic energy is left to the energy account.
        """

        def mix(a: Floats, b: Floats) -> Floats:
            return (1.0 - part) * a + part * b

        return Snapshot(
            state,
            mix(self.strain, end.strain),
            mix(self.strain_rate, end.strain_rate),
            mix(self.section_force, end.section_force),
            mix(self.reaction, end.reaction),
            kinetic_energy(system.problem.mass, state.twist),
            0.0,
            self._blended_joints(end, part),
            None
            if self.branch_power is None or end.branch_power is None
            else mix(self.branch_power, end.branch_power),
            None
            if self.branch_strain is None or end.branch_strain is None
            else mix(self.branch_strain, end.branch_strain),
        )

    def _blended_joints(self, end: Snapshot, part: float) -> JointState | None:
        if self.joints is None or end.joints is None:
            return None
        return JointState(
            *((1.0 - part) * a + part * b for a, b in zip(self.joints, end.joints, strict=True))
        )


@dataclass
class History:
    """Recorded states, one list entry each; instants are times [s] or load factors."""

    instant: list[float] = field(default_factory=list)
    snapshots: list[Snapshot] = field(default_factory=list)
    energy: list[tuple[float, float, float, float, float, float, float]] = field(default_factory=list)
    step_size: list[float] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    branches: list[Floats] = field(default_factory=list)  # energy lost by each Maxwell branch so far
    unstable: list[int] = field(default_factory=list)  # negative eigenvalues of the points of a path
    start: Snapshot | None = None
    """The state at 0, if it was recorded here."""
    last: tuple[float, Snapshot] | None = None
    """The last instant and state that were recorded here."""

    @property
    def count(self) -> int:
        """States recorded so far."""
        return len(self.instant)

    def record(
        self, instant: float, snapshot: Snapshot, account: EnergyAccount, step_size: float, iterations: int
    ) -> None:
        """Append a snapshot and the energy account at an instant."""
        if instant == 0.0:
            self.start = snapshot
        self.snapshots.append(snapshot)
        self.energy.append(
            (
                account.kinetic,
                account.elastic,
                account.viscous,
                account.external,
                account.numerical,
                account.outside,
                account.actuator,
            )
        )
        self.branches.append(account.branches)
        self.step_size.append(step_size)
        self.iterations.append(iterations)
        self.last = instant, snapshot
        self.instant.append(instant)  # at the end, which makes it count

    def truncate(self, count: int) -> None:
        """Keep the first ``count`` records only."""
        for values in (
            self.instant,
            self.snapshots,
            self.energy,
            self.branches,
            self.step_size,
            self.iterations,
        ):
            del values[count:]

    def sample(self, most: int) -> list[tuple[float, Snapshot]]:
        """Return at most about so many of the recorded states, evenly, each with its instant."""
        count = len(self.snapshots)
        chosen = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
        return [(self.instant[k], self.snapshots[k]) for k in chosen]
