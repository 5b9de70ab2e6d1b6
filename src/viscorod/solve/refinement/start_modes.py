"""The slowest small motions about the state in which a motion begins: errors of mesh and steps are told by them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.errors import SolveError
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.modes.relaxing import Relaxing, vibrating
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["StartModes"]

COUNT = 24
"""Slowest vibrations that are followed in large models; in small ones it is all."""
PRECISE = 1e-6
"""Part of a squared frequency that rounding may spoil: errors are told by these modes, which is no use below that."""


@dataclass(frozen=True)
class StartModes:
    """Undamped vibrations about a state at rest, rigid motions apart; body increments, orthonormal by the mass.

    Attributes:
        omega: angular frequencies [rad/s] ``(k,)``; shapes: ``(6 n, k)``.
        decay: rates at which the vibrations fade [1/s] ``(k,)``, to first order in the damping.
        rigid: motions that nothing resists, or that grow ``(6 n, m)``.
    """

    omega: Floats
    shapes: Floats
    decay: Floats
    rigid: Floats

    @classmethod
    def about(cls, static: StaticSolver, state: State, scale: float, count: int = COUNT) -> StartModes:
        """Find the modes of small motions about a state under ``scale`` times the loads just before t = 0."""
        linear = linearise(static, state, scale=scale)
        return cls.of(linear, Relaxing.of(static.system, state, linear), count)

    @classmethod
    def of(cls, linear: Linearisation, relaxing: Relaxing | None = None, count: int = COUNT) -> StartModes:
        """Find the modes of small motions, at least ``count`` of them if there are as many; none if they cannot be.

        Args:
            linear: the motions; relaxing: what Maxwell branches add to their stiffness.
        """
        rows = linear.basis.shape[0]
        linear = vibrating(linear, relaxing)
        try:
            found = undamped_modes(linear, count, precise=PRECISE, quick=True)
        except SolveError:
            return cls(np.zeros(0), np.zeros((rows, 0)), np.zeros(0), np.zeros((rows, 0)))
        swinging = found.squares > 0.0
        vectors, basis, squares = found.shapes[:, swinging], found.linear.basis, found.squares[swinging]
        decay = 0.5 * np.einsum("ik,ik->k", vectors, found.linear.damping @ vectors)
        others = np.hstack([found.rigid, found.shapes[:, ~swinging]])
        shapes = np.asarray(basis @ vectors)
        if relaxing is not None:
            squares, lost = relaxing.apart(squares, shapes)
            decay = decay + lost
        return cls(np.sqrt(squares), shapes, decay, np.asarray(basis @ others))

    @property
    def eigenvalues(self) -> np.ndarray:
        """One of each vibration [1/s] ``(k,)``, of overdamped ones that by which they creep back."""
        root = np.sqrt((self.decay**2 - self.omega**2).astype(complex))
        return np.asarray(-(self.omega**2) / (self.decay + root))
