"""Where in a model a block row of its equations belongs, in words."""

from __future__ import annotations

import numpy as np

from viscorod.solve.problem.problem import Problem

__all__ = ["describe_node"]


def describe_node(problem: Problem, node: int) -> str:
    """Describe a node by its rod, element and arc length or by its body, and a row of multipliers by what it holds."""
    if node >= problem.size:
        return _describe_multipliers(problem, node - problem.size)
    stations, bodies = problem.stations, problem.bodies
    if node in bodies.nodes:
        return f"body '{bodies.names[int(np.argmax(bodies.nodes == node))]}'"
    at = int(np.argmax(stations.nodes == node))
    rod, s = int(stations.rod[at]), float(stations.s[at])
    starts = np.sort(np.concatenate([e.start[e.rod == rod] for e in problem.sets]))
    element = int(np.searchsorted(starts, s, side="right"))
    return f"rod '{problem.rods[rod]}', element {element}, s = {s:.6g} m"


def _describe_multipliers(problem: Problem, row: int) -> str:
    joint = np.flatnonzero(problem.joints.row == row)
    if len(joint):
        return f"joint '{problem.joints.names[joint[0]]}'"
    element = int(problem.held.element[np.argmax(problem.held.place // 6 == row)])
    rods = np.concatenate([e.rod for e in problem.sets])
    starts = np.concatenate([e.start for e in problem.sets])
    rod = rods[element]
    number = 1 + np.count_nonzero(starts[rods == rod] < starts[element])
    return f"held strains of rod '{problem.rods[rod]}', element {number}"
