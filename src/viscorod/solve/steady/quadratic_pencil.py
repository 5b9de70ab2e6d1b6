"""Small motions ``M y'' + C y' + K y = 0`` as a first-order system, and its shifted inverse.

In the free motions y of the nodes they are the roots of ``det Q(s) = 0``, ``Q(s) = s^2 M + s C + K``, without those of
the copies of a rotation. With ``u = y' + A y`` they are the eigenvalues of a first-order system, of which a shifted
inverse needs the factors of ``Q`` alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.solve.modes.linearisation import factored
from viscorod.typing import Floats

__all__ = ["QuadraticPencil", "ShiftedInverse"]

RESTING = 1e-12
"""Part of the largest entry of C1 below which ``C1 Z`` of a copy is 0."""


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


class ShiftedInverse:
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
