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

from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.problem.mirror_plane import MirrorPlane
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

__all__ = ["growth_out_of_plane"]

FULL = 240
"""Number of motions out of the plane up to which full matrices are factorised."""
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
    """Small motions out of a plane."""

    def __init__(self, static: StaticSolver, plane: MirrorPlane) -> None:
        self.static = static
        problem, supports, pattern = static.system.problem, static.supports, static.system.matrix.pattern
        self.rows = rows = np.setdiff1d(supports.free_rows(), plane.equations(problem))
        self.unit = np.where(rows % 6 < 3, problem.length, 1.0)
        self.small = len(rows) <= FULL
        if not self.small:
            return
        # where the entries of blocks are in the full matrix
        number, within = np.full(6 * problem.size, -1), np.arange(6)
        number[rows] = np.arange(len(rows))
        row = number[6 * pattern.rows[:, None, None] + within]
        column = number[6 * pattern.columns[:, None, None] + within[:, None]]
        row, column = np.broadcast_arrays(row, column)
        self._entries = np.flatnonzero((row >= 0) & (column >= 0))
        self._places = (row * len(rows) + column).ravel()[self._entries]
        self._mass = None if len(supports.partial) else self._inertia(problem.mass).toarray()

    def _inertia(self, mass: Floats) -> sparse.csr_array:
        scale = sparse.diags_array(self.unit)
        return sparse.csr_array(scale @ block_diagonal(mass)[self.rows][:, self.rows] @ scale)

    def unstable(self, t: float, at: Snapshot) -> Callable[[float], bool]:
        """Return what tells whether they grow faster than at a rate [1/s], at the time ``t`` [s]."""
        system, supports = self.static.system, self.static.supports
        problem, moving = system.problem, at.state
        state = State(moving.r, moving.q, np.zeros_like(moving.twist), moving.multiplier)
        system.stress.reshape(-1, 6)[system.gauss_indices()] = at.section_force
        system.assemble(state, self.static.loads.at(t, True, 1.0), None, tangent=True, moving=False)
        blocks, mass = system.matrix.blocks, problem.mass
        if len(supports.partial):
            supports.update(t, True)
            supports.impose(state, system.residual(), system.matrix, tangent=True)
            mass, starts = mass.copy(), problem.pattern.starts
            for k in supports.partial:
                node, Z = supports.set.nodes[k], supports.free_directions(int(k), state)
                column = slice(starts[node], starts[node + 1])
                blocks[column] = Z.T @ blocks[column]
                mass[node] = Z.T @ mass[node] @ Z
        if not self.small:
            K, M = problem.pattern.part(blocks, self.rows, self.unit), self._inertia(mass)
            none = sparse.csc_array((0, len(self.rows)))  # of the nodes
            return lambda rate: negative_eigenvalues(Tangent(K + rate**2 * M, none, None)) > 0
        stiffness = np.zeros((len(self.rows), len(self.rows)))
        stiffness.reshape(-1)[self._places] = blocks.reshape(-1)[self._entries]
        stiffness *= 0.5 * np.multiply.outer(self.unit, self.unit)
        stiffness += stiffness.T.copy()
        inertia = self._inertia(mass).toarray() if self._mass is None else self._mass
        return lambda rate: _indefinite(stiffness + rate**2 * inertia)


def _indefinite(matrix: Floats) -> bool:
    """Return whether a symmetric matrix has a negative eigenvalue."""
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return True
    return False
