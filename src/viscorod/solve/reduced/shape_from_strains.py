"""The poses of all nodes from the strains along the rods and the poses of a few nodes from which these begin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from viscorod.mechanics.elements.basis import gauss, lobatto
from viscorod.mechanics.rotations.quaternion import from_matrices, matrices
from viscorod.solve.formulations.system import System
from viscorod.solve.problem.problem import Problem
from viscorod.solve.transient.pose_check import half_lengths
from viscorod.typing import Floats, Integers

__all__ = ["Root", "ShapeFromStrains"]

HATS: Floats = np.zeros((6, 16))
"""From ``(V, U)`` to the matrix ``[[U~, V], [0, 0]]``, row by row."""
HATS[[0, 1, 2, 3, 4, 5, 3, 4, 5], [3, 7, 11, 9, 2, 4, 6, 8, 1]] = [1, 1, 1, 1, 1, 1, -1, -1, -1]
STEPS = 3
"""Steps of the Magnus expansion of fourth order between neighbouring nodes."""


@dataclass(frozen=True)
class Root:
    """A node from which poses are found, and what supports hold of it.

    Attributes:
        node: its number; held: it stands still; pinned: its position does.
    """

    node: int
    held: bool
    pinned: bool


@dataclass(frozen=True)
class _Chain:
    """A rod that is reached at one of its stations; poses are matrices ``[[R, r], [0, 1]]``.

    Attributes:
        points: which Gauss points are its own, ``(e, g)``.
        weights: from the strains at an element's Gauss points to those at the places of the steps ``(2, steps, g)``.
        lengths: of the steps, element by element ``(e, steps)`` [m].
        nodes: those of its stations, in order of arc length; links, back: poses of the stations in the axes of the
            nodes, and the inverse ``(k, 4, 4)``.
        first: the station at which it is reached, by its number along the rod.
        new, again: stations whose nodes nothing else poses, and those reached twice or held, but the first.
        offsets: from the poses that reference strains make to those of the reference shape ``(k, 4, 4)``.
    """

    points: Integers
    weights: Floats
    lengths: Floats
    nodes: Integers
    links: Floats
    back: Floats
    first: int
    new: Integers
    again: Integers
    offsets: Floats

    def along(self, strain: Floats) -> Floats:
        """Return the poses of the stations ``(s, k, 4, 4)`` seen from the first, of total strains ``(s, m, 6)``."""
        own = strain[:, self.points] @ HATS  # (s, e, g, 16)
        first, second = self.weights[0] @ own, self.weights[1] @ own
        shape = len(strain), self.lengths.size, 4, 4
        A, B, h = first.reshape(shape), second.reshape(shape), self.lengths.reshape(-1, 1, 1)
        T = _exponential(0.5 * h * (A + B) + np.sqrt(3.0) / 12.0 * h**2 * (A @ B - B @ A))
        reach = 1
        while reach < T.shape[1]:  # products of neighbours, of these with theirs, and so on
            T[:, reach:] = T[:, :-reach] @ T[:, reach:]
            reach *= 2
        out = np.empty((len(strain), 1 + T.shape[1] // STEPS, 4, 4))
        out[:, 0], out[:, 1:] = np.eye(4), T[:, STEPS - 1 :: STEPS]
        return out


class ShapeFromStrains:
    """Poses of all nodes from strains at the Gauss points, in the order of results.

    ``R' = R U~``, ``r' = R V`` are integrated along the rods. Those of the reference shape are met exactly without
    strains. Where rods make a loop one of its nodes is reached twice, and how far it is from closed is told.

    Args:
        system: whose unstressed strains and rods these are.
    """

    def __init__(self, system: System) -> None:
        self.problem = problem = system.problem
        self.roots = _roots(problem)
        self._root_nodes = np.array([root.node for root in self.roots])
        self._reference = system.elements().reference.reshape(-1, 6)[system.gauss_indices()]
        self._unmoved = _matrices(problem.positions, problem.quaternions)
        self._chains: list[_Chain] = []
        posed, held = np.zeros((2, problem.size), dtype=bool)
        posed[self._root_nodes] = True
        held[problem.supports.nodes[(problem.supports.fixed[:, :3] == 1.0).all(axis=1)]] = True
        rods = list(range(len(problem.rods)))
        while rods:
            rod = next(one for one in rods if posed[self._nodes(one)].any())
            rods.remove(rod)
            self._chains.append(self._chain(system, rod, posed, held))
            posed[self._nodes(rod)] = True

    def _nodes(self, rod: int) -> Integers:
        stations = self.problem.stations
        nodes: Integers = stations.nodes[stations.rod == rod]
        return nodes

    def _chain(self, system: System, rod: int, posed: np.ndarray, held: np.ndarray) -> _Chain:
        problem, order = self.problem, int(self.problem.rod_orders[rod])
        nodes, links = self._nodes(rod), problem.stations.links[problem.stations.rod == rod]
        points = np.flatnonzero(system.gauss_positions().rod == rod).reshape(-1, order)
        width = np.repeat(np.diff(lobatto(order)[0]) / STEPS, STEPS)
        middle, offset = np.cumsum(width) - 1.0 - 0.5 * width, 0.5 / np.sqrt(3.0) * width
        weights = np.stack([_through(gauss(order)[0], place) for place in (middle - offset, middle + offset)])
        lengths = half_lengths(system, rod)[:, None] * width
        attached = np.tile(np.eye(4), (len(nodes), 1, 1))
        linked = links >= 0
        attached[linked] = _matrices(
            problem.link_positions[links[linked]], problem.link_quaternions[links[linked]]
        )
        known = np.flatnonzero(posed[nodes])
        again = np.flatnonzero(posed[nodes] | held[nodes])
        chain = _Chain(
            points,
            weights,
            lengths,
            nodes,
            attached,
            _inverse(attached),
            int(known[0]),
            np.flatnonzero(~posed[nodes]),
            again[again != known[0]],
            np.tile(np.eye(4), (len(nodes), 1, 1)),
        )
        stations = self._unmoved[nodes] @ attached
        relative = _inverse(stations[:1]) @ stations
        return replace(chain, offsets=_inverse(chain.along(self._reference[None])[0]) @ relative)

    def poses(self, strain: Floats, r0: Floats, q0: Floats, near: Floats) -> tuple[Floats, Floats, float]:
        """Return the poses of all nodes, and by how much [m] loops are open at most, and held places missed.

        Args:
            strain: of the sections ``(s, m, 6)``; r0, q0: poses of the roots ``(s, roots, 3)``, ``(s, roots, 4)``.
            near: quaternions ``(n, 4)`` to which those that are returned are near, of the two of a rotation.

        Returns:
            ``(s, n, 3)``, ``(s, n, 4)`` and the distance.
        """
        T, gap = np.tile(self._unmoved, (len(strain), 1, 1, 1)), 0.0
        T[:, self._root_nodes] = _matrices(r0, q0)
        total = self._reference + strain
        for chain in self._chains:
            own, at = chain.along(total) @ chain.offsets, slice(chain.first, chain.first + 1)
            begin = T[:, chain.nodes[at]] @ chain.links[at] @ _inverse(own[:, at])
            nodal = begin @ own @ chain.back
            if len(chain.again):
                missed = nodal[:, chain.again, :3, 3] - T[:, chain.nodes[chain.again], :3, 3]
                gap = max(gap, float(np.abs(missed).max()))
            T[:, chain.nodes[chain.new]] = nodal[:, chain.new]
        q = from_matrices(T[..., :3, :3].reshape(-1, 3, 3)).reshape(*T.shape[:2], 4)
        q[np.einsum("sni,ni->sn", q, near) < 0.0] *= -1.0
        return T[..., :3, 3].copy(), q, gap


def _exponential(X: Floats) -> Floats:
    """Return the poses of constant motions ``[[w~, v], [0, 0]]``, ``(..., 4, 4)``: ``I + X + b X^2 + c X^3``."""
    square = X[..., 2, 1] ** 2 + X[..., 0, 2] ** 2 + X[..., 1, 0] ** 2
    small = square < 1e-4
    angle = np.sqrt(np.where(small, 1.0, square))
    b = np.where(small, 0.5 - square / 24.0 + square**2 / 720.0, 2.0 * (np.sin(0.5 * angle) / angle) ** 2)
    c = np.where(small, 1.0 / 6.0 - square / 120.0 + square**2 / 5040.0, (angle - np.sin(angle)) / angle**3)
    X2 = X @ X
    return np.asarray(np.eye(4) + X + b[..., None, None] * X2 + c[..., None, None] * (X2 @ X))


def _matrices(r: Floats, q: Floats) -> Floats:
    """Return poses as matrices ``(..., 4, 4)``."""
    out = np.zeros((*r.shape[:-1], 4, 4))
    out[..., :3, :3] = matrices(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3, 3)
    out[..., :3, 3], out[..., 3, 3] = r, 1.0
    return out


def _inverse(T: Floats) -> Floats:
    """Return the inverse of poses ``(..., 4, 4)``."""
    out = np.zeros_like(T)
    out[..., :3, :3] = np.swapaxes(T[..., :3, :3], -1, -2)
    out[..., :3, 3] = -(out[..., :3, :3] @ T[..., :3, 3:])[..., 0]
    out[..., 3, 3] = 1.0
    return out


def _roots(problem: Problem) -> tuple[Root, ...]:
    """Return one node of every part that rods connect: where it is held best."""
    label = np.arange(problem.size)
    stations = problem.stations
    for rod in range(len(problem.rods)):
        nodes = stations.nodes[stations.rod == rod]
        for other in np.unique(label[nodes])[1:]:
            label[label == other] = label[nodes].min()
    held = {
        int(node): fixed for node, fixed in zip(problem.supports.nodes, problem.supports.fixed, strict=True)
    }
    roots = []
    for part in np.unique(label):
        nodes = np.flatnonzero(label == part)
        score = [
            float(held[int(n)].sum() + 10.0 * held[int(n)][:3].all()) if int(n) in held else 0.0
            for n in nodes
        ]
        node = int(nodes[int(np.argmax(score))])
        fixed = held.get(node, np.zeros(6))
        roots.append(Root(node, bool(fixed.all()), bool(fixed[:3].all())))
    return tuple(roots)


def _through(points: Floats, xi: Floats) -> Floats:
    """Return the Lagrange polynomials on ``points (g,)`` at ``xi (k,)``: ``(k, g)``."""
    values = np.ones((len(xi), len(points)))
    for g, point in enumerate(points):
        for other in np.delete(points, g):
            values[:, g] *= (xi - other) / (point - other)
    return values
