"""The linear systems of a collocation step with full matrices, one for each eigenvalue of the method."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

__all__ = ["CollocationFactors"]


class CollocationFactors:
    """Factors of ``mu/h - J`` for the eigenvalues ``mu`` of a method: one real, the others in conjugate pairs."""

    def __init__(self, tableau: Tableau) -> None:
        self.tableau = tableau

    def factorise(self, J: Floats, h: float) -> bool:
        """Factorise for a step of length ``h`` [s] and a Jacobian ``(m, m)``; return whether that is finite."""
        if not np.isfinite(J).all():
            return False
        one = np.eye(len(J))
        self._real = scipy.linalg.lu_factor(self.tableau.real / h * one - J, check_finite=False)
        self._pairs = [
            scipy.linalg.lu_factor(pair / h * one - J, check_finite=False) for pair in self.tableau.pairs
        ]
        return True

    def solve(self, residual: Floats) -> Floats:
        """Return the corrections of all stages ``(s, m)``."""
        modes = self.tableau.to_modes @ residual
        out = np.empty_like(modes)
        out[0] = scipy.linalg.lu_solve(self._real, modes[0], check_finite=False)
        for m, pair in enumerate(self._pairs):
            solution = scipy.linalg.lu_solve(
                pair, modes[2 * m + 1] + 1j * modes[2 * m + 2], check_finite=False
            )
            out[2 * m + 1], out[2 * m + 2] = solution.real, solution.imag
        return np.asarray(self.tableau.to_stages @ out)

    def error(self, rate: Floats, Z: Floats, h: float) -> Floats:
        """Return the estimated error of a step (see ``Tableau.error``).

        Args:
            rate: at the start of the step ``(m,)``; Z: stages less the state there ``(s, m)``; h: length [s].
        """
        side = rate + self.tableau.error @ Z / h
        return np.asarray(scipy.linalg.lu_solve(self._real, side, check_finite=False))
