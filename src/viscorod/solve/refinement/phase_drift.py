"""What wrong frequencies make of a motion in time: vibrations on a coarse mesh run ahead of those on a finer one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.errors import SolveError
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.modes.undamped import undamped_modes
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


class PhaseDrift:
    """The slowest undamped vibrations about a state at rest, on a mesh and on the one twice as fine.

    Args:
        finer: the finer mesh; static: solver of the coarse one; shape: the state on it; scale: multiple of the loads
            at t = 0 that act there.

    Attributes:
        omega, shapes: on the coarse mesh [rad/s] ``(k,)``, body increments of the nodes with unit modal mass
            ``(6 n, k)``; errors: how much faster they are there, in parts ``(k,)``; decay: rates at which they fade
            [1/s] ``(k,)``.
    """

    def __init__(self, finer: FinerMesh, static: StaticSolver, shape: Shape, scale: float) -> None:
        self.problem = finer.coarse
        linear = linearise(static, shape.state, scale=scale)
        self.omega, self.shapes, decay = slowest(linear, COUNT)
        other = corrected(Balance(finer, factor=scale), finer.take_over(shape)) if len(self.omega) else None
        self.decay, self.errors = decay, np.zeros(len(decay))
        if other is None:
            return
        better, _, _ = slowest(linearise(finer.static, other, scale=scale), COUNT)
        away = np.abs(self.omega[:, None] / better[None, :] - 1.0).min(axis=1, initial=np.inf)
        self.errors = np.where(away < MATCHED, away, 0.0)

    @property
    def leading(self) -> float:
        """The largest relative error of the slowest frequencies."""
        return float(self.errors[:LEADING].max(initial=0.0))

    def gap(self, times: Sequence[float], rates: Sequence[Floats]) -> float:
        """Return how far a motion has drifted from that on the finer mesh at most [m].

        The amplitude of a vibration is that of its acceleration over the square of its frequency: a fast one that only
        follows slower ones, without a phase of its own, has little of it.

        Args:
            times: of some states of the motion [s]; rates: of the twists of all nodes there ``(n, 6)``.
        """
        if not len(self.omega):
            return 0.0
        modal = self.shapes.T @ block_diagonal(self.problem.mass)
        reach = np.linalg.norm(self.shapes.reshape(self.problem.size, 6, -1)[:, :3], axis=1).max(axis=0)
        largest, amplitude = 0.0, np.zeros(len(self.omega))
        for t, rate in zip(times, rates, strict=True):
            # where acceleration passes zero, the amplitude of neighbours in time counts
            amplitude = np.maximum(0.5 * amplitude, np.abs(modal @ rate.ravel()) / self.omega**2)
            # what has faded has left no phase
            lasted = t / np.maximum(self.decay * t, 1.0)
            ahead = np.minimum(self.errors * self.omega * lasted, 2.0)
            largest = max(largest, float(np.linalg.norm(amplitude * reach * ahead)))
        return largest


def slowest(linear: Linearisation, count: int) -> tuple[Floats, Floats, Floats]:
    """Return the slowest undamped vibrations that are not rigid motions.

    Returns:
        angular frequencies [rad/s] ``(k,)``, body increments of the nodes with unit modal mass ``(6 n, k)``, and the
        rates at which the vibrations fade to first order in the damping [1/s] ``(k,)``; none if they cannot be found.
    """
    try:
        found = undamped_modes(linear, count)
    except SolveError:
        return np.zeros(0), np.zeros((linear.basis.shape[0], 0)), np.zeros(0)
    swinging = np.flatnonzero(found.squares > 0.0)[:count]
    vectors = found.shapes[:, swinging]
    decay = 0.5 * np.einsum("ik,ik->k", vectors, found.linear.damping @ vectors)
    return np.sqrt(found.squares[swinging]), np.asarray(found.linear.basis @ vectors), decay
