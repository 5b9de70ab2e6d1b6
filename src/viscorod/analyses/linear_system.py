"""Linear systems: a model made linear about a state, with inputs and outputs, as matrices."""

from __future__ import annotations

import json

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.linear_about import linear_about
from viscorod.results.linear_system import LinearSystem
from viscorod.solve.linear_systems.second_order import second_order
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.response import LinearSettings
from viscorod.typing import Integers

__all__ = ["linear_system"]


def linear_system(discrete: DiscreteModel, settings: LinearSettings) -> LinearSystem:
    """Make a model linear; see ``Model.linear``."""
    about = linear_about(discrete, settings, measured=False)
    small, problem = about.small, discrete.problem
    matrices, Z = second_order(small, about.inputs, about.readings)
    motions = tuple(small.dof_names(_node_names(problem)))
    names = motions if Z is None else tuple(f"combination {k + 1}" for k in range(Z.shape[1]))
    return LinearSystem(
        matrices,
        tuple(one.label for one in settings.inputs),
        tuple(one.label for one in settings.outputs),
        tuple(one.unit for one in settings.inputs),
        tuple(one.unit for one in settings.outputs),
        names,
        motions,
        Z,
        None if small.gradients is None else small.gradients @ small.free,
        {} if Z is not None else _ends(problem, small.free_places),
        about.text,
        discrete.options.title,
        len(about.loose),
        (*json.loads(discrete.attributes["doubts"]), *about.notes),
    )


def _node_names(problem: Problem) -> list[str]:
    """Return the names of all nodes: the first station or body that each is."""
    found = [""] * problem.size
    stations = problem.stations
    ends = problem.rod_lengths
    for rod, s, node in zip(stations.rod, stations.s, stations.nodes, strict=True):
        place = "start" if s == 0.0 else "end" if s >= ends[rod] * (1.0 - 1e-12) else ""
        name = f"{problem.rods[rod]}.{place}" if place else f"{problem.rods[rod]}@{s:.6g}"
        found[node] = found[node] or name
    for name, node in zip(problem.bodies.names, problem.bodies.nodes, strict=True):
        if "." not in name:
            found[node] = name
    return found


def _ends(problem: Problem, places: Integers) -> dict[str, Integers]:
    """Return the coordinates of both ends of every rod, as far as supports leave them free."""
    found, stations = {}, problem.stations
    for number, name in enumerate(problem.rods):
        mine = np.flatnonzero(stations.rod == number)
        first, last = mine[np.argmin(stations.s[mine])], mine[np.argmax(stations.s[mine])]
        nodes = stations.nodes[[first, last]]
        found[name] = np.flatnonzero(np.isin(places // 6, nodes)).astype(np.int64)
    return found
