"""A motion with more harmonics than it was found with: what that changes of its multipliers."""

from __future__ import annotations

import numpy as np

from viscorod.solve.periodic.floquet import multipliers
from viscorod.solve.periodic.fourier import Fourier
from viscorod.solve.periodic.orbit import Orbit, Setting
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_solver import OrbitSolver

__all__ = ["multipliers_with_more_harmonics"]


def multipliers_with_more_harmonics(
    balance: OrbitBalance, orbit: Orbit, setting: Setting, harmonics: int
) -> np.ndarray | None:
    """Return the multipliers, the largest first, of the motion near an orbit; None if the iteration finds none.

    Args:
        balance: of the model, with the phases of the orbit, which it has again afterwards; setting: of the motion.
        harmonics: it is to have.
    """
    before, finer = balance.fourier, Fourier(harmonics)
    weights = before.at(finer.phases)
    more = Orbit(np.tensordot(weights, orbit.X, axes=1), weights @ orbit.multiplier)
    balance.use(finer)
    try:
        solver = OrbitSolver(balance, [])
        none = np.zeros((0, finer.count, balance.problem.pattern.size, 6)), np.zeros((0, 0))
        found = solver.solve(more, setting, none, fresh=True)
        if found is None:
            return None
        jacobian = solver.linearise(found.orbit, found.motion, none)
        return multipliers(balance, setting.omega, jacobian.linear, jacobian.groups)
    finally:
        balance.use(before)
