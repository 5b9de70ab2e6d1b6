"""What an analysis records: plain arrays at stations and Gauss points, ready to become a data set."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from viscorod.mechanics import inertia
from viscorod.mechanics.attachment import link_map
from viscorod.mechanics.quaternion import product
from viscorod.mechanics.rotation import rotate_rows
from viscorod.solve.problem import Problem
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System
from viscorod.typing import Floats


class StationReader:
    """Turns nodal states into fields at the stations (element nodes of every rod, attachments applied)."""

    def __init__(self, problem: Problem) -> None:
        stations = problem.stations
        self.nodes = stations.nodes
        count = len(stations.nodes)
        self._offset = np.zeros((count, 3))
        self._turn = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        self._map = np.tile(np.eye(6), (count, 1, 1))
        for k in np.flatnonzero(stations.links >= 0):
            link = stations.links[k]
            self._offset[k] = problem.link_positions[link]
            self._turn[k] = problem.link_quaternions[link]
            link_map(self._offset[k], self._turn[k], self._map[k])
        self._linked = bool((stations.links >= 0).any())

    def read(self, state: State) -> tuple[Floats, Floats, Floats, Floats]:
        """Return positions [m], unit quaternions, global velocities [m/s] and body angular velocities [rad/s]."""
        r, q, twist = state.r[self.nodes], state.q[self.nodes], state.twist[self.nodes]
        if self._linked:
            r = r + _rotate(q, self._offset)
            q = product(q, self._turn)
            twist = np.einsum("nij,nj->ni", self._map, twist)
        return r, q, _rotate(q, np.ascontiguousarray(twist[:, :3])), twist[:, 3:].copy()


def _rotate(q: Floats, a: Floats) -> Floats:
    """Rotate body vectors ``a (n, 3)`` by unit quaternions ``q (n, 4)``."""
    out = np.empty_like(a)
    rotate_rows(q, a, out)
    return out


@dataclass
class EnergyAccount:
    """Energies so far [J]; ``numerical`` is what the balance lacks."""

    kinetic: float = 0.0
    elastic: float = 0.0
    viscous: float = 0.0
    external: float = 0.0
    start: float = 0.0

    @property
    def numerical(self) -> float:
        """T + W + D - P - (T + W)_0: energy that the time integration produced (negative: lost)."""
        return self.kinetic + self.elastic + self.viscous - self.external - self.start


@dataclass
class History:
    """Fields recorded at the output instants, one list entry each (units as in the data set they become)."""

    position: list[Floats] = field(default_factory=list)
    rotation: list[Floats] = field(default_factory=list)
    velocity: list[Floats] = field(default_factory=list)
    angular_velocity: list[Floats] = field(default_factory=list)
    strain: list[Floats] = field(default_factory=list)
    section_force: list[Floats] = field(default_factory=list)
    dissipation: list[Floats] = field(default_factory=list)
    reaction: list[Floats] = field(default_factory=list)
    momentum: list[Floats] = field(default_factory=list)
    energy: list[tuple[float, float, float, float, float]] = field(default_factory=list)
    instant: list[float] = field(default_factory=list)
    step_size: list[float] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)

    def record(
        self,
        instant: float,
        reader: StationReader,
        state: State,
        system: System,
        supports: SupportState,
        account: EnergyAccount,
        step_size: float,
        iterations: int,
    ) -> None:
        """Append the present state; ``instant`` is the time [s] or the load factor."""
        r, q, v, w = reader.read(state)
        points = system.gauss_points()
        self.instant.append(instant)
        self.position.append(r)
        self.rotation.append(q)
        self.velocity.append(v)
        self.angular_velocity.append(w)
        self.strain.append(points.strain)
        self.section_force.append(points.section_force)
        self.dissipation.append(points.dissipation)
        self.reaction.append(supports.global_reactions(state))
        momenta = np.empty_like(state.twist)
        inertia.momenta(system.problem.mass, state.r, state.q, state.twist, momenta)
        self.momentum.append(momenta.sum(axis=0))
        self.energy.append(
            (account.kinetic, account.elastic, account.viscous, account.external, account.numerical)
        )
        self.step_size.append(step_size)
        self.iterations.append(iterations)
