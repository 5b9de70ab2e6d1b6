"""A mesh of elements half as long, and the state of a coarser mesh on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot, station_reader
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.division import Divisions, divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.half_elements import half_elements, read
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["Carried", "FinerMesh", "Shape"]


@dataclass(frozen=True)
class Shape:
    """A solution at one instant, as a finer mesh takes it over.

    Attributes:
        state: poses and multipliers of the nodes.
        section_force: at the Gauss points in the order of results ``(m, 6)``.
        near: angles of joints, whole turns included ``(c,)``.
    """

    state: State
    section_force: Floats
    near: Floats

    @classmethod
    def of(cls, snapshot: Snapshot) -> Shape:
        """Return what of a solution a finer mesh takes over."""
        near = np.zeros(0) if snapshot.joints is None else snapshot.joints.value
        return cls(snapshot.state, snapshot.section_force, near)


@dataclass(frozen=True)
class Carried:
    """Some solutions as the finer mesh takes them over.

    Attributes:
        shapes: the solutions on the coarse mesh.
        r, q: positions [m] and unit quaternions at the finer stations ``(k, stations, 3)``, ``(k, stations, 4)``.
        section_force: at the finer Gauss points in the order of results ``(k, m, 6)``.
    """

    shapes: Sequence[Shape]
    r: Floats
    q: Floats
    section_force: Floats

    def of(self, some: list[int]) -> Carried:
        """Return some of them."""
        shapes = [self.shapes[k] for k in some]
        return Carried(shapes, self.r[some], self.q[some], self.section_force[some])


class FinerMesh:
    """The problem with all elements halved, and the solvers that work on it.

    Args:
        model: that was discretised; coarse: the problem that came of it.

    Attributes:
        problem, system, supports, static: of the finer mesh.
        divisions: of the coarse one; halves: its elements read in their halves.
        reference: positions of the finer stations in the reference shape ``(stations, 3)`` [m]; reference_turns: their
            unit quaternions ``(stations, 4)``; coarse_reference: positions where the coarse mesh has them.
    """

    def __init__(self, model: ModelDescription, coarse: Problem) -> None:
        self.coarse = coarse
        self.divisions: Divisions = divisions_of(coarse)
        self.halves = half_elements(tuple((one.order, one.count) for one in self.divisions.values()))
        finer = {name: division.halved() for name, division in self.divisions.items()}
        self.problem = discretise(model, validated=True, divisions=finer)
        self.system = GeometricSystem(self.problem)
        self.system.relaxation = None  # what branches hold is given with the state
        self.supports = SupportState(self.problem)
        self.static = StaticSolver(self.system, self.supports)
        self.reader, self._coarse_reader = station_reader(self.problem), station_reader(coarse)
        self.reference, self.reference_turns = self.stations(self.problem.positions, self.problem.quaternions)
        self.coarse_reference = self.interpolated(coarse.positions, coarse.quaternions)[0]

    def stations(self, r: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return positions [m] and unit quaternions of the rods' stations, from those of the nodes of the finer mesh.

        Args:
            r, q: ``(..., n, 3)``, ``(..., n, 4)``; so are the stations.
        """
        count = len(self.problem.stations.nodes)
        r, q = self.reader.poses(r, q)
        return r[..., :count, :], q[..., :count, :]

    def interpolated(self, r: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return positions [m] and unit quaternions at the finer stations, from those of the nodes of the coarse mesh.

        Args:
            r, q: ``(..., n, 3)``, ``(..., n, 4)``; so are the stations.
        """
        count, stations = len(self.coarse.stations.nodes), self.halves.stations
        r, q = self._coarse_reader.poses(r, q)
        mixed = read(stations, self._aligned(q[..., :count, :]))
        return read(stations, r[..., :count, :]), mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)

    def _aligned(self, q: Floats) -> Floats:
        """Return quaternions of coarse stations ``(..., stations, 4)``, each nearest to the one before on its rod."""
        flips = np.zeros(q.shape[:-1], dtype=bool)
        np.less(np.einsum("...nk,...nk->...n", q[..., 1:, :], q[..., :-1, :]), 0.0, out=flips[..., 1:])
        if not flips.any():
            return q
        flips[..., self.halves.rod_stations] = False
        turned = np.cumsum(flips, axis=-1)
        turned = turned - turned[..., self.halves.rod_stations[self.coarse.stations.rod]]
        return np.where(turned[..., None] % 2 == 1, -q, q)

    def carried(self, shapes: Sequence[Shape]) -> Carried:
        """Return some states of the coarse mesh as the finer one has them."""
        r, q = self.interpolated(*(np.array([getattr(s.state, name) for s in shapes]) for name in "rq"))
        return Carried(shapes, r, q, read(self.halves.points, np.array([s.section_force for s in shapes])))

    @property
    def bodies(self) -> int:
        """Number of nodes that are rigid bodies, the first ones of both meshes."""
        stations = self.problem.stations
        return int(stations.nodes[stations.links < 0].min(initial=self.problem.size))

    def take_over(self, carried: Carried, k: int = 0) -> State:
        """Return one of some states on the finer mesh; its section forces become the stress iterate."""
        problem, stations, shape = self.problem, self.problem.stations, carried.shapes[k]
        state = State.reference(problem)
        own = stations.links < 0
        bodies = self.bodies
        state.r[:bodies], state.q[:bodies] = shape.state.r[:bodies], shape.state.q[:bodies]
        state.r[stations.nodes[own]], state.q[stations.nodes[own]] = carried.r[k, own], carried.q[k, own]
        joints = 6 * problem.joints.blocks
        state.multiplier[:joints] = shape.state.multiplier[:joints]
        if len(shape.near):
            self.system.constraints.near[:] = shape.near
        self._set_stress(carried.section_force[k], state)
        return state

    def set_prestress(self, field: Floats) -> None:
        """Take section forces beside the elastic ones at the Gauss points of the finer mesh ``(m, 6)``."""
        self.system.prestress = self.arranged(field, self.system)

    def _set_stress(self, field: Floats, state: State) -> None:
        stress, held = self.arranged(field, self.system), self.problem.held
        self.system.stress[:] = stress
        state.multiplier[held.place] = held.weight * stress[held.element, held.point, held.component]

    @staticmethod
    def arranged(field: Floats, system: GeometricSystem) -> Floats:
        """Return a field at the Gauss points of a system in the order of results as an array ``(e, points, 6)``."""
        whole = np.zeros(system.elements().reference.shape)
        whole.reshape(-1, 6)[system.gauss_indices()] = field
        return whole
