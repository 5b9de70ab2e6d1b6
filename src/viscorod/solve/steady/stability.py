"""Small motions about a steady rotation: eigenvalues of both formulations, and whether any of them grows.

A perturbed rotation may just be the same one seen from elsewhere: turned in space, or moved. In body twists and strains
such copies are not perturbations at all; from the poses of the geometric formulation they are taken out exactly, which
leaves the same eigenvalues.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.steady.branch_springs import BranchSprings
from viscorod.solve.steady.free_motions import FreeMotions
from viscorod.solve.steady.growth_limits import GrowthLimits, growth_limits
from viscorod.solve.steady.lossless_motions import LosslessMotions
from viscorod.solve.steady.quadratic_pencil import QuadraticPencil
from viscorod.solve.steady.root_counts import growing
from viscorod.solve.steady.slow_motions import MOST, Found, slow_motions
from viscorod.typing import Floats

SLOW = 1e-4
"""Motions with ``|s|`` below this part of the angular speed are neutral: round-off splits a double zero that far."""
FAINT = 1e-9
"""Motions that grow or fade by less than this part of ``|s|`` or, if larger, of the angular speed are neutral."""
FULL = 300
"""Free motions up to which full matrices are used."""
FAR = 30.0
"""Angular speeds within which all motions are sought: more would take long."""
CLEAR = 1.5
"""Distance at which overdamped motions crowd, in that within which others may grow, beyond which they are far."""
ROUND_OFF = 10.0 * float(np.finfo(float).eps)
"""Error of the matrices, as a part of what adds up to their entries, and of ``1/s``."""


@dataclass
class SecondOrder:
    """Small motions about a steady rotation, before supports: ``M d'' + C d' + K d = 0`` in body increments ``d``.

    Sparse ``(6 n, 6 n)``; ``ad`` is ``ad(x)`` of every node ``(n, 6, 6)``; ``circulatory``: loads have no potential;
    ``gradients``: of conditions that d fulfils ``(rows, 6 n)``; ``branches``: beside the stiffness.
    """

    mass: sparse.csr_array
    damping: sparse.csr_array
    stiffness: sparse.csr_array
    ad: Floats
    circulatory: bool
    gradients: sparse.csr_array | None = None
    branches: BranchSprings | None = None


@dataclass
class FirstOrder:
    """Small motions about a steady rotation: ``mass z' = matrix z``.

    ``magnitude`` has the sizes of what adds up to the entries of the matrix: round-off is a part of them. From the
    intrinsic formulation ``z`` are changes of strains, then of free twists. ``increments`` returns the body increments
    of the nodes ``(6 n,)`` that belong to ``s`` and ``z``. Where there is a ``pencil`` the matrices are sparse.
    ``relaxing``: some unknowns are those of Maxwell branches.
    """

    mass: Any
    matrix: Any
    magnitude: Any
    increments: Callable[[complex, np.ndarray], np.ndarray]
    limits: GrowthLimits = field(default_factory=GrowthLimits)
    pencil: QuadraticPencil | None = None
    relaxing: bool = False

    @property
    def size(self) -> int:
        """Number of motions of first order."""
        copies = 0 if self.pencil is None else self.pencil.Z.shape[1]
        return int(self.mass.shape[0]) - copies

    def residuals(self, s: np.ndarray, z: np.ndarray) -> Floats:
        """Return what motions (columns) leave of each equation, as a part of what adds up to it."""
        left = np.abs(self.matrix @ z - s * (self.mass @ z))
        size = self.magnitude @ np.abs(z) + np.abs(s) * (abs(self.mass) @ np.abs(z))
        return np.asarray((left.max(axis=0, initial=0.0)) / np.maximum(size.max(axis=0, initial=0.0), 1e-300))


@dataclass(frozen=True)
class Stability:
    """Eigenvalues ``s`` [1/s] of small motions ``exp(s t)``, one of each conjugate pair (Im >= 0), slowest first.

    ``unstable`` and ``neutral`` count those (both of a pair) that grow, and that neither grow nor fade; ``growth`` is
    the largest rate of those that grow [1/s]. ``vectors`` belong to the eigenvalues, one column each. ``certified``
    tells whether it is proved that none that grows is missing, ``complete`` whether none of those listed is.
    """

    system: FirstOrder | LosslessMotions
    eigenvalues: np.ndarray
    vectors: np.ndarray
    unstable: int
    neutral: int
    growth: float
    certified: bool = True
    complete: bool = True

    def increments(self, count: int) -> np.ndarray:
        """Return the body increments of the nodes ``(6 n, m)`` in the ``count`` slowest motions."""
        found = [
            self.system.increments(complex(s), z)
            for s, z in zip(self.eigenvalues[:count], self.vectors.T[:count], strict=True)
        ]
        return np.array(found).T.reshape(-1, len(found))

    def residuals(self, count: int) -> Floats:
        """Return what the ``count`` slowest motions leave of each equation, as a part of what adds up to it."""
        return self.system.residuals(self.eigenvalues[:count], self.vectors[:, :count])


def first_order(small: SecondOrder, free: FreeMotions, copies: Sequence[Floats], rate: float) -> FirstOrder:
    """Return small motions in poses as a system of first order, without the ``copies`` of the rotation.

    With ``u = y' + A y``, the change of the twists, the pencil ``M y'' + C y' + K y`` in the free motions y reads
    ``y' = u - A y``, ``M u' = -(C - M A) u - (K - (C - M A) A) y``. Copies have u = 0 and stay copies: the complement W
    of them obeys ``b' = W^T u - W^T A W b`` with ``y = W b``. Maxwell branches have unknowns of their own.

    Args:
        free: motions that supports and conditions leave.
        copies: body increments ``(6 n,)`` that take the rotation to copies of itself; rate: angular speed [rad/s].
    """
    basis, inverse = free.basis, free.inverse
    M, C, K = (sparse.csr_array(basis.T @ (m @ basis)) for m in (small.mass, small.damping, small.stiffness))
    count = basis.shape[1]
    A, Z = sparse.csr_array((count, count)), np.zeros((count, 0))
    if len(copies):
        A = sparse.csr_array(inverse @ (sparse.block_diag(list(small.ad), format="csr") @ basis))
        Z, _ = np.linalg.qr(inverse @ np.array(copies).T)
    limits = growth_limits(small, free, rate)
    if count > FULL and small.branches is None:
        pencil = QuadraticPencil(M, C, K, A, Z)
        return FirstOrder(
            pencil.mass,
            pencil.matrix,
            pencil.magnitude,
            lambda _, z: np.asarray(basis @ z[:count]),
            limits,
            pencil,
        )
    M, C, K, A = (matrix.toarray() for matrix in (M, C, K, A))
    W = scipy.linalg.null_space(Z.T) if len(copies) else np.eye(count)
    C1 = C - M @ A
    K1 = K - C1 @ A
    kept = W.shape[1]
    mass = np.eye(kept + count)
    mass[kept:, kept:] = M
    matrix = np.block([[-W.T @ A @ W, W.T], [-K1 @ W, -C1]])
    sizes = np.abs(W)
    magnitude = np.block([[sizes.T @ np.abs(A) @ sizes, sizes.T], [np.abs(K1) @ sizes, np.abs(C1)]])
    moved = basis @ W
    if small.branches is not None:
        stretch, times = (small.branches.stretch @ basis).toarray(), small.branches.times
        mass, matrix, magnitude = _with_branches(mass, matrix, magnitude, stretch, times, W)
    return FirstOrder(
        mass,
        matrix,
        magnitude,
        lambda _, z: np.asarray(moved @ z[:kept]),
        limits,
        relaxing=small.branches is not None,
    )


def _with_branches(
    mass: Floats, matrix: Floats, magnitude: Floats, stretch: Floats, times: Floats, W: Floats
) -> tuple[Floats, Floats, Floats]:
    """Add the springs of Maxwell branches to a system of first order, ``z' = (F W b - z)/tau``.

    Args:
        stretch: F ``(m, free)`` in the free motions; times: of the springs ``(m,)``; W: free motions by those kept.
    """
    kept, count, size = W.shape[1], len(W), len(matrix)
    seen = stretch @ W
    down, up = np.zeros((len(times), size)), np.zeros((size, len(times)))
    down[:, :kept] = seen / times[:, None]
    up[kept : kept + count] = stretch.T
    matrix, magnitude = matrix.copy(), magnitude.copy()
    matrix[kept:, :kept] -= stretch.T @ seen
    magnitude[kept:, :kept] += np.abs(stretch).T @ np.abs(seen)
    relaxed = np.diag(-1.0 / times)
    return (
        scipy.linalg.block_diag(mass, np.eye(len(times))),
        np.block([[matrix, up], [down, relaxed]]),
        np.block([[magnitude, np.abs(up)], [np.abs(down), -relaxed]]),
    )


def stability(system: FirstOrder | LosslessMotions, rate: float, count: int) -> Stability:
    """Return the eigenvalues of ``mass z' = matrix z``: all of them, or of large and of lossless systems the slowest.

    They are found from those of ``(matrix - s0 mass)^-1 mass``, so that slow ones are accurate however stiff the fast
    ones are. Round-off moves ``s`` by up to ``|y| |error| |x| / |y mass x|`` with its left and right vectors: much
    where two neutral motions coincide, and in undamped rods that are far stiffer against stretching than bending. No
    motion beyond the limits of growth is unstable, whatever round-off makes of it; so the slow ones of a large system
    are enough.

    Args:
        rate: angular speed [rad/s], by which s0 is chosen; count: how many of the slowest are wanted.
    """
    if isinstance(system, LosslessMotions):
        found = system.slowest(count)
        s = 1j * found.frequencies
        return Stability(system, s, found.motions, 0, system.size, 0.0, complete=found.complete)
    shift = 0.37 * rate  # no eigenvalue of its own, and slow
    certified = complete = True
    limits = system.limits
    if system.pencil is not None:
        slow, certified = _of_iteration(system.pencil, shift, limits, rate, count)
        s, left, right, complete = slow.roots, slow.left, slow.right, slow.certified
        theta = 1.0 / (s - shift)
        error, overlap = _products(system, left, right)
    else:
        matrix = system.matrix - shift * system.mass
        rows = np.abs(matrix).max(axis=1)
        inverse = np.linalg.inv(matrix / rows[:, None]) / rows
        theta, left, right = scipy.linalg.eig(inverse @ system.mass, left=True, right=True)
        kept = np.abs(theta) > 1e-15 * np.abs(theta).max()
        s = shift + 1.0 / theta[kept]
        error, overlap = _products(system, inverse.T @ left[:, kept].conj(), right[:, kept])
        right = right[:, kept]
    with np.errstate(divide="ignore"):
        bound = FAINT * np.maximum(np.abs(s), rate) + ROUND_OFF * error / overlap
    bound += ROUND_OFF * system.size * np.abs(s - shift) ** 2 * np.abs(theta).max()
    s[np.abs(s) < FAINT * rate] = 0.0
    bound[np.abs(s) <= SLOW * rate] = np.inf
    grows = (s.real > bound) & limits.allow(s)
    unstable = int(np.count_nonzero(grows))
    neutral = int(np.count_nonzero((np.abs(s.real) <= bound) | ((s.real > bound) & ~grows)))
    if limits.lossless:  # what does not grow does not fade, but for the mirror image of what does
        neutral = system.size - 2 * unstable
    growth = float(s.real[grows].max(initial=0.0))
    upper = s.imag >= -1e-12 * np.abs(s)
    if system.relaxing:  # branches that relax hardly move anything, and there are very many of them
        upper &= (s.real >= 0.0) | (s.imag > np.abs(s.real))
    if system.pencil is not None and complete:
        upper &= np.abs(s) <= slow.reach - shift  # beyond, slower ones may be missing
    s, right = s[upper], right[:, upper]
    order = np.argsort(np.abs(s), kind="stable")
    return Stability(system, s[order], right[:, order], unstable, neutral, growth, certified, complete)


def _of_iteration(
    pencil: QuadraticPencil, shift: float, limits: GrowthLimits, rate: float, count: int
) -> tuple[Found, bool]:
    """Return the slowest motions, and whether all that grow are among them.

    Where overdamped motions crowd within the limits of growth, the others are counted in the half plane where motions
    grow, and sought there if they are missing.
    """
    radius = min(limits.radius, FAR * rate)
    around = float(np.hypot(shift, radius))
    crowd = pencil.creep < CLEAR * around
    found = slow_motions(pencil, shift, around, count, limits, 6 * count + 40 if crowd else MOST)
    if found.certified:
        return found, limits.radius <= FAR * rate
    missing = growing(pencil, found.roots, radius, limits)
    return found, missing == 0 and limits.radius <= FAR * rate


def _products(system: FirstOrder, left: np.ndarray, right: np.ndarray) -> tuple[Floats, Floats]:
    """Return ``|y| magnitude |x|`` and ``|y mass x|`` of left and right vectors."""
    error = np.einsum("ik,ik->k", np.abs(left), system.magnitude @ np.abs(right))
    return error, np.abs(np.einsum("ik,ik->k", left, system.mass @ right))
