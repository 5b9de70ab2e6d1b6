"""The poses of all nodes from the strains along the rods and the poses of a few nodes from which these begin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from viscorod.mechanics.elements.basis import gauss, lobatto
from viscorod.mechanics.elements.poses_from_strains import bracket, exponential, rotated
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.solve.formulations.system import System
from viscorod.solve.problem.problem import Problem
from viscorod.solve.transient.pose_check import half_lengths
from viscorod.typing import Floats, Integers

__all__ = ["Root", "ShapeFromStrains"]

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
    """A rod that is reached at one of its stations.

    Attributes:
        stations: numbers of its stations, in order of arc length; nodes: theirs.
        points: which Gauss points are its own.
        weights: from the strains at an element's Gauss points to those at the places of the steps ``(2, steps, g)``.
        lengths: of the steps, element by element ``(e, steps)`` [m].
        first: the station at which it is reached, by its number along the rod.
        new, again: stations whose nodes nothing else poses, and those reached twice or held, but the first.
        turns, offsets: from the poses that reference strains make to those of the reference shape.
    """

    stations: Integers
    nodes: Integers
    points: Integers
    weights: Floats
    lengths: Floats
    first: int
    new: Integers
    again: Integers
    offsets: Floats
    turns: Floats


def joined(r: Floats, q: Floats, d: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """Return poses ``(d, turn)`` that are given in the frames of others ``(r, q)``, component by component.

    The arrays are small: ``np.cross`` would take five times as long.
    """
    w, x, y, z = (q[..., i] for i in range(4))
    a, b, c = (d[..., i] for i in range(3))
    u, v, s = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    moved = np.stack(
        [a + w * u + y * s - z * v, b + w * v + z * u - x * s, c + w * s + x * v - y * u], axis=-1
    )
    return r + moved, product(q, turn)


def inverse(r: Floats, q: Floats) -> tuple[Floats, Floats]:
    """Return the poses of the frames in which poses ``(r, q)`` are given, seen from there."""
    back = conjugate(q)
    return -rotated(back, r), back


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
        reference = system.elements().reference.reshape(-1, 6)[system.gauss_indices()]
        self._reference = reference
        self._r0, self._q0 = problem.positions, problem.quaternions
        self._chains: list[_Chain] = []
        self._order(system)

    # --- where rods begin

    def _order(self, system: System) -> None:
        problem, rods = self.problem, set(range(len(self.problem.rods)))
        posed = np.zeros(problem.size, dtype=bool)
        posed[[root.node for root in self.roots]] = True
        held = np.zeros(problem.size, dtype=bool)
        held[problem.supports.nodes[(problem.supports.fixed[:, :3] == 1.0).all(axis=1)]] = True
        while rods:
            for rod in sorted(rods):
                stations = np.flatnonzero(problem.stations.rod == rod)
                nodes = problem.stations.nodes[stations]
                known = np.flatnonzero(posed[nodes])
                if len(known):
                    again = np.flatnonzero(posed[nodes] | held[nodes])
                    seen = np.flatnonzero(~posed[nodes]), again[again != known[0]]
                    self._chains.append(self._chain(system, rod, stations, int(known[0]), seen))
                    posed[nodes] = True
                    rods.remove(rod)
                    break
            else:
                raise AssertionError("rods without a root")

    def _chain(
        self, system: System, rod: int, stations: Integers, first: int, seen: tuple[Integers, Integers]
    ) -> _Chain:
        problem, order = self.problem, int(self.problem.rod_orders[rod])
        points = np.flatnonzero(system.gauss_positions().rod == rod)
        at = gauss(order)[0]
        width = np.repeat(np.diff(lobatto(order)[0]) / STEPS, STEPS)
        begin = np.append(-1.0, -1.0 + np.cumsum(width)[:-1])
        middle, offset = begin + 0.5 * width, 0.5 / np.sqrt(3.0) * width
        weights = np.stack([_through(at, middle - offset), _through(at, middle + offset)])
        lengths = half_lengths(system, rod)[:, None] * width
        none = np.zeros((len(stations), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(stations), 1))
        nodes = problem.stations.nodes[stations]
        chain = _Chain(stations, nodes, points, weights, lengths, first, *seen, *none)
        d, turn = self._along(chain, self._reference[None])
        r0, q0 = self._stations(chain, self._r0[None], self._q0[None])
        r0, q0 = joined(*inverse(r0[:, :1], q0[:, :1]), r0, q0)
        offsets, turns = joined(*inverse(d, turn), r0, q0)
        return replace(chain, offsets=offsets[0], turns=turns[0])

    def _stations(self, chain: _Chain, r: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return the poses of a rod's stations from those of its nodes ``(s, n, ...)``."""
        problem, links = self.problem, self.problem.stations.links[chain.stations]
        r, q = r[:, chain.nodes].copy(), q[:, chain.nodes].copy()
        linked = links >= 0
        if linked.any():
            k = links[linked]
            link = problem.link_positions[k], problem.link_quaternions[k]
            r[:, linked], q[:, linked] = joined(r[:, linked], q[:, linked], *link)
        return r, q

    # --- poses

    def _along(self, chain: _Chain, strain: Floats) -> tuple[Floats, Floats]:
        """Return the poses of a rod's stations, seen from its start, of total strains ``(s, m, 6)``."""
        count, steps = chain.lengths.shape
        order = steps // STEPS
        own = strain[:, chain.points].reshape(len(strain), count, order, 6)
        first, second = np.einsum("akg,segi->aseki", chain.weights, own)
        h = chain.lengths[..., None]
        motion = 0.5 * h * (first + second) + np.sqrt(3.0) / 12.0 * h**2 * bracket(first, second)
        d, turn = exponential(motion.reshape(len(strain), count * steps, 6))
        reach = 1
        while reach < count * steps:  # products of neighbours, of these with theirs, and so on
            further = joined(d[:, :-reach], turn[:, :-reach], d[:, reach:], turn[:, reach:])
            d[:, reach:], turn[:, reach:] = further
            reach *= 2
        d, turn = d[:, STEPS - 1 :: STEPS], turn[:, STEPS - 1 :: STEPS]
        start = np.zeros((len(strain), 1, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(strain), 1, 1))
        return np.concatenate([start[0], d], axis=1), np.concatenate([start[1], turn], axis=1)

    def poses(self, strain: Floats, r0: Floats, q0: Floats) -> tuple[Floats, Floats, float]:
        """Return the poses of all nodes, and by how much [m] loops are open at most, and held places missed.

        Args:
            strain: of the sections ``(s, m, 6)``; r0, q0: poses of the roots ``(s, roots, 3)``, ``(s, roots, 4)``.

        Returns:
            ``(s, n, 3)``, ``(s, n, 4)`` and the distance.
        """
        problem, states, gap = self.problem, len(strain), 0.0
        r = np.tile(problem.positions, (states, 1, 1))
        q = np.tile(problem.quaternions, (states, 1, 1))
        for k, root in enumerate(self.roots):
            r[:, root.node], q[:, root.node] = r0[:, k], q0[:, k]
        total = self._reference + strain
        for chain in self._chains:
            d, turn = self._along(chain, total)
            d, turn = joined(d, turn, chain.offsets, chain.turns)
            there, at = self._stations(chain, r, q), slice(chain.first, chain.first + 1)
            begin = joined(there[0][:, at], there[1][:, at], *inverse(d[:, at], turn[:, at]))
            nodal = self._nodes(chain, *joined(*begin, d, turn))
            if len(chain.again):
                missed = nodal[0][:, chain.again] - r[:, chain.nodes[chain.again]]
                gap = max(gap, float(np.abs(missed).max()))
            new = chain.nodes[chain.new]
            r[:, new], q[:, new] = nodal[0][:, chain.new], nodal[1][:, chain.new]
        return r, q, gap

    def _nodes(self, chain: _Chain, r: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return the poses of the nodes of a rod's stations."""
        problem, links = self.problem, self.problem.stations.links[chain.stations]
        linked = links >= 0
        if linked.any():
            k = links[linked]
            back = inverse(problem.link_positions[k], problem.link_quaternions[k])
            r[:, linked], q[:, linked] = joined(r[:, linked], q[:, linked], *back)
        return r, q


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
