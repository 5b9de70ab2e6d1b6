"""A clamped-hinged circular arch under a load at its crown: the inextensible elastica by shooting."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar, root

Array = np.ndarray


def arch_at(sag: float, guess: Array, angle: float) -> Array:
    """Reactions at the hinge, angle there, and load at which the crown has sunk by ``sag``.

    The radius and the bending stiffness are 1; the arch runs from the hinge over the crown to the clamp.
    """
    half = 0.5 * angle

    def along(force: Array, start: Array) -> Array:
        def slope(s: float, y: Array) -> list[float]:
            c, n = np.cos(y[2]), np.sin(y[2])
            return [c, n, y[3] - 1.0, -(c * force[1] - n * force[0])]

        return solve_ivp(slope, (0, half), start, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]

    def gaps(u: Array) -> list[float]:
        crown = along(u[:2], np.array([0.0, 0.0, u[2], 0.0]))
        end = along(u[:2] + np.array([0.0, u[3]]), crown)
        return [crown[1] - (1 - np.cos(half) - sag), end[0] - 2 * np.sin(half), end[1], end[2] + half]

    found = root(gaps, guess, tol=1e-12)
    if np.abs(found.fun).max() > 1e-8:
        raise RuntimeError(f"no arch at sag {sag}")
    return found.x


def limit_load(angle: float, sags: Array, bracket: tuple[float, float]) -> tuple[float, float]:
    """Largest load and the sag there, found from ``sags`` that lead from 0 to near it."""
    known = np.array([-0.01, 0.0, 0.5 * angle, 0.01])
    for sag in sags:
        known = arch_at(sag, known, angle)

    def load(sag: float) -> float:
        return -arch_at(sag, known, angle)[3]

    top = minimize_scalar(load, bounds=bracket, method="bounded", options={"xatol": 1e-7})
    return -top.fun, top.x


if __name__ == "__main__":
    print(limit_load(np.radians(215.0), np.linspace(0.01, 1.14, 60), (1.12, 1.155)))
