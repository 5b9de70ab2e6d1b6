"""The energy of periodic motions: what goes in and what is lost, as powers at all phases."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import energies
from viscorod.solve.periodic.orbit import Motion
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_loads import OrbitLoads
from viscorod.typing import Floats

__all__ = ["losses", "put_in", "unit_powers"]


def losses(balance: OrbitBalance, motion: Motion) -> Floats:
    """Return the power lost to viscosity, dampers and outside at all phases ``(N,)`` [W]."""
    elastic, lost = np.empty((2, balance.fourier.count))
    energies(balance.elements, motion.points.strain, motion.points.strain_rate, elastic, lost)
    lost = lost + motion.powers[1] + motion.powers[2]
    if balance.system.relaxation is not None:
        branches, section = balance.system.relaxation.branches, balance.elements.section
        weights = balance.sections.weights()
        for j, tau in enumerate(balance.problem.relaxation_times):
            stretched = motion.spring[j]
            power = np.einsum(
                "pegi,egij,pegj,eg->p", stretched, branches[section, j], stretched, weights, optimize=True
            )
            lost = lost + power / tau
    return np.asarray(lost)


def put_in(balance: OrbitBalance, motion: Motion) -> Floats:
    """Return the power that loads, supports and motors put in at all phases ``(N,)`` [W]."""
    nodes = balance.supports.set.nodes
    by_supports = np.einsum("pki,pki->p", motion.force[:, nodes], motion.twist[:, nodes])
    lack = motion.setting.lack * np.einsum("pki,kij,pkj->p", motion.twist, balance.body.mass, motion.twist)
    return np.asarray(motion.drive + motion.powers[0] + by_supports + lack)


def unit_powers(balance: OrbitBalance, motion: Motion) -> Floats:
    """Return the power of each input over its own force or motion ``(N, k)``: the rate conjugate to a force."""
    drive, problem = balance.drive, balance.problem
    found = np.zeros((balance.fourier.count, len(drive.signals)))
    r, q = (np.array([getattr(state, name) for state in motion.states]) for name in ("r", "q"))
    for k, number in enumerate(drive.loads):
        if number < 0:
            continue
        for size, sign in ((1.0, 1.0), (0.0, -1.0)):
            load = balance.load_of({int(number): size})
            external, _ = OrbitLoads.of([load] * balance.fourier.count).add(problem, r, q, motion.twist)
            found[:, k] += sign * np.einsum("pki,pki->p", external, motion.twist)
    return found
