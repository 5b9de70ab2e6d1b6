"""What is read off small motions: rows of displacements, strains, section forces and reactions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product
from viscorod.solve.formulations.system import System
from viscorod.solve.history import StationReader
from viscorod.solve.linear_systems.ports import Inputs
from viscorod.solve.linear_systems.small_motions import SmallMotions, global_axes
from viscorod.solve.settings.signals import Output
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats, Integers

__all__ = ["Reading", "Readings", "gauss_points_at", "readings_of", "supported_node"]


@dataclass(frozen=True)
class Reading:
    """An output with its place in the mesh.

    Attributes:
        output: what is read.
        stations: that take part ``(k,)``; weights: theirs ``(k,)``.
        rod: number of the rod, -1 on bodies; s: arc length [m].
    """

    output: Output
    stations: Integers
    weights: Floats
    rod: int
    s: float


@dataclass(frozen=True)
class Readings:
    """Outputs of small motions: ``sum_i c_i(s) R_i d + multipliers L + direct u``.

    Attributes:
        outputs: what is read.
        rows: ``R_i (outputs, 6 n)``, one for each coefficient of the small motions.
        multipliers: ``L (outputs, rows)``; direct: ``(outputs, inputs)``.
    """

    outputs: tuple[Output, ...]
    rows: tuple[sparse.csr_array, ...]
    multipliers: Floats
    direct: Floats


def readings_of(
    solver: StaticSolver, small: SmallMotions, readings: Sequence[Reading], inputs: Inputs
) -> Readings:
    """Return the rows of all outputs.

    Raises:
        InputError: what is wanted is not there, by name.
    """
    problem, count = small.problem, len(readings)
    conditions = 0 if small.gradients is None else small.gradients.shape[0]
    terms = len(small.coefficients)
    rows = [sparse.lil_array((count, 6 * problem.size)) for _ in range(terms)]
    multipliers, direct = np.zeros((count, conditions)), np.zeros((count, len(inputs.signals)))
    axes = global_axes(small.state)
    for k, reading in enumerate(readings):
        output = reading.output
        if output.quantity == "motion":
            rows[output.derivative][[k]] = _motion_row(small, reading)
        elif output.quantity == "reaction":
            node = supported_node(solver, output, k)
            j, R = output.component, axes[node]
            across = R[j % 3]
            own = slice(6 * node + 3 * (j // 3), 6 * node + 3 * (j // 3) + 3)
            for i in range(terms):
                rows[i][[k]] = sparse.csr_array(across @ small.nodal[i][own].toarray())[None]
            if small.gradients is not None:
                multipliers[k] = small.gradients[:, own].toarray() @ across
            direct[k] = -across @ inputs.force[own]
        else:
            points, weights = gauss_points_at(solver.system, reading, k)
            for g, weight in zip(points, weights, strict=True):
                place = 6 * int(g)
                if output.quantity == "strain":
                    rows[0][[k]] += weight * small.strains[[place + output.component]]
                    continue
                for i in range(terms):
                    section = small.section[i][g][output.component]
                    if section.any():
                        part = sparse.csr_array(section[None]) @ small.strains[place : place + 6]
                        rows[i][[k]] += weight * part
                multipliers[k] += weight * _held_force(solver.system, small, int(g), output.component)
    return Readings(
        tuple(r.output for r in readings), tuple(map(sparse.csr_array, rows)), multipliers, direct
    )


def _motion_row(small: SmallMotions, reading: Reading) -> sparse.csr_array:
    """Return the row of a displacement or a rotation, global axes, as the element interpolates it."""
    problem, state, j = small.problem, small.state, reading.output.component
    reader = StationReader(problem)
    row = np.zeros(6 * problem.size)
    nodes = reader.nodes[reading.stations]
    _, q, _, _ = reader.read(state.r, state.q, np.zeros((problem.size, 6)))
    q = q[reading.stations]
    signs = np.where(q @ q[0] < 0.0, -1.0, 1.0)[:, None]
    q = signs * q
    middle = reading.weights @ q
    size = float(middle @ middle)
    R = matrices((middle / np.sqrt(size))[None])[0]
    unit = np.zeros((problem.size, 6))
    for k, node in enumerate(nodes):
        for i in range(6):
            unit[node, i] = 1.0
            _, _, v, w = reader.read(state.r, state.q, unit)
            unit[node, i] = 0.0
            at = reading.stations[k]
            if j < 3:
                row[6 * node + i] += reading.weights[k] * v[at, j]
                continue
            rate = product(q[k], np.concatenate([[0.0], 0.5 * w[at]]))
            turned = 2.0 * product(conjugate(middle), rate)[1:] / size
            row[6 * node + i] += reading.weights[k] * (R @ turned)[j - 3]
    return sparse.csr_array(row[None])


def supported_node(solver: StaticSolver, output: Output, k: int) -> int:
    """Return the node of a support.

    Raises:
        InputError: there is none.
    """
    supports = solver.supports.set
    for number, name in enumerate(supports.names):
        if output.place in name.split(" + "):
            return int(supports.nodes[number])
    known = ", ".join(supports.names) or "none"
    raise InputError(
        Fault(f"outputs[{k}]", repr(output.label), "nothing is supported there", f"the supports are {known}")
    )


def gauss_points_at(system: System, reading: Reading, k: int) -> tuple[Integers, Floats]:
    """Return the Gauss points of the element at a place, and the weights of their polynomial there."""
    problem, places = system.problem, system.gauss_positions()
    if reading.rod < 0:
        raise InputError(
            Fault(
                f"outputs[{k}]",
                repr(reading.output.label),
                "a body has no strains",
                "give a place on a rod, or a motion",
            )
        )
    order = int(problem.rod_orders[reading.rod])
    mine = np.flatnonzero(places.rod == reading.rod)
    stations = problem.stations
    ends = np.sort(stations.s[stations.rod == reading.rod])[::order]
    slack = 1e-9 * (ends[-1] - ends[0])
    element = int(np.clip(np.searchsorted(ends, reading.s + slack, side="right") - 1, 0, len(ends) - 2))
    points = mine[element * order : (element + 1) * order]
    s = places.s[points]
    weights = np.ones(order)
    for a in range(order):
        others = np.delete(s, a)
        weights[a] = np.prod((reading.s - others) / (s[a] - others))
    return points, weights


def _held_force(system: System, small: SmallMotions, point: int, component: int) -> Floats:
    """Return the row of multipliers that is the force of a held strain at a Gauss point; zeros if it is not held."""
    held, row = small.problem.held, np.zeros(0 if small.gradients is None else small.gradients.shape[0])
    if not len(held.place):
        return row
    points = system.elements().reference.shape[1]
    number = int(system.gauss_indices()[point])
    mine = np.flatnonzero((held.element * points + held.point == number) & (held.component == component))
    for m in mine:
        at = int(np.searchsorted(system.constraints.used, held.place[m]))
        row[at] = 1.0 / (small.condition_scale[at] * held.weight[m])
    return row
