"""The slowest small motions of large rotating models: shift and invert with sparse matrices, certified by a count.

In the free motions y of the nodes they are the roots of ``det Q(s) = 0``, ``Q(s) = s^2 M + s C + K``, without those of
the copies of the rotation. With ``u = y' + A y`` they are the eigenvalues of a first-order system, of which a shifted
inverse needs the factors of ``Q`` alone. That none is missing within a circle is proved by the argument principle: the
phase of ``det Q`` over the roots that are known does not wind around zero on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.modes.linearisation import factored
from viscorod.solve.steady.growth_limits import GrowthLimits
from viscorod.typing import Floats

__all__ = ["MOST", "Found", "QuadraticPencil", "growing", "slow_motions"]

MOST = 400
"""Roots that are sought at most."""
ATTEMPTS = 3
TOLERANCE, RESTARTS = 1e-13, 20
CLOSE = 1e-7
"""Relative distance of inverse roots below which they are one, whose vectors are found together."""
WIDE = 0.03
"""Gap between two distances, as a part of them, that is wide."""
RESTING = 1e-12
"""Part of the largest entry of C1 below which ``C1 Z`` of a copy is 0."""
STEPS, FINEST = 4, 9
"""Parts of a half circle at first, and how often one is halved at most."""
EVALUATIONS = 150
"""Points of a circle that are looked at, at most."""
NEAR_AXIS = 1e-6
"""Distance from the imaginary axis, in the angular speed, beyond which motions are counted as growing ones."""
NEUTRAL = 2e-4
"""Distance from zero, in the angular speed, within which motions are neutral."""
TURN, ALIKE = 1.5, 0.7
"""Changes of phase [rad] in the halves of a part of a circle, and difference of both, beyond which these are looked at
themselves."""


class QuadraticPencil:
    """``M y'' + C y' + K y = 0`` without ``copies``, as a first-order system of ``z = (y, u)``.

    Args:
        mass, damping, stiffness: sparse ``(m, m)``.
        carried: A, with which copies have no ``u``; zero without copies.
        copies: orthonormal motions ``(m, c)`` that are the same rotation seen from elsewhere; y is without them.
    """

    def __init__(
        self,
        mass: sparse.csr_array,
        damping: sparse.csr_array,
        stiffness: sparse.csr_array,
        carried: sparse.csr_array,
        copies: Floats,
    ) -> None:
        self.M, self.C, self.K, self.A, self.Z = mass, damping, stiffness, carried, copies
        self.C1 = sparse.csr_array(damping - mass @ carried)
        self.K1 = sparse.csr_array(stiffness - self.C1 @ carried)
        self.size = int(mass.shape[0])

    def without_copies(self, y: np.ndarray) -> np.ndarray:
        """Return motions ``(m, ...)`` without their part that only copies the rotation."""
        return np.asarray(y - self.Z @ (self.Z.T @ y))

    def at(self, s: complex) -> sparse.csr_array:
        """Return ``Q(s)`` bordered by the copies: ``[[Q, (s M + C1) Z], [Z', 0]]``.

        So it is regular where only copies are at rest, and its determinant has no roots of copies.
        """
        Q = sparse.csr_array(s**2 * self.M + s * self.C + self.K)
        if not self.Z.shape[1]:
            return Q
        border = sparse.csr_array(s * (self.M @ self.Z) + self.C1 @ self.Z)
        down = sparse.csr_array(float(np.abs(self.K.diagonal()).mean()) * self.Z.T)
        return sparse.csr_array(sparse.block_array([[Q, border], [down, None]]))

    def at_rest(self) -> sparse.csr_array:
        """Return ``at(0)`` with another border for copies that are at rest where they are, of which ``C1 Z`` is 0."""
        if not self.Z.shape[1]:
            return self.at(0.0)
        border = self.C1 @ self.Z
        _, sizes, turned = np.linalg.svd(border, full_matrices=False)
        Z, border = self.Z @ turned.T, border @ turned.T
        resting = sizes <= RESTING * max(float(sizes.max()), float(np.abs(self.C1.data).max(initial=0.0)))
        border[:, resting] = (self.M @ Z)[:, resting]
        down = sparse.csr_array(float(np.abs(self.K.diagonal()).mean()) * Z.T)
        return sparse.csr_array(sparse.block_array([[self.K, sparse.csr_array(border)], [down, None]]))

    @property
    def creep(self) -> float:
        """The rate [1/s] near which roots of overdamped motions crowd: stiffness over damping, infinite without any."""
        damping, stiffness = self.C.diagonal(), self.K.diagonal()
        some = (damping > 0.0) & (stiffness > 0.0)
        return float((stiffness[some] / damping[some]).min(initial=np.inf))

    @cached_property
    def mass(self) -> sparse.csr_array:
        """The mass of the first-order system."""
        return sparse.csr_array(sparse.block_diag([sparse.eye_array(self.size), self.M]))

    @cached_property
    def matrix(self) -> _WithoutCopies:
        """The matrix of the first-order system."""
        one = sparse.eye_array(self.size)
        return _WithoutCopies(
            sparse.csr_array(sparse.block_array([[-self.A, one], [-self.K1, -self.C1]])), self
        )

    @cached_property
    def magnitude(self) -> sparse.csr_array:
        """The sizes of what adds up to the entries of the matrix."""
        one = sparse.eye_array(self.size)
        return sparse.csr_array(sparse.block_array([[abs(self.A), one], [abs(self.K1), abs(self.C1)]]))

    def determinant(self, s: complex) -> float:
        """Return the phase [rad] of the determinant, without the roots of copies."""
        return factored(self.at(s).astype(complex)).phase


@dataclass
class _WithoutCopies:
    whole: sparse.csr_array
    pencil: QuadraticPencil

    def __matmul__(self, z: np.ndarray) -> np.ndarray:
        out, m = np.asarray(self.whole @ z), self.pencil.size
        out[:m] = self.pencil.without_copies(out[:m])
        return out


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


class _Inverse:
    """The inverse ``(matrix - shift mass)^-1 mass`` and its transpose."""

    def __init__(self, pencil: QuadraticPencil, shift: float) -> None:
        self.pencil, self.shift = pencil, shift
        self.H = sparse.csr_array(shift * pencil.M + pencil.C1)
        self.c = pencil.Z.shape[1]
        self.factor = factored(pencil.at(shift))

    def _solved(
        self, top: np.ndarray, bottom: np.ndarray, *, transposed: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        both = np.concatenate([top, bottom])
        if np.iscomplexobj(both):
            real, imaginary = (
                self.factor.solve(part.copy(), transposed=transposed) for part in (both.real, both.imag)
            )
            found = real + 1j * imaginary
        else:
            found = self.factor.solve(both, transposed=transposed)
        return found[: self.pencil.size], found[self.pencil.size :]

    def solve(self, f: np.ndarray, g: np.ndarray) -> np.ndarray:
        """Return z with ``(matrix - shift mass) z = (f, g)``."""
        p = self.pencil
        f = p.without_copies(f)
        y, mu = self._solved(-g - self.H @ f, np.zeros((self.c, *f.shape[1:])))
        return np.concatenate([y, self.shift * y + p.A @ y + p.Z @ mu + f])

    def transposed(self, z: np.ndarray) -> np.ndarray:
        """Return ``(matrix - shift mass)^-T z``."""
        p = self.pencil
        a, b = p.without_copies(z[: p.size]), z[p.size :]
        t, _ = self._solved(a + self.shift * b + p.A.T @ b, p.Z.T @ b, transposed=True)
        return np.concatenate([p.without_copies(b - self.H.T @ t), -t])

    def apply(self, z: np.ndarray) -> np.ndarray:
        """Return the inverse times the mass times z."""
        m = self.pencil.size
        return self.solve(z[:m], np.asarray(self.pencil.M @ z[m:]))

    def apply_transposed(self, z: np.ndarray) -> np.ndarray:
        """Return the transpose of :meth:`apply` of z."""
        w = self.transposed(z)
        m = self.pencil.size
        return np.concatenate([w[:m], self.pencil.M.T @ w[m:]])


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
    inverse = _Inverse(pencil, shift)
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
            missing = _missing(pencil, roots, shift, reach, limits)
            if missing == 0 or last:
                certified = missing == 0 and reach > needed
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


def _missing(
    pencil: QuadraticPencil, roots: np.ndarray, shift: float, reach: float, limits: GrowthLimits
) -> int | None:
    """Return how many roots within ``reach`` of the shift are not known, by the argument principle; None if unknown.

    The determinant is divided by the known ones and by that of a much stiffer system, ``K + B M``, which has as fast
    motions and no slow ones: ``|s^2 + s (d + i g) + k + B| > 0`` for ``|s| < r`` if ``B > r^2 + r G + N`` and
    overdamped motions creep faster than r. So the phase on the circle changes little. It is that of a real function:
    the upper half of the circle tells.
    """
    r = abs(shift) + reach
    if not (np.isfinite(limits.softening) and r < pencil.creep):
        return None
    stiffness = 4.0 * (r**2 + r * limits.gyroscopic) + limits.softening
    other = QuadraticPencil(
        pencil.M, pencil.C, sparse.csr_array(pencil.K + stiffness * pencil.M), pencil.A, pencil.Z[:, :0]
    )
    known = roots[np.abs(roots - shift) < 1.5 * reach]

    def phase(angle: float) -> complex:
        s = complex(shift + reach * np.exp(1j * angle))
        turned = pencil.determinant(s) - other.determinant(s)
        return complex(np.exp(1j * (turned - float(np.angle(s - known).sum()))))

    return _winding(phase, np.linspace(0.0, np.pi, STEPS + 1))


def growing(pencil: QuadraticPencil, roots: np.ndarray, radius: float, limits: GrowthLimits) -> int | None:
    """Return how many roots with Re s > 0 and ``|s| < radius`` are not among those that are known; None if unknown.

    It is the winding of ``det Q`` over that of a system with more damping and stiffness and without gyroscopic forces,
    which has no such roots (Kelvin and Tait; Chetaev) and is as overdamped.
    """
    softening, rate = limits.softening, limits.spin
    if not np.isfinite(softening):
        return None
    damping = sparse.csr_array(0.5 * (pencil.C + pencil.C.T) + 4.0 * rate * pencil.M)
    stiffness = sparse.csr_array(0.5 * (pencil.K + pencil.K.T) + (softening + rate**2) * pencil.M)
    other = QuadraticPencil(pencil.M, damping, stiffness, pencil.A, pencil.Z[:, :0])
    known = roots[roots.real > -0.2 * radius]  # the others make no difference beside the other system
    moved = known - np.abs(known.real) - 0.5 * radius
    outer, inner, least = 1.05 * radius, NEUTRAL * rate, NEAR_AXIS * rate

    def place(part: float) -> complex:
        """Go along an arc from the real axis, down beside the imaginary one, and around zero."""
        if part <= 1.0:
            return complex(outer * np.exp(0.5j * np.pi * part) + least)
        if part <= 2.0:
            return complex(least, outer + (part - 1.0) * (inner - outer))
        return complex(inner * np.exp(0.5j * np.pi * (3.0 - part)) + least)

    def phase(part: float) -> complex:
        s = place(part)
        turned = pencil.determinant(s) - other.determinant(s)
        return complex(np.exp(1j * (turned - float((np.angle(s - known) - np.angle(s - moved)).sum()))))

    return _winding(phase, np.linspace(0.0, 3.0, 3 * STEPS + 1))


def _winding(phase: Callable[[float], complex], ends: Floats) -> int | None:
    """Return how often a function that is real at both ends of a way winds around zero on it and its mirror image."""
    values: dict[float, complex] = {}

    def change(a: float, b: float) -> float:
        for place in (a, b):
            if place not in values:
                values[place] = phase(place)
        return float(np.angle(values[b] / values[a]))

    pending = [(float(a), float(b), 0) for a, b in pairwise(ends)]
    total = 0.0
    try:
        while pending:
            a, b, depth = pending.pop()
            middle = 0.5 * (a + b)
            halves = change(a, middle), change(middle, b)
            if max(abs(part) for part in halves) < TURN and abs(halves[1] - halves[0]) < ALIKE:
                total += sum(halves)
            elif depth == FINEST or len(values) > EVALUATIONS:
                return None
            else:
                pending += [(a, middle, depth + 1), (middle, b, depth + 1)]
    except SolveError:
        return None
    return round(total / np.pi)
