"""From rods to elements and nodes: where elements end, which nodes rods share, and how nodes are numbered."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.elements.basis import gauss, gauss_table, lobatto
from viscorod.mechanics.elements.section_laws import SectionLaws, law_address
from viscorod.mechanics.nodes.attached_poses import link_map
from viscorod.mechanics.rotations.quaternion import conjugate, from_matrices, matrices, product
from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.rod import Rod
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.problem.division import Division
from viscorod.solve.problem.problem import ElementSet, Stations
from viscorod.typing import Floats, Integers

NONE = np.zeros(0, dtype=np.int64)
"""Numbers of a model without rods."""


@dataclass(frozen=True)
class RodMesh:
    """One rod divided: element ends, node stations, reference poses."""

    name: str
    rod: Rod
    order: int
    ends: Floats
    s: Floats
    positions: Floats
    quaternions: Floats

    def node_at(self, s: float) -> int | None:
        """Return the index (within the rod) of the node at arc length ``s`` [m], or None between nodes."""
        node = int(np.argmin(np.abs(self.s - s)))
        return node if abs(self.s[node] - s) <= 1e-9 * self.rod.length else None


@dataclass(frozen=True)
class Mesh:
    """All rods divided and joined.

    ``shared[i][k]`` is the node of station k of rod i and ``links[i][k]`` its attachment (or -1), see ``ElementSet``;
    ``body_nodes`` and ``body_links`` are those of the rigid bodies, whose nodes are the first. Of several bodies that
    are attached to each other, the first one has the node.
    """

    rods: tuple[RodMesh, ...]
    bodies: tuple[AnyBody, ...]
    shared: tuple[Integers, ...]
    links: tuple[Integers, ...]
    body_nodes: Integers
    body_links: Integers
    positions: Floats
    quaternions: Floats
    link_positions: Floats
    link_quaternions: Floats

    @cached_property
    def _index(self) -> dict[str, int]:
        return {mesh.name: i for i, mesh in enumerate(self.rods)}

    def rod_index(self, name: str) -> int:
        """Return the index of a rod by name."""
        return self._index[name]


def divide(name: str, rod: Rod, division: Division) -> RodMesh:
    """Put nodes on the elements of a rod.

    Raises:
        InputError: there are too few elements for the turns of the reference shape.
    """
    order, ends = division.order, division.ends
    inner = 0.5 * (lobatto(order)[0] + 1.0)
    s = (ends[:-1, None] + np.diff(ends)[:, None] * inner[None, :-1]).ravel()
    s = np.append(s, rod.length)
    _require_turns(name, rod, s, len(ends) - 1)
    positions, frames = rod.frames(s)
    return RodMesh(name, rod, order, ends, s, positions, from_matrices(frames))


def _require_turns(name: str, rod: Rod, s: Floats, count: int) -> None:
    """Refuse nodes between which the frame turns so far that it might as well have turned the other way."""
    turn = np.diff(rod.turned(s))
    worst = int(np.argmax(turn))
    if turn[worst] >= np.pi:
        needed = int(np.ceil(count * turn[worst]))
        given = rod.elements is not None
        raise InputError(
            Fault(
                f"rods.{name}.elements",
                str(rod.elements) if given else "",
                f"too few: between the nodes at s = {s[worst]:.6g} and {s[worst + 1]:.6g} m the reference shape turns "
                f"by {turn[worst]:.3g} rad, and beyond half a turn an element cannot tell which way",
                f"give at least {needed}{', or leave it out' if given else ''}",
            )
        )


def join(rods: list[RodMesh], bodies: list[AnyBody], attachments: list[tuple[int, int]]) -> Mesh:
    """Number the nodes, bodies first, then rod by rod; what is attached shares one node with a constant relative pose.

    Args:
        rods: divided rods; bodies: rigid bodies.
        attachments: pairs of numbers: bodies, then the stations of all rods.
    """
    first = len(bodies) + np.cumsum([0, *(len(mesh.s) for mesh in rods)])
    total = int(first[-1])
    centres = np.array([body.position() for body in bodies]).reshape(-1, 3)
    frames = np.array([body.frame() for body in bodies]).reshape(-1, 3, 3)
    positions = np.concatenate([centres, *(mesh.positions for mesh in rods)])
    quaternions = np.concatenate([from_matrices(frames), *(mesh.quaternions for mesh in rods)])
    root = _first_of_each(total, attachments)
    keep, number = np.unique(root, return_inverse=True)
    links = -np.ones(total, dtype=np.int64)
    attached = np.flatnonzero(root != np.arange(total))
    links[attached] = np.arange(len(attached))
    back = conjugate(quaternions[root[attached]])
    arms = positions[attached] - positions[root[attached]]
    return Mesh(
        rods=tuple(rods),
        bodies=tuple(bodies),
        shared=tuple(np.ascontiguousarray(number[first[i] : first[i + 1]]) for i in range(len(rods))),
        links=tuple(np.ascontiguousarray(links[first[i] : first[i + 1]]) for i in range(len(rods))),
        body_nodes=number[: len(bodies)],
        body_links=links[: len(bodies)],
        positions=np.ascontiguousarray(positions[keep]),
        quaternions=np.ascontiguousarray(quaternions[keep]),
        link_positions=np.ascontiguousarray((matrices(back) @ arms[:, :, None])[:, :, 0]),
        link_quaternions=product(back, quaternions[attached]),
    )


def _first_of_each(total: int, pairs: list[tuple[int, int]]) -> Integers:
    """Return the lowest of all numbers that pairs connect with each number below ``total``."""
    first = list(range(total))

    def lowest(k: int) -> int:
        while first[k] != k:
            first[k] = first[first[k]]
            k = first[k]
        return k

    for a, b in pairs:
        low, high = sorted((lowest(a), lowest(b)))
        first[high] = low
    return np.array([lowest(k) for k in range(total)], dtype=np.int64)


def element_nodes(nodes: Integers, order: int) -> Integers:
    """Arrange the nodes of a rod by element ``(elements, order + 1)``."""
    count = (len(nodes) - 1) // order
    return np.ascontiguousarray(nodes[order * np.arange(count)[:, None] + np.arange(order + 1)[None, :]])


def stations_of(mesh: Mesh) -> Stations:
    """Return all element nodes, rod by rod."""
    return Stations(
        rod=np.concatenate([NONE, *(np.full(len(m.s), i) for i, m in enumerate(mesh.rods))]),
        s=np.concatenate([np.zeros(0), *(m.s for m in mesh.rods)]),
        nodes=np.concatenate([NONE, *mesh.shared]),
        links=np.concatenate([NONE, *mesh.links]),
    )


class SectionTable:
    """Distinct section matrices, each stored once."""

    def __init__(self) -> None:
        self._index: dict[bytes, int] = {}
        self.stiffness: list[Floats] = []
        self.damping: list[Floats] = []
        self.held: list[Floats] = []
        self.branches: list[dict[float, Floats]] = []
        self.laws: list[tuple[int, Floats]] = []

    def add(self, rod: Rod, s: float, held: Floats) -> int:
        """Return the index of a rod's section without what ``held (6,)`` marks: multipliers give those forces."""
        stiffness, damping, _ = rod.matrices_at(s)
        times, branches = rod.branches_at(s)
        address, parameters = (0, np.zeros(0)) if rod.law is None else self._law(rod.law, stiffness)
        key = b"".join(array.tobytes() for array in (stiffness, damping, times, branches, held, parameters))
        key += address.to_bytes(8)
        if key not in self._index:
            self._index[key] = len(self.stiffness)
            free = np.outer(1.0 - held, 1.0 - held)
            self.stiffness.append(free * stiffness)
            self.damping.append(free * damping)
            self.held.append(held)
            self.laws.append((address, parameters))
            own: dict[float, Floats] = {}
            for time, branch in zip(times.tolist(), branches, strict=True):
                own[time] = own.get(time, 0.0) + free * branch
            self.branches.append(own)
        return self._index[key]

    @staticmethod
    def _law(law: AnySectionLaw, stiffness: Floats) -> tuple[int, Floats]:
        return law_address(law.respond), np.asarray(law.parameters(stiffness), dtype=float)

    def branches_of(self, times: list[float]) -> Floats:
        """Return the stiffnesses of Maxwell branches with these relaxation times ``(sections, n, 6, 6)``."""
        none = np.zeros((6, 6))
        found = [own.get(time, none) for own in self.branches for time in times]
        return np.array(found).reshape(len(self.branches), len(times), 6, 6)


