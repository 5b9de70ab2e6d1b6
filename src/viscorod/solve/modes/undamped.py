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

from viscorod.solve.modes.linearisation import DENSE, EPS, Linearisation, beyond_precision
from viscorod.solve.modes.vibration_problem import VibrationProblem
from viscorod.solve.once import once
from viscorod.solve.statics.work import PRECISE
from viscorod.typing import Floats

SMALL = 200
"""Motions up to which all is done with full matrices."""
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


def undamped_modes(
    linear: Linearisation,
    count: int,
    near: float | None = None,
    *,
    precise: float = PRECISE,
    quick: bool = False,
) -> Undamped:
    """Return at least ``count`` modes, if there are as many: the slowest, or those nearest to a frequency.

    Args:
        linear: small motions about an equilibrium.
        count: of modes beside rigid motions.
        near: angular frequency [rad/s].
        precise: part of ``w^2`` that rounding may spoil, where all modes are found; beyond, the work of shapes tells.
        quick: whether sums may be taken in another order, which changes what comes first of equal frequencies.
    """
    dense = linear.gradients is None and linear.mass.shape[0] <= DENSE
    if not dense and count + EXTRA >= linear.motions - linear.rigid - 1:
        linear, dense = linear.unconditional(), True
    if dense:
        return _of_full_matrices(linear, precise, quick=quick)
    problem = VibrationProblem(linear)
    problem.require_finite()
    return _of_iteration(linear, problem, count, 0.0 if near is None else near**2)


class _AllModes(NamedTuple):
    """All modes of a problem as full matrices have them, with the sizes of their terms."""

    problem: VibrationProblem
    squares: Floats
    shapes: Floats
    sizes: Floats


@once
def _all_modes(linear: Linearisation) -> _AllModes:
    return _modes_of(VibrationProblem(linear), linear)


@once
def _all_modes_quickly(linear: Linearisation) -> _AllModes:
    return _modes_of(VibrationProblem(linear, full=linear.mass.shape[0] <= SMALL), linear)


def _modes_of(problem: VibrationProblem, linear: Linearisation) -> _AllModes:
    """Return all modes by full matrices.

    Eigenvalues of the inverse problem are accurate for slow modes, Rayleigh quotients of its vectors for fast ones.
    """
    problem.require_finite()
    k, size = problem.k, problem.size
    lift = problem.without_rigid(np.eye(size)[:, k:])
    found = None if k else _inverse_modes(linear)
    if found is None:
        K = sparse.csr_array(problem.K)[k:, k:].toarray()
        M = lift.T @ (problem.M @ lift)
        M = 0.5 * (M + M.T)
        found = _inverse(M, K)
    if found is None:  # an unstable or neutral equilibrium
        squares, shapes = _indefinite(K, M)
    else:
        inverse, shapes = found[:2]
        kept = inverse > EPS * size * inverse.max(initial=0.0) * 1e-3
        inverse, shapes = inverse[kept][::-1], shapes[:, kept][:, ::-1]
        squares = 1.0 / inverse
    shapes = problem.normalised(lift @ shapes if k else shapes)
    # where the inverse has lost digits, the shape has them: its error counts squared
    energies = np.einsum("ik,ik->k", shapes, problem.K @ shapes)
    sizes = problem.sizes(shapes)
    lowest = np.abs(squares).min(initial=np.inf)
    fast = np.abs(squares) > np.sqrt(lowest) * np.sqrt(np.maximum(sizes, np.abs(squares)))
    squares = np.where(fast, energies, squares)
    order = np.argsort(squares, kind="stable")
    return _AllModes(problem, squares[order], shapes[:, order], sizes[order])


