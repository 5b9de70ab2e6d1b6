"""Records of an analysis: plain arrays at nodes and Gauss points, ready to become a data set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from viscorod.mechanics.nodes.attached_poses import link_map
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.rotations.quaternion import product
from viscorod.mechanics.rotations.rotation import rotate_rows
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.energy_account import EnergiesKnown, EnergiesWithin, EnergyAccount, StepShare
from viscorod.solve.formulations.system import State, System
from viscorod.solve.once import once_of_layout
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

    def poses(self, r: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return positions [m] and unit quaternions of the stations in nodal poses; see :meth:`read`."""
        r, q = r[..., self.nodes, :], q[..., self.nodes, :]
        if self._linked:
            r = r + _rotate(q, np.broadcast_to(self._offset, r.shape).copy())
            q = product(q, np.broadcast_to(self._turn, q.shape))
        return r, q

    def read(self, r: Floats, q: Floats, twist: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return positions [m], unit quaternions, global velocities [m/s] and body angular velocities [rad/s].

        Args:
            r, q, twist: nodal states ``(..., n, 3)``, ``(..., n, 4)``, ``(..., n, 6)``.
        """
        (r, q), twist = self.poses(r, q), twist[..., self.nodes, :]
        if self._linked:
            twist = np.einsum("nij,...nj->...ni", self._map, twist)
        return r, q, _rotate(q, twist[..., :3]), twist[..., 3:].copy()


@once_of_layout
def station_reader(problem: Problem) -> StationReader:
    """Return what reads fields at the stations of a problem; all problems of one layout share it."""
    return StationReader(problem)


def _rotate(q: Floats, a: Floats) -> Floats:
    """Rotate body vectors ``a (..., 3)`` by unit quaternions ``q (..., 4)``."""
    out = np.empty(a.shape)
    rotate_rows(
        np.ascontiguousarray(q).reshape(-1, 4), np.ascontiguousarray(a).reshape(-1, 3), out.reshape(-1, 3)
    )
    return out


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


class Snapshots(NamedTuple):
    """States at ``k`` instants one after the other: the fields of :class:`Snapshot` with the instants first.

    ``multiplier`` has one array per instant, which several may share.
    """

    r: Floats
    q: Floats
    twist: Floats
    multiplier: list[Floats]
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    reaction: Floats
    kinetic: Floats
    elastic: Floats
    joints: JointState | None = None
    branch_power: Floats | None = None
    branch_strain: Floats | None = None

    @classmethod
    def of(cls, snapshot: Snapshot) -> Snapshots:
        """Return one snapshot as a series, of the same arrays."""
        state, strain, rate, force, reaction, kinetic, elastic, joints, power, spring = snapshot
        return cls(
            state.r[None],
            state.q[None],
            state.twist[None],
            [state.multiplier],
            strain[None],
            rate[None],
            force[None],
            reaction[None],
            np.array([kinetic]),
            np.array([elastic]),
            None if joints is None else JointState(*(field[None] for field in joints)),
            None if power is None else power[None],
            None if spring is None else spring[None],
        )

    @classmethod
    def joined(cls, pieces: Sequence[Snapshots]) -> Snapshots:
        """Return all states of some series in arrays of their own; what one of them lacks none has."""

        def join(parts: list[Any]) -> Any:
            if any(part is None for part in parts):
                return None
            if isinstance(parts[0], JointState):
                return JointState(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))
            if isinstance(parts[0], list):
                return [item for part in parts for item in part]
            return np.concatenate(parts)

        return cls(**{name: join([getattr(piece, name) for piece in pieces]) for name in cls._fields})

    @property
    def instants(self) -> int:
        """Their number."""
        return len(self.r)

    def at(self, k: int) -> Snapshot:
        """Return the one at instant ``k``, of parts of the arrays."""
        joints, power, spring = self.joints, self.branch_power, self.branch_strain
        return Snapshot(
            State(self.r[k], self.q[k], self.twist[k], self.multiplier[k]),
            self.strain[k],
            self.strain_rate[k],
            self.section_force[k],
            self.reaction[k],
            float(self.kinetic[k]),
            float(self.elastic[k]),
            None if joints is None else JointState(*(field[k] for field in joints)),
            None if power is None else power[k],
            None if spring is None else spring[k],
        )

    def each(self) -> list[Snapshot]:
        """Return all of them by themselves."""
        return [self.at(k) for k in range(self.instants)]

    def first(self, count: int) -> Snapshots:
        """Return the first ``count`` of them."""
        joints = self.joints
        cut: dict[str, Any] = {
            name: None if values is None else values[:count] for name, values in self._asdict().items()
        }
        if joints is not None:
            cut["joints"] = JointState(*(values[:count] for values in joints))
        return type(self)(**cut)


class Records(NamedTuple):
    """Consecutive records: states, and energies or what they follow from, at one place or several of a step."""

    states: Snapshots
    energy: EnergyAccount | EnergiesWithin | EnergiesKnown

    def first(self, count: int) -> Records:
        """Return the first ``count`` of them."""
        energy = self.energy
        if isinstance(energy, EnergiesWithin):
            step = StepShare._make(values[:count] for values in energy.step)
            energy = energy._replace(parts=energy.parts[:count], kinetic=energy.kinetic[:count], step=step)
        elif isinstance(energy, EnergiesKnown):
            energy = EnergiesKnown(energy.rows[:count], energy.branches[:count])
        return Records(self.states.first(count), energy)


@dataclass
class History:
    """Recorded states; instants are times [s] or load factors.

    Attributes:
        records: pieces of one or more states, whose arrays they keep.
        instant, step_size, iterations: one entry per state.
        unstable: negative eigenvalues of the points of a path.
        start: the state at 0, if it was recorded here.
    """

    instant: list[float] = field(default_factory=list)
    records: list[Records] = field(default_factory=list)
    step_size: list[float] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    unstable: list[int] = field(default_factory=list)
    start: Snapshot | None = None

    @property
    def count(self) -> int:
        """States recorded so far."""
        return len(self.instant)

    @property
    def snapshots(self) -> list[Snapshot]:
        """The states that are here, each by itself."""
        return [snapshot for piece in self.records for snapshot in piece.states.each()]

    def record(
        self, instant: float, snapshot: Snapshot, account: EnergyAccount, step_size: float, iterations: int
    ) -> None:
        """Append a snapshot and the energy account at an instant."""
        self.extend([instant], Records(Snapshots.of(snapshot), account.copy()), step_size, iterations)

    def extend(
        self,
        instants: list[float],
        records: Records,
        step_size: float | list[float],
        iterations: int | list[int],
    ) -> None:
        """Append states at their instants, of one step, or of several with a step [s] and iterations for each state."""
        if instants[0] == 0.0:
            self.start = records.states.at(0)
        count = len(instants)
        self.records.append(records)
        self.step_size += step_size if isinstance(step_size, list) else [step_size] * count
        self.iterations += iterations if isinstance(iterations, list) else [iterations] * count
        self.instant += instants  # at the end, which makes them count

    def states(self) -> Snapshots:
        """Return all states, in arrays of their own."""
        return Snapshots.joined([piece.states for piece in self.records])

    def energies(self) -> tuple[Floats, Floats]:
        """Return the energies ``(k, 7)``, as in :attr:`EnergyAccount.recorded`, and losses of branches ``(k, n)``."""
        pieces = [piece.energy for piece in self.records]
        inside = [piece for piece in pieces if isinstance(piece, EnergiesWithin)]
        energy, branches, done = np.empty((len(self.instant), 7)), [], 0
        within, taken = EnergiesWithin.rows(inside) if inside else np.empty((0, 7)), 0
        for piece in pieces:
            if isinstance(piece, EnergiesWithin):
                count = len(piece.parts)
                energy[done : done + count] = within[taken : taken + count]
                branches.append(piece.before.branches + piece.step.branches)
                taken += count
            elif isinstance(piece, EnergiesKnown):
                count = len(piece.rows)
                energy[done : done + count] = piece.rows
                branches.append(piece.branches)
            else:
                count = 1
                energy[done] = piece.recorded
                branches.append(piece.branches[None])
            done += count
        return energy, np.concatenate(branches)

    def truncate(self, count: int) -> None:
        """Keep the first ``count`` records only."""
        for values in (self.instant, self.step_size, self.iterations):
            del values[count:]
        kept: list[Records] = []
        left = count
        for piece in self.records:
            if left <= 0:
                break
            instants = piece.states.instants
            kept.append(piece.first(left) if left < instants else piece)
            left -= instants
        self.records = kept

    def sample(self, most: int) -> list[tuple[float, Snapshot]]:
        """Return at most about so many of the recorded states, evenly, each with its instant."""
        snapshots = self.snapshots
        count = len(snapshots)
        chosen = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
        return [(self.instant[k], snapshots[k]) for k in chosen]
