"""A mesh of elements half as long, and the state of a coarser mesh on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from viscorod.mechanics.elements.basis import gauss, lagrange, lobatto
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.division import Divisions, divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["FinerMesh", "Shape", "halves"]


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


@dataclass(frozen=True)
class Halves:
    """Polynomials of an element of one order, read in its halves.

    Attributes:
        nodes: from its nodes to those of both halves ``(2 p + 1, p + 1)``.
        points: from its Gauss points to those of both halves ``(2 p, p)``.
        places: where section forces are compared, in ``[-1, 1]`` ``(k,)``: ends, middle and Gauss points.
        whole: from its Gauss points to these places ``(k, p)``; divided: from those of the halves ``(k, 2 p)``.
    """

    nodes: Floats
    points: Floats
    places: Floats
    whole: Floats
    divided: Floats


@lru_cache
def halves(order: int) -> Halves:
    """Return the interpolation from an element to its halves."""
    inner = 0.5 * (lobatto(order)[0] + 1.0)
    nodes = lagrange(order, np.concatenate([inner - 1.0, inner[1:]]))[0]
    x = gauss(order)[0]
    points = _through(x, np.concatenate([0.5 * (x - 1.0), 0.5 * (x + 1.0)]))
    places = np.concatenate([[-1.0], x, [0.0, 1.0]])
    first = places <= 0.0
    divided = np.zeros((len(places), 2 * order))
    divided[first, :order] = _through(x, 2.0 * places[first] + 1.0)
    divided[~first, order:] = _through(x, 2.0 * places[~first] - 1.0)
    return Halves(nodes, points, places, _through(x, places), divided)


def _through(points: Floats, at: Floats) -> Floats:
    """Return the values ``(k, p)`` at places of the Lagrange polynomials through ``points (p,)``."""
    values = np.ones((len(at), len(points)))
    for j, point in enumerate(points):
        for other in np.delete(points, j):
            values[:, j] *= (at - other) / (point - other)
    return values


class FinerMesh:
    """The problem with all elements halved, and the solvers that work on it.

    Args:
        model: that was discretised; coarse: the problem that came of it.

    Attributes:
        problem, system, supports, static: of the finer mesh.
        divisions: of the coarse one.
        reference: positions of the finer stations in the reference shape ``(stations, 3)`` [m]; coarse_reference: where
            the coarse mesh has them.
    """

    def __init__(self, model: ModelDescription, coarse: Problem) -> None:
        self.coarse = coarse
        self.divisions: Divisions = divisions_of(coarse)
        finer = {name: division.halved() for name, division in self.divisions.items()}
        self.problem = discretise(model, validated=True, divisions=finer)
        self.system = GeometricSystem(self.problem)
        self.system.relaxation = None  # what branches hold is given with the state
        self.supports = SupportState(self.problem)
        self.static = StaticSolver(self.system, self.supports)
        self.reader, self._coarse_reader = StationReader(self.problem), StationReader(coarse)
        self.reference = self.stations(State.reference(self.problem))[0]
        self.coarse_reference = self.interpolated(State.reference(coarse))[0]

    def stations(self, state: State) -> tuple[Floats, Floats]:
        """Return positions ``(stations, 3)`` [m] and unit quaternions of the rods' stations in a finer state."""
        return self._rods(self.reader, self.problem, state)

    def coarse_stations(self, state: State) -> tuple[Floats, Floats]:
        """Return positions and unit quaternions of the rods' stations in a state of the coarse mesh."""
        return self._rods(self._coarse_reader, self.coarse, state)

    @staticmethod
    def _rods(reader: StationReader, problem: Problem, state: State) -> tuple[Floats, Floats]:
        r, q, _, _ = reader.read(state.r, state.q, np.zeros((problem.size, 6)))
        count = len(problem.stations.nodes)
        return r[:count], q[:count]

    def interpolated(self, state: State) -> tuple[Floats, Floats]:
        """Return positions [m] and unit quaternions at the finer stations in a state of the coarse mesh."""
        r, q = self.coarse_stations(state)
        for rod in range(len(self.sizes)):
            mine = self.coarse.stations.rod == rod
            q[mine] = _aligned(q[mine])
        mixed = self.at_stations(q)
        return self.at_stations(r), mixed / np.linalg.norm(mixed, axis=1, keepdims=True)

    def at_stations(self, field: Floats) -> Floats:
        """Return a field at the coarse stations of the rods ``(stations, k)`` at the finer ones."""
        pieces, first = [], 0
        for order, count in self.sizes:
            last = first + order * count + 1
            pieces.append(_refined(field[first:last], order, count))
            first = last
        return np.concatenate(pieces)

    @property
    def bodies(self) -> int:
        """Number of nodes that are rigid bodies, the first ones of both meshes."""
        stations = self.problem.stations
        return int(stations.nodes[stations.links < 0].min(initial=self.problem.size))

    def take_over(self, shape: Shape) -> State:
        """Return a state of the coarse mesh as the finer one has it; its section forces become the stress iterate."""
        problem, stations = self.problem, self.problem.stations
        state = State.reference(problem)
        fine_r, fine_q = self.interpolated(shape.state)
        own = stations.links < 0
        bodies = self.bodies
        state.r[:bodies], state.q[:bodies] = shape.state.r[:bodies], shape.state.q[:bodies]
        state.r[stations.nodes[own]], state.q[stations.nodes[own]] = fine_r[own], fine_q[own]
        joints = 6 * problem.joints.blocks
        state.multiplier[:joints] = shape.state.multiplier[:joints]
        if len(shape.near):
            self.system.constraints.near[:] = shape.near
        self._set_stress(self.spread(shape.section_force), state)
        return state

    def spread(self, field: Floats) -> Floats:
        """Return a field at the coarse Gauss points ``(m, 6)`` at those of the finer mesh, in the order of results."""
        pieces, first = [], 0
        for order, count in self.sizes:
            mine = field[first : first + order * count].reshape(count, order, -1)
            pieces.append(np.einsum("gk,ekc->egc", halves(order).points, mine).reshape(-1, field.shape[1]))
            first += order * count
        return np.concatenate(pieces)

    def set_prestress(self, field: Floats) -> None:
        """Take section forces beside the elastic ones at the coarse Gauss points ``(m, 6)``."""
        self.system.prestress = self.arranged(self.spread(field), self.system)

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

    @property
    def sizes(self) -> list[tuple[int, int]]:
        """Order and number of the coarse elements of every rod."""
        return [(division.order, division.count) for division in self.divisions.values()]


def _refined(values: Floats, order: int, count: int) -> Floats:
    """Return values at the stations of a rod ``(p n + 1, k)`` at those of the halved elements ``(2 p n + 1, k)``."""
    nodes = values[order * np.arange(count)[:, None] + np.arange(order + 1)]
    inside = np.einsum("fk,ekc->efc", halves(order).nodes, nodes)
    return np.concatenate([inside[:, :-1].reshape(-1, values.shape[1]), values[-1:]])


def _aligned(q: Floats) -> Floats:
    """Return quaternions ``(n, 4)``, each in the hemisphere of the one before it."""
    flips = np.sum(q[1:] * q[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(np.concatenate([[False], flips])) % 2 == 1, -1.0, 1.0)
    return np.asarray(signs[:, None] * q)
