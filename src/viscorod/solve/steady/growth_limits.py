"""How fast motions about a steady rotation may grow at all: what is beyond that is round-off.

Of ``M y'' + C y' + K y = 0`` let y be a motion ``exp(s t)``, ``s = a + i b``, a > 0, with ``y* M y = 1``. With the
symmetric and skew parts ``y* C y = d + i g`` and ``y* K y = k + i c``

    a^2 - b^2 + a d - b g + k = 0,        b (2 a + d) + a g + c = 0.

Dampers have d >= 0; those to the ground add to c as they turn, at most the angular speed w times d. With the largest
gyroscopic rate ``|g| <= G``, the largest rate ``|c| <= w d + L`` by loads that are not conservative, and the smallest
stiffness ``k >= -N``

    |b| <= max(G/2, w) + L/(2 a),        a^2 <= b^2 + |b| G + N:

motions that grow are no faster than the rotation is, but for the softening by loads (compare Bolotin, Nonconservative
Problems of the Theory of Elastic Stability, 1963; Merkin, Introduction to the Theory of Stability, 1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.steady.free_motions import FreeMotions
    from viscorod.solve.steady.stability import SecondOrder

__all__ = ["GrowthLimits", "growth_limits"]

SLACK = 1.01
DOUBLINGS = 100
FAINT = 1e-9
"""Growth, as a part of the angular speed, that counts as none."""
ROUND_OFF = 1e-12
"""Part of a matrix, symmetric or skew, that counts as none."""


@dataclass(frozen=True)
class GrowthLimits:
    """Largest rates [1/s], and their squares, that enter the growth of motions; infinite where they are not known.

    Attributes:
        spin: w; gyroscopic: G; loads: L [1/s^2]; softening: N [1/s^2].
        lossless: nothing damps, and all loads have a potential.
    """

    spin: float = np.inf
    gyroscopic: float = np.inf
    loads: float = 0.0
    softening: float = np.inf
    lossless: bool = False

    @property
    def radius(self) -> float:
        """The largest ``|s|`` [1/s] of a motion that grows by more than a faint part of the angular speed."""
        return float(self._radii(np.array([FAINT * self.spin]))[0])

    def allow(self, s: np.ndarray) -> np.ndarray:
        """Return which roots with positive real parts may be those of motions that grow."""
        if not np.isfinite(self.spin):
            return np.ones(s.shape, dtype=bool)
        growth = np.maximum(s.real, FAINT * self.spin)
        return np.asarray(np.abs(s) <= SLACK * self._radii(growth))

    def _radii(self, growth: Floats) -> Floats:
        turning = np.full(growth.shape, max(0.5 * self.gyroscopic, self.spin))
        if self.loads:
            turning = turning + 0.5 * self.loads / growth
        squares: Floats = 2.0 * turning**2 + turning * self.gyroscopic + self.softening
        return np.sqrt(squares)


def growth_limits(small: SecondOrder, free: FreeMotions, rate: float) -> GrowthLimits:
    """Return the limits of small motions that turn with an angular speed ``rate`` [rad/s].

    They are those of the motions that supports allow, of which conditions leave a part: but for the softening, which is
    that of this part. Maxwell branches add to k, and to d as dashpots that turn with the model do.

    Args:
        small: before supports and conditions; free: motions that these leave.
    """
    basis = free.supported
    M, C, K = (sparse.csr_array(basis.T @ (m @ basis)) for m in (small.mass, small.damping, small.stiffness))
    n = len(small.ad)
    mass = _nodal(small.mass, n)
    if min(float(np.linalg.eigvalsh(block).min()) for block in mass) <= 0.0:
        return GrowthLimits()
    gyroscopic = max(_largest(_skew(own), m) for own, m in zip(_nodal(small.damping, n), mass, strict=True))
    loads = 0.0
    if small.circulatory:
        root = np.sqrt(M.diagonal())
        least = min(float(np.linalg.eigvalsh(m / np.sqrt(np.outer(*[np.diag(m)] * 2))).min()) for m in mass)
        skew = abs(0.5 * (K - K.T)) @ (1.0 / root)
        loads = float((skew / root).max(initial=0.0)) / least
    damped = small.branches is not None or abs(C + C.T).max() > ROUND_OFF * abs(C).max()
    softening = _softening(K, M, free.conditions, rate)
    return GrowthLimits(rate, gyroscopic, loads, softening, not damped and loads == 0.0)


def _softening(
    K: sparse.csr_array, M: sparse.csr_array, conditions: sparse.csr_array | None, rate: float
) -> float:
    """Return N [1/s^2] with ``K + N M`` positive definite within the conditions, by an inertia count."""
    stiff = sparse.csr_array(0.5 * (K + K.T))
    basis = sparse.csc_array(K.shape)
    softening = rate**2
    for _ in range(DOUBLINGS):
        if negative_eigenvalues(Tangent(sparse.csr_array(stiff + softening * M), basis, conditions)) == 0:
            return softening
        softening *= 2.0
    return np.inf


def _nodal(matrix: sparse.csr_array, n: int) -> Floats:
    """Return the diagonal blocks ``(n, 6, 6)``."""
    bsr = sparse.bsr_array(matrix, blocksize=(6, 6))
    out = np.zeros((n, 6, 6))
    for k in range(n):
        for slot in range(bsr.indptr[k], bsr.indptr[k + 1]):
            if bsr.indices[slot] == k:
                out[k] += bsr.data[slot]
    return out


def _skew(block: Floats) -> Floats:
    return np.asarray(0.5 * (block - block.T))


def _largest(skew: Floats, mass: Floats) -> float:
    """Return the largest eigenvalue of a skew block over the mass, by size."""
    return float(np.abs(scipy.linalg.eigvals(skew, mass)).max())
