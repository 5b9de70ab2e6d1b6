"""From the loads of a model to wrenches on nodes or within elements."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from viscorod.mechanics.elements.basis import gauss, lagrange, lobatto
from viscorod.mechanics.rotations.quaternion import from_matrices
from viscorod.model.actions.load_effects import MotionLaw, TimeFactor
from viscorod.model.connections.place import BodyPlace
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.problem.mesh import RodMesh
from viscorod.solve.problem.placement import Placement
from viscorod.solve.problem.problem import MotionLoad, NodalLoad, StationLoad
from viscorod.typing import Floats


def place_loads(
    model: ModelDescription, places: Placement
) -> tuple[tuple[NodalLoad, ...], tuple[StationLoad, ...], tuple[MotionLoad, ...]]:
    """Return the loads of a model on nodes, those within elements, and those that see motion."""
    nodal: list[NodalLoad] = []
    inside: list[StationLoad] = []
    moving: list[MotionLoad] = []
    for number, load in enumerate(model.loads):
        load.place(model, _LoadPlacing(number, places, nodal, inside, moving))
    return tuple(nodal), tuple(inside), tuple(moving)


class _LoadPlacing:
    """Puts the wrenches of one load into the lists; a `Placing`."""

    def __init__(
        self,
        load: int,
        places: Placement,
        nodal: list[NodalLoad],
        inside: list[StationLoad],
        moving: list[MotionLoad],
    ) -> None:
        self.load, self.places, self.nodal, self.inside, self.moving = load, places, nodal, inside, moving

    def at(self, place: str, wrench: Floats, factor: TimeFactor, *, following: bool = False) -> None:
        """Put a wrench on a node, or within an element."""
        found = self.places.find(place)
        spot = self.places.spot(found)
        if spot is not None:
            on_node = spot.wrench(wrench) if following else wrench
            self._nodal([spot.node], [on_node], [spot.arm], factor, following)
            return
        assert not isinstance(found, BodyPlace)  # these have nodes
        s = found.s

        def here(_t: float, _before: bool) -> float:
            return s

        self.travelling(found.rod, here, wrench, factor, following=following)

    def along(
        self,
        rod: str,
        density: Callable[[float], Floats],
        factor: TimeFactor,
        *,
        start: float = 0.0,
        end: float | None = None,
        following: bool = False,
    ) -> None:
        """Put nodal wrenches on a rod: the density integrated with the shape functions over the loaded part."""
        index = self.places.mesh.rod_index(rod)
        mesh = self.places.mesh.rods[index]
        end = mesh.rod.length if end is None else end
        points, weights = gauss(mesh.order + 2)
        nodes: list[int] = []
        wrenches: list[Floats] = []
        arms: list[Floats] = []
        for e, (a, b) in enumerate(zip(mesh.ends[:-1], mesh.ends[1:], strict=True)):
            low, high = max(a, start), min(b, end)
            if high <= low:
                continue
            s = 0.5 * (low + high) + 0.5 * (high - low) * points
            shapes, _ = lagrange(mesh.order, 2.0 * (s - a) / (b - a) - 1.0)
            densities = np.array([density(float(x)) for x in s])
            sums = np.einsum("gk,gi,g->ki", shapes, densities, 0.5 * (high - low) * weights)
            for k, wrench in enumerate(sums):
                spot = self.places.at_station(index, e * mesh.order + k)
                nodes.append(spot.node)
                wrenches.append(spot.wrench(wrench) if following else wrench)
                arms.append(spot.arm)
        self._nodal(nodes, wrenches, arms, factor, following)

    def travelling(
        self, rod: str, position: TimeFactor, wrench: Floats, factor: TimeFactor, *, following: bool = False
    ) -> None:
        """Put a wrench within whichever element it is in."""
        dead, carried = _split(wrench, following)
        index = self.places.mesh.rod_index(rod)
        self.inside.append(StationLoad(self.load, index, position, dead, carried, factor))

    def seeing_motion(
        self,
        rod: str,
        law: MotionLaw,
        factor: TimeFactor,
        *,
        start: float = 0.0,
        end: float | None = None,
    ) -> None:
        """Let a law act at the nodes of a rod, each for its part of the length."""
        index = self.places.mesh.rod_index(rod)
        mesh = self.places.mesh.rods[index]
        lengths = nodal_lengths(mesh, start, mesh.rod.length if end is None else end)
        stations = np.flatnonzero(lengths)
        spots = [self.places.at_station(index, int(k)) for k in stations]
        turns = from_matrices(np.array([spot.turn for spot in spots]).reshape(-1, 3, 3))
        nodes = np.array([spot.node for spot in spots], dtype=np.int64)
        arms = np.array([spot.arm for spot in spots]).reshape(-1, 3)
        self.moving.append(MotionLoad(self.load, nodes, arms, turns, lengths[stations], law, factor))

    def seeing_motion_at(self, place: str, law: MotionLaw, factor: TimeFactor) -> None:
        """Let a law act on the node of a place, at which an element ends."""
        spot = self.places.spot(self.places.find(place))
        assert spot is not None  # elements end where such loads act
        nodes, turns = np.array([spot.node], dtype=np.int64), from_matrices(spot.turn[None])
        self.moving.append(MotionLoad(self.load, nodes, spot.arm[None], turns, np.ones(1), law, factor))

    def everywhere(self, acceleration: Floats, factor: TimeFactor) -> None:
        """Let all masses have weight."""
        none, empty = np.empty(0, dtype=np.int64), np.empty((0, 6))
        self.nodal.append(NodalLoad(self.load, none, empty, empty, acceleration, np.empty((0, 3)), factor))

    def _nodal(
        self,
        nodes: list[int],
        wrenches: list[Floats],
        arms: list[Floats],
        factor: TimeFactor,
        following: bool,
    ) -> None:
        dead, carried = _split(np.array(wrenches), following)
        self.nodal.append(
            NodalLoad(
                self.load, np.array(nodes, dtype=np.int64), dead, carried, np.zeros(3), np.array(arms), factor
            )
        )


def nodal_lengths(mesh: RodMesh, start: float, end: float) -> Floats:
    """Return the lengths [m] that the nodes of a rod stand for from one element end to another, as mass is lumped."""
    lengths = np.zeros(len(mesh.s))
    weights = lobatto(mesh.order)[1]
    for e, (a, b) in enumerate(pairwise(mesh.ends)):
        if start < 0.5 * (a + b) < end:
            lengths[e * mesh.order : (e + 1) * mesh.order + 1] += 0.5 * (b - a) * weights
    return lengths


def _split(wrench: Floats, following: bool) -> tuple[Floats, Floats]:
    """Return wrenches ``(..., 6)`` as dead and following ones."""
    none = np.zeros_like(wrench)
    return (none, wrench) if following else (wrench, none)
