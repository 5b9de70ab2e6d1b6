"""Small motions at one value of a parameter: all slow roots at once, or one of them from a good guess.

In free motions y they are ``s^2 M + s C + K + sum_j s tau_j/(1 + s tau_j) K_j``, of which copies of the same rotation
seen from elsewhere are no motions. Slow roots are found by a block Krylov space of the inverse about a real shift
(Saad, Numerical Methods for Large Eigenvalue Problems, 2nd ed., 2011, 6.5): blocks find roots that coincide, as those
of round shafts do. With Maxwell branches K_j each root starts from that without them, and they grow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.steady.quadratic_pencil import QuadraticPencil
from viscorod.typing import Floats

__all__ = ["MovingPencil", "Spectrum"]

BLOCK = 4
"""Vectors of a block: roots that coincide at most."""
CONVERGED, SURE = 1e-13, 1e-6
"""Change of a root, as a part of it, that is round-off; and by which it has converged at all."""
ALIKE = 1e-8
"""Difference of the sizes of two roots, as a part of them, that is round-off."""
EXHAUSTED = 1e-12
"""Part of a block that is round-off where nothing new is left."""
FASTEST = 1e-10
"""Inverse root, as a part of the largest, below which it is round-off: that of what has next to no inertia."""
RESIDUAL = 1e-12
"""What a vector may leave of the inverse, as a part of the largest inverse root."""
ITERATIONS = 15
FAR = 0.3
"""Part of a root by which a growing part of branches may move it."""
SMALL = 0.01
"""Part of the distance that a root may move by which small ones are measured."""
FULL = 1000
"""Unknowns of first order up to which the Krylov space may be everything."""
GROWING = (0.1, 0.3, 0.6, 1.0)
"""Parts of Maxwell branches through which roots are followed from those without."""


@dataclass(frozen=True)
class Spectrum:
    """Roots ``s`` [1/s], one of each pair (Im >= 0), slowest first, and their motions as body increments ``(6 n, m)``.

    ``complete``: all up to the largest ``|s|`` are there, as far as the iteration tells. ``space``: dimension of the
    space in which they were found.
    """

    roots: np.ndarray
    shapes: np.ndarray
    complete: bool = True
    space: int = 0


@dataclass(frozen=True)
class MovingPencil:
    """Small motions at one value of the parameter.

    Attributes:
        quadratic: without branches, in free motions; branches, times: K_j of these and their times [s].
        basis: free motions as body increments of the nodes ``(6 n, free)``.
    """

    quadratic: QuadraticPencil
    basis: sparse.csr_array
    branches: tuple[sparse.csr_array, ...] = ()
    times: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """Number of motions of first order."""
        return 2 * self.quadratic.size - int(self.quadratic.Z.shape[1])

    def slowest(self, count: int, reach: float, shift: float, space: int = 0) -> Spectrum:
        """Return at least ``count`` roots and all with ``|s| < reach`` [1/s], from a real ``shift`` [1/s].

        ``space``: dimension of the space in which those of a similar pencil were found; what is wanted is only looked
        for from there on.

        Raises:
            SolveError: they were not found.
        """
        roots, vectors, complete, space = _Krylov(self.quadratic, shift).slowest(count, reach, space)
        if self.branches:
            kept = np.flatnonzero(roots.imag > 0.0)
            found = [self._with_branches(complex(roots[k]), vectors[:, k]) for k in kept]
            pairs = [pair for pair in found if pair is not None]
            if not pairs:
                raise SolveError("The small motions with Maxwell branches were not found")
            roots = np.array([s for s, _ in pairs])
            vectors = np.array([y for _, y in pairs]).T
            distinct = [k for k in range(len(roots)) if not _again(roots, vectors, k)]
            roots, vectors, complete = roots[distinct], vectors[:, distinct], len(distinct) == len(kept)
        order = _slowest_first(roots)
        return Spectrum(roots[order], np.asarray(self.basis @ vectors[:, order]), complete, space)

    def refined(self, s: complex, shape: np.ndarray, far: float) -> tuple[complex, np.ndarray] | None:
        """Return the root next to ``s`` whose motion is like a shape ``(6 n,)``, by Newton's method; None without.

        Args:
            s, shape: the guess; far: distance [1/s] beyond which another root is not meant.
        """
        found = self._newton(s, self._coordinates(shape), 1.0, far)
        return None if found is None else (found[0], np.asarray(self.basis @ found[1]))

    def stiffness_near_zero(self, shape: np.ndarray) -> float:
        """Return the eigenvalue of the stiffness over the inertia that is nearest to zero for motions like a shape.

        It changes its sign where a motion diverges [1/s^2].
        """
        p = self.quadratic
        x = self._coordinates(shape).real
        if not x.any():
            x = self._coordinates(shape).imag
        border = p.Z.shape[1]
        try:
            factor = SparseLU(p.at_rest())
        except RuntimeError:  # a pivot is exactly zero: just here the stiffness vanishes
            return 0.0
        value = np.inf
        for _ in range(100):
            x /= np.sqrt(x @ (p.M @ x))
            better = factor.solve(np.concatenate([p.M @ x, np.zeros(border)]))[: p.size]
            before, value = value, 1.0 / float(x @ (p.M @ better))
            x = better
            if abs(value - before) <= 1e-14 * abs(value):
                break
        return value

    def _coordinates(self, shape: np.ndarray) -> np.ndarray:
        parts = np.column_stack([shape.real, shape.imag])
        found = self._gram.solve(np.asarray(self.basis.T @ parts))
        return self.quadratic.without_copies(found[:, 0] + 1j * found[:, 1])

    @cached_property
    def _gram(self) -> SparseLU:
        return SparseLU(self.basis.T @ self.basis)

    def _with_branches(self, s: complex, y: np.ndarray) -> tuple[complex, np.ndarray] | None:
        """Return the root to which one without branches leads as they grow."""
        for part in GROWING:
            found = self._newton(s, y, part, FAR * abs(s))
            if found is None:
                return None
            s, y = found
        return s, y

    def _newton(
        self, s: complex, y: np.ndarray, part: float, far: float
    ) -> tuple[complex, np.ndarray] | None:
        """Return a root and its vector near a guess by inverse iteration, Newton's method on both."""
        p, c = self.quadratic, self.quadratic.Z.shape[1]
        border = sparse.csr_array(p.M @ p.Z) if c else None
        v = np.concatenate([y, np.zeros(c)]).astype(complex)
        against, start, last = v.conj() / np.vdot(v, v).real, s, np.inf
        for _ in range(ITERATIONS):
            matrix, slope = p.at(s), 2.0 * s * (p.M @ v[: p.size]) + p.C @ v[: p.size]
            for K, tau in zip(self.branches, self.times, strict=True):
                more = part * (s * tau / (1.0 + s * tau)) * K
                if c:
                    more = sparse.block_diag([more, sparse.csr_array((c, c))])
                matrix = matrix + more
                slope = slope + part * tau / (1.0 + s * tau) ** 2 * (K @ v[: p.size])
            if border is not None:
                slope = slope + border @ v[p.size :]
            try:
                better = SparseLU(matrix.astype(complex)).solve(np.concatenate([slope, np.zeros(c)]))
            except RuntimeError:  # exactly singular: this is the root
                return s, v[: p.size]
            scale = against @ better
            if not np.isfinite(scale) or scale == 0.0:
                return None
            change = -(against @ v) / scale
            v, s = better / scale, s + change
            if abs(s - start) > far:
                return None
            before, last = last, float(abs(change)) / max(abs(s), SMALL * far)
            if last <= CONVERGED or (before < SURE and last > 0.1 * before):
                break
        return (s, v[: p.size]) if last <= SURE else None