@dataclass(frozen=True)
class SetPlaces:
    """Where the elements of one order are: what of an ``ElementSet`` does not depend on sections and materials.

    ``rods`` are the indices of their rods, in this order; the other fields are those of ``ElementSet``.
    """

    order: int
    rods: tuple[int, ...]
    nodes: Integers
    links: Integers
    slots: Integers
    rod: Integers
    start: Floats
    half_lengths: Floats
    shapes: Floats
    slopes: Floats
    weights: Floats


def set_places(mesh: Mesh, pattern: Pattern) -> tuple[SetPlaces, ...]:
    """Return where elements are, by order."""
    found = []
    # rigid bodies alone have one set without elements, so that compiled code sees what it always sees
    for order in sorted({m.order for m in mesh.rods}) or [1]:
        rods = tuple(i for i, m in enumerate(mesh.rods) if m.order == order)
        ends = [mesh.rods[i].ends for i in rods]
        none = np.zeros((0, order + 1), dtype=np.int64)
        nodes = np.concatenate([none, *(element_nodes(mesh.shared[i], order) for i in rods)])
        shapes, slopes = gauss_table(order)
        found.append(
            SetPlaces(
                order=order,
                rods=rods,
                nodes=nodes,
                links=np.concatenate([none, *(element_nodes(mesh.links[i], order) for i in rods)]),
                slots=pattern.slots(nodes),
                rod=np.concatenate(
                    [NONE, *(np.full(len(s) - 1, i) for i, s in zip(rods, ends, strict=True))]
                ),
                start=np.concatenate([np.zeros(0), *(s[:-1] for s in ends)]),
                half_lengths=np.concatenate([np.zeros(0), *(0.5 * np.diff(s) for s in ends)]),
                shapes=shapes,
                slopes=slopes,
                weights=gauss(order)[1],
            )
        )
    return tuple(found)


