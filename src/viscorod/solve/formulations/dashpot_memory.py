"""The state of Maxwell branches: the strains of their dashpots, from step to step.

Statics, and everything about small motions that is not damping, sees the relaxed rods: the stiffness alone. A motion
begins relaxed in the shape and with the strains that it starts with, as if these had always been held.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.typing import Floats, Integers


def at_points(spring: Floats, places: Integers) -> Floats:
    """Return strains of springs ``(..., n, e, points, 6)`` at Gauss points in the order of results ``(..., m, n, 6)``.

    Args:
        spring: of the branches; places: where the Gauss points are among all, flattened ``(m,)``.
    """
    flat = spring.reshape(*spring.shape[:-3], -1, 6)[..., places, :]
    return np.ascontiguousarray(np.swapaxes(flat, -3, -2))


class DashpotMemory:
    """Strains of the dashpots at the last accepted instant ``(n, e, points, 6)``, and what follows from them.

    For integrators that advance strains by themselves (generalised-alpha), strains that are linear in time over ``h``
    give ``beta = e^(-h/tau) beta_0 + tau/h (1 - e^(-h/tau)) (eps - eps_0)`` exactly (Simo and Hughes 1998, 10.3).

    Args:
        elements: of the problem; times: of relaxation ``(n,)`` [s]; branches: stiffnesses ``(sections, n, 6, 6)``.

    Attributes:
        dashpot: ``alpha (n, e, points, 6)``; strain: of the sections then ``(e, points, 6)``.
        known: a motion has begun.
        stiffness: of the branches, added to that of the sections ``(sections, 6, 6)``, by :meth:`relax` or
            :meth:`set_step`; prestress: their section forces beside it ``(e, points, 6)``.
    """

    def __init__(self, elements: Elements, times: Floats, branches: Floats) -> None:
        self.times, self.branches = times, branches
        points = elements.reference.shape
        self.dashpot: Floats = np.zeros((len(times), *points))
        self.strain: Floats = np.zeros(points)
        self.known = False
        self.stiffness: Floats
        self.prestress: Floats
        self.relax()
        self._at_points = np.moveaxis(branches[elements.section], 2, 0)  # (n, e, points, 6, 6)
        inside = np.arange(points[1]) < elements.order[:, None]
        weights = elements.weights[elements.order] * elements.half_lengths[:, None]
        self._weight: Floats = np.where(inside, weights, 0.0)
        self._decay: Floats = np.ones((len(times), 1, 1, 1))
        self._duration = 0.0

    def begin(self, strain: Floats) -> None:
        """Begin relaxed at ``strain (e, points, 6)``, unless a motion has begun."""
        if not self.known:
            self.dashpot[:] = strain
            self.strain[:] = strain
            self.known = True

    def relax(self) -> None:
        """Remove the stiffness and the stress of the branches: statics sees the relaxed rods."""
        self.stiffness = np.zeros((len(self.branches), 6, 6))
        self.prestress = np.zeros_like(self.strain)

    def set_step(self, duration: float) -> None:
        """Set stiffness and prestress for a step of ``duration`` [s] from the last accepted instant; 0: at once."""
        ratio = duration / self.times
        instant = -np.expm1(-ratio) / ratio if duration > 0.0 else np.ones(len(ratio))
        self._duration, self._decay = duration, np.exp(-ratio)[:, None, None, None]
        self.stiffness = np.einsum("j,sjab->sab", instant, self.branches)
        past = self._decay * (self.strain - self.dashpot) - instant[:, None, None, None] * self.strain
        self.prestress = self._forces(past).sum(axis=0)

    def force(self, strain: Floats) -> Floats:
        """Return the section forces of the branches at ``strain (e, points, 6)``, at the last accepted instant."""
        return np.asarray(self._forces(strain - self.dashpot).sum(axis=0))

    def advance(self, strain: Floats) -> Floats:
        """Advance to ``strain (e, points, 6)`` at the end of the step; return the dissipated energies ``(n,)`` [J].

        With strains linear in time, ``beta = p + q e^(-t/tau)`` and ``p = tau eps_t``: the loss is integrated exactly.
        """
        h, tau = self._duration, self.times[:, None, None, None]
        loss = np.zeros(len(self.times))
        if h > 0.0:
            p = tau / h * (strain - self.strain)
            q = self.strain - self.dashpot - p
            end = p + self._decay * q
            ratio = h / self.times
            mixed = -2.0 * np.expm1(-ratio)
            squared = -0.5 * np.expm1(-2.0 * ratio)
            loss = ratio * self._product(p, p) + mixed * self._product(p, q) + squared * self._product(q, q)
            self.dashpot[:] = strain - end
        self.strain[:] = strain
        self.set_step(0.0)
        return np.asarray(loss)

    def energy(self, strain: Floats) -> float:
        """Return the energy [J] of the branches at ``strain (e, points, 6)``, at the last accepted instant."""
        spring = strain - self.dashpot
        return 0.5 * float(self._product(spring, spring).sum())

    def power(self, strain: Floats) -> Floats:
        """Return the power that the branches dissipate per length [W/m] at ``strain (e, points, 6)``."""
        spring = strain - self.dashpot
        return np.asarray(np.einsum("jega,jega,j->eg", spring, self._forces(spring), 1.0 / self.times))

    def _product(self, a: Floats, b: Floats) -> Floats:
        """Return ``int a_j.C_j b_j`` of every branch ``(n,)``."""
        return np.asarray(np.einsum("eg,jega,jega->j", self._weight, a, self._forces(b)))

    def _forces(self, spring: Floats) -> Floats:
        """Return the forces of springs with the strains ``(n, e, points, 6)``, likewise."""
        return np.asarray((self._at_points @ spring[..., None])[..., 0])
