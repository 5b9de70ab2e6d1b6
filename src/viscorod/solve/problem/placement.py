"""The places that a model names, in the mesh: at a node, at an arm from one, or within an element."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.rotations.quaternion import from_matrices, matrices
from viscorod.model.connections.place import AnyPlace, BodyPlace
from viscorod.model.connections.resolved_places import find, position_of
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.problem.mesh import Mesh
from viscorod.solve.problem.problem import Bodies
from viscorod.typing import Floats


@dataclass(frozen=True)
class MeshPlace:
    """A place that is rigidly connected with a node.

    Attributes:
        node: the node; arm: the place in the node's axes (3,) [m]; turn: from the place's axes to the node's (3, 3).
    """

    node: int
    arm: Floats
    turn: Floats

    def wrench(self, wrench: Floats) -> Floats:
        """Return a wrench (6,) at the place, in its axes, as one on the node in the node's."""
        force, moment = self.turn @ wrench[:3], self.turn @ wrench[3:]
        return np.concatenate([force, moment + np.cross(self.arm, force)])


MOST_SPOTS = 1000
"""Stations that are kept."""


class Placement:
    """Finds places of a model in its mesh.

    Args:
        model: whose places; mesh: its own.
        spots: stations of rods that were found in this mesh, by index of the rod and arc length [m], for more.
    """

    def __init__(
        self,
        model: ModelDescription,
        mesh: Mesh,
        spots: dict[tuple[int, float], MeshPlace | None] | None = None,
    ) -> None:
        self.model, self.mesh = model, mesh
        self.spots = {} if spots is None else spots
        self._bodies = {name: index for index, name in enumerate(model.bodies)}

    def find(self, text: str) -> AnyPlace:
        """Return the place that a text names."""
        return find(self.model, text)

    def spot(self, place: AnyPlace) -> MeshPlace | None:
        """Return the node of a place, or None between the nodes of a rod."""
        mesh = self.mesh
        if isinstance(place, BodyPlace):
            body = self._bodies[place.body]
            node, link = int(mesh.body_nodes[body]), int(mesh.body_links[body])
            R = matrices(mesh.quaternions[node][None])[0]
            turn = np.eye(3) if link < 0 else matrices(mesh.link_quaternions[link][None])[0]
            return MeshPlace(node, R.T @ (position_of(self.model, place)[0] - mesh.positions[node]), turn)
        rod = mesh.rod_index(place.rod)
        if (rod, place.s) in self.spots:
            return self.spots[rod, place.s]
        station = mesh.rods[rod].node_at(place.s)
        found = None if station is None else self.at_station(rod, station)
        if len(self.spots) < MOST_SPOTS:
            self.spots[rod, place.s] = found
        return found

    def at_station(self, rod: int, station: int) -> MeshPlace:
        """Return where a station of a rod is."""
        mesh = self.mesh
        node, link = int(mesh.shared[rod][station]), int(mesh.links[rod][station])
        if link < 0:
            return MeshPlace(node, np.zeros(3), np.eye(3))
        return MeshPlace(node, mesh.link_positions[link], matrices(mesh.link_quaternions[link][None])[0])

    def node(self, place: AnyPlace) -> int:
        """Return the node of a place that is known to have one."""
        spot = self.spot(place)
        assert spot is not None  # supports, attachments and joints are at element ends
        return spot.node

    def bodies(self) -> Bodies:
        """Return mass centres and named points of all bodies."""
        names, nodes, arms, turns = [], [], [], []
        for name, body in self.model.bodies.items():
            for point in (None, *body.points):
                spot = self.spot(BodyPlace(name, point))
                assert spot is not None
                names.append(name if point is None else f"{name}.{point}")
                nodes.append(spot.node)
                arms.append(spot.arm)
                turns.append(spot.turn)
        return Bodies(
            tuple(names),
            np.array(nodes, dtype=np.int64),
            np.array(arms).reshape(-1, 3),
            from_matrices(np.array(turns).reshape(-1, 3, 3)),
        )
