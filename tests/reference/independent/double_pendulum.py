"""Rigid double pendulum: two uniform slender bars on revolute joints, in the x-z plane, gravity along -z.

With a, b the angles of the bars below the x axis (a bar at angle a points to (cos a, -sin a)), masses m, M and lengths
l1, l2, Lagrange's equations are

    (m/3 + M) l1^2 a'' + (M l1 l2 / 2) cos(a - b) b'' = -(M l1 l2 / 2) sin(a - b) b'^2 + (m/2 + M) g l1 cos a
    (M l1 l2 / 2) cos(a - b) a'' + (M/3) l2^2 b''     = +(M l1 l2 / 2) sin(a - b) a'^2 + (M/2) g l2 cos b
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .galerkin import Array


@dataclass(frozen=True)
class DoublePendulum:
    """Masses in kg, lengths in m, gravity in m/s2."""

    masses: tuple[float, float] = (1.0, 1.0)
    lengths: tuple[float, float] = (1.0, 1.0)
    gravity: float = 9.81

    def accelerations(self, a: float, b: float, da: float, db: float) -> Array:
        """Second derivatives of the angles."""
        (m, M), (l1, l2), g = self.masses, self.lengths, self.gravity
        c, s = M * l1 * l2 / 2 * np.cos(a - b), M * l1 * l2 / 2 * np.sin(a - b)
        mass = np.array([[(m / 3 + M) * l1 * l1, c], [c, M * l2 * l2 / 3]])
        load = [
            -s * db * db + (m / 2 + M) * g * l1 * np.cos(a),
            s * da * da + M / 2 * g * l2 * np.cos(b),
        ]
        return np.linalg.solve(mass, load)

    def solve(self, times: Array, angles: tuple[float, float] = (0.0, 0.0), *, rtol: float = 1e-12) -> Array:
        """Angles and their rates at the times, from rest; one row a time."""
        found = solve_ivp(
            lambda _t, y: np.concatenate([y[2:], self.accelerations(*y)]),
            (0.0, float(times[-1])),
            [*angles, 0.0, 0.0],
            "DOP853",
            t_eval=times,
            rtol=rtol,
            atol=rtol,
        )
        return found.y.T

    def places(self, states: Array) -> tuple[Array, Array]:
        """Places (x, z) of the elbow and of the tip."""
        a, b = states[:, 0], states[:, 1]
        elbow = self.lengths[0] * np.column_stack([np.cos(a), -np.sin(a)])
        return elbow, elbow + self.lengths[1] * np.column_stack([np.cos(b), -np.sin(b)])

    def energy(self, states: Array) -> Array:
        """Kinetic and potential energy."""
        (m, M), (l1, l2), g = self.masses, self.lengths, self.gravity
        a, b, da, db = states.T
        kinetic = (
            (m / 3 + M) * (l1 * da) ** 2 / 2
            + M * (l2 * db) ** 2 / 6
            + M * l1 * l2 / 2 * np.cos(a - b) * da * db
        )
        return kinetic - (m / 2 + M) * g * l1 * np.sin(a) - M / 2 * g * l2 * np.sin(b)

    def frequencies(self) -> Array:
        """Angular frequencies of small oscillations about the hanging state."""
        (m, M), (l1, l2), g = self.masses, self.lengths, self.gravity
        mass = np.array([[(m / 3 + M) * l1 * l1, M * l1 * l2 / 2], [M * l1 * l2 / 2, M * l2 * l2 / 3]])
        stiffness = np.diag([(m / 2 + M) * g * l1, M / 2 * g * l2])
        return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))
