"""The arrays of a model whose rods have other materials or sections, where everything else stays as it is discretised.

Discretising a model anew takes four times as long, most of it for what is the same: nodes, supports, joints, a pattern.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.solve.history import StationReader
from viscorod.solve.once import once
from viscorod.solve.problem.division import Division, divisions_of
from viscorod.solve.problem.load_placing import place_loads
from viscorod.solve.problem.mesh import Mesh, RodMesh, divide, element_sets
from viscorod.solve.problem.placement import Placement
from viscorod.solve.problem.problem import Problem

__all__ = ["with_other_rods"]

OWN = ("material", "section")
"""Fields of rods that may differ."""
ROUNDING = 1e-14
"""Part of the length of a rod, and rotation, that positions are told apart by."""
UNKNOWN: Any = None


def with_other_rods(model: ModelDescription, problem: Problem, other: ModelDescription) -> Problem | None:
    """Return the problem of another model; None if its nodes might be elsewhere, or more than its rods is another.

    Args:
        model, problem: a model, discretised; other: the model with other numbers.
    """
    mine, its = model.parts(), other.parts()
    if model.bodies or not all(_same(mine[name], its[name]) for name in mine if name != "rods"):
        return None
    pairs = {name: (rod, other.rods.get(name)) for name, rod in model.rods.items()}
    if len(other.rods) != len(pairs) or not all(_alike(*pair) for pair in pairs.values()):
        return None
    mesh = _mesh(problem)
    rods = [replace(known, rod=rod) for known, rod in zip(mesh.rods, other.rods.values(), strict=True)]
    for known, before in zip(rods, model.rods.values(), strict=True):
        if known.rod is not before and not _in_place(known):
            return None
    mesh = replace(mesh, rods=tuple(rods))
    sets, mass, times = element_sets(mesh, problem.pattern)
    nodal, station, motion = place_loads(other, Placement(other, mesh))
    rest = tuple(
        (mesh.rod_index(strain.rod), strain.on(other.rods[strain.rod])) for strain in other.rest_strains
    )
    return replace(
        problem,
        sets=sets,
        mass=mass,
        relaxation_times=times,
        nodal_loads=nodal,
        station_loads=station,
        motion_loads=motion,
        rest_strains=rest,
    )


def _same(one: Any, other: Any) -> bool:
    """Return whether two tables or lists have the same entries, the very objects."""
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(one[key] is other[key] for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))
    return bool(one is other or one == other)


def _alike(rod: Rod, other: Rod | None) -> bool:
    """Return whether two rods differ in nothing but their materials and sections."""
    if other is None or type(rod) is not type(other):
        return False
    fields = (name for name in type(rod).model_fields if name not in OWN)
    return rod is other or all(getattr(rod, name) is getattr(other, name) for name in fields)


def _in_place(mesh: RodMesh) -> bool:
    """Return whether the sections of a rod at its nodes are where they were."""
    found = divide(mesh.name, mesh.rod, Division(mesh.order, mesh.ends))
    apart = np.abs(found.positions - mesh.positions).max()
    turned = 1.0 - np.abs(np.sum(found.quaternions * mesh.quaternions, axis=1)).min()
    return bool(apart <= ROUNDING * mesh.ends[-1] and turned <= ROUNDING)


@once
def _mesh(problem: Problem) -> Mesh:
    """Return the mesh of a problem without bodies, but for what its rods are."""
    stations, divisions, none = problem.stations, divisions_of(problem), np.zeros(0, dtype=np.int64)
    positions, quaternions = StationReader(problem).poses(problem.positions, problem.quaternions)
    rods, nodes, links = [], [], []
    for number, (name, division) in enumerate(divisions.items()):
        of = np.flatnonzero(stations.rod == number)
        poses = positions[of], quaternions[of]
        rods.append(RodMesh(name, UNKNOWN, division.order, division.ends, stations.s[of], *poses))
        nodes.append(stations.nodes[of])
        links.append(stations.links[of])
    return Mesh(
        rods=tuple(rods),
        bodies=(),
        shared=tuple(nodes),
        links=tuple(links),
        body_nodes=none,
        body_links=none,
        positions=problem.positions,
        quaternions=problem.quaternions,
        link_positions=problem.link_positions,
        link_quaternions=problem.link_quaternions,
    )
