"""The equations of steady rotations in either formulation: unknowns, residual and derivative, scalar measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.formulations.system import State
from viscorod.solve.steady.lossless_motions import LosslessMotions
from viscorod.solve.steady.rigid_rotation import RotationAxis
from viscorod.solve.steady.sparse_least_squares import smallest_solution
from viscorod.solve.steady.stability import FirstOrder
from viscorod.typing import Floats

Measure: TypeAlias = Literal["spin", "energy", "momentum", "elastic"]
"""The number that picks one of a family: angular velocity [rad/s], kinetic and elastic energy [J], angular momentum
[N m s], elastic energy [J]."""

RANK = 1e-12
"""Singular values below this part of the largest belong to symmetries, along which nothing is moved."""


@dataclass
class Balance:
    """A linearisation: ``matrix (m, k) @ change = -residual (m,)``, sparse where it is large."""

    residual: Floats
    matrix: Floats | sparse.csr_array

    def with_row(self, row: Floats) -> Floats | sparse.csr_array:
        """Return the matrix with one more row ``(k,)``."""
        if isinstance(self.matrix, np.ndarray):
            return np.vstack([self.matrix, row])
        return sparse.csr_array(sparse.vstack([self.matrix, sparse.csr_array(row[None])]))


@dataclass(frozen=True)
class Tangent:
    """Small motions in body increments of all nodes, before supports are imposed: matrices by increments and rates.

    Attributes:
        stiffness, damping: ``(6 n, 6 n)``; rows: of the stiffness in the motions that supports leave ``(free, 6 n)``.
        unbalanced: forces that the supports take ``(n, 6)``; gradients: of conditions ``(rows, 6 n)``; None without.
    """

    stiffness: sparse.csr_array
    damping: sparse.csr_array
    rows: sparse.csr_array
    unbalanced: Floats
    gradients: sparse.csr_array | None


class SteadyEquations(Protocol):
    """Unknowns of a steady rotation and the equations that they fulfil."""

    line: RotationAxis
    """The line about which everything turns."""

    def balance(self) -> Balance:
        """Return residual and derivative at the present unknowns."""

    def change_at_spin(self) -> Floats | None:
        """Return the change of the unknowns ``(k,)`` that balances them at the present angular speed.

        None where that is not told quickly, or where more than one does: where something moves freely.
        """

    def measure(self, kind: Measure) -> tuple[float, Floats]:
        """Return the value of a scalar measure and its derivative ``(k,)`` by the unknowns."""

    def set_spin(self, value: float) -> None:
        """Set the angular speed [rad/s] without changing the shape."""

    def scales(self) -> Floats:
        """Return the scale of every unknown ``(k,)``: what a large change is."""

    def update(self, change: Floats) -> None:
        """Change the unknowns."""

    def residual(self) -> tuple[Floats, float]:
        """Return the balance of the nodes ``(n, 6)`` before supports, and the gap that they leave over the forces."""

    def save(self) -> object:
        """Return a copy of the unknowns for :meth:`restore`."""

    def restore(self, kept: object) -> None:
        """Return to kept unknowns."""

    def state(self) -> State:
        """Return poses and twists of all nodes."""

    def fields(self) -> tuple[Floats, Floats]:
        """Return strains and elastic section forces at the Gauss points ``(e, points, 6)``."""

    def elastic_energy(self) -> float:
        """Return the elastic energy [J] at the last residual or measure."""

    def small_motions(self) -> FirstOrder | LosslessMotions:
        """Return the matrices of small motions at the present state."""


def imbalance(left: Floats, forces: tuple[Floats, ...], inertial: float, length: float) -> float:
    """Return the largest component of what is ``left (n, 6)`` of a balance as a part of the forces in it.

    Args:
        forces: those that balance, each ``(n, 6)``; inertial: mass times length times squared angular speed over the
            number of nodes [N], for rotations without any forces; length: by which moments are measured [m].
    """
    size = sum((np.abs(force) for force in forces), np.zeros_like(left))
    force = max(float(size[:, :3].max()), float(size[:, 3:].max()) / length, inertial)
    return float(max(np.abs(left[:, :3]).max() / force, np.abs(left[:, 3:]).max() / (force * length)))


def least_squares(matrix: Floats | sparse.csr_array, right: Floats, sizes: Floats) -> Floats:
    """Return the smallest change that fulfils the equations best, all of them scaled to the same size.

    Symmetries (turning about the axis, round sections about themselves) leave the matrix short of rank.
    """
    if not isinstance(matrix, np.ndarray):
        wide = sparse.csr_array(matrix @ sparse.diags_array(sizes))
        largest = np.asarray(abs(wide).max(axis=1).todense()).ravel()
        largest[largest == 0.0] = 1.0
        return (
            smallest_solution(sparse.csr_array(sparse.diags_array(1.0 / largest) @ wide), right / largest)
            * sizes
        )
    scaled = matrix * sizes
    rows = np.abs(scaled).max(axis=1)
    rows[rows == 0.0] = 1.0
    scaled /= rows[:, None]
    change, *_ = scipy.linalg.lstsq(
        scaled, right / rows, cond=RANK, lapack_driver="gelsy", overwrite_a=True, check_finite=False
    )
    result: Floats = change * sizes
    return result