def element_sets(mesh: Mesh, places: tuple[SetPlaces, ...]) -> tuple[tuple[ElementSet, ...], Floats, Floats]:
    """Return element arrays by order, nodal masses ``(n, 6, 6)`` lumped at Gauss-Lobatto nodes, relaxation times."""
    mass = np.zeros((len(mesh.positions), 6, 6))
    for body, node, link in zip(mesh.bodies, mesh.body_nodes, mesh.body_links, strict=True):
        own = body.mass_matrix()
        mass[node] += own if link < 0 else _moved(own, mesh, int(link))
    tables: list[SectionTable] = []
    numbers: list[tuple[Integers, Floats]] = []
    for where in places:
        table = SectionTable()
        section = np.empty((len(where.nodes), where.order), dtype=np.int64)
        widths = np.empty(section.shape)
        first = 0
        for i in where.rods:
            mine = slice(first, first + len(mesh.rods[i].ends) - 1)
            section[mine], widths[mine], lumped = _sections_along(mesh.rods[i].rod, where, mine, table)
            if len(mesh.link_positions):
                links = where.links[mine]
                for e, k in zip(*np.nonzero(links >= 0), strict=True):
                    lumped[e, k] = _moved(lumped[e, k], mesh, int(links[e, k]))
            np.add.at(mass, where.nodes[mine], lumped)
            first = mine.stop
        tables.append(table)
        numbers.append((section, widths))
    # branches of one time are one branch, whatever rods they are in
    times = sorted({time for table in tables for own in table.branches for time in own})
    sets = [
        ElementSet(
            order=where.order,
            nodes=where.nodes,
            links=where.links,
            slots=where.slots,
            rod=where.rod,
            start=where.start,
            half_lengths=where.half_lengths,
            shapes=where.shapes,
            slopes=where.slopes,
            weights=where.weights,
            section=section,
            half_widths=widths,
            stiffness=np.reshape(table.stiffness, (-1, 6, 6)),
            damping=np.reshape(table.damping, (-1, 6, 6)),
            held=np.reshape(table.held, (-1, 6)),
            branches=table.branches_of(times),
            laws=SectionLaws.of(table.laws, np.reshape(table.held, (-1, 6))),
        )
        for where, table, (section, widths) in zip(places, tables, numbers, strict=True)
    ]
    return tuple(sets), mass, np.array(times)


def _sections_along(
    rod: Rod, where: SetPlaces, mine: slice, table: SectionTable
) -> tuple[Integers, Floats, Floats]:
    """Return the sections of a rod and their half widths at the Gauss points of its elements, and lumped masses."""
    order = where.order
    start, half = where.start[mine], where.half_lengths[mine]
    section = np.empty((len(start), order), dtype=np.int64)
    widths = np.empty((len(start), order))
    nodes, lumps = lobatto(order)
    held = np.array(rod.constrained_strains, dtype=float)
    if rod.uniform:
        section[:] = table.add(rod, 0.0, held)
        widths[:] = rod.section_at(0.0).half_width or 0.0
        mass_per_length = rod.matrices_at(0.0)[2]
        return section, widths, half[:, None, None, None] * lumps[:, None, None] * mass_per_length
    points = gauss(order)[0]
    lumped = np.empty((len(start), order + 1, 6, 6))
    middle = start + half
    for e in range(len(start)):
        for g in range(order):
            s = middle[e] + half[e] * points[g]
            section[e, g] = table.add(rod, s, held)
            widths[e, g] = rod.section_at(s).half_width or 0.0
        for k in range(order + 1):
            # just inside the element: the section may change at its end
            inside = middle[e] + half[e] * nodes[k] * (1.0 - 1e-9)
            lumped[e, k] = half[e] * lumps[k] * rod.matrices_at(inside)[2]
    return section, widths, lumped


def link_matrix(mesh: Mesh, link: int) -> Floats:
    """Return the body increment of an attached end per increment of the shared node ``(6, 6)``."""
    X = np.empty((6, 6))
    link_map(mesh.link_positions[link], mesh.link_quaternions[link], X)
    return X


def _moved(mass: Floats, mesh: Mesh, link: int) -> Floats:
    X = link_matrix(mesh, link)
    return np.asarray(X.T @ mass @ X)
