"""The eigenvalue problem of undamped vibrations: its matrices without rigid motions, and what round-off spoils."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.modes.linearisation import EPS, Linearisation, beyond_precision, factored
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.solve.statics.work import PRECISE
from viscorod.typing import Floats

__all__ = ["VibrationProblem"]


class VibrationProblem:
    """``K x = w^2 M x`` without rigid motions, which are eliminated: ``R' M x = 0``.

    Args:
        linear: small motions, which may keep this object: it refers to parts of them only.
        full: whether to keep full matrices, which take less than calls of SciPy where they are small.
    """

    def __init__(self, linear: Linearisation, *, full: bool = False) -> None:
        k = linear.rigid
        self.basis, self.gradients, self.work = linear.basis, linear.gradients, linear.work
        self.levers = linear.levers
        self.motions, self.k = linear.motions, k
        self.K: sparse.csr_array | Floats
        self.M: sparse.csr_array | Floats
        if full:
            stiffness, self.M = linear.stiffness.toarray(), linear.mass.toarray()
            self.K = 0.5 * (stiffness + stiffness.T)
        else:
            self.K = sparse.csr_array(0.5 * (linear.stiffness + linear.stiffness.T))
            self.M = linear.mass
        self.size = self.M.shape[0]
        rigid = np.zeros((self.size, k))
        rigid[:k] = np.eye(k)
        if k:
            own = linear.mass[:k, :k].toarray()
            inertia, directions = np.linalg.eigh(own)
            heavy = inertia > EPS * k * inertia.max()  # what has neither mass nor stiffness does not matter
            if heavy.all():
                root = scipy.linalg.cholesky(own)
                rigid[:k] = scipy.linalg.solve_triangular(root, np.eye(k))
            else:
                rigid = np.zeros((self.size, int(heavy.sum())))
                rigid[:k] = directions[:, heavy] / np.sqrt(inertia[heavy])
        self.rigid = rigid
        self._momenta = self.M @ rigid

    def require_finite(self) -> None:
        """Refuse matrices with entries that are no numbers."""
        if not np.isfinite(self.K.diagonal()).all() or not np.isfinite(self.M.diagonal()).all():
            raise beyond_precision()

    def inertia(self, x: np.ndarray) -> np.ndarray:
        """Return mass times ``x``, without the momenta of rigid motions."""
        return np.asarray(self.M @ self.without_rigid(x))

    def without_rigid(self, x: np.ndarray) -> np.ndarray:
        """Return motions ``(size, ...)`` orthogonal to rigid ones."""
        return np.asarray(x - self.rigid @ (self._momenta.T @ x))

    def normalised(self, x: Floats) -> Floats:
        """Return columns with ``x.M x = 1``."""
        size = np.sqrt(np.einsum("ik,ik->k", x, self.M @ x))
        return np.asarray(x / size)

    def solver(self, square: float) -> Callable[[np.ndarray], np.ndarray]:
        """Return the inverse of ``K - square M`` in the motions without rigid ones.

        Raises:
            SolveError: it is singular.
        """
        k = self.k if square == 0.0 else 0
        A = sparse.csr_array(self.K - square * self.M)[k:, k:]
        G = self.gradients
        rows = 0
        if G is not None:
            scale = float(np.abs(A.diagonal()).mean())
            G = sparse.csr_array(G[:, k:]) * scale
            rows = G.shape[0]
            A = sparse.block_array([[A + G.T @ G / scale, G.T], [G, None]])
        factor = factored(A)

        def solve(b: np.ndarray) -> np.ndarray:
            if np.iscomplexobj(b):
                return np.asarray(solve(b.real.copy()) + 1j * solve(b.imag.copy()))
            right = np.concatenate([b[k:], np.zeros((rows, *b.shape[1:]))])
            x = np.zeros(b.shape)
            x[k:] = factor.solve(right)[: len(b) - k]
            return self.without_rigid(x)

        return solve

    def below(self, square: float) -> int:
        """Return the number of modes, rigid ones too if ``square`` is positive, with ``w^2 < square``."""
        shifted = sparse.csr_array(self.K - square * self.M)
        work = self.work
        if work is not None:
            work = work.plus(self.M, -square)
        return negative_eigenvalues(Tangent(shifted, self.basis, self.gradients, work))

    def refined(
        self, squares: Floats, shapes: Floats, precise: float = PRECISE, sizes: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Return ``w^2`` and shapes again, by the work of shapes where the rounding of the stiffness spoils them.

        They are those of Rayleigh and Ritz in the space of these shapes.

        Args:
            squares, shapes: what was found; precise: part of ``w^2`` that rounding may spoil.
            sizes: what :meth:`sizes` returns for them, if it is known.
        """
        work = self.work
        poor = EPS * (self.sizes(shapes) if sizes is None else sizes) > precise * np.abs(squares)
        if work is None or not poor.any():
            return squares, shapes
        slow = shapes[:, poor]
        form, _ = work.form(slow)
        new, turn = scipy.linalg.eigh(form, slow.T @ (self.M @ slow))
        squares, shapes = squares.copy(), shapes.copy()
        squares[poor], shapes[:, poor] = new, slow @ turn
        order = np.argsort(squares, kind="stable")
        return squares[order], shapes[:, order]

    def sizes(self, shapes: Floats) -> Floats:
        """Return the sums of the sizes of all terms of ``x.K x``, of which one part in 1e16 is round-off."""
        return np.asarray(np.einsum("ik,ik->k", np.abs(shapes), abs(self.K) @ np.abs(shapes)))

    def neutral(self, squares: Floats, shapes: Floats, sizes: Floats | None = None) -> np.ndarray:
        """Return which shapes, of unit inertia, have no stiffness but round-off; ``sizes`` as in :meth:`refined`."""
        levers = np.zeros(shapes.shape[1])
        if self.levers is not None:
            levers = self.levers @ np.abs(self.basis @ shapes) ** 2
        found = np.abs(squares) <= 10.0 * EPS * ((self.sizes(shapes) if sizes is None else sizes) + levers)
        if self.work is not None and found.any():
            _, size = self.work.form(shapes[:, found])
            found[found] = np.abs(squares[found]) <= 10.0 * EPS * (size + levers[found])
        return found
