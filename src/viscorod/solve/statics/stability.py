"""Stability of an equilibrium: by the tangent stiffness where it is symmetric, else by the small motions themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from viscorod.solve.formulations.system import State
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.modes.vibrations import linearise
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
RESTARTS = 30
"""Of the search for eigenvalues; those that have converged by then are looked at."""
DENSE = 120
"""Number of free motions up to which all eigenvalues are computed."""


class Stability(NamedTuple):
    """How small motions about an equilibrium go on.

    Attributes:
        unstable: number of negative eigenvalues of a symmetric stiffness, else of motions ``exp(s t)`` with Re s > 0.
        divergent: how many of them leave without oscillating: their number changes where the tangent is singular.
        by_motion: whether the stiffness is not symmetric, so that motions were looked at.
    """

    unstable: int
    divergent: int
    by_motion: bool

    @property
    def oscillating(self) -> int:
        """Number of growing oscillations, two for each pair: flutter."""
        return self.unstable - self.divergent


def stability_of(
    static: StaticSolver, state: State, t: float = 0.0, *, before: bool = True, scale: float = 1.0
) -> Stability:
    """Return the stability of an equilibrium.

    Under following forces and dead moments the tangent stiffness K is not symmetric, and its symmetric part says
    nothing about stability (Beck 1952; Bolotin 1963). Then ``s^2 M x + s D x + K x = 0`` is solved for its slowest
    motions.
    """
    tangent = static.tangent(state, t, before=before, scale=scale)
    if not circulatory(static.loads.at(t, before, scale)) or _symmetric(tangent):
        count = negative_eigenvalues(tangent)
        return Stability(count, count, False)
    linear = linearise(static, state, t, before=before, scale=scale)
    if linear.stiffness.shape[0] == 0:  # every motion is held
        return Stability(0, 0, True)
    small = _SmallMotions(linear.stiffness, linear.damping, linear.mass, linear.gradients)
    values = small.squares()
    real = np.abs(values.imag) <= COMPLEX * np.abs(values) + FAINT * small.shift
    divergent = int(np.count_nonzero(real & (values.real < -small.noise)))
    if not linear.damping.count_nonzero():
        return Stability(divergent + int(np.count_nonzero(~real)), divergent, True)
    s = small.rates()
    growing = s.real > GROWTH * np.abs(s) + small.noise / np.maximum(np.abs(s), np.sqrt(small.noise))
    oscillating = growing & (np.abs(s.imag) > COMPLEX * np.abs(s))
    return Stability(divergent + int(np.count_nonzero(oscillating)), divergent, True)


def stability_attributes(found: Stability) -> dict[str, Any]:
    """Return the attributes of a result that tell the stability of its last state."""
    return {
        "negative_eigenvalues": found.unstable,
        "flutter": found.oscillating,
        "stability": "small motions" if found.by_motion else "tangent stiffness",
    }


def circulatory(loads: LoadState) -> bool:
    """Return whether loads may do work along a closed way: following ones, and moments about fixed axes."""
    if loads.following.any() or loads.dead[:, 3:].any():
        return True
    return any(load.following.any() or load.dead[..., 3:].any() for load in loads.stations)


def _symmetric(tangent: Tangent) -> bool:
    difference = abs(tangent.stiffness - tangent.stiffness.T)
    return bool(difference.max() <= ASYMMETRY * abs(tangent.stiffness).max())


class _SmallMotions:
    """The pencil ``s^2 M + s D + K`` with conditions ``G x = 0``."""

    def __init__(
        self,
        K: sparse.csr_array,
        D: sparse.csr_array,
        M: sparse.csr_array,
        G: sparse.csr_array | None,
    ) -> None:
        self.K, self.D, self.M, self.G = K, D, M, G
        self.size = int(K.shape[0])
        mean = float(np.abs(K.diagonal()).sum() / M.diagonal().sum())
        self.shift = SHIFT * mean
        self.noise = 16.0 * np.finfo(float).eps * mean

    def squares(self) -> np.ndarray:
        """Return the smallest ``-s^2`` without damping: the eigenvalues of ``K x = k M x``."""
        shift = -self.shift
        solve = self._solver(self.K - shift * self.M)
        if self.G is None and self.size <= DENSE:
            theta = np.linalg.eigvals(solve(self.M.toarray()))
        else:
            theta = _largest(lambda x: solve(self.M @ x), self.size, MOTIONS)
        return shift + 1.0 / _slowest(theta, MOTIONS)

    def rates(self) -> np.ndarray:
        """Return the smallest s with damping, both of each pair."""
        n, shift = self.size, float(np.sqrt(self.shift))
        solve = self._solver(shift**2 * self.M + shift * self.D + self.K)
        slope = shift * self.M + self.D

        def apply(z: Floats) -> Floats:
            x = -solve(slope @ z[:n] + self.M @ z[n:])
            return np.concatenate([x, shift * x + z[:n]])

        if self.G is None and n <= DENSE:
            theta = np.linalg.eigvals(np.array([apply(column) for column in np.eye(2 * n)]).T)
        else:
            theta = _largest(apply, 2 * n, 2 * MOTIONS)
        return shift + 1.0 / _slowest(theta, 2 * MOTIONS)

    def _solver(self, matrix: sparse.csr_array) -> Callable[[Floats], Floats]:
        import scipy.sparse.linalg as spla

        whole, rows = sparse.csc_array(matrix), 0
        if self.G is not None:
            rows = int(self.G.shape[0])
            held = self.G * float(np.abs(matrix.diagonal()).mean())
            whole = sparse.csc_array(sparse.block_array([[matrix, held.T], [held, None]]))
        try:
            factor = spla.splu(whole)
        except RuntimeError:
            raise SingularMatrixError(0) from None
        return lambda b: np.asarray(
            factor.solve(np.concatenate([b, np.zeros((rows, *b.shape[1:]))]))[: self.size]
        )


def _slowest(theta: np.ndarray, count: int) -> np.ndarray:
    """Return the ``count`` largest of inverse eigenvalues: those of stiff motions are round-off."""
    ordered = theta[np.argsort(-np.abs(theta), kind="stable")][:count]
    return np.asarray(ordered[np.abs(ordered) > 1e-14 * np.abs(ordered[0])])


def _largest(apply: Callable[[Floats], Floats], size: int, count: int) -> np.ndarray:
    """Return the ``count`` largest eigenvalues in size of an operator."""
    import scipy.sparse.linalg as spla

    operator = spla.LinearOperator((size, size), matvec=apply, dtype=float)
    start = np.random.default_rng(1).standard_normal(size)
    wanted = min(count, size - 2)
    space = min(size, 3 * count)
    try:
        found = spla.eigs(
            operator, wanted, v0=start, ncv=space, tol=1e-10, maxiter=RESTARTS, return_eigenvectors=False
        )
    except spla.ArpackNoConvergence as error:
        found = error.eigenvalues
    return np.asarray(found)
