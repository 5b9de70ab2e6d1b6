"""Where the nodes of a model are, which of them couple, and what holds them: all of a problem but its numbers.

Members of a sweep that differ in materials, loads or settings have one layout, which is found once. A layout is found
again by the parts of the model that it comes from: by the same objects, not by equal ones, and by how rods are divided.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import AnyPlace, BodyPlace
from viscorod.model.connections.resolved_places import find
from viscorod.model.connections.support_base import ResolvedSupport
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.solve.constraints.strain_multipliers import multiplier_cliques
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.problem.division import Divisions
from viscorod.solve.problem.joint_set import JointSet, joint_set
from viscorod.solve.problem.mesh import Mesh, divide, element_nodes, join, stations_of
from viscorod.solve.problem.placement import Placement
from viscorod.solve.problem.problem import Bodies, Stations, SupportSet
from viscorod.typing import Integers

__all__ = ["Layout", "layout_of"]

MOST_NODES = 2_000
"""Nodes of a model beyond which its layout is not kept: it is a small part of the work then."""
KEPT = 8
"""Layouts that are kept, those that were used last."""


@dataclass(frozen=True)
class Layout:
    """See the fields of the same names of :class:`~viscorod.solve.problem.problem.Problem`.

    Attributes:
        first_held: block row of the first multiplier of held strains.
        found: what was found of this layout by :func:`~viscorod.solve.once.once_of_layout`, by name.
    """

    mesh: Mesh
    pattern: Pattern
    bodies: Bodies
    joints: JointSet
    multipliers: int
    first_held: int
    interiors: tuple[Integers, ...]
    supports: SupportSet
    stations: Stations
    length: float
    found: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.mesh.positions)

    def mesh_of(self, model: ModelDescription) -> Mesh:
        """Return the mesh with the rods of a model that has this layout."""
        mesh = self.mesh
        if all(one.rod is model.rods[one.name] for one in mesh.rods):
            return mesh
        return replace(mesh, rods=tuple(replace(one, rod=model.rods[one.name]) for one in mesh.rods))


def layout_of(model: ModelDescription, divisions: Divisions) -> Layout:
    """Return the layout of a model whose rods are divided so: that of an earlier one with the same, if it is kept.

    Raises:
        InputError: the mesh cannot satisfy the model.
    """
    nodes = sum(division.order * division.count + 1 for division in divisions.values())
    if nodes + len(model.bodies) > MOST_NODES or any(map(_computed, model.rods.values())):
        return _laid_out(model, divisions)
    return _kept(_Alike(model, divisions))


class _Alike:
    """A model and its divisions, equal to all whose layout comes from the same parts."""

    def __init__(self, model: ModelDescription, divisions: Divisions) -> None:
        self.given: tuple[ModelDescription, Divisions] | None = (model, divisions)
        self._parts: list[Any] = []
        for name, rod in model.rods.items():
            division = divisions[name]
            self._parts += [name, division.order, division.ends.tobytes(), *map(_token, _shape(rod))]
        for name, body in model.bodies.items():
            self._parts += [name, _part(body)]
        for parts in (model.supports, model.attachments, model.joints, model.springs):
            self._parts += [len(parts), *map(_part, parts)]
        self._number = hash(tuple(self._parts))

    def __hash__(self) -> int:
        return self._number

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Alike) and self._parts == other._parts


class _Same:
    """An object, equal to itself alone; it is kept, so that no other one takes its place."""

    def __init__(self, part: Any) -> None:
        self.part = part

    def __hash__(self) -> int:
        return id(self.part)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.part is other.part


def _part(part: Any) -> Any:
    """Return what stands for a part of a model: itself, and what its tables hold now, which its user may change."""
    tables = [value for value in getattr(part, "__dict__", {}).values() if isinstance(value, dict)]
    return _Same(part), *((key, _token(value)) for table in tables for key, value in table.items())


def _shape(rod: Rod) -> tuple[Any, ...]:
    """Return what of a rod its nodes depend on, and which strains it holds."""
    return rod.centreline, rod.d1, rod.turn, rod.tilt, rod.constrained_strains, rod.elements


def _computed(rod: Rod) -> bool:
    """Return whether the shape of a rod comes from functions of its user, who may want other values the next time."""
    return any(map(callable, (rod.turn, rod.tilt, *(value for _, value in rod.centreline))))


def _token(value: Any) -> Any:
    """Return what stands for a value: numbers to the last bit, other objects themselves."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if value is None or isinstance(value, bool | int | float | str):
        return repr(value)
    if isinstance(value, tuple):
        return tuple(map(_token, value))
    return _Same(value)