def resolved_modes(linear: Linearisation) -> tuple[Floats, Floats] | None:
    """Return all ``1/w^2`` [s^2], increasing, and shapes with ``x.K x = 1``; None unless full matrices tell them.

    Nothing is rigid then, the equilibrium is stable, and of no shape does rounding spoil the stiffness, so that none of
    them has to be looked at again. The last one is the slowest, to the last digit what :func:`undamped_modes` has.
    """
    if linear.gradients is not None or linear.rigid or not 0 < linear.mass.shape[0] <= DENSE:
        return None
    try:
        found = _inverse_modes(linear)
    except ValueError:  # entries that are no numbers
        return None
    if found is None or not found[0][0] > 0.0 or not 2.0 * EPS * found[2] <= PRECISE:
        return None
    return found[:2]


_Inverse = tuple[Floats, Floats, float]
"""Eigenvalues ``1/w^2``, increasing, of ``M x = K x / w^2``, vectors with ``x.K x = 1``, and the largest sum of the
sizes of the terms of this 1, of which one part in 1e16 is round-off."""


@once
def _inverse_modes(linear: Linearisation) -> _Inverse | None:
    """Return the modes of the inverse problem of motions of which none is rigid; None as of :func:`_inverse`."""
    K, M = linear.stiffness.toarray(), linear.mass.toarray()
    return _inverse(0.5 * (M + M.T), 0.5 * (K + K.T))


def _inverse(M: Floats, K: Floats) -> _Inverse | None:
    """Return the modes of the inverse problem; None where the stiffness is not positive definite."""
    try:
        inverse, shapes = scipy.linalg.eigh(M, K)
    except np.linalg.LinAlgError:
        return None
    size = np.abs(shapes)
    return inverse, shapes, float((size * (np.abs(K) @ size)).sum(axis=0).max(initial=0.0))


def _of_full_matrices(linear: Linearisation, precise: float = PRECISE, *, quick: bool = False) -> Undamped:
    """Return all modes."""
    problem, raw, raw_shapes, sizes = _all_modes_quickly(linear) if quick else _all_modes(linear)
    squares, shapes = problem.refined(raw, raw_shapes, precise, sizes)
    neutral = problem.neutral(squares, shapes, sizes if shapes is raw_shapes else None)
    rigid = np.hstack([problem.rigid, shapes[:, neutral]])
    squares, shapes = squares[~neutral], shapes[:, ~neutral]
    flexible = shapes / squares

    def flexibility(b: np.ndarray) -> np.ndarray:
        return np.asarray(flexible @ (shapes.T @ b))

    return Undamped(linear, rigid, squares, shapes, 0, True, True, flexibility)


def _indefinite(K: Floats, M: Floats) -> tuple[Floats, Floats]:
    """Return eigenvalues and vectors of ``K x = w^2 M x`` where ``K`` is not positive definite.

    It is inverted with a shift that rounding does not hide: a hinge that turns freely may leave 1e-53 in place of a 0.
    """
    try:
        found = scipy.linalg.eigh(K, M, eigvals_only=True)
        shift = max(2.0 * abs(float(found[0])), EPS * abs(float(found[-1])))
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


def _of_iteration(linear: Linearisation, problem: VibrationProblem, count: int, square: float) -> Undamped:
    """Return the modes nearest to ``square`` and prove that there are no others among them."""
    most = problem.motions - problem.k
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
            return _of_full_matrices(linear.unconditional())
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
    return Undamped(linear, rigid, squares, shapes, first, False, certified, flexibility)


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


def _missing(problem: VibrationProblem, squares: Floats, square: float, reach: float) -> int:
    """Return how many modes within ``reach`` of ``square`` are not among those found, by counting pivots."""
    low, high = square - reach, square + reach
    there = problem.below(high)
    if square > 0.0:
        there -= problem.below(low)
    if square == 0.0 or low < 0.0:
        there -= problem.k
    return there - int(np.count_nonzero((squares < high) & ((squares > low) | (square == 0.0))))


def _lanczos(
    problem: VibrationProblem,
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
                ncv=min(problem.motions - problem.k, max(2 * count + 10, 20)),
                maxiter=100,
            )
        except spla.ArpackNoConvergence as error:
            values, vectors = error.eigenvalues, error.eigenvectors
        except spla.ArpackError:
            continue
        if len(values):
            return values, vectors
    raise beyond_precision()
