"""Floquet multipliers of a periodic motion: what small disturbances become after one period.

The small motions about an orbit, ``p' = dx - ad(x) p`` and ``M dx' + C dx + K p = 0`` with coefficients of the period
(and multipliers of conditions, and dashpots ``tau alpha' = eps - alpha`` of Maxwell branches), are integrated over one
period by Radau IIA of five stages: order 9, and stiff motions that die out within a step do so exactly. The
coefficients are those at the phases of the orbit, as trigonometric polynomials. The eigenvalues of the map of a period
are the multipliers (Nayfeh and Balachandran, Applied Nonlinear Dynamics, 1995, chapter 7). Velocities that conditions
do not allow have multipliers of zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import linalg

from viscorod.errors import Fault, InputError
from viscorod.solve.linear.matrix import unit_of
from viscorod.solve.periodic.floquet_kernels import fill_steps
from viscorod.solve.periodic.orbit import Linearised
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_matrix import strains_of_nodes, whole_matrix
from viscorod.solve.transient.integrators.tableau import radau
from viscorod.typing import Floats, Integers

__all__ = ["multipliers"]

MOST = 400
"""Motions that couple at most: a period of one orbit takes about half a minute then."""
STAGES = 5
STEPS = 8
"""Steps of a period at least; more than one for every harmonic. Order 9: a vibration that swings once in a step keeps
its amplitude to 2e-4 and a slow one to 1e-9."""


def multipliers(
    balance: OrbitBalance,
    omega: float,
    linear: Linearised,
    groups: Sequence[Integers],
    steps: int = 0,
) -> np.ndarray:
    """Return all Floquet multipliers, the largest first.

    Args:
        balance: of the model; omega: angular frequency [rad/s]; linear: derivatives at the orbit.
        groups: of motions that do not couple; steps: of a period, chosen unless given.

    Raises:
        InputError: more motions couple than full matrices are good for.
    """
    largest = max(map(len, groups))
    if largest > MOST:
        raise InputError(
            Fault(
                "stability",
                "true",
                f"{largest} motions of the model couple, and Floquet multipliers come from full matrices of {MOST} "
                "at most",
                "give stability = false, or fewer elements",
            )
        )
    steps = steps or max(STEPS, balance.fourier.harmonics * 3 // 2)
    whole = _Coefficients(balance, linear, steps)
    found = []
    for motions in groups:
        first = None
        for own in _Period(whole, omega, motions).maps():
            first = own if first is None else own @ first
        assert first is not None
        found.append(linalg.eigvals(first, check_finite=False))
    values = np.concatenate(found)
    return np.asarray(values[np.argsort(-np.abs(values))])


class _Coefficients:
    """Coefficients of small motions at all stages of all steps of a period, scaled."""

    def __init__(self, balance: OrbitBalance, linear: Linearised, steps: int) -> None:
        self.balance, self.steps, self.method = balance, steps, radau(STAGES)
        problem = balance.problem
        self.size, self.stages = 6 * problem.size, STAGES
        phases = 2.0 * np.pi * ((np.arange(steps)[:, None] + self.method.nodes) / steps).ravel()
        self._weights = balance.fourier.at(phases)
        unit = unit_of(problem.length)
        self.unit = np.ones(6 * problem.pattern.size)
        self.unit[: self.size] = np.tile([unit] * 3 + [1.0] * 3, problem.size)
        pattern, nodes = problem.pattern, np.arange(problem.size)
        self.K, self.C = (
            whole_matrix(balance, part, pattern.rows, pattern.columns) for part in (linear.K, linear.C)
        )
        self.M, self.ad = (whole_matrix(balance, part, nodes, nodes) for part in (linear.M, linear.ad))
        self.partial = balance.supports.partial
        self.Z: Floats | None = None
        if len(self.partial):
            self.Z = np.tile(np.eye(len(self.unit)), (len(self.K), 1, 1))
            for number, k in enumerate(self.partial):
                first = 6 * int(balance.supports.set.nodes[k])
                self.Z[:, first : first + 6, first : first + 6] = linear.Z[:, number]
        self.B = None
        if problem.relaxing:
            self.B = strains_of_nodes(balance, linear.strain)
            self.moduli = _weighted_moduli(balance)

    def forces(self, matrix: Floats, rows: Integers, columns: Integers) -> Floats:
        """Return a part of a matrix of forces by motions ``(N, R, R)`` at all stages ``(steps, stages, ...)``."""
        return self.at(matrix[:, rows[:, None], columns] * (self.unit[rows][:, None] * self.unit[columns]))

    def motions(self, matrix: Floats, rows: Integers, columns: Integers) -> Floats:
        """Return a part of a matrix of motions by motions, likewise."""
        return self.at(self.turned(matrix, rows, columns))

    def turned(self, matrix: Floats, rows: Integers, columns: Integers) -> Floats:
        """Return a part of a matrix of motions by motions at the phases of the orbit, scaled."""
        return np.asarray(matrix[:, rows[:, None], columns] * (self.unit[columns] / self.unit[rows][:, None]))

    def at(self, values: Floats) -> Floats:
        """Return values at the phases of the orbit ``(N, ...)`` at all stages of all steps."""
        flat = self._weights @ values.reshape(len(values), -1)
        return np.asarray(flat.reshape(self.steps, self.stages, *values.shape[1:]))


def _weighted_moduli(balance: OrbitBalance) -> Floats:
    """Return the moduli of the branches with the weights of the points ``(branches, points, 6, 6)``."""
    elements, memory = balance.elements, balance.system.relaxation
    assert memory is not None
    found = [
        elements.weights[order, g] * elements.half_lengths[e] * memory.branches[elements.section[e, g]]
        for e, order in enumerate(elements.order.tolist())
        for g in range(order)
    ]
    return np.swapaxes(np.array(found), 0, 1)


class _Period:
    """Small motions of one group: maps of the steps of a period."""

    def __init__(self, whole: _Coefficients, omega: float, motions: Integers) -> None:
        self.whole, self.method = whole, whole.method
        self.h = 2.0 * np.pi / omega / whole.steps
        self.steps, self.stages = whole.steps, whole.stages
        size, supports = whole.size, whole.balance.supports
        nodal, self.conditions = motions[motions < size], motions[motions >= size]
        self.rows = np.concatenate([nodal, self.conditions])
        self.poses = self.twists = nodal
        partial = 6 * supports.set.nodes[supports.partial]
        if len(partial):  # twists there are along all axes
            nodes = np.unique(nodal // 6)
            mine = np.concatenate(
                [first + np.arange(6) for first in partial if first // 6 in nodes] or [nodal[:0]]
            )
            self.twists = np.union1d(nodal, mine.astype(np.int64))
        self.K, self.C, self.M = (
            whole.forces(part, self.rows, self.twists) for part in (whole.K, whole.C, whole.M)
        )
        self.own = whole.forces(whole.K, self.rows, self.conditions)
        self.turned = whole.motions(whole.ad, self.twists, self.twists)
        columns = np.searchsorted(self.twists, self.poses)
        self.Z: Floats | None = None
        self.Z0 = np.eye(len(self.twists))[:, columns]
        if whole.Z is not None:
            self.Z0 = whole.turned(whole.Z[:1], self.twists, self.twists)[0][:, columns]
            self.Z = whole.motions(whole.Z, self.twists, self.twists)[..., columns]
            self.turned = self.turned @ self.Z
        self.G = None
        if whole.B is not None:
            G = whole.at(whole.B[:, :, self.twists] * whole.unit[self.twists])
            self.G = G if self.Z is None else G @ self.Z
        if self.G is not None:
            A, unit = self.method.matrix, np.eye(self.stages)
            times = whole.balance.problem.relaxation_times
            self.factors = np.array([np.linalg.inv(unit + self.h / tau * A) for tau in times])
            self.strained = np.abs(self.G).max(axis=(0, 1, 3)) > 0.0

    def maps(self) -> Floats:
        """Return the maps of all steps ``(steps, m, m)``."""
        d, s = self.method.derivative / self.h, self.stages
        twice, starts = d @ d, d.sum(axis=1)
        f, t, u = len(self.poses), len(self.twists), len(self.rows)
        K, C, M, Z, turned = self.K, self.C, self.M, self.Z, self.turned
        J = np.zeros((self.steps, s, u, s, u))
        right = np.zeros((self.steps, s, u, f + t))
        if Z is None:  # then the mass does not change
            fill_steps(d, twice, C, M[0, 0] @ turned, np.ascontiguousarray(M[0, 0]), J)
        for i in range(s):
            viscous, inertia = C[:, i], M[:, i]
            J[:, i, :, i, :f] += (K[:, i] if Z is None else K[:, i] @ Z[:, i]) + viscous @ turned[:, i]
            J[:, i, :, i, f:] = self.own[:, i]
            right[:, i, :, :f] = (starts[i] * viscous + (d @ starts)[i] * inertia) @ self.Z0
            right[:, i, :, f:] = starts[i] * inertia
            if Z is None:
                continue
            for j in range(s):
                block = d[i, j] * viscous + twice[i, j] * inertia
                J[:, i, :, j, :f] += block @ Z[:, j] + d[i, j] * (inertia @ turned[:, j])
        if self.G is not None:
            right = np.concatenate([right, self._add_branches(J)], axis=-1)
        found = np.linalg.solve(
            J.reshape(self.steps, s * u, s * u), right.reshape(self.steps, s * u, right.shape[-1])
        )
        y: Floats = np.asarray(found.reshape(self.steps, s, u, -1)[:, :, :f], dtype=np.float64)
        moved = y if Z is None else Z @ y
        last = turned[:, -1] @ y[:, -1] + np.einsum("j,ajxc->axc", d[-1], moved)
        last[..., :f] -= starts[-1] * self.Z0
        parts = [y[:, -1], last]
        if self.G is not None:
            parts.append(self._dashpots_at_end(y, f + t))
        return np.concatenate(parts, axis=1)

    def _add_branches(self, J: Floats) -> Floats:
        """Add the branches to the matrices of the steps; return their right sides by the strains of the dashpots."""
        assert self.G is not None
        f, points = len(self.poses), self.G.shape[2] // 6
        G = self.G.reshape(self.steps, self.stages, points, 6, f)
        rows = int(self.strained.sum())
        right = np.zeros((self.steps, self.stages, J.shape[2], len(self.factors) * rows))
        for b, F in enumerate(self.factors):
            pushed = np.einsum("asgif,gij->asfgj", G, self.whole.moduli[b])
            pushed = pushed.reshape(self.steps, self.stages, f, 6 * points)
            for i in range(self.stages):
                for j in range(self.stages):
                    J[:, i, :f, j, :f] += F[i, j] * (pushed[:, i] @ self.G[:, j])
                right[:, i, :f, rows * b : rows * (b + 1)] = F[i].sum() * pushed[:, i][..., self.strained]
        return right

    def _dashpots_at_end(self, y: Floats, start: int) -> Floats:
        """Return the strains of the dashpots at the ends of steps, by what the free poses at the stages are."""
        assert self.G is not None
        strain = self.G[:, :, self.strained] @ y
        rows = strain.shape[2]
        found = []
        for b, F in enumerate(self.factors):
            own = strain[:, -1] - np.einsum("j,ajxc->axc", F[-1], strain)
            own[:, :, start + rows * b : start + rows * (b + 1)] += F[-1].sum() * np.eye(rows)
            found.append(own)
        return np.concatenate(found, axis=1)
