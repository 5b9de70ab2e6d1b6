"""The intrinsic equations between the velocities and strains of a basis: constant arrays, quadratic terms.

With ``x1 = sum phi_j q1_j`` and ``eps = sum psi_j q2_j``, orthonormal by mass and stiffness, compatibility (AWP 14)
tested with the stresses ``C psi_i`` and momentum (AWP 13) with ``phi_i`` are

    q2' = G(q2) q1                    G_ij = A_ij + sum_k H_ijk q2_k
    q1' = -S(q1) q1 - G(q2)^T (q2 + D q2') + f

with ``A_ij = <C psi_i, phi_j' - E^T phi_j>``, ``H_ijk = <C psi_i, L1(phi_j)^T psi_k>``, the skew ``S_ij = sum_k <phi_i,
L1(phi_j) M phi_k> q1_k``, ``D_ij = <psi_i, D psi_j>`` and ``f_i = <phi_i, f>``; so

    d/dt (|q1|^2/2 + |q2|^2/2) = q1.f - q2'.D q2'

exactly, as AWP (19). With linearised damping (AWP 22) the viscous term is ``A^T D A q1``, and what it dissipates
``A q1.D A q1``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from viscorod.solve.problem.problem import Problem
from viscorod.solve.reduced.motion_basis import MotionBasis
from viscorod.solve.reduced.point_operators import PointOperators, curved, momentum_flux, products
from viscorod.typing import Floats

__all__ = ["QuadraticModel", "TestedBalance"]


@dataclass(frozen=True)
class TestedBalance:
    """The balance of momentum tested with other velocities, which it does not fulfil: what supports hold it by.

    Attributes:
        velocity: the other velocities ``(6 n, c)``; mass: their products with the accelerations ``(c, k)``.
        turning: with the inertial forces of two velocities ``(c, k, k)``.
        rate, curved: their strain rates, linear ``(l, c)`` and in products with strains ``(l, c, l)``.
    """

    velocity: Floats
    mass: Floats
    turning: Floats
    rate: Floats
    curved: Floats


@dataclass(frozen=True)
class QuadraticModel:
    """Reduced equations; ``k`` velocities and ``l`` strains.

    Attributes:
        basis: the velocities and strains; linearised: damping is that of AWP (22).
        rate: ``A (l, k)``; curved: ``H (l, k, l)``; turning: ``S`` by velocities ``(k, k, k)``; damping: ``D (l, l)``.
    """

    basis: MotionBasis
    linearised: bool
    rate: Floats
    curved: Floats
    turning: Floats
    damping: Floats

    @classmethod
    def of(
        cls, problem: Problem, operators: PointOperators, basis: MotionBasis, *, linearised: bool
    ) -> QuadraticModel:
        """Compute the coefficients by the quadrature of the elements."""
        rate, bent = _strain_rates(operators, basis, basis.velocity)
        _, turning = _inertia(problem, basis, basis.velocity)
        turning = 0.5 * (turning - turning.transpose(1, 0, 2))  # skew to the last bit
        viscous = np.einsum("gij,kgj->kgi", operators.damping, basis.strain)
        damping = products(basis.strain, viscous)
        return cls(basis, linearised, rate, bent, turning, 0.5 * (damping + damping.T))

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of velocities and of strains."""
        return self.rate.shape[1], self.rate.shape[0]

    def tested(self, problem: Problem, operators: PointOperators, velocity: Floats) -> TestedBalance:
        """Return the balance tested with other velocities ``(6 n, c)``."""
        rate, bent = _strain_rates(operators, self.basis, velocity)
        mass, turning = _inertia(problem, self.basis, velocity)
        return TestedBalance(velocity, mass, turning, rate, bent)

    def gradient(self, q2: Floats) -> Floats:
        """Return ``G (l, k)``."""
        return np.asarray(self.rate + self.curved @ q2)

    def stress_rate(self, q1: Floats, strain_rate: Floats) -> Floats:
        """Return the strain rates ``(l,)`` in the law of damping."""
        return np.asarray(self.rate @ q1) if self.linearised else strain_rate

    def rates(self, y: Floats, force: Floats) -> Floats:
        """Return ``(q1', q2')`` in states ``y = (q1, q2)``, ``(s, k + l)``, under generalised forces ``(s, k)``."""
        strains, k = self.rate.shape
        q1, q2 = y[:, :k], y[:, k:]
        G = self.rate + (self._curved_rows @ q2.T).T.reshape(-1, strains, k)
        S = (self._turning_rows @ q1.T).T.reshape(-1, k, k)
        strain_rate = (G @ q1[..., None])[..., 0]
        pushed = force - (S @ q1[..., None])[..., 0]
        if self.linearised:
            pushed -= (q2[:, None] @ G)[:, 0] + q1 @ (self.rate.T @ self.damping @ self.rate)
        else:
            pushed -= ((q2 + strain_rate @ self.damping)[:, None] @ G)[:, 0]
        return np.concatenate([pushed, strain_rate], axis=1)

    @cached_property
    def _curved_rows(self) -> Floats:
        return self.curved.reshape(-1, self.curved.shape[2])

    @cached_property
    def _turning_rows(self) -> Floats:
        return self.turning.reshape(-1, self.turning.shape[2])

    def jacobian(self, y: Floats) -> Floats:
        """Return the derivatives of :meth:`rates` without those of forces ``(k + l, k + l)``."""
        strains, k = self.rate.shape
        q1, q2 = y[:k], y[k:]
        G, by_strain = self.gradient(q2), np.einsum("ijk,j->ik", self.curved, q1)
        out = np.empty((k + strains, k + strains))
        out[k:, :k], out[k:, k:] = G, by_strain
        out[:k, :k] = -(self.turning @ q1) - np.einsum("ijk,j->ik", self.turning, q1)
        if self.linearised:
            stress = q2
            out[:k, :k] -= self.rate.T @ self.damping @ self.rate
            out[:k, k:] = -G.T
        else:
            stress = q2 + self.damping @ (G @ q1)
            out[:k, :k] -= G.T @ self.damping @ G
            out[:k, k:] = -G.T @ (np.eye(strains) + self.damping @ by_strain)
        out[:k, k:] -= np.einsum("ijk,i->jk", self.curved, stress)
        return out

    def dissipated(self, y: Floats, change: Floats) -> float:
        """Return the power [W] that viscosity takes in a state with rates ``change``."""
        k = self.rate.shape[1]
        rate = self.stress_rate(y[:k], change[k:])
        return float(rate @ (self.damping @ rate))

    def reactions(self, balance: TestedBalance, y: Floats, change: Floats, external: Floats) -> Floats:
        """Return what is left of the balance tested with other velocities ``(c,)``; external: wrenches ``(n, 6)``."""
        k = self.rate.shape[1]
        q1, q2 = y[:k], y[k:]
        viscous = self.damping @ self.stress_rate(q1, change[k:])
        G = balance.rate + balance.curved @ q2
        inner = G.T @ q2 + (balance.rate if self.linearised else G).T @ viscous
        inertial = balance.mass @ change[:k] + (balance.turning @ q1) @ q1
        return np.asarray(inner + inertial - balance.velocity.T @ external.ravel())