def _slowest_first(roots: np.ndarray) -> np.ndarray:
    """Return the order by size; of roots of one size, as two that flutter without damping are, growing ones first."""
    order = np.argsort(np.abs(roots), kind="stable")
    sizes = np.abs(roots[order])
    group = np.cumsum(np.diff(sizes, prepend=sizes[:1]) > ALIKE * sizes)
    return order[np.lexsort((-roots[order].real, group))]


def _again(roots: np.ndarray, vectors: np.ndarray, k: int) -> bool:
    """Return whether a root is one of those before it, to which another start led too."""
    for j in range(k):
        if abs(roots[j] - roots[k]) < ALIKE * abs(roots[k]):
            x, y = vectors[:, j], vectors[:, k]
            if abs(np.vdot(x, y)) ** 2 > 0.999999 * np.vdot(x, x).real * np.vdot(y, y).real:
                return True
    return False


def _orthonormal(W: Floats, known: Floats, size: float, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Return an orthonormal block and its coefficients; random directions without any where the space is exhausted."""
    new, rest = np.linalg.qr(W)
    new, again = np.linalg.qr(new - known @ (known.T @ new))  # what is small may not be orthogonal yet
    lost = (np.abs(np.diag(rest)) <= EXHAUSTED * size) | (np.abs(np.diag(again)) < 0.5)
    rest = again @ rest
    if lost.any():
        new[:, lost] = random.standard_normal((len(W), int(lost.sum())))
        for _ in range(3):
            new[:, lost] -= known @ (known.T @ new[:, lost])
            new, turn = np.linalg.qr(new)
        rest[lost] = 0.0
        signs = np.sign(np.diag(turn))
        new = new * np.where(lost, 1.0, signs)
    return new, rest


class _Krylov:
    """A block Krylov space of ``(matrix - shift mass)^-1 mass`` of a quadratic pencil of first order."""

    def __init__(self, pencil: QuadraticPencil, shift: float) -> None:
        self.pencil, self.shift = pencil, shift
        p = pencil
        self.H = sparse.csr_array(shift * p.M + p.C1)
        self.copies = p.Z.shape[1]
        try:
            self.factor = SparseLU(p.at(shift))
        except RuntimeError:
            raise SolveError("The small motions were not found: their matrix is singular") from None

    def apply(self, z: Floats) -> Floats:
        """Return the inverse times the mass times columns z."""
        p, m = self.pencil, self.pencil.size
        f, g = z[:m], np.asarray(p.M @ z[m:])
        right = -g - self.H @ f
        if not self.copies:
            y = self.factor.solve(right)
            return np.concatenate([y, self.shift * y + p.A @ y + f])
        f = p.without_copies(f)
        right = -g - self.H @ f
        both = self.factor.solve(np.concatenate([right, np.zeros((self.copies, z.shape[1]))]))
        y, mu = both[:m], both[m:]
        return np.concatenate([y, self.shift * y + p.A @ y + p.Z @ mu + f])

    def _units(self) -> Floats:
        """Return sizes of the unknowns that have about the same energy: in them the inverse is nearly normal."""
        p = self.pencil
        stiff, mass = np.abs(p.K.diagonal()), np.abs(p.M.diagonal())
        least = 1e-12 * float((stiff / mass).max()) * mass
        return np.concatenate([1.0 / np.sqrt(np.maximum(stiff, least)), 1.0 / np.sqrt(mass)])

    def slowest(self, count: int, reach: float, space: int) -> tuple[np.ndarray, np.ndarray, bool, int]:
        """Return at least ``count`` roots, one of each pair, and all up to ``reach``, with their vectors ``(m, k)``.

        The third is whether these are all, the last the dimension of the space, ``space`` at least.
        """
        p = self.pencil
        size = 2 * p.size
        most = min(size - self.copies, FULL)
        random = np.random.default_rng(1)
        unit = self._units()[:, None]

        def step(V: Floats) -> Floats:
            return self.apply(V * unit) / unit

        start, _ = np.linalg.qr(step(step(random.standard_normal((size, BLOCK)))))
        V, H = np.empty((size, most + BLOCK), order="F"), np.zeros((most + BLOCK, most + BLOCK))
        V[:, :BLOCK] = start
        done, wanted = 0, min(most, max(6 * count + 20, space))
        while True:
            while done < wanted:
                mine = slice(done, done + BLOCK)
                W, known = step(V[:, mine]), V[:, : done + BLOCK]
                along = known.T @ W
                W = W - known @ along
                again = known.T @ W
                W = W - known @ again
                H[: done + BLOCK, mine] += along + again
                new, rest = _orthonormal(W, known, float(np.abs(along).max()), random)
                done += BLOCK
                if done >= most:
                    break
                V[:, done : done + BLOCK], H[done : done + BLOCK, mine] = new, rest
            full = done >= most
            theta, z = np.linalg.eig(H[:done, :done])
            order = np.argsort(-np.abs(theta), kind="stable")
            theta, z = theta[order], z[:, order]
            left = 0.0 * np.abs(theta)
            if not full:
                left = np.linalg.norm(H[done : done + BLOCK, :done] @ z, axis=0)
            with np.errstate(divide="ignore", invalid="ignore"):
                s = self.shift + 1.0 / theta
            good = (left <= RESIDUAL * np.abs(theta[0])) & (np.abs(theta) > FASTEST * np.abs(theta[0]))
            first_bad = int(np.argmin(good)) if not good.all() else len(good)
            s, z = s[:first_bad], z[:, :first_bad]
            known_up_to = float(np.abs(s[-1] - self.shift)) - abs(self.shift) if len(s) else 0.0
            upper = s.imag >= -1e-12 * np.abs(s)
            enough = np.count_nonzero(upper) >= count and known_up_to > reach
            if full or enough:
                s, z = s[upper], z[:, upper]
                bound = 1.001 * max(reach, float(np.sort(np.abs(s))[: max(count, 1)].max(initial=0.0)))
                s, z = s[np.abs(s) <= bound], z[:, np.abs(s) <= bound]
                y = unit[: p.size] * (V[: p.size, :done] @ z)
                s = np.where(np.abs(s.imag) <= 1e-9 * np.abs(s), s.real + 0j, s)
                return s, y, full or bool(enough), done
            wanted = min(most, int(1.35 * done) + 16)
