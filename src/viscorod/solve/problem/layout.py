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
from viscorod.model.connections.resolved_places import find, size_of
from viscorod.model.connections.support_base import ResolvedSupport
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.constraints.strain_multipliers import multiplier_cliques
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.problem.chosen_divisions import alike_divided, chosen_divisions
from viscorod.solve.problem.division import Divisions
from viscorod.solve.problem.joint_set import JointSet, joint_set
from viscorod.solve.problem.mesh import Mesh, SetPlaces, divide, element_nodes, join, set_places, stations_of
from viscorod.solve.problem.model_parts import Alike, computed, part_token, shape_token, token
from viscorod.solve.problem.placement import MeshPlace, Placement
from viscorod.solve.problem.problem import Bodies, Stations, SupportSet
from viscorod.typing import Integers

__all__ = ["Layout", "chosen_layout", "layout_of"]

MOST_NODES = 2_000
"""Nodes of a model beyond which its layout is not kept: it is a small part of the work then."""
KEPT = 8
"""Layouts that are kept, those that were used last."""


@dataclass(frozen=True)
class Layout:
    """See the fields of the same names of :class:`~viscorod.solve.problem.problem.Problem`.

    Attributes:
        first_held: block row of the first multiplier of held strains.
        sets: where elements are, by order.
        spots: stations of rods whose nodes were sought, by index of the rod and arc length [m].
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
    sets: tuple[SetPlaces, ...]
    spots: dict[tuple[int, float], MeshPlace | None] = field(default_factory=dict, compare=False, repr=False)
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
    if not _is_kept(model, divisions):
        return _laid_out(model, divisions)
    return _kept(Alike((model, divisions), _parts(model, divisions)))


def chosen_layout(model: ModelDescription) -> Layout:
    """Return the layout of a model whose rods are divided as they say or the program chooses.

    Raises:
        InputError: the mesh cannot satisfy the model.
    """
    known = alike_divided(model)
    found = None if known is None else _kept_as_chosen(known)
    return layout_of(model, chosen_divisions(model)) if found is None else found


def _is_kept(model: ModelDescription, divisions: Divisions) -> bool:
    """Return whether the layout of a model is kept: it is small, and no function says where its nodes are."""
    nodes = sum(division.order * division.count + 1 for division in divisions.values())
    return nodes + len(model.bodies) <= MOST_NODES and not any(map(computed, model.rods.values()))


def _parts(model: ModelDescription, divisions: Divisions) -> list[Any]:
    """Return what stands for all that the layout of a model depends on."""
    found: list[Any] = []
    for name, rod in model.rods.items():
        division = divisions[name]
        found += [name, division.order, division.ends.tobytes(), *map(token, shape_token(rod))]
    for name, body in model.bodies.items():
        found += [name, part_token(body)]
    for parts in (model.supports, model.attachments, model.joints, model.springs):
        found += [len(parts), *map(part_token, parts)]
    return found


@lru_cache(maxsize=KEPT)
def _kept(alike: Alike) -> Layout:
    return _laid_out(*alike.taken())


@lru_cache(maxsize=KEPT)
def _kept_as_chosen(alike: Alike) -> Layout | None:
    """Return the layout of models that are divided alike; None if it is not kept."""
    model = alike.taken()
    divisions = chosen_divisions(model)
    return layout_of(model, divisions) if _is_kept(model, divisions) else None


def _laid_out(model: ModelDescription, divisions: Divisions) -> Layout:
    mesh = _mesh(model, divisions)
    places = Placement(model, mesh)
    nodes = len(mesh.positions)
    length = size_of(model)
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
        sets=set_places(mesh, pattern),
        spots=places.spots,
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
    length = size_of(model)
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
