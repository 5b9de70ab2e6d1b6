"""A straight beam in a plane, as arrays: displacements along and across it, rotations, and their strains.

Nodes, interpolation and Gauss points are those of the geometrically exact rod on the same mesh: polynomials of order p
between p + 1 Gauss-Lobatto nodes, p Gauss points per element, which neither lock in shear nor in stretch. Unknowns are
(u, w, phi) of every node, along the tangent t, along the transverse axis e, and about t x e. Strains are

    gamma = w' - phi,     eps = u' (+ w'^2/2),     kappa = phi'

(Artola, Wynn and Palacios, (35), (37), (38)). What supports hold, and gamma in theories without shear, are linear
conditions, which a basis of the remaining motions fulfils.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import null_space

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.planar.planar_theory import PlanarTheory
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["PlanarBeam", "Plane", "nodal_loads"]

ROTARY = 1e-5
"""Part of the rotary inertia that theories without it keep, as Artola, Wynn and Palacios do: no massless motions."""


@dataclass(frozen=True)
class Plane:
    """The plane of a beam.

    Attributes:
        tangent, across, normal: unit vectors, global axes; normal = tangent x across.
        transverse: 0 if ``across`` is d1 of the sections, 1 if it is d2.
    """

    tangent: Floats
    across: Floats
    normal: Floats
    transverse: int

    @classmethod
    def of(cls, problem: Problem, transverse: int) -> Plane:
        """Return the plane of the tangent and of d1 (0) or d2 (1) of the first node."""
        R = matrices(problem.quaternions[:1])[0]
        tangent, across = R[:, 2], R[:, transverse]
        return cls(tangent, across, np.cross(tangent, across), transverse)

    @property
    def strains(self) -> Integers:
        """Numbers of shear, stretch and bending in the plane among the six strains."""
        return np.array([0, 2, 4] if self.transverse == 0 else [1, 2, 3])

    @property
    def motions(self) -> Integers:
        """Numbers of the motions along, across and about the normal among the six of a node, body axes."""
        return np.array([2, 0, 4] if self.transverse == 0 else [2, 1, 3])

    @property
    def turn(self) -> float:
        """Sign of the section's axis of bending along the normal."""
        return 1.0 if self.transverse == 0 else -1.0


def nodal_loads(problem: Problem, state: LoadState) -> Floats:
    """Return the wrenches of loads on the nodes of the undeformed rods (n, 6), body axes."""
    external = np.zeros((problem.size, 6))
    state.add(problem, (problem.positions, problem.quaternions), None, external)
    return external


