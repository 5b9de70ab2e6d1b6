"""How far two states of a motion are apart, and how large section forces are."""

from __future__ import annotations

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.typing import Floats

__all__ = ["distance", "largest"]


def largest(section_force: Floats) -> Floats:
    """Return the largest force and moment ``(2,)``."""
    return np.asarray(np.linalg.norm(section_force.reshape(-1, 2, 3), axis=2).max(axis=0))


def distance(state: State, r: Floats, q: Floats) -> Floats:
    """Return the largest displacement [m] and rotation [rad] of a node from other poses ``(2,)``."""
    far = np.linalg.norm(state.r - r, axis=1).max()
    chord = np.minimum(np.square(state.q - q).sum(axis=1), np.square(state.q + q).sum(axis=1))
    return np.array([far, 4.0 * np.arcsin(min(0.5 * np.sqrt(chord.max()), 1.0))])
