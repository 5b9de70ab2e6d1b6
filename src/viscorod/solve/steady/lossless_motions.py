"""Small motions that nothing damps about a rotation whose stiffness is positive: it is proved that none of them grows.

In free motions y they are ``M y'' + G y' + K y = 0`` with M and K symmetric and G skew. With K > 0 the energy
``y' M y'/2 + y K y/2`` keeps what it is and bounds them: no motion grows, whatever G (Kelvin and Tait; Merkin,
Introduction to the Theory of Stability, 1997, 6.2). In the scalar product of the energy the inverse of the first-order
system in ``(y, y')``

    (f, g) -> (-K^-1 (G f + M g), f)

is skew, so its eigenvalues ``-i/w`` are found by a block Krylov space as accurately as those of symmetric matrices. By
the inertia of the Hermitian matrix ``K - w^2 M + i w G``, whose number of negative eigenvalues is that of frequencies
below w (Lancaster, Lambda-Matrices and Vibrating Systems, 1966, 7.7), it is proved that none is missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.statics.tangent import (
    SMALL,
    factor_without_exchanges,
    surely_positive,
    surely_positive_factors,
)
from viscorod.typing import Floats

__all__ = ["LosslessMotions", "Slowest"]

ROUND_OFF = 1e-12
"""Part of a matrix, symmetric or skew, that counts as none."""
BLOCKS = (2, 6, 12)
"""Vectors of a block, one after the other where frequencies are missing: so many of them may coincide."""

FIRST, FURTHER = 22, 1.25
"""Vectors of the space beside four for every motion that is wanted, at first; and by how much it grows."""
PART = 0.5
"""Part of all motions of first order from which on full matrices are used in place of a space."""
LARGE = 2000
"""Motions of first order up to which they are used where a space was not enough."""
CONVERGED, ROUGH = 3e-11, 1e-5
"""What a vector leaves of the inverse, as a part of its eigenvalue, where it is found, and where its frequency is."""
FAST = 1e3
"""Times the slowest frequency, beyond which frequencies are made anew: round-off of the inverse grows with them."""
GAP = 1e-4
"""Relative distance of two frequencies between which it is counted."""
EXHAUSTED = 1e-13
"""Part of a vector that is round-off where nothing new is left in it."""
DOUBTFUL = 1e-4
"""Part of a vector that is left below which round-off of its image counts."""


class Slowest(NamedTuple):
    """Angular frequencies [rad/s], slowest first, their motions ``(free, k)``, and whether none is missing for sure."""

    frequencies: Floats
    motions: np.ndarray
    complete: bool


@dataclass(frozen=True)
class LosslessMotions:
    """Small motions ``M y'' + G y' + K y = 0`` of which none can grow.

    Attributes:
        mass, gyroscopic, stiffness: in free motions ``(m, m)``, full if they are small, else sparse; basis: these as
            body increments ``(6 n, m)``.
        solve: y with ``K y = b``.
    """

    mass: Any
    gyroscopic: Any
    stiffness: Any
    basis: sparse.csc_array
    solve: Callable[[Floats], Floats]

    @classmethod
    def of(
        cls,
        mass: sparse.csr_array,
        damping: sparse.csr_array,
        stiffness: sparse.csr_array,
        basis: sparse.csc_array,
    ) -> LosslessMotions | None:
        """Return the motions; None where energy is taken or given, or the stiffness is not surely positive.

        The ``mass`` is positive.
        """
        M, C, K = mass, damping, stiffness
        if stiffness.shape[0] <= SMALL:
            M, C, K = (matrix.toarray() for matrix in (M, C, K))
        if not stiffness.shape[0] or not (_alike(K, 1.0) and _alike(C, -1.0)):
            return None
        symmetric = 0.5 * (K + K.T)
        solve = _positive(symmetric)
        return None if solve is None else cls(M, 0.5 * (C - C.T), symmetric, basis, solve)

    def _at(self, frequency: float) -> Any:
        """Return the Hermitian matrix of motions with an angular frequency [rad/s]."""
        return self.stiffness - frequency**2 * self.mass + (1j * frequency) * self.gyroscopic

    @property
    def size(self) -> int:
        """Number of motions of first order."""
        return 2 * int(self.mass.shape[0])

    def increments(self, _: complex, y: np.ndarray) -> np.ndarray:
        """Return the body increments ``(6 n,)`` of a motion ``(m,)``."""
        return np.asarray(self.basis @ y)

    def residuals(self, s: np.ndarray, y: np.ndarray) -> Floats:
        """Return what motions (columns) leave of each equation of first order, as a part of what adds up to it."""
        parts = [self.stiffness @ y, s * (self.gyroscopic @ y), s**2 * (self.mass @ y)]
        left, sizes = np.abs(sum(parts)), np.abs(y)
        below = abs(self.stiffness) @ sizes + np.abs(s) * (
            abs(self.gyroscopic) @ sizes + np.abs(s) * (abs(self.mass) @ sizes)
        )
        size = np.maximum(below.max(axis=0, initial=0.0), (2.0 * np.abs(s) * sizes).max(axis=0, initial=0.0))
        return np.asarray(left.max(axis=0, initial=0.0) / np.maximum(size, 1e-300))

    def slowest(self, count: int) -> Slowest:
        """Return the ``count`` slowest motions, or all if there are less."""
        m = self.size // 2
        count, found = min(count, m), None
        for block in BLOCKS:
            if 4 * count + FIRST > PART * self.size or block > m:
                break
            found = self._found(count, block)
            if found.complete:
                return self._refined(found)
        if found is None or self.size <= LARGE:
            found = self._of_all(count)
        return self._refined(found)

    def _of_all(self, count: int) -> Slowest:
        """Return the ``count`` slowest motions from full matrices."""
        lower, of_mass = (np.linalg.cholesky(_full(matrix)) for matrix in (self.stiffness, self.mass))
        inverse = np.linalg.inv(lower)
        coupled = inverse @ of_mass
        inner = np.block(
            [[-inverse @ (self.gyroscopic @ inverse.T), -coupled], [coupled.T, np.zeros_like(lower)]]
        )
        values, weights = np.linalg.eigh(0.5j * (inner - inner.T))
        order = np.argsort(-values)[:count]
        return Slowest(1.0 / values[order], inverse.T @ weights[: len(lower), order], True)

    def _refined(self, found: Slowest) -> Slowest:
        """Return the same with the fast ones, of which an inverse tells less, as exact as the slow ones.

        One iteration with the inverse at its own frequency and a Rayleigh quotient make each of them anew.
        """
        frequencies, motions = found.frequencies.copy(), found.motions.copy()
        for k in np.flatnonzero(frequencies > FAST * frequencies[0]):
            w, y = frequencies[k], motions[:, k]
            try:
                y = SparseLU(self._at(float(w))).solve(2.0 * w * (self.mass @ y) - 1j * (self.gyroscopic @ y))
            except RuntimeError:  # it is the frequency to the last digit
                continue
            y /= np.linalg.norm(y)
            stiff, inert, turning = (
                float(np.vdot(y, matrix @ y).real)
                for matrix in (self.stiffness, self.mass, 1j * self.gyroscopic)
            )
            motions[:, k] = y
            frequencies[k] = 0.5 * (turning + np.sqrt(turning**2 + 4.0 * stiff * inert)) / inert
        return Slowest(frequencies, motions, found.complete)

    def _found(self, count: int, block: int) -> Slowest:
        """Return the ``count`` slowest motions from a Krylov space."""
        space = _Krylov(self, block)
        wanted, most = 4 * count + FIRST, int(PART * self.size)
        while True:
            space.grow(wanted)
            frequencies, rough, weights = space.values()
            last = wanted >= most or space.exhausted
            known = int(np.argmin(np.append(rough < CONVERGED, False)))
            if known >= count or last:
                at = self._counted(frequencies, rough, count)
                if at is not None or last:
                    complete = at is not None and self.below(at) == int(np.count_nonzero(frequencies < at))
                    complete = complete and known >= count
                    return Slowest(frequencies[:count], space.motions(weights[:, :count]), complete)
            wanted = min(int(FURTHER * wanted) + 2, most)

    @staticmethod
    def _counted(frequencies: Floats, rough: Floats, count: int) -> float | None:
        """Return a frequency in a gap beyond the ``count`` slowest; None if none is known."""
        for k in range(count, len(frequencies)):
            if rough[k] > ROUGH:
                return None
            low, high = frequencies[k - 1], frequencies[k]
            if high - low > GAP * high:
                return float(0.5 * (low + high))
        return None

    def below(self, frequency: float) -> int | None:
        """Return how many motions are slower than a frequency [rad/s], by signs of pivots; None if one vanishes."""
        matrix = self._at(frequency)
        if isinstance(matrix, np.ndarray):
            pivots, exchanged, failed = scipy.linalg.lapack.zhetrf(matrix, lower=1)
            double = np.count_nonzero(exchanged < 0) // 2  # each has one negative eigenvalue
            single = np.count_nonzero(pivots.diagonal().real[exchanged > 0] < 0.0)
            return None if failed else int(single + double)
        factor = factor_without_exchanges(sparse.csc_array(matrix))
        return None if factor is None else int(np.count_nonzero(factor.U.diagonal().real < 0.0))


def _full(matrix: Any) -> Floats:
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def _alike(matrix: Any, sign: float) -> bool:
    """Return whether a matrix is symmetric (1) or skew (-1) but for round-off."""
    return bool(abs(matrix - sign * matrix.T).max() <= ROUND_OFF * abs(matrix).max())


def _positive(matrix: Any) -> Callable[[Floats], Floats] | None:
    """Return what solves with a symmetric matrix if it is surely positive definite, else None."""
    if isinstance(matrix, np.ndarray):
        if not surely_positive(matrix):
            return None
        root = scipy.linalg.cholesky(matrix, lower=True, check_finite=False)
        potrs = scipy.linalg.lapack.dpotrs
        return lambda b: np.asarray(potrs(root, b, lower=1)[0])
    factor = surely_positive_factors(sparse.csc_array(matrix))
    return None if factor is None else factor.solve


class _Krylov:
    """A block Krylov space of the inverse, orthonormal in the scalar product of the energy.

    Vectors are ``(f, g)``: motions and rates. With each is kept ``(K f, M g)``, which the inverse tells more accurately
    than a product with K would.
    """

    def __init__(self, system: LosslessMotions, block: int) -> None:
        self.system, self.m = system, system.size // 2
        self.count = self.done = 0
        self.vectors, self.images = np.empty((2, 0, 0))
        self.inner: Floats = np.zeros((0, 0))
        self.exhausted = False
        self._reserve(8 * block)
        random = np.random.default_rng(1)
        self._append(*self._applied(*random.standard_normal((2, self.m, block))))

    def grow(self, wanted: int) -> None:
        """Let the inverse act on the newest vectors until there are so many that it has acted on."""
        while self.done < wanted and not self.exhausted:
            first, last = self.done, self.count
            self._append(
                *self._applied(self.vectors[: self.m, first:last], self.images[self.m :, first:last])
            )
            self.done = last

    def values(self) -> tuple[Floats, Floats, np.ndarray]:
        """Return frequencies, slowest first, what their vectors leave as a part of the inverse, and their weights."""
        p = self.done
        inner = self.inner[:p, :p]
        inverse, weights = np.linalg.eigh(0.5j * (inner - inner.T))
        order = np.flatnonzero(inverse > 0.0)[::-1]
        inverse, weights = inverse[order], weights[:, order]
        left = np.linalg.norm(self.inner[p : self.count, :p] @ weights, axis=0)
        return 1.0 / inverse, left / inverse, weights

    def motions(self, weights: np.ndarray) -> np.ndarray:
        """Return the motions ``(m, k)`` that have weights."""
        return np.asarray(self.vectors[: self.m, : self.done] @ weights)

    def _applied(self, f: Floats, momentum: Floats) -> tuple[Floats, Floats]:
        """Return the inverse of ``(f, g)``, and the image of that, from f and ``M g``."""
        system, m = self.system, self.m
        made, image = np.empty((2, 2 * m, f.shape[1]))
        image[:m] = -(system.gyroscopic @ f + momentum)
        made[:m] = system.solve(image[:m])
        made[m:] = f
        image[m:] = system.mass @ f
        return made, image

    def _append(self, made: Floats, image: Floats) -> None:
        """Add what is new in some vectors, and keep what is not in the matrix of the inverse in this space."""
        p, b = self.count, made.shape[1]
        self._reserve(p + b)
        known, images = self.vectors[:, :p], self.images[:, :p]
        sizes, turned = np.sqrt(np.einsum("ik,ik->k", made, image)), np.eye(b)
        inside: Floats = np.zeros((p, b))
        for _ in range(3):  # twice is enough, but where hardly anything is new
            parts = images.T @ made
            made, image = made - known @ parts, image - images @ parts
            inside += parts @ turned
            made, image, root = self._orthonormal(made, image, sizes)
            turned, left = root @ turned, root.diagonal()
            if (left > 0.5 * sizes[: len(left)]).all():
                break
            sizes = np.ones(made.shape[1])
        new = slice(p, p + made.shape[1])
        self.vectors[:, new], self.images[:, new], self.count = made, image, new.stop
        self.exhausted = new.start == new.stop
        if p:
            columns = slice(self.done, self.done + b)
            self.inner[:p, columns], self.inner[new, columns] = inside, turned

    def _orthonormal(self, made: Floats, image: Floats, sizes: Floats) -> tuple[Floats, Floats, Floats]:
        """Return orthonormal vectors, their images, and the weights ``(k, b)`` that make the given ones of them.

        ``sizes (b,)`` were theirs, of which round-off is a part: with little left of one it has no image but its own,
        and with nothing it is left out. By Gram and Schmidt, for there are few.
        """
        m, b, count = self.m, made.shape[1], 0
        back: Floats = np.zeros((b, b))
        new, images = np.empty((2, made.shape[0], b))
        for j in range(b):
            x, y = made[:, j], image[:, j]
            if count:
                back[:count, j] = parts = images[:, :count].T @ x
                x, y = x - new[:, :count] @ parts, y - images[:, :count] @ parts
            size = math.sqrt(max(float(x @ y), 0.0))
            if size <= EXHAUSTED * sizes[j]:
                continue
            new[:, count], images[:, count], back[count, j] = x / size, y / size, size
            if size < DOUBTFUL * sizes[j]:
                images[:m, count] = self.system.stiffness @ new[:m, count]
                images[m:, count] = self.system.mass @ new[m:, count]
            count += 1
        return new[:, :count], images[:, :count], back[:count]

    def _reserve(self, count: int) -> None:
        """Make room for so many vectors."""
        there = self.vectors.shape[1]
        if count <= there:
            return
        room = max(count, 2 * there)
        for name in ("vectors", "images"):
            wider: Any = np.zeros((2 * self.m, room), order="F")
            wider[:, : self.count] = getattr(self, name)[:, : self.count] if there else 0.0
            setattr(self, name, wider)
        inner = np.zeros((room, room))
        inner[:there, :there] = self.inner[:there, :there]
        self.inner = inner
