"""Equilibria, motions and frequencies of planar beams of an approximate theory."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import cho_factor, cho_solve, eigh

from viscorod.errors import SolveError
from viscorod.solve.planar.planar_beam import PlanarBeam
from viscorod.typing import Floats

__all__ = ["equilibrium_of", "motion_of", "squares_about", "squares_of"]

ITERATIONS = 30
SMALL = 1e-10
"""Change of the displacements over themselves at which an equilibrium is found."""
MOST_STEPS = 200
TOLERANCE = 1e-6
"""Relative tolerance of motions in time; the absolute one is this part of what the loads deflect at rest."""


def equilibrium_of(beam: PlanarBeam, load: Floats) -> Floats:
    """Return the displacements (3 n,) under nodal forces, by Newton's method with as many load steps as it needs.

    Raises:
        SolveError: none was found.
    """
    y = np.zeros(beam.basis.shape[1])
    reached, step = 0.0, 1.0
    for _ in range(MOST_STEPS):
        found = _newton(beam, min(1.0, reached + step) * load, y)
        if found is None:
            step *= 0.5
            continue
        y, reached, step = found, min(1.0, reached + step), 2.0 * step
        if reached >= 1.0:
            return np.asarray(beam.basis @ y)
    raise SolveError(
        f"{beam.theory.title}: no equilibrium beyond {100.0 * reached:.4g} % of the loads was found: the beam may "
        "buckle there"
    )


def _newton(beam: PlanarBeam, load: Floats, start: Floats) -> Floats | None:
    Z, y = beam.basis, start.copy()
    for _ in range(ITERATIONS):
        x = Z @ y
        residual = Z.T @ (load - beam.internal(x))
        K = Z.T @ beam.tangent(x)[0] @ Z
        try:
            change = np.linalg.solve(K, residual)
        except np.linalg.LinAlgError:
            return None
        y = y + change
        if not np.isfinite(y).all() or np.abs(y).max() > 1e3 * beam.problem.length:
            return None
        if not beam.theory.stretching or np.abs(change).max() <= SMALL * np.abs(y).max():
            return y
    return None


def squares_of(stiffness: Floats, mass: Floats, count: int) -> Floats:
    """Return the least squares of angular frequencies (count,), 1/s^2; negative ones grow.

    The largest of M y = K y/w^2 are found: shear and rotary inertia may be very stiff and very small, and the least of
    K y = w^2 M y would drown in the round-off of the largest.
    """
    K = 0.5 * (stiffness + stiffness.T)
    try:
        inverse = eigh(mass, K, eigvals_only=True)
    except np.linalg.LinAlgError:  # not positive definite: unstable
        found: Floats = eigh(K, mass, eigvals_only=True)
        return found[:count]
    return np.asarray(1.0 / inverse[::-1][:count])


def squares_about(beam: PlanarBeam, x: Floats, count: int) -> Floats:
    """Return the least squares of undamped angular frequencies about an equilibrium, 1/s^2."""
    return squares_of(beam.basis.T @ beam.tangent(x)[0] @ beam.basis, beam.reduced_mass, count)


class _Rates:
    """Rates of the state (motions and velocities of the beam's basis) for an integrator of ordinary equations."""

    def __init__(self, beam: PlanarBeam, loads: Callable[[float, bool], Floats]) -> None:
        self.beam, self.loads = beam, loads
        self.size = beam.basis.shape[1]
        self._factor = cho_factor(beam.reduced_mass)

    def acceleration(self, t: float, state: Floats, before: bool) -> Floats:
        Z, k = self.beam.basis, self.size
        force = self.loads(t, before) - self.beam.internal(Z @ state[:k], Z @ state[k:])
        return np.asarray(cho_solve(self._factor, Z.T @ force))

    def rate(self, t: float, state: Floats, end: float) -> Floats:
        """Return the rate of a state before the next corner of the loads."""
        return np.concatenate([state[self.size :], self.acceleration(t, state, t >= end)])

    def jacobian(self, t: float, state: Floats) -> Floats:
        del t
        Z, k = self.beam.basis, self.size
        K, D = self.beam.tangent(Z @ state[:k], Z @ state[k:])
        lower = -cho_solve(self._factor, Z.T @ np.hstack([K @ Z, D @ Z]))
        return np.vstack([np.hstack([np.zeros((k, k)), np.eye(k)]), lower])


def motion_of(
    beam: PlanarBeam,
    loads: Callable[[float, bool], Floats],
    start: Floats,
    times: Floats,
    corners: Floats,
) -> tuple[Floats, Floats, Floats]:
    """Return displacements, velocities and accelerations (times, 3 n) of a motion from rest.

    Radau's method of order 5 follows the error; it starts anew at the corners of the loads.

    Args:
        beam: which.
        loads: nodal forces (3 n,) at a time, or just before it.
        start: displacements (3 n,) at the first time.
        times: increasing, s.
        corners: times at which loads are not smooth, s.

    Raises:
        SolveError: the motion could not be followed.
    """
    Z, rates = beam.basis, _Rates(beam, loads)
    size = rates.size
    y = np.concatenate([Z.T @ start, np.zeros(size)])
    scale = max(_deflection(beam, loads, times, corners), float(np.abs(y).max(initial=0.0)), 1e-300)
    omega = math.sqrt(float(squares_about(beam, np.zeros(len(Z)), 1)[0]))
    atol = TOLERANCE * scale * np.repeat([1.0, omega], size)
    ends = [float(times[0]), *(float(c) for c in corners if times[0] < c < times[-1]), float(times[-1])]
    states, accelerations = np.empty((times.size, 2 * size)), np.empty((times.size, size))
    for first, last in pairwise(ends):
        mine = np.flatnonzero((times >= first) & (times <= last))
        wanted = np.unique(np.append(times[mine], last))
        matrix = rates.jacobian if beam.theory.stretching else rates.jacobian(first, y)
        rate = partial(rates.rate, end=last)
        found = solve_ivp(
            rate, (first, last), y, "Radau", t_eval=wanted, rtol=TOLERANCE, atol=atol, jac=matrix
        )
        if not found.success:
            raise SolveError(f"{beam.theory.title}: the motion could not be followed beyond {first:.6g} s")
        y = found.y[:, -1]
        states[mine] = found.y.T[np.searchsorted(wanted, times[mine])]
        accelerations[mine] = [rates.acceleration(float(times[k]), states[k], times[k] >= last) for k in mine]
    return states[:, :size] @ Z.T, states[:, size:] @ Z.T, accelerations @ Z.T


def _deflection(
    beam: PlanarBeam, loads: Callable[[float, bool], Floats], times: Floats, corners: Floats
) -> float:
    """Return what the largest loads of a motion would move the beam's basis at rest, linearly."""
    Z = beam.basis
    probes = np.concatenate([times[:: max(1, times.size // 50)], corners])
    largest = np.max([np.abs(loads(float(t), side)) for t in probes for side in (True, False)], axis=0)
    K = Z.T @ beam.tangent(np.zeros(len(Z)))[0] @ Z
    return float(np.abs(np.linalg.solve(K, Z.T @ largest)).max(initial=0.0))
