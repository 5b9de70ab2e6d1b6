"""What is read off a periodic motion: displacements, strains, section forces and reactions at all phases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product, rotation_vectors
from viscorod.solve.history import StationReader
from viscorod.solve.linear_systems.readings import Reading, gauss_points_at, supported_node
from viscorod.solve.periodic.orbit import Motion
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats, Integers

__all__ = ["OrbitOutputs"]


class OrbitOutputs:
    """Reads outputs.

    Args:
        balance: of the model; solver: of its statics, which knows its supports; readings: outputs with their places.

    Raises:
        InputError: what is wanted is not there, by name.
    """

    def __init__(self, balance: OrbitBalance, solver: StaticSolver, readings: Sequence[Reading]) -> None:
        self.balance, self.readings = balance, tuple(readings)
        self._reader = StationReader(balance.problem)
        self._points: dict[int, tuple[Integers, Floats]] = {}
        self._nodes: dict[int, int] = {}
        for k, reading in enumerate(self.readings):
            if reading.output.quantity == "reaction":
                self._nodes[k] = supported_node(solver, reading.output, k)
            elif reading.output.quantity != "motion":
                self._points[k] = gauss_points_at(solver.system, reading, k)
        problem = balance.problem
        still = np.zeros((problem.size, 6))
        self._r0, self._q0, _, _ = self._reader.read(problem.positions, problem.quaternions, still)

    def read(self, motion: Motion) -> Floats:
        """Return all outputs at all phases ``(N, outputs)``, displacements from the reference shape, SI units."""
        r, q = (np.array([getattr(state, name) for state in motion.states]) for name in ("r", "q"))
        places = self._reader.read(r, q, motion.twist)
        found = np.zeros((len(r), len(self.readings)))
        for k, reading in enumerate(self.readings):
            j = reading.output.component
            if reading.output.quantity == "motion":
                found[:, k] = self._moved(reading, places, motion.setting.omega)[:, j % 3]
            elif reading.output.quantity == "reaction":
                node = self._nodes[k]
                own = motion.force[:, node, 3 * (j // 3) : 3 * (j // 3) + 3]
                found[:, k] = np.einsum("pij,pj->pi", matrices(q[:, node]), own)[:, j % 3]
            else:
                points, weights = self._points[k]
                values = motion.points.strain if reading.output.quantity == "strain" else motion.points.stress
                flat = values.reshape(len(values), -1, 6)[:, self.balance.system.gauss_indices()]
                found[:, k] = flat[:, points, j] @ weights
        return found

    def _moved(self, reading: Reading, places: tuple[Floats, ...], omega: float) -> Floats:
        """Return a displacement or rotation vector, or its derivatives, at all phases ``(N, 3)``, global axes."""
        r, q, v, w = places
        at, weights = reading.stations, reading.weights
        turns, order = reading.output.component >= 3, reading.output.derivative
        if order == 0:
            if not turns:
                return np.asarray(np.einsum("k,pki->pi", weights, r[:, at] - self._r0[at]))
            turned = product(q[:, at], conjugate(np.broadcast_to(self._q0[at], q[:, at].shape).copy()))
            vectors = rotation_vectors(turned.reshape(-1, 4)).reshape(*turned.shape[:2], 3)
            return np.asarray(np.einsum("k,pki->pi", weights, vectors))
        rates = np.einsum(
            "pkij,pkj->pki", matrices(q[:, at].reshape(-1, 4)).reshape(len(q), len(at), 3, 3), w[:, at]
        )
        found = np.einsum("k,pki->pi", weights, rates if turns else v[:, at])
        return np.asarray(found if order == 1 else omega * self.balance.D @ found)
