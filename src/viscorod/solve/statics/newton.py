"""Newton's method on poses: one assemble-solve-update iteration, its measures of convergence, and how it fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from viscorod.mechanics.rotations.rotation import increment_size
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.typing import Floats


class Outcome(Enum):
    """Outcome of an iteration or a run, with its meaning as value."""

    CONVERGED = "converged"
    COMPLETED = "completed"
    DIVERGED = "Newton's method diverged"
    SLOW = "Newton's method did not converge in the allowed iterations"
    SINGULAR = "the tangent matrix is singular"
    NOT_FINITE = "a force became infinite or undefined"
    BROKEN = "a rod is stretched or sheared to a hundred times its length"
    WRAPPED = "neighbouring nodes of a rod turn against each other by half a turn, beyond which it is unknown which way"
    INSIDE_OUT = "sections are pressed through each other: the stretch of a rod is negative"
    TOO_SMALL = "the motion needs steps too small to ever reach the end"
    NO_BRANCH = "no branch was found at the bifurcation"
    POINTS = "the path has as many points as are allowed"
    INTERRUPTED = "the run was stopped"

    def advice(self, *, static: bool) -> str:
        """Return advice on what to try."""
        if self is Outcome.NOT_FINITE:
            return "check the magnitudes of loads, motions and stiffnesses, and what functions of time return"
        if self is Outcome.BROKEN:
            return "look for a load or a motion that grows without bound, and check loads against stiffnesses"
        if self is Outcome.WRAPPED:
            return "give the rod more elements"
        if self is Outcome.INSIDE_OUT:
            return "look for a load beyond what the axial and shear stiffness carry, or give more load_steps"
        if self is Outcome.TOO_SMALL:
            return (
                "look for a load or a motion that grows without bound there, or give a larger tolerance, or a shorter "
                "duration"
            )
        if self is Outcome.NO_BRANCH:
            return "give a smaller arc_length, or a small load that prefers one way where the path branches"
        if self is Outcome.POINTS:
            return "give more points"
        if not static:
            return (
                "try a smaller tolerance or time_step, more elements where it bends most, or with generalized_alpha a "
                "lower spectral_radius (more numerical damping of the highest frequencies)"
            )
        if self is Outcome.SINGULAR:
            return "the structure moves freely, or this is a limit or bifurcation load: add a support, reduce the load"
        return (
            "give more load_steps, refine the mesh where it bends most, check the load against the stiffness, "
            "or look for buckling below this load"
        )


@dataclass(frozen=True)
class NewtonReport:
    """Report of one Newton solution.

    Attributes:
        outcome: CONVERGED or the reason of failure.
        iterations: number of linear solutions.
        change: size of the last increment (displacement over model length, or rotation in rad, whichever is larger).
        residual: largest nodal force imbalance [N] (moments divided by the model length) before the last increment.
        node: where that imbalance was.
    """

    outcome: Outcome
    iterations: int
    change: float
    residual: float
    node: int

    @property
    def converged(self) -> bool:
        """True if the balance is solved."""
        return self.outcome is Outcome.CONVERGED


ROUGH = 1e-5
"""Largest increment that may be due to round-off."""
STALLED = 0.2
"""Part of the last increment that one is at least which no longer shrinks: Newton's method would square it."""


class Convergence:
    """Decides after each increment whether to stop: small increments of displacements (over the length) and rotations.

    A residual test would need more digits than a slender rod has: the axial force of exact positions, rounded to
    double precision, is EA times 1e-16, which may exceed any bending force. The increment is free of that, because the
    noise is balanced by displacements of the size of the rounding itself. Where that is more than the tolerance, in
    rods ten thousand times longer than thick and where next to nothing resists a motion, a state has converged if all
    imbalance left is round-off.
    """

    def __init__(self, length: float, tolerance: float, iterations: int) -> None:
        self.length = length
        self.tolerance = tolerance
        self.iterations = iterations
        self._last = np.inf
        self._grown = 0

    def judge(
        self, increment: Floats, count: int, round_off: Callable[[], bool] | None = None
    ) -> tuple[Outcome | None, float]:
        """Return the verdict (None: go on) and the size of ``increment`` (n, 6) after ``count`` iterations.

        ``round_off`` tells whether the imbalance before the increment was round-off; it is asked only where it matters.
        An increment beyond ``ROUGH`` is then not one to be made.
        """
        size = increment_size(increment, self.length)
        if not np.isfinite(size):
            return Outcome.NOT_FINITE, size
        if size <= self.tolerance:
            return Outcome.CONVERGED, size
        if size > 1e4:
            return Outcome.DIVERGED, size
        if (
            round_off is not None
            and count > 1
            and (size > STALLED * self._last or size > ROUGH)
            and round_off()
        ):
            return Outcome.CONVERGED, size
        self._grown = self._grown + 1 if size > self._last else 0
        self._last = size
        if self._grown >= 6:
            return Outcome.DIVERGED, size
        if count >= self.iterations:
            return Outcome.SLOW, size
        return None, size


def worst_node(residual: Floats, length: float) -> tuple[float, int]:
    """Return the largest force imbalance [N] (moments over ``length``) of ``residual`` (n, 6) and its node."""
    size = np.maximum(np.abs(residual[:, :3]).max(axis=1), np.abs(residual[:, 3:]).max(axis=1) / length)
    node = int(np.argmax(size))
    return float(size[node]), node


def imbalance_within(limit: float, residual: Floats, length: float) -> bool:
    """Return whether no force [N] (moment over ``length``) of ``residual`` (n, 6) exceeds a limit."""
    fx, fy, fz, mx, my, mz = np.abs(residual).max(axis=0).tolist()
    return bool(max(fx, fy, fz) <= limit and max(mx, my, mz) / length <= limit)


def interruption(asked: KeyboardInterrupt) -> str:
    """Return why a solution was interrupted."""
    return str(asked) or "interrupted from the keyboard"


__all__ = [
    "Convergence",
    "NewtonReport",
    "Outcome",
    "SingularMatrixError",
    "imbalance_within",
    "interruption",
    "worst_node",
]
