"""Whether a motion that a symmetry keeps in its plane is unstable against motions out of it, and how fast these grow.

About a motion in a plane of symmetry, small motions in it and out of it do not couple. Out of it they obey
``M x'' + C x' + K x = 0`` with the stiffness K of the present stresses and loads; a squared rate ``k`` of
``K x = k M x`` below zero lets what there is grow by ``exp(sqrt(-k) t)``, less where it is damped (as a beam that is
bent beyond its lateral buckling load tilts).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy import sparse
from scipy.linalg.lapack import dpbtrf

from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.problem.mirror_plane import MirrorPlane
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

__all__ = ["growth_out_of_plane"]

MOST = 3e7
"""Products that a factorisation of a band may take; those of wider ones are sparse."""
LEAST = 1.0
"""Exponent by which a motion that lasts would have to grow to be looked at."""
HALVINGS = 4
"""Of the interval between two growth rates, one twice the other."""


def growth_out_of_plane(
    static: StaticSolver, plane: MirrorPlane, states: Sequence[tuple[float, Snapshot]]
) -> tuple[float, float]:
    """Return the exponent by which motions out of a plane grow in a motion, and when that begins.

    Args:
        static: solver of the problem; plane: in which the motion stays.
        states: of the motion, with their times [s], ascending from more than 0.

    Returns:
        the integral of the growth rate, by the trapezoidal rule between the states, rounded down by a few per cent; the
        time of the first state where there is one [s].
    """
    small = _SmallMotions(static, plane)
    times = np.array([t for t, _ in states])
    rates = np.array([_rate(small.unstable(t, state), LEAST / times[-1]) for t, state in states])
    growing = np.flatnonzero(rates)
    if not len(growing):
        return 0.0, 0.0
    exponent = rates[0] * times[0] + np.trapezoid(rates, times)
    return float(exponent), float(times[growing[0]])


def _rate(faster: Callable[[float], bool], least: float) -> float:
    """Return the largest rate [1/s] that something is ``faster`` than, nearly; 0 if it is below ``least``."""
    if not faster(least):
        return 0.0
    low = least
    while faster(2.0 * low):
        low *= 2.0
    high = 2.0 * low
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if faster(middle) else (low, middle)
    return low


class _SmallMotions:
    """Small motions out of a plane; displacements are measured in lengths of the model.

    Entries of the blocks of a matrix go to a band, of which the lower half is stored: half of those below the
    diagonal, and half of their counterparts above it.
    """

    def __init__(self, static: StaticSolver, plane: MirrorPlane) -> None:
        self.static = static
        problem, supports, pattern = static.system.problem, static.supports, static.system.matrix.pattern
        self.rows = rows = np.setdiff1d(supports.free_rows(), plane.equations(problem))
        self.unit = np.where(rows % 6 < 3, problem.length, 1.0)
        number, within = np.full(6 * problem.size, -1), np.arange(6)
        number[rows] = np.arange(len(rows))
        own = number[6 * pattern.rows[:, None, None] + within]
        other = number[6 * pattern.columns[:, None, None] + within[:, None]]
        own, other = (index.ravel() for index in np.broadcast_arrays(own, other))
        found = (own >= 0) & (other >= 0)
        self.width = int(np.abs(own - other)[found].max(initial=0))
        self._halves = []
        for first, second in ((own, other), (other, own)):
            entries = np.flatnonzero(found & (first >= second))
            i, j = first[entries], second[entries]
            self._halves.append((entries, (i - j) * len(rows) + j, 0.5 * self.unit[i] * self.unit[j]))

    def unstable(self, t: float, at: Snapshot) -> Callable[[float], bool]:
        """Return what tells whether they grow faster than at a rate [1/s], at the time ``t`` [s]."""
        system, supports = self.static.system, self.static.supports
        problem, moving = system.problem, at.state
        state = State(moving.r, moving.q, np.zeros_like(moving.twist), moving.multiplier)
        loads = self.static.loads.at(t, True, 1.0)
        system.assemble(state, loads, None, tangent=False, moving=False)
        system.reset_stress()
        system.assemble(state, loads, None, tangent=True, moving=False)
        blocks, mass, pattern = system.matrix.blocks, problem.mass, problem.pattern
        self._add_inertia(system.residual()[: problem.size], blocks)
        if len(supports.partial):
            supports.update(t, True)
            supports.impose(state, system.residual(), system.matrix, tangent=True)
            mass = mass.copy()
            for k in supports.partial:
                node, Z = supports.set.nodes[k], supports.free_directions(int(k), state)
                column = slice(pattern.starts[node], pattern.starts[node + 1])
                blocks[column] = Z.T @ blocks[column]
                mass[node] = Z.T @ mass[node] @ Z
        stiffness = blocks.copy()

        def faster(rate: float) -> bool:
            blocks[:] = stiffness
            blocks[pattern.diagonal[: problem.size]] += rate**2 * mass  # symmetric
            return self._indefinite(blocks)

        return faster

    def _add_inertia(self, unbalanced: Floats, blocks: Floats) -> None:
        """Subtract the derivative of inertial forces, which keep their directions in space as nodes turn."""
        supports, diagonal = self.static.supports, self.static.system.problem.pattern.diagonal
        free = np.setdiff1d(np.arange(len(unbalanced)), supports.set.nodes)
        slots = diagonal[free]
        for i, j, k in (
            (0, 1, 2),
            (1, 2, 0),
            (2, 0, 1),
        ):  # f x theta, of which the component i is f_j t_k - f_k t_j
            blocks[slots, 3 + k, i] -= unbalanced[free, j]
            blocks[slots, 3 + j, i] += unbalanced[free, k]

    def _indefinite(self, blocks: Floats) -> bool:
        """Return whether a matrix, its symmetric part, has a negative eigenvalue."""
        count = len(self.rows)
        if count * self.width**2 > MOST:
            whole = self.static.system.problem.pattern.part(blocks, self.rows, self.unit)
            none = sparse.csc_array((0, count))  # of the nodes
            return negative_eigenvalues(Tangent(whole, none, None)) > 0
        band = np.zeros((self.width + 1) * count)
        for entries, places, factors in self._halves:
            band[places] += factors * blocks.reshape(-1)[entries]
        return bool(dpbtrf(band.reshape(self.width + 1, count), lower=1)[1] != 0)
