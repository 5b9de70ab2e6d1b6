"""The slowest small motions of large rotating models: shift and invert with sparse matrices, certified by a count.

They are the largest eigenvalues of a shifted inverse (see ``quadratic_pencil``). That none is missing within a circle
is proved by the argument principle (see ``root_counts``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from viscorod.errors import SolveError
from viscorod.solve.steady.growth_limits import GrowthLimits
from viscorod.solve.steady.quadratic_pencil import QuadraticPencil, ShiftedInverse
from viscorod.solve.steady.root_counts import missing
from viscorod.typing import Floats

__all__ = ["MOST", "Found", "slow_motions"]

MOST = 400
"""Roots that are sought at most."""
ATTEMPTS = 3
TOLERANCE, RESTARTS = 1e-13, 20
CLOSE = 1e-7
"""Relative distance of inverse roots below which they are one, whose vectors are found together."""
WIDE = 0.03
"""Gap between two distances, as a part of them, that is wide."""


@dataclass(frozen=True)
class Found:
    """Roots ``s`` with their right and left vectors, one column each, nearest to a real shift first.

    ``reach``: radius around the shift within which they are all; ``certified``: whether that is proved.
    """

    roots: np.ndarray
    right: np.ndarray
    left: np.ndarray
    reach: float
    certified: bool


def slow_motions(
    pencil: QuadraticPencil,
    shift: float,
    radius: float,
    count: int,
    limits: GrowthLimits,
    most: int = MOST,
) -> Found:
    """Return the roots within a ``radius`` around a ``shift``, and at least the ``count`` slowest, one of each pair.

    ``most`` roots are sought at most; where that is not enough, what is found is not certified.

    Raises:
        SolveError: ``Q(shift)`` is singular to working precision.
    """
    inverse = ShiftedInverse(pencil, shift)
    wanted = most if most < MOST else 2 * count + 12
    most = min(most, 2 * pencil.size - 2 - pencil.Z.shape[1])
    wanted = min(wanted, most)
    random = np.random.default_rng(1)
    for attempt in range(2 * ATTEMPTS):
        theta, right = _largest(inverse.apply, 2 * pencil.size, wanted, random)
        other, left = _largest(inverse.apply_transposed, 2 * pencil.size, wanted, random)
        roots = shift + 1.0 / theta
        left = inverse.transposed(_matched(theta, right, other, left))
        distances = np.abs(roots - shift)
        slow = np.sort(np.abs(roots[roots.imag >= 0.0]))
        needed = max(radius, abs(shift) + float(slow[min(count, len(slow)) - 1]))
        enough = distances[-1] > needed and len(slow) >= count
        last = len(theta) < wanted or wanted == most or attempt == 2 * ATTEMPTS - 1
        if enough or last:
            reach = _gap(distances, needed)
            lost = missing(pencil, roots, shift, reach, limits)
            if lost == 0 or last:
                certified = lost == 0 and reach > needed
                inside = distances < (reach if certified else np.inf)
                return Found(roots[inside], right[:, inside], left[:, inside], reach, certified)
        wanted = min(int(1.6 * wanted) + 4, most)
    raise AssertionError("unreachable")


def _largest(apply: Any, size: int, count: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the ``count`` largest eigenvalues of an operator with their vectors, or fewer, largest first."""
    import scipy.sparse.linalg as spla

    start = apply(random.standard_normal(size))
    operator = spla.LinearOperator((size, size), matvec=apply, dtype=float)
    try:
        theta, vectors = spla.eigs(
            operator, count, v0=start, tol=TOLERANCE, ncv=min(size, 2 * count + 10), maxiter=RESTARTS
        )
    except spla.ArpackNoConvergence as error:
        theta, vectors = error.eigenvalues, error.eigenvectors
    if len(theta) < 2:
        raise SolveError(
            "The small motions about the rotation were not found: the iteration did not converge"
        )
    order = np.argsort(-np.abs(theta), kind="stable")
    return theta[order], vectors[:, order]


def _matched(theta: np.ndarray, right: np.ndarray, other: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Return the left vectors in the order of the right ones, biorthogonal to those with the same eigenvalue."""
    order, free = [], np.ones(len(other), dtype=bool)
    for value in theta:
        if not free.any():
            order.append(int(np.argmin(np.abs(other - value))))
            continue
        places = np.flatnonzero(free)
        nearest = int(places[np.argmin(np.abs(other[places] - value))])
        free[nearest] = False
        order.append(nearest)
    found = left[:, order]
    for k in range(len(theta)):
        same = np.flatnonzero(np.abs(theta - theta[k]) < CLOSE * abs(theta[k]))
        if same[0] == k and len(same) > 1:
            gram = found[:, same].T @ right[:, same]
            if np.linalg.cond(gram) < 1e8:
                found[:, same] = found[:, same] @ np.linalg.inv(gram).T
    return found


def _gap(distances: Floats, radius: float) -> float:
    """Return a distance in the first wide gap beyond a radius."""
    first = max(int(np.searchsorted(distances, radius)), 1)
    ends = np.maximum(distances[first - 1 :], radius)
    if len(ends) < 2:
        return float(max(distances[-1], radius)) * (1.0 + 1e-6)
    gaps = np.diff(ends) / ends[1:]
    wide = np.flatnonzero(gaps > WIDE)
    k = int(wide[0]) if len(wide) else int(np.argmax(gaps))
    return float(0.5 * (ends[k] + ends[k + 1]))