class PlanarBeam:
    """The discretised beam of one theory.

    Attributes:
        theory, plane, problem: which.
        shear, stretch, bend, slope: operators (points, 3 n) of w' - phi, u', phi' and w' at the Gauss points.
        weights: quadrature lengths (points,), m.
        stiffness, damping: of (gamma, eps, kappa) at the points (points, 3, 3); none of a strain that is held.
        mass: (3 n, 3 n).
        basis: motions that supports and the theory allow (3 n, free).
    """

    def __init__(self, problem: Problem, plane: Plane, theory: PlanarTheory, held_shear: bool) -> None:
        self.problem, self.plane, self.theory = problem, plane, theory
        self.shears = theory.shear and not held_shear
        (elements,) = problem.sets
        n, order = problem.size, elements.order
        count = len(elements.nodes) * order
        self.shear, self.stretch, self.bend, self.slope = np.zeros((4, count, 3 * n))
        self.weights = (elements.half_lengths[:, None] * elements.weights).ravel()
        for k, nodes in enumerate(elements.nodes):
            rows = slice(k * order, (k + 1) * order)
            slopes = elements.slopes / elements.half_lengths[k]
            self.stretch[rows, 3 * nodes] = slopes
            self.slope[rows, 3 * nodes + 1] = slopes
            self.bend[rows, 3 * nodes + 2] = slopes
            self.shear[rows, 3 * nodes + 1] = slopes
            self.shear[rows, 3 * nodes + 2] = -elements.shapes
        sections = elements.section.ravel()
        self.stiffness, self.damping = (
            self._in_plane(given[sections]) for given in (elements.stiffness, elements.damping)
        )
        self.mass = self._mass()
        self._conditions()

    def _in_plane(self, given: Floats) -> Floats:
        """Return section matrices of the strains in the plane (points, 3, 3); none of shear that is held."""
        kept = self.plane.strains
        signs = np.array([1.0 if self.shears else 0.0, 1.0, self.plane.turn])
        found: Floats = given[:, kept[:, None], kept] * np.outer(signs, signs)
        return found

    def _mass(self) -> Floats:
        kept, n = self.plane.motions, self.problem.size
        signs = np.array([1.0, 1.0, self.plane.turn])
        blocks = self.problem.mass[:, kept[:, None], kept] * np.outer(signs, signs)
        if not self.theory.shear:
            part = np.array([1.0, 1.0, np.sqrt(ROTARY)])
            blocks = blocks * np.outer(part, part)
        found = np.zeros((3 * n, 3 * n))
        for k in range(n):
            found[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = blocks[k]
        return found

    def _conditions(self) -> None:
        """Find the conditions of supports and held shear, and the motions that they allow."""
        supports, plane = self.problem.supports, self.plane
        rows = []
        for node, axes, fixed in zip(supports.nodes, supports.axes, supports.fixed, strict=True):
            for k in np.flatnonzero(fixed):
                row = np.zeros(3 * self.problem.size)
                axis = axes[:, k % 3]
                if k < 3:
                    row[3 * node : 3 * node + 2] = axis @ plane.tangent, axis @ plane.across
                else:
                    row[3 * node + 2] = axis @ plane.normal
                if np.abs(row).max() > 1e-12:
                    rows.append(row)
        self.supported = np.array(rows).reshape(-1, 3 * self.problem.size)
        conditions = self.supported
        if not self.shears:
            unit = np.abs(self.shear).max(axis=1, keepdims=True)
            conditions = np.concatenate([conditions, self.shear / unit])
        self.basis = null_space(conditions) if len(conditions) else np.eye(3 * self.problem.size)

    @property
    def free(self) -> bool:
        """Whether supports leave a rigid motion in the plane."""
        place = (self.problem.positions - self.problem.positions[0]) @ self.plane.tangent
        rigid = np.zeros((self.problem.size, 3, 3))
        rigid[:, 0, 0] = rigid[:, 1, 1] = 1.0
        rigid[:, 1, 2], rigid[:, 2, 2] = place, 1.0
        held = self.supported @ rigid.reshape(-1, 3)
        return int(np.linalg.matrix_rank(held, tol=1e-9)) < 3

    def loads(self, state: LoadState) -> Floats:
        """Return the forces of loads on the nodes of the undeformed beam (3 n,), N and N m."""
        plane = self.plane
        found = nodal_loads(self.problem, state)[:, plane.motions] * np.array([1.0, 1.0, plane.turn])
        return np.asarray(found.ravel())

    # --- strains, forces, matrices

    def strains(self, x: Floats) -> Floats:
        """Return (gamma, eps, kappa) at the Gauss points (points, 3) of displacements (3 n,)."""
        stretch = self.stretch @ x
        if self.theory.stretching:
            stretch = stretch + 0.5 * (self.slope @ x) ** 2
        return np.column_stack([self.shear @ x, stretch, self.bend @ x])

    def rates(self, x: Floats, v: Floats) -> Floats:
        """Return the strain rates (points, 3)."""
        return np.column_stack([self.shear @ v, self.stretching(x) @ v, self.bend @ v])

    def stretching(self, x: Floats) -> Floats:
        """Return the derivative of the stretch by displacements (points, 3 n)."""
        if not self.theory.stretching:
            return self.stretch
        found: Floats = self.stretch + (self.slope @ x)[:, None] * self.slope
        return found

    def stress(self, x: Floats, v: Floats | None = None) -> Floats:
        """Return shear force, axial force and moment at the Gauss points (points, 3); held shear has none here."""
        force: Floats = np.einsum("gij,gj->gi", self.stiffness, self.strains(x))
        if v is not None:
            force += np.einsum("gij,gj->gi", self.damping, self.rates(x, v))
        return force

    def internal(self, x: Floats, v: Floats | None = None) -> Floats:
        """Return the internal forces (3 n,)."""
        force = self.weights[:, None] * self.stress(x, v)
        found: Floats = (
            self.shear.T @ force[:, 0] + self.stretching(x).T @ force[:, 1] + self.bend.T @ force[:, 2]
        )
        return found

    def tangent(self, x: Floats, v: Floats | None = None) -> tuple[Floats, Floats]:
        """Return the derivatives of the internal forces by displacements and by velocities, (3 n, 3 n) each."""
        operators = np.stack([self.shear, self.stretching(x), self.bend], axis=1)  # (points, 3, 3 n)
        flat = operators.reshape(-1, operators.shape[2])

        def product(matrix: Floats) -> Floats:
            weighted = np.einsum("gij,gjk->gik", self.weights[:, None, None] * matrix, operators)
            found: Floats = flat.T @ weighted.reshape(flat.shape)
            return found

        K, D = product(self.stiffness), product(self.damping)
        if self.theory.stretching:
            axial = self.weights * self.stress(x, v)[:, 1]
            K = K + self.slope.T @ (axial[:, None] * self.slope)
            if v is not None:  # the rate of stretch depends on the slope too
                rate = np.zeros_like(operators)
                rate[:, 1] = (self.slope @ v)[:, None] * self.slope
                weighted = np.einsum("gij,gjk->gik", self.weights[:, None, None] * self.damping, rate)
                K = K + flat.T @ weighted.reshape(flat.shape)
        return K, D

    def section_forces(self, x: Floats, balance: Floats, v: Floats | None = None) -> Floats:
        """Return shear force, axial force and moment at the Gauss points (points, 3).

        Shear that is held follows from the balance: what external less internal and inertial forces (3 n,) leave is
        carried by supports and held shear.
        """
        force = self.stress(x, v)
        if not self.shears:
            carried = np.concatenate([self.supported, self.weights[:, None] * self.shear])
            force[:, 0] = np.linalg.lstsq(carried.T, balance, rcond=None)[0][len(self.supported) :]
        return force

    @cached_property
    def reduced_mass(self) -> Floats:
        """The mass matrix of the free motions (free, free)."""
        found: Floats = self.basis.T @ self.mass @ self.basis
        return found

    @cached_property
    def order(self) -> Integers:
        """Order of the Gauss points by arc length."""
        (elements,) = self.problem.sets
        found: Integers = np.argsort(np.repeat(elements.start, elements.order), kind="stable")
        return found