def _strain_rates(operators: PointOperators, basis: MotionBasis, velocity: Floats) -> tuple[Floats, Floats]:
    """Return ``A (l, c)`` and ``H (l, c, l)`` of velocities ``(6 n, c)``."""
    stresses = operators.stresses(basis.strain)
    rate = products(stresses, operators.rates(velocity))
    bent = (
        np.stack(
            [
                stresses.reshape(len(stresses), -1) @ curved(twist, basis.strain).reshape(len(stresses), -1).T
                for twist in operators.twists(velocity)
            ],
            axis=1,
        )
        if velocity.shape[1]
        else np.zeros((len(stresses), 0, len(stresses)))
    )
    return rate, bent


def _inertia(problem: Problem, basis: MotionBasis, velocity: Floats) -> tuple[Floats, Floats]:
    """Return products of velocities ``(6 n, c)`` with ``M phi_k (c, k)``, and with ``L1(phi_j) M phi_k (c, k, k)``."""
    nodal = basis.velocity.T.reshape(-1, problem.size, 6)
    momenta = np.einsum("nij,knj->kni", problem.mass, nodal)
    mass = velocity.T @ momenta.reshape(len(momenta), -1).T
    turning = np.stack(
        [velocity.T @ momentum_flux(one, momenta).reshape(len(momenta), -1).T for one in nodal],
        axis=1,
    )
    return np.asarray(mass), turning
