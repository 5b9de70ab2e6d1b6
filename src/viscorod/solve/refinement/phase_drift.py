"""What wrong frequencies make of a motion in time: vibrations on a coarse mesh run ahead of those on a finer one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.solve.history import Snapshot
from viscorod.solve.modes.vibrations import Linearisation, linearise
from viscorod.solve.refinement.correction import Balance, corrected
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["PhaseDrift"]

COUNT = 12
"""Slowest vibrations that are followed."""
LEADING = 4
"""Of these, those that a mesh has to resolve before anything is known of the motion."""
MATCHED = 0.1
"""Difference of two frequencies, in parts, from which on they are not of the same vibration."""
FASTEST = 1.5
"""Frequency over the rate of the motion up to which a vibration has a phase of its own."""
DENSE = 600
"""Motions up to which full matrices are used."""


class PhaseDrift:
    """The slowest undamped vibrations about a state at rest, on a mesh and on the one twice as fine.

    Args:
        finer: the finer mesh; static: solver of the coarse one; shape: the state on it; scale: multiple of the loads
            at t = 0 that act there.

    Attributes:
        omega, shapes: on the coarse mesh [rad/s] ``(k,)``, body increments of the nodes with unit modal mass
            ``(6 n, k)``; errors: how much faster they are there, in parts ``(k,)``.
    """

    def __init__(self, finer: FinerMesh, static: StaticSolver, shape: Shape, scale: float) -> None:
        self.problem = finer.coarse
        self.omega, self.shapes = slowest(linearise(static, shape.state, scale=scale), COUNT)
        better = np.zeros(0)
        other = corrected(Balance(finer, factor=scale), finer.take_over(shape)) if len(self.omega) else None
        if other is not None:
            better, _ = slowest(linearise(finer.static, other, scale=scale), COUNT)
        count = min(len(self.omega), len(better))
        self.omega, self.shapes = self.omega[:count], self.shapes[:, :count]
        errors = np.abs(self.omega - better[:count]) / better[:count]
        self.errors = np.where(errors < MATCHED, errors, 0.0)

    @property
    def leading(self) -> float:
        """The largest relative error of the slowest frequencies."""
        return float(self.errors[:LEADING].max(initial=0.0))

    def gap(self, states: Sequence[tuple[float, Snapshot]], rate: float) -> float:
        """Return how far a motion has drifted from that on the finer mesh at most [m].

        Vibrations that are faster than the motion follow it without a phase of their own, and do not count.

        Args:
            states: of the motion, with their times [s]; rate: of a vibration as fast as the motion [rad/s].
        """
        moving = self.omega <= FASTEST * rate
        if not moving.any():
            return 0.0
        mass = sparse.block_diag(list(self.problem.mass), format="csr")
        modal = self.shapes.T @ mass
        reach = np.linalg.norm(self.shapes.reshape(self.problem.size, 6, -1)[:, :3], axis=1).max(axis=0)
        largest = 0.0
        amplitude = np.zeros(len(self.omega))
        for t, snapshot in states:
            # where velocity and displacement pass each other, the amplitude of neighbours in time counts
            amplitude = np.maximum(0.5 * amplitude, np.abs(modal @ snapshot.state.twist.ravel()) / self.omega)
            ahead = np.where(moving, np.minimum(self.errors * self.omega * t, 2.0), 0.0)
            largest = max(largest, float(np.linalg.norm(amplitude * reach * ahead)))
        return largest


def slowest(linear: Linearisation, count: int) -> tuple[Floats, Floats]:
    """Return the slowest undamped angular frequencies [rad/s] that are not rigid, and body increments of the nodes.

    The latter have unit modal mass ``(6 n, k)``. Large problems with conditions have none.
    """
    import scipy.sparse.linalg as spla

    size = linear.mass.shape[0]
    if linear.gradients is not None:
        if size > DENSE:
            return np.zeros(0), np.zeros((linear.basis.shape[0], 0))
        linear = linear.unconditional()
        size = linear.mass.shape[0]
    K, M = 0.5 * (linear.stiffness + linear.stiffness.T), 0.5 * (linear.mass + linear.mass.T)
    shift = 1e-10 * float(K.diagonal().sum() / M.diagonal().sum())
    shifted = sparse.csc_array(K + shift * M)
    wanted = min(count + 6, size)
    none = np.zeros(0), np.zeros((linear.basis.shape[0], 0))
    try:
        if size <= DENSE:
            inverse, vectors = scipy.linalg.eigh(
                M.toarray(), shifted.toarray(), subset_by_index=[size - wanted, size - 1]
            )
        else:
            solve = spla.LinearOperator((size, size), matvec=spla.splu(shifted).solve)
            inverse, vectors = spla.eigsh(sparse.csc_array(M), wanted, shifted, Minv=solve, which="LA")
    except (np.linalg.LinAlgError, RuntimeError, spla.ArpackError):
        return none
    order = np.argsort(-inverse)
    values, vectors = 1.0 / inverse[order] - shift, vectors[:, order]
    moving = values > max(1e4 * shift, 0.0)
    values, vectors = values[moving][:count], vectors[:, moving][:, :count]
    norm = np.sqrt(np.einsum("ik,ik->k", vectors, M @ vectors))
    return np.sqrt(values), np.asarray(linear.basis @ (vectors / norm))
