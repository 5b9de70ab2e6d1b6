"""The shape that given strains make of the reference shape: rods are integrated from their starts."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.poses_from_strains import along_rod
from viscorod.solve.formulations.system import State, System
from viscorod.solve.transient.pose_check import half_lengths
from viscorod.typing import Floats


def strain_rods(system: System, state: State) -> Floats:
    """Move ``state`` from the reference shape to that of the problem's initial strains.

    Returns:
        the strains at the Gauss points, in the order of results ``(m, 6)``.
    """
    problem, gauss = system.problem, system.gauss_positions()
    strain = np.zeros((len(gauss.s), 6))
    unstressed = system.elements().reference + system.imposed.driven(0.0)
    reference = unstressed.reshape(-1, 6)[system.gauss_indices()]
    for rod, field in problem.initial_strain.items():
        points, stations = gauss.rod == rod, problem.stations.rod == rod
        strain[points] = [field(float(s)) for s in gauss.s[points]]
        order, half = int(problem.rod_orders[rod]), half_lengths(system, rod)
        total = (reference + strain)[points].reshape(len(half), order, 6)
        nodes = problem.stations.nodes[stations]
        r, q = along_rod(order, half, total, state.r[nodes[0]], state.q[nodes[0]])
        state.r[nodes], state.q[nodes] = r, q
    return strain
