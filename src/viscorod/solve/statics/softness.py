"""How the smallest stiffnesses change along a path: two may vanish within one step, and its ends look alike."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Inverse
from viscorod.typing import Floats

__all__ = ["Softness", "softest_motions", "softness"]

COUNT = 4
"""Motions with the smallest stiffness that are looked at."""
CHANGE = 1e-3
"""Distance along the path by which their stiffness is differenced."""
FULL = 40
"""Motions up to which all stiffnesses are computed."""


class Softness(NamedTuple):
    """The smallest stiffnesses at a point of a path ``(k,)``, and how they change with the distance along it."""

    stiffness: Floats
    slope: Floats

    def may_vanish_before(self, other: Softness, distance: float) -> bool:
        """Return whether a stiffness may have changed its sign and back on the way to another point.

        It heads for zero at the first point and comes from there at the other one, both nearer than these are to each
        other: so does all that vanishes twice, and curves one way in between.
        """
        return bool(self._vanishing(distance) & other._vanishing(-distance))

    def _vanishing(self, distance: float) -> set[bool]:
        """Return the signs of stiffnesses that would vanish within a distance if they went on as they change here."""
        after = self.stiffness + distance * self.slope
        return {bool(sign) for sign in self.stiffness[after * self.stiffness < 0.0] > 0.0}


class Line(Protocol):
    """What is needed of a path to follow it a little further."""

    static: StaticSolver
    t: float
    before: bool

    def solve(self, state: State, factor: float) -> tuple[Floats, Floats]:
        """Return the increments that close the imbalance, and those per load factor."""


def softness(path: Line, state: State, factor: float, rate: float) -> Softness | None:
    """Return the smallest stiffnesses at an equilibrium and their slopes along the path; None where it is singular.

    Section forces are carried along linearly: those of the moved nodes would be off by the large stiffness against
    stretching times the square of the way.

    Args:
        path: its equations; state, factor: the equilibrium.
        rate: change of the load factor with the distance.
    """
    static = path.static
    system = static.system
    try:
        inverse = Inverse(static.tangent(state, path.t, before=path.before, scale=factor))
        stiffness, motions = softest_motions(inverse)
        _, per_factor = path.solve(state, factor)
        gone = CHANGE * rate * per_factor
        moved = state.copy()
        retract(moved.r, moved.q, gone, moved.r, moved.q)
        system.carry_stress(gone)
        moved.multiplier += system.multiplier_change(gone)
        further = static.tangent_here(moved, path.t, before=path.before, scale=factor + CHANGE * rate)
        flexible = Inverse(further).apply(motions)
    except SingularMatrixError:
        return None
    then = np.einsum("ik,ik->k", motions, flexible) / np.einsum("ik,ik->k", flexible, flexible)
    return Softness(stiffness, (then - stiffness) / CHANGE)


def softest_motions(inverse: Inverse) -> tuple[Floats, Floats]:
    """Return the smallest stiffnesses ``(k,)`` and their motions of unit length ``(size, k)``."""
    import scipy.sparse.linalg as spla

    if inverse.size <= FULL:
        flexible, motions = np.linalg.eigh(inverse.apply(np.eye(inverse.size)))
    else:
        operator = spla.LinearOperator((inverse.size,) * 2, matvec=inverse.apply, dtype=float)
        start = inverse.apply(np.random.default_rng(1).standard_normal(inverse.size))
        try:
            flexible, motions = spla.eigsh(operator, COUNT, v0=start, tol=1e-6)
        except spla.ArpackNoConvergence as error:
            flexible, motions = error.eigenvalues, error.eigenvectors
    order = np.argsort(-np.abs(flexible), kind="stable")[:COUNT]
    order = order[np.abs(flexible[order]) > 0.0]
    return 1.0 / flexible[order], motions[:, order]
