"""Undamped modes, certified: rigid motions are known from geometry, and an inertia count proves that none is missing.

The symmetric problem ``K x = w^2 M x`` is solved for its slowest modes, or for those nearest to a frequency, by Lanczos
iterations on the inverse; small ones with full matrices. By Sylvester's law of inertia the number of negative pivots of
``K - m M`` is that of modes with ``w^2 < m``: where fewer were found, the search goes on beside those until they agree
(Ericsson and Ruhe 1980, Grimes, Lewis and Simon 1994).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.modes.linearisation import DENSE, EPS, Linearisation, beyond_precision, factored
from viscorod.solve.once import once
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.solve.statics.work import PRECISE
from viscorod.typing import Floats

EXTRA = 4
"""Modes found beside those that are asked for, to end at a gap between frequencies."""
GAP = 1e-4
"""Relative distance of squared frequencies that makes a gap."""
MANY = 30
"""Modes of one frequency above which not all of them are sought: in a thousand equal rods there are two thousand."""
ATTEMPTS = 6
"""How often the search is begun anew where modes are missing."""
TOLERANCE = 1e-12


@dataclass(frozen=True)
class Undamped:
    """Undamped modes in the motions of a linearisation, ``phi.M phi = 1``, rigid ones apart.

    Attributes:
        linear: the motions in which they are given.
        rigid: motions without any stiffness ``(size, k)``, orthonormal as well; neutral ones behind those of geometry.
        squares: ``w^2`` of the others [1/s^2], increasing; negative where the equilibrium is unstable.
        shapes: of the same ``(size, m)``.
        first: how many modes lie below them; 0 unless those near a frequency were sought.
        complete: they are all that there are.
        certified: an inertia count, or full matrices, proved that none is missing between them, but for others of the
            frequency of the last.
    """

    linear: Linearisation
    rigid: Floats
    squares: Floats
    shapes: Floats
    first: int
    complete: bool
    certified: bool
    flexibility: Callable[[np.ndarray], np.ndarray]
    """Displacements under forces ``(size, m)``, without rigid motions."""

    def accelerations(self, forces: np.ndarray) -> np.ndarray:
        """Return those under ``forces (size, m)``, of a ``complete`` set of modes, without rigid motions."""
        return np.asarray(self.shapes @ (self.shapes.T @ forces))


class _Problem:
    """``K x = w^2 M x`` without rigid motions, which are eliminated: ``R' M x = 0``."""

    def __init__(self, linear: Linearisation) -> None:
        k = linear.rigid
        self.linear, self.k = linear, k
        self.K = sparse.csr_array(0.5 * (linear.stiffness + linear.stiffness.T))
        self.M = linear.mass
        self.size = self.M.shape[0]
        rigid = np.zeros((self.size, k))
        rigid[:k] = np.eye(k)
        if k:
            inertia, directions = np.linalg.eigh(self.M[:k, :k].toarray())
            heavy = inertia > EPS * k * inertia.max()  # what has neither mass nor stiffness does not matter
            if heavy.all():
                root = scipy.linalg.cholesky(self.M[:k, :k].toarray())
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
        G = self.linear.gradients
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
        work = self.linear.work
        if work is not None:
            work = work.plus(self.M, -square)
        return negative_eigenvalues(Tangent(shifted, self.linear.basis, self.linear.gradients, work))

    def refined(
        self, squares: Floats, shapes: Floats, precise: float = PRECISE, sizes: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Return ``w^2`` and shapes again, by the work of shapes where the rounding of the stiffness spoils them.

        They are those of Rayleigh and Ritz in the space of these shapes.

        Args:
            squares, shapes: what was found; precise: part of ``w^2`` that rounding may spoil.
            sizes: what :meth:`sizes` returns for them, if it is known.
        """
        work = self.linear.work
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
        found = np.abs(squares) <= 10.0 * EPS * (self.sizes(shapes) if sizes is None else sizes)
        if self.linear.work is not None and found.any():
            _, size = self.linear.work.form(shapes[:, found])
            found[found] = np.abs(squares[found]) <= 10.0 * EPS * size
        return found


def undamped_modes(
    linear: Linearisation, count: int, near: float | None = None, *, precise: float = PRECISE
) -> Undamped:
    """Return at least ``count`` modes, if there are as many: the slowest, or those nearest to a frequency.

    Args:
        linear: small motions about an equilibrium.
        count: of modes beside rigid motions.
        near: angular frequency [rad/s].
        precise: part of ``w^2`` that rounding may spoil, where all modes are found; beyond, the work of shapes tells.
    """
    dense = linear.gradients is None and linear.mass.shape[0] <= DENSE
    if not dense and count + EXTRA >= linear.motions - linear.rigid - 1:
        linear, dense = linear.unconditional(), True
    if dense:
        return _of_full_matrices(linear, precise)
    problem = _Problem(linear)
    problem.require_finite()
    return _of_iteration(problem, count, 0.0 if near is None else near**2)


class _AllModes(NamedTuple):
    """All modes of a problem as full matrices have them, with the sizes of their terms (:meth:`_Problem.sizes`)."""

    problem: _Problem
    squares: Floats
    shapes: Floats
    sizes: Floats


@once
def _all_modes(linear: Linearisation) -> _AllModes:
    """Return all modes by full matrices.

    Eigenvalues of the inverse problem are accurate for slow modes, Rayleigh quotients of its vectors for fast ones.
    """
    problem = _Problem(linear)
    problem.require_finite()
    k, size = problem.k, problem.size
    K = problem.K[k:, k:].toarray()
    lift = problem.without_rigid(np.eye(size)[:, k:])
    M = lift.T @ (problem.M @ lift)
    M = 0.5 * (M + M.T)
    try:
        inverse, shapes = scipy.linalg.eigh(M, K)
        kept = inverse > EPS * size * inverse.max(initial=0.0) * 1e-3
        inverse, shapes = inverse[kept][::-1], shapes[:, kept][:, ::-1]
        squares = 1.0 / inverse
    except np.linalg.LinAlgError:  # an unstable or neutral equilibrium
        squares, shapes = _indefinite(K, M)
    shapes = problem.normalised(lift @ shapes)
    # where the inverse has lost digits, the shape has them: its error counts squared
    energies = np.einsum("ik,ik->k", shapes, problem.K @ shapes)
    sizes = problem.sizes(shapes)
    lowest = np.abs(squares).min(initial=np.inf)
    fast = np.abs(squares) > np.sqrt(lowest) * np.sqrt(np.maximum(sizes, np.abs(squares)))
    squares = np.where(fast, energies, squares)
    order = np.argsort(squares, kind="stable")
    return _AllModes(problem, squares[order], shapes[:, order], sizes[order])


def _of_full_matrices(linear: Linearisation, precise: float = PRECISE) -> Undamped:
    """Return all modes."""
    problem, raw, raw_shapes, sizes = _all_modes(linear)
    squares, shapes = problem.refined(raw, raw_shapes, precise, sizes)
    neutral = problem.neutral(squares, shapes, sizes if shapes is raw_shapes else None)
    rigid = np.hstack([problem.rigid, shapes[:, neutral]])
    squares, shapes = squares[~neutral], shapes[:, ~neutral]
    flexible = shapes / squares

    def flexibility(b: np.ndarray) -> np.ndarray:
        return np.asarray(flexible @ (shapes.T @ b))

    return Undamped(problem.linear, rigid, squares, shapes, 0, True, True, flexibility)


def _indefinite(K: Floats, M: Floats) -> tuple[Floats, Floats]:
    """Return eigenvalues and vectors of ``K x = w^2 M x`` where ``K`` is not positive definite."""
    try:
        lowest = float(scipy.linalg.eigh(K, M, eigvals_only=True, subset_by_index=(0, 0))[0])
        shift = 2.0 * abs(lowest)
        for _ in range(20):
            try:
                inverse, shapes = scipy.linalg.eigh(M, K + shift * M)
            except np.linalg.LinAlgError:
                shift *= 10.0
                continue
            kept = inverse > 0.0
            return 1.0 / inverse[kept] - shift, shapes[:, kept]
    except np.linalg.LinAlgError:
        pass
    raise beyond_precision()


def _of_iteration(problem: _Problem, count: int, square: float) -> Undamped:
    """Return the modes nearest to ``square`` and prove that there are no others among them."""
    most = problem.linear.motions - problem.k
    solve = problem.solver(square)
    squares, shapes = np.zeros(0), np.zeros((problem.size, 0))
    wanted, certified, reach = count + EXTRA, False, np.inf
    start = np.random.default_rng(1)
    for _ in range(ATTEMPTS):
        new, directions = _lanczos(
            problem, solve, square, min(wanted, most - len(squares) - 1), shapes, start
        )
        squares, shapes = problem.refined(np.append(squares, new), np.hstack([shapes, directions]))
        order = np.argsort(np.abs(squares - square), kind="stable")
        squares, shapes = squares[order], shapes[:, order]
        reach, inside = _gap(np.abs(squares - square), count)
        missing = _missing(problem, squares, square, reach)
        certified = missing == 0 and inside >= min(count, most)
        if certified:
            squares, shapes = squares[:inside], shapes[:, :inside]
            break
        below = _cluster(np.abs(squares - square), count)
        if missing > MANY and below is not None and _missing(problem, squares, square, below) == 0:
            squares, shapes, certified = (
                squares[:count],
                shapes[:, :count],
                True,
            )  # the rest is equal to the last
            break
        wanted = max(missing, 0) + EXTRA
        if wanted + len(squares) >= most - 1:
            return _of_full_matrices(problem.linear.unconditional())
    low = square - reach
    first = 0
    if certified and low > 0.0:
        first = problem.below(low) - problem.k
    order = np.argsort(squares, kind="stable")
    squares, shapes = squares[order], problem.normalised(shapes[:, order])
    neutral = problem.neutral(squares, shapes)
    rigid = np.hstack([problem.rigid, shapes[:, neutral]])
    squares, shapes = squares[~neutral], shapes[:, ~neutral]
    flexibility = solve if square == 0.0 else problem.solver(0.0)
    return Undamped(problem.linear, rigid, squares, shapes, first, False, certified, flexibility)


def _gap(distances: Floats, count: int) -> tuple[float, int]:
    """Return a distance at a gap beyond ``count`` increasing ones, if there is one, and how many lie within it."""
    last = len(distances)
    for k in range(min(count, last), last):
        if distances[k] - distances[k - 1] > GAP * distances[k]:
            return float(0.5 * (distances[k] + distances[k - 1])), k
    return float(distances[-1]) * (1.0 + GAP) if last else 0.0, 0


def _cluster(distances: Floats, count: int) -> float | None:
    """Return a distance in the gap before those that equal the ``count``th; None if there are less."""
    if len(distances) < count or count == 0:
        return None
    first = count - 1
    while first > 0 and distances[first] - distances[first - 1] <= GAP * distances[first]:
        first -= 1
    before = distances[first - 1] if first else 0.0
    return float(max(0.5 * (before + distances[first]), distances[first] * (1.0 - GAP)))


def _missing(problem: _Problem, squares: Floats, square: float, reach: float) -> int:
    """Return how many modes within ``reach`` of ``square`` are not among those found, by counting pivots."""
    low, high = square - reach, square + reach
    there = problem.below(high)
    if square > 0.0:
        there -= problem.below(low)
    if square == 0.0 or low < 0.0:
        there -= problem.k
    return there - int(np.count_nonzero((squares < high) & ((squares > low) | (square == 0.0))))


def _lanczos(
    problem: _Problem,
    solve: Callable[[np.ndarray], np.ndarray],
    square: float,
    count: int,
    known: Floats,
    random: np.random.Generator,
) -> tuple[Floats, Floats]:
    """Return the eigenvalues nearest to ``square`` beside ``known`` vectors, and their vectors."""
    import scipy.sparse.linalg as spla

    size, shape = problem.size, problem.M.shape
    momenta = problem.M @ known

    def beside(x: np.ndarray) -> np.ndarray:
        return np.asarray(x - known @ (momenta.T @ x))

    inverse = spla.LinearOperator(shape, matvec=lambda b: beside(solve(b)), dtype=float)
    inertia = spla.LinearOperator(shape, matvec=problem.inertia, dtype=float)
    start = beside(solve(problem.inertia(random.standard_normal(size))))
    for tolerance in (TOLERANCE, 1e-8):
        try:
            values, vectors = spla.eigsh(
                problem.K,
                count,
                inertia,
                sigma=square,
                OPinv=inverse,
                v0=start,
                tol=tolerance,
                ncv=min(problem.linear.motions - problem.k, max(2 * count + 10, 20)),
                maxiter=100,
            )
        except spla.ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        except spla.ArpackError:
            continue
        if len(values):
            return values, vectors
    raise beyond_precision()
