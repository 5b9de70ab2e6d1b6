"""Small motions about a steady rotation: eigenvalues of both formulations, and whether any of them grows.

A perturbed rotation may just be the same one seen from elsewhere: turned in space, or moved. In body twists and strains
such copies are not perturbations at all; from the poses of the geometric formulation they are taken out exactly, which
leaves the same eigenvalues.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State
from viscorod.solve.steady.rigid_rotation import RotationAxis, rigid_twists
from viscorod.typing import Floats

SLOW = 1e-4
"""Motions with ``|s|`` below this part of the angular speed are neutral: round-off splits a double zero that far."""
FAINT = 1e-9
"""Motions that grow or fade by less than this part of ``|s|`` or, if larger, of the angular speed are neutral."""
ROUND_OFF = 10.0 * float(np.finfo(float).eps)
"""Error of the matrices, as a part of what adds up to their entries, and of ``1/s``."""


@dataclass
class SecondOrder:
    """Small motions about a steady rotation, before supports: ``M d'' + C d' + K d = 0`` in body increments ``d``.

    Dense ``(6 n, 6 n)``; ``ad`` is ``ad(x)`` of every node ``(n, 6, 6)``.
    """

    mass: Floats
    damping: Floats
    stiffness: Floats
    ad: Floats


@dataclass
class FirstOrder:
    """Small motions about a steady rotation: ``mass z' = matrix z``.

    ``magnitude`` has the sizes of what adds up to the entries of the matrix: round-off is a part of them. From the
    intrinsic formulation ``z`` are changes of strains, then of free twists. ``increments`` returns the body increments
    of the nodes ``(6 n,)`` that belong to ``s`` and ``z``.
    """

    mass: Floats
    matrix: Floats
    magnitude: Floats
    increments: Callable[[complex, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Stability:
    """Eigenvalues ``s`` [1/s] of small motions ``exp(s t)``, one of each conjugate pair (Im >= 0), slowest first.

    ``unstable`` and ``neutral`` count those (both of a pair) that grow, and that neither grow nor fade; ``growth`` is
    the largest rate of those that grow [1/s]. ``vectors`` belong to the eigenvalues, one column each.
    """

    system: FirstOrder
    eigenvalues: np.ndarray
    vectors: np.ndarray
    unstable: int
    neutral: int
    growth: float

    def increments(self, count: int) -> np.ndarray:
        """Return the body increments of the nodes ``(6 n, m)`` in the ``count`` slowest motions."""
        found = [
            self.system.increments(complex(s), z)
            for s, z in zip(self.eigenvalues[:count], self.vectors.T[:count], strict=True)
        ]
        return np.array(found).T.reshape(-1, len(found))

    def residuals(self, count: int) -> Floats:
        """Return what the ``count`` slowest motions leave of each equation, as a part of what adds up to it."""
        s, z = self.eigenvalues[:count], self.vectors[:, :count]
        left = np.abs(self.system.matrix @ z - s * (self.system.mass @ z))
        size = self.system.magnitude @ np.abs(z) + np.abs(s) * (np.abs(self.system.mass) @ np.abs(z))
        return np.asarray((left.max(axis=0, initial=0.0)) / np.maximum(size.max(axis=0, initial=0.0), 1e-300))


def first_order(
    small: SecondOrder,
    supports: SupportState,
    state: State,
    line: RotationAxis,
    copies: Floats,
    length: float,
) -> FirstOrder:
    """Return small motions in poses as a system of first order, without the ``copies`` of the rotation.

    With ``u = y' + A y``, the change of the twists, the pencil ``M y'' + C y' + K y`` in the free motions y reads
    ``y' = u - A y``, ``M u' = -(C - M A) u - (K - (C - M A) A) y``. Copies have u = 0 and stay copies: the complement W
    of them obeys ``b' = W^T u - W^T A W b`` with ``y = W b``.

    Args:
        supports: with reactions and directions at the state.
        copies: spatial velocity fields ``(c, 6)`` (velocity of the centre, angular velocity) that take the rotation to
            copies of itself.
        length: by which displacements are measured.
    """
    basis = supports.free_basis(state).toarray()
    unit = np.where(supports.free_rows() % 6 < 3, length, 1.0)
    basis = basis * unit
    M, C, K = (basis.T @ matrix @ basis for matrix in (small.mass, small.damping, small.stiffness))
    count = basis.shape[1]
    inverse = np.linalg.pinv(basis)
    A = np.zeros((count, count))
    W = np.eye(count)
    if len(copies):
        n = len(state.r)
        whole = np.zeros((6 * n, 6 * n))
        for k, block in enumerate(small.ad):
            whole[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = block
        A = inverse @ whole @ basis
        fields = [rigid_twists(state.r, state.q, c[:3], c[3:], line.centre).ravel() for c in copies]
        Z = inverse @ np.array(fields).T
        W = scipy.linalg.null_space(Z.T)
    C1 = C - M @ A
    K1 = K - C1 @ A
    kept = W.shape[1]
    mass = np.eye(kept + count)
    mass[kept:, kept:] = M
    matrix = np.block([[-W.T @ A @ W, W.T], [-K1 @ W, -C1]])
    sizes = np.abs(W)
    magnitude = np.block([[sizes.T @ np.abs(A) @ sizes, sizes.T], [np.abs(K1) @ sizes, np.abs(C1)]])
    moved = basis @ W
    return FirstOrder(mass, matrix, magnitude, lambda _, z: np.asarray(moved @ z[:kept]))


def stability(system: FirstOrder, rate: float) -> Stability:
    """Return the eigenvalues of ``mass z' = matrix z``.

    They are found from those of ``(matrix - s0 mass)^-1 mass``, so that slow ones are accurate however stiff the fast
    ones are. Round-off moves ``s`` by up to ``|y| |error| |x| / |y mass x|`` with its left and right vectors: much
    where two neutral motions coincide, and in undamped rods that are far stiffer against stretching than bending.

    Args:
        rate: angular speed [rad/s], by which s0 is chosen.
    """
    size = len(system.mass)
    shift = 0.37 * rate  # no eigenvalue of its own, and slow
    matrix = system.matrix - shift * system.mass
    rows = np.abs(matrix).max(axis=1)
    inverse = np.linalg.inv(matrix / rows[:, None]) / rows
    theta, left, right = scipy.linalg.eig(inverse @ system.mass, left=True, right=True)
    found = np.abs(theta) > 1e-15 * np.abs(theta).max()
    s = shift + 1.0 / theta[found]
    left, right = inverse.T @ left[:, found], right[:, found]
    overlap = np.abs(np.einsum("ik,ij,jk->k", left.conj(), system.mass, right, optimize=True))
    error = np.einsum("ik,ij,jk->k", np.abs(left), system.magnitude, np.abs(right), optimize=True)
    with np.errstate(divide="ignore"):
        bound = FAINT * np.maximum(np.abs(s), rate) + ROUND_OFF * error / overlap
    bound += ROUND_OFF * size * np.abs(s - shift) ** 2 * np.abs(theta).max()
    s[np.abs(s) < FAINT * rate] = 0.0
    bound[np.abs(s) <= SLOW * rate] = np.inf
    unstable = int(np.count_nonzero(s.real > bound))
    neutral = int(np.count_nonzero(np.abs(s.real) <= bound))
    upper = s.imag >= -1e-12 * np.abs(s)
    growth = float(s.real[s.real > bound].max(initial=0.0))
    s, right = s[upper], right[:, upper]
    order = np.argsort(np.abs(s), kind="stable")
    return Stability(system, s[order], right[:, order], unstable, neutral, growth)
