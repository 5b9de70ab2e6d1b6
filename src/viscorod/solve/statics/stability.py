"""Stability of an equilibrium: by the tangent stiffness where it is symmetric, else by the small motions themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

__all__ = ["Stability", "circulatory", "stability_attributes", "stability_of"]

ASYMMETRY = 1e-12
"""Difference of a stiffness from its transpose, as a part of its largest entry, that passes for round-off."""
COMPLEX = 1e-5
"""Imaginary part of the square of a frequency, as a part of its size, that round-off leaves of coinciding ones."""
FAINT = 1e-3
"""The same in units of the shift: where two motions without stiffness coincide."""
GROWTH = 1e-9
"""Growth of a damped motion, as a part of its frequency, that round-off leaves."""
SHIFT = 1e-10
"""About which eigenvalues are sought, as a part of the mean stiffness over the mean inertia."""
MOTIONS = 24
"""Number of the slowest motions that are looked at."""
NO_INERTIA = (
    ", with an inertia in proportion to the stiffness, for a section was given without: flutter may differ"
)
"""What is said of the stability where the inertia is not known."""
SOME_MOTIONS = "small motions, not all of which were found"
RESTARTS = 30
"""Of the search for eigenvalues by iteration."""
DENSE, MOST = 240, 3000
"""Sizes up to which all eigenvalues are computed, at once and where those wanted crowd."""


class Stability(NamedTuple):
    """How small motions about an equilibrium go on.

    Attributes:
        unstable: number of negative eigenvalues of a symmetric stiffness, else of motions ``exp(s t)`` with Re s > 0.
        divergent: how many of them leave without oscillating: their number changes where the tangent is singular.
        by_motion: whether the stiffness is not symmetric, so that motions were looked at.
        complete: False if not all of the slowest motions were found: others may grow.
    """

    unstable: int
    divergent: int
    by_motion: bool
    complete: bool = True

    @property
    def oscillating(self) -> int:
        """Number of growing oscillations, two for each pair: flutter."""
        return self.unstable - self.divergent


def stability_of(
    static: StaticSolver,
    state: State,
    t: float = 0.0,
    *,
    before: bool = True,
    scale: float = 1.0,
    solved: bool = False,
) -> Stability:
    """Return the stability of an equilibrium; ``solved`` says that the solver has just found it.

    Under following forces and dead moments the tangent stiffness K is not symmetric, and its symmetric part says
    nothing about stability (Beck 1952; Bolotin 1963). Then ``s^2 M x + s D x + K x = 0`` is solved for its slowest
    motions.
    """
    circulating = circulatory(static.loads.at(t, before, scale))
    if solved and not circulating and static.surely_stable(state, t, before=before, scale=scale):
        return Stability(0, 0, False)
    tangent = static.tangent(state, t, before=before, scale=scale)
    if not circulating or _symmetric(tangent):
        count = negative_eigenvalues(tangent)
        return Stability(count, count, False)
    linear = linearise(static, state, t, before=before, scale=scale)
    if linear.stiffness.shape[0] == 0:  # every motion is held
        return Stability(0, 0, True)
    small = _SmallMotions(linear)
    values = small.squares()
    real = np.abs(values.imag) <= COMPLEX * np.abs(values) + FAINT * small.shift
    divergent = int(np.count_nonzero(real & (values.real < -small.noise)))
    if not linear.damping.count_nonzero():
        return Stability(divergent + int(np.count_nonzero(~real)), divergent, True, small.complete)
    s = small.rates()
    growing = s.real > GROWTH * np.abs(s) + small.noise / np.maximum(np.abs(s), np.sqrt(small.noise))
    oscillating = growing & (np.abs(s.imag) > COMPLEX * np.abs(s))
    return Stability(divergent + int(np.count_nonzero(oscillating)), divergent, True, small.complete)


def stability_attributes(
    found: Stability, inertia_known: Callable[[], bool] = lambda: True
) -> dict[str, Any]:
    """Return the attributes of a result that tell the stability of its last state."""
    judged = "tangent stiffness"
    if found.by_motion:
        judged = "small motions" if found.complete else SOME_MOTIONS
        judged += "" if inertia_known() else NO_INERTIA
    return {
        "negative_eigenvalues": found.unstable,
        "flutter": found.oscillating,
        "stability": judged,
    }


def circulatory(loads: LoadState) -> bool:
    """Return whether loads may do work along a closed way: following ones, moments about fixed axes, wind."""
    if loads.pushes or loads.following.any() or loads.dead[:, 3:].any():
        return True
    return any(load.following.any() or load.dead[..., 3:].any() for load in loads.stations)


def _symmetric(tangent: Tangent) -> bool:
    difference = abs(tangent.stiffness - tangent.stiffness.T)
    return bool(difference.max() <= ASYMMETRY * abs(tangent.stiffness).max())


class _SmallMotions:
    """The pencil ``s^2 M + s D + K`` with conditions ``G x = 0``."""

    def __init__(self, linear: Linearisation) -> None:
        self.linear = linear
        self.K, self.D, self.M = linear.stiffness, linear.damping, linear.mass
        self.size = int(self.K.shape[0])
        mean = float(np.abs(self.K.diagonal()).sum() / self.M.diagonal().sum())
        self.shift = SHIFT * mean
        self.noise = 16.0 * np.finfo(float).eps * mean
        self.complete = True

    def squares(self) -> np.ndarray:
        """Return the smallest ``-s^2`` without damping: the eigenvalues of ``K x = k M x``."""
        solve = self.linear.solver(sparse.csr_array(self.K + self.shift * self.M))
        return self._slowest(lambda x: solve(self.M @ x), self.size, MOTIONS) - self.shift

    def rates(self) -> np.ndarray:
        """Return the smallest s with damping, both of each pair."""
        n, shift = self.size, float(np.sqrt(self.shift))
        solve = self.linear.solver(sparse.csr_array(shift**2 * self.M + shift * self.D + self.K))
        slope = shift * self.M + self.D

        def apply(z: Floats) -> Floats:
            x = -solve(slope @ z[:n] + self.M @ z[n:])
            return np.concatenate([x, shift * x + z[:n]])

        return self._slowest(apply, 2 * n, 2 * MOTIONS) + shift

    def _slowest(self, inverse: Callable[[Floats], Floats], size: int, count: int) -> np.ndarray:
        """Return the ``count`` smallest eigenvalues from their ``inverse``: those of stiff motions are round-off."""
        theta = self._largest(inverse, size, count)
        ordered = theta[np.argsort(-np.abs(theta), kind="stable")][:count]
        return np.asarray(1.0 / ordered[np.abs(ordered) > 1e-14 * np.abs(ordered).max(initial=0.0)])

    def _largest(self, apply: Callable[[Floats], Floats], size: int, count: int) -> np.ndarray:
        """Return at least the ``count`` largest eigenvalues of an operator, or fewer where they crowd.

        Fewer are sought before full matrices are made, and those of large models are left ``complete`` no more.
        """
        import scipy.sparse.linalg as spla

        found = np.zeros(0, dtype=complex)
        if size > DENSE:
            operator = spla.LinearOperator((size, size), matvec=apply, dtype=float)
            start = np.random.default_rng(1).standard_normal(size)
            for wanted in (count, count // 2):
                options = {"v0": start, "ncv": min(size, 3 * count), "tol": 1e-10, "maxiter": RESTARTS}
                try:
                    return np.asarray(spla.eigs(operator, wanted, return_eigenvectors=False, **options))
                except spla.ArpackNoConvergence as error:
                    found = np.asarray(error.eigenvalues)
        if size <= MOST:
            return np.asarray(np.linalg.eigvals(apply(np.eye(size))))
        self.complete = False
        return found