@lru_cache(maxsize=KEPT)
def _kept(alike: _Alike) -> Layout:
    assert alike.given is not None
    given, alike.given = alike.given, None  # sections and loads are not kept
    return _laid_out(*given)


def _laid_out(model: ModelDescription, divisions: Divisions) -> Layout:
    mesh = _mesh(model, divisions)
    places = Placement(model, mesh)
    nodes = len(mesh.positions)
    length = max(m.rod.length for m in mesh.rods)
    joints = joint_set(
        model.resolved_joints(),
        model.resolved_springs(),
        places.node,
        mesh.positions,
        mesh.quaternions,
        length,
    )
    held_members, held_rows = multiplier_cliques(mesh, nodes + joints.blocks)
    elements = [element_nodes(shared, m.order) for m, shared in zip(mesh.rods, mesh.shared, strict=True)]
    multipliers = joints.blocks + held_rows
    pattern = Pattern.of(nodes + multipliers, [*elements, *joints.cliques(nodes), *held_members])
    return Layout(
        mesh=mesh,
        pattern=pattern,
        bodies=places.bodies(),
        joints=joints.placed(pattern, nodes),
        multipliers=multipliers,
        first_held=nodes + joints.blocks,
        interiors=_interiors(mesh, elements),
        supports=_supports(model, places),
        stations=stations_of(mesh),
        length=length,
    )


def _mesh(model: ModelDescription, divisions: Divisions) -> Mesh:
    pairs = [(find(model, a.a), find(model, a.b)) for a in model.attachments]
    rods = [divide(name, rod, divisions[name]) for name, rod in model.rods.items()]
    bodies = {name: i for i, name in enumerate(model.bodies)}
    first = len(bodies) + np.cumsum([0, *(len(rod.s) for rod in rods)])
    index = {rod.name: i for i, rod in enumerate(rods)}

    def number(place: AnyPlace) -> int:
        if isinstance(place, BodyPlace):
            return bodies[place.body]
        node = rods[index[place.rod]].node_at(place.s)
        assert node is not None  # places of attachments are element ends
        return int(first[index[place.rod]]) + node

    return join(rods, list(model.bodies.values()), [(number(a), number(b)) for a, b in pairs])


def _interiors(mesh: Mesh, elements: list[Integers]) -> tuple[Integers, ...]:
    """Return the inner nodes of elements ``(elements, order - 1)``; where joints and supports act, elements end.

    Where strains are held, their multipliers keep the inner nodes in place: by themselves these have no stiffness.
    """
    return tuple(
        nodes[:, 1:-1].copy()
        for m, nodes in zip(mesh.rods, elements, strict=True)
        if m.order > 1 and not any(m.rod.constrained_strains)
    )


def _supports(model: ModelDescription, placement: Placement) -> SupportSet:
    resolved: dict[int, list[ResolvedSupport]] = {}
    places: dict[int, dict[str, None]] = {}
    length = max(rod.length for rod in model.rods.values())
    for index, support in enumerate(model.resolved_supports()):
        spot = placement.spot(support.place)
        assert spot is not None  # places of supports are element ends
        still = len(support.held) == len(MOTIONS) and not support.motion
        if np.abs(spot.arm).max() > 1e-9 * length and not still:
            raise InputError(
                Fault(
                    f"{support.path}.at",
                    support.label,
                    "the place is rigidly attached to a body whose centre is elsewhere",
                    "support the body at its centre, or use a joint to ground",
                )
            )
        places.setdefault(spot.node, {})[model.supports[index].at] = None
        resolved.setdefault(spot.node, []).append(support)
    nodes = np.array(sorted(resolved), dtype=np.int64)
    axes = np.empty((len(nodes), 3, 3))
    fixed = np.zeros((len(nodes), 6))
    motions: list[tuple[int, int, TimeFunction]] = []
    names = []
    for k, node in enumerate(nodes):
        group = resolved[int(node)]
        axes[k] = group[0].axes
        names.append(" + ".join(places[node]))
        for held in group:
            if np.abs(held.axes - axes[k]).max() > 1e-9:
                raise InputError(
                    Fault(
                        held.path,
                        held.label,
                        f"its axes differ from those of {group[0].label}, which holds the same place",
                        "hold the place by one support, or give both the same axes",
                    )
                )
            for word in held.held:
                fixed[k, MOTIONS.index(word)] = 1.0
            motions.extend((k, MOTIONS.index(word), motion) for word, motion in held.motion.items())
    return SupportSet(nodes, np.ascontiguousarray(axes), fixed, tuple(names), tuple(motions))
